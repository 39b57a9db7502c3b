//! The slow plain twin: every sphere against every point, and the volume of the hull against the sum of all.

use super::*;
use glam::I64Vec3;

/// Six times the volume between the origin and a face of whole numbers, exact.
fn exact_volume([a, b, c]: [DVec3; 3]) -> i128 {
    let [a, b, c] = [a, b, c].map(|p| p.as_i64vec3());
    let wide = |p: I64Vec3| [i128::from(p.x), i128::from(p.y), i128::from(p.z)];
    let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (wide(a), wide(b), wide(c));
    ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
}

/// Numbers in 0..1 that look like chance.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn random(n: usize, seed: u64) -> Vec<DVec3> {
    let mut next = noise(seed);
    (0..n).map(|_| DVec3::new(next(), next(), next()) * 10.0).collect()
}

fn boxes(counts: [usize; 3], step: f64) -> Vec<DVec3> {
    let mut points = Vec::new();
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            points.extend((0..counts[0]).map(|x| DVec3::new(x as f64, y as f64, z as f64) * step));
        }
    }
    points
}

fn made(positions: &[DVec3]) -> Tetrahedra {
    let grid = Grid::new(positions);
    let Rank::Space(start) = grid.rank else { panic!("{:?}", grid.rank) };
    tetrahedralise(&grid.points, start)
}

fn check(what: &str, positions: &[DVec3]) -> Tetrahedra {
    let made = made(positions);
    made.validate().unwrap_or_else(|error| panic!("{what}: {error}"));
    let corners = |cell: &Cell| cell.corners.map(|corner| made.points[corner as usize]);
    let mut used = vec![false; made.points.len()];
    for cell in &made.cells[..made.solid] {
        cell.corners.iter().for_each(|&corner| used[corner as usize] = true);
        let held = made.points.iter().find(|&&point| inside_sphere(corners(cell), point) > 0.0);
        assert_eq!(held, None, "{what}: inside the sphere of {cell:?}");
    }
    assert!(used.iter().all(|&used| used), "{what}: a point has no cell");
    let filled: i128 = made.cells[..made.solid]
        .iter()
        .map(|cell| {
            let [a, b, c, d] = corners(cell);
            exact_volume([a - d, b - d, c - d])
        })
        .sum();
    let faces = made.hull().map(|face| exact_volume(face.map(|corner| made.points[corner as usize])));
    assert_eq!(filled.abs(), faces.sum::<i128>().abs(), "{what}: volume");
    made
}

#[test]
fn grids_have_empty_spheres_and_no_flat_tetrahedra() {
    assert!(check("4 x 4 x 4", &boxes([4, 4, 4], 1.0)).solid >= 27 * 5);
    assert!(check("10^3 of 0.1", &boxes([10, 10, 10], 0.1)).solid >= 729 * 5);
    assert!(check("20 x 20 x 2", &boxes([20, 20, 2], 0.7)).solid >= 361 * 5);
    check("a box", &boxes([2, 2, 2], 3.0));
}

#[test]
fn random_points_have_empty_spheres() {
    for seed in 1..20 {
        check("few", &random(4 + seed as usize, seed));
    }
    check("500", &random(500, 77));
}

#[test]
fn points_on_a_sphere_and_a_turned_grid_have_empty_spheres() {
    let on_sphere: Vec<DVec3> = random(300, 5).iter().map(|p| (*p - 5.0).normalize() * 4.0).collect();
    check("sphere", &on_sphere);
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 0.2);
    let turned: Vec<DVec3> = boxes([6, 6, 3], 0.5).iter().map(|p| turn * *p).collect();
    check("turned", &turned);
}

/// As f32 gives it, too.
#[test]
fn a_turned_grid_has_no_slivers() {
    for turn in [[0.3, 0.7, 0.2], [0.0, 0.4, 0.0], [1.9, -0.6, 2.5]] {
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, turn[0], turn[1], turn[2]);
        let far = DVec3::new(12.0, -3.0, 7.0);
        let place = |p: &DVec3| (turn * *p + far).as_vec3().as_dvec3();
        let positions: Vec<DVec3> = boxes([7, 4, 3], 0.45).iter().map(place).collect();
        let made = check("turned", &positions);
        let volume = |cell: &Cell| volume(cell.corners.map(|corner| made.points[corner as usize]));
        let volumes = made.cells[..made.solid].iter().map(volume);
        let (least, most) = volumes.fold((f64::MAX, 0.0), |(least, most), v| (v.min(least), v.max(most)));
        assert!(least > 0.9 * 0.5 * most, "{least} {most}");
    }
}

#[test]
fn points_in_one_place_are_one_and_told() {
    let once = random(60, 3);
    let thrice: Vec<DVec3> = once.iter().chain(&once).chain(&once).copied().collect();
    let grid = Grid::new(&thrice);
    assert_eq!((grid.points.len(), grid.merged.len()), (60, 120));
    assert!(
        grid.merged.iter().all(|&[one, kept]| thrice[one as usize] == thrice[kept as usize] && kept < 60)
    );
    assert_eq!(check("thrice", &thrice).solid, check("once", &once).solid);
    let mut near = random(40, 9);
    near.extend(random(40, 9).iter().map(|p| *p + 1e-6));
    check("a micrometre apart", &near);
}

#[test]
fn rank_is_what_the_points_span() {
    let rank = |points: &[DVec3]| match Grid::new(points).rank {
        Rank::None => 0,
        Rank::One => 1,
        Rank::Line(_) => 2,
        Rank::Plane(_) => 3,
        Rank::Space(_) => 4,
    };
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 0.2);
    let turned = |points: Vec<DVec3>| points.into_iter().map(|p| turn * p).collect::<Vec<_>>();
    assert_eq!(rank(&[]), 0);
    assert_eq!(rank(&[DVec3::ONE; 5]), 1);
    assert_eq!(rank(&[DVec3::ONE, DVec3::ONE + 1e-6]), 2);
    assert_eq!(rank(&turned(boxes([9, 1, 1], 0.3))), 2);
    assert_eq!(rank(&boxes([9, 4, 1], 0.3)), 3);
    assert_eq!(rank(&turned(boxes([9, 4, 1], 0.3))), 3);
    let mut plane = turned(boxes([9, 4, 1], 0.3));
    plane.push(turn * DVec3::new(0.5, 0.5, 0.01));
    assert_eq!(rank(&plane), 4);
    check("a plane and a point", &plane);
}

#[test]
fn a_walk_ends_where_the_point_is() {
    for positions in [random(200, 8), boxes([5, 5, 5], 0.1)] {
        let grid = Grid::new(&positions);
        let made = made(&positions);
        let mut next = noise(4);
        let mut cell = 0;
        for _ in 0..500 {
            let at = grid.at(DVec3::new(next(), next(), next()) * 12.0 - 1.0);
            let found = made.locate(at, cell);
            if (found as usize) < made.solid {
                assert!((0..4).all(|slot| made.volume_with(found, slot, at) >= 0.0));
                cell = found;
            } else {
                assert!(made.beyond(&made.cells[found as usize], at) > 0.0);
            }
        }
    }
}
