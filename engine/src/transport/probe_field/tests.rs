//! Numerics cases 48 to 50: weights are shares, and the light that they give is continuous along any line.

use super::*;
use crate::transport::Probe;
use glam::{DQuat, EulerRot};

fn noise(seed: u64) -> impl FnMut() -> f32 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / (1_u64 << 24) as f32
    }
}

fn transport(positions: &[Vec3]) -> Transport {
    let probe = |&position: &Vec3| Probe { position, valid: 1.0, ..Probe::default() };
    Transport { probes: positions.iter().map(probe).collect(), ..Transport::default() }
}

fn boxes(counts: [usize; 3], step: f32) -> Vec<Vec3> {
    let mut points = Vec::new();
    for z in 0..counts[2] {
        for y in 0..counts[1] {
            points.extend((0..counts[0]).map(|x| Vec3::new(x as f32, y as f32, z as f32) * step));
        }
    }
    points
}

fn turned(points: Vec<Vec3>) -> Vec<Vec3> {
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, 0.7, 0.2);
    points.into_iter().map(|p| (turn * p.as_dvec3()).as_vec3()).collect()
}

fn random(n: usize, seed: u64) -> Vec<Vec3> {
    let mut next = noise(seed);
    (0..n).map(|_| Vec3::new(next(), next(), next()) * 4.0).collect()
}

impl ProbeField {
    /// The least height of the tetrahedron or triangle that weighs a place, or the distance of its two probes;
    /// infinite where all places have the same light [m].
    fn height(&self, at: Vec3, cell: &mut Cell) -> f64 {
        let at = self.grid.at(at.as_dvec3());
        let point = |index: u32| self.grid.points[index as usize];
        let least = match &self.shape {
            Shape::None | Shape::One => f64::INFINITY,
            Shape::Line(_) | Shape::Plane(_) => {
                let blend = self.blend(at, cell);
                let used: Vec<DVec3> =
                    blend.iter().filter(|one| one.1 > 0.0).map(|one| point(one.0)).collect();
                match used[..] {
                    [a, b] => a.distance(b),
                    [a, b, c] => {
                        let sides = [a.distance(b), b.distance(c), c.distance(a)];
                        (b - a).cross(c - a).length() / sides.into_iter().fold(0.0, f64::max)
                    }
                    _ => f64::INFINITY,
                }
            }
            Shape::Space(space) => {
                space.blend(at, &mut cell.solid);
                let corners = space.tetrahedra.cells[cell.solid as usize].corners.map(point);
                let height = |k: usize| {
                    let [a, b, c] = [1, 2, 3].map(|step| corners[(k + step) % 4]);
                    let normal = (b - a).cross(c - a).normalize();
                    (corners[k] - a).dot(normal).abs()
                };
                (0..4).map(height).fold(f64::INFINITY, f64::min)
            }
        };
        least * self.grid.step
    }
}

/// f64, as a step may be less than f32 can tell.
fn light(weights: &Weights, values: &[f32]) -> f64 {
    weights
        .probes
        .iter()
        .zip(weights.weights)
        .map(|(&p, w)| f64::from(w) * f64::from(values[p as usize]))
        .sum()
}

/// Along random lines: shares, and no jumps.
fn continuous(what: &str, positions: &[Vec3], values: &[f32]) {
    let field = ProbeField::new(&transport(positions));
    let centre = positions.iter().sum::<Vec3>() / positions.len() as f32;
    let reach = positions.iter().map(|p| p.distance(centre)).fold(0.1, f32::max) * 1.5;
    let range =
        values.iter().fold(0.0_f32, |a, v| a.max(*v)) - values.iter().fold(f32::MAX, |a, v| a.min(*v));
    let mut next = noise(99);
    let mut cell = Cell::default();
    for _ in 0..400 {
        let mut random = || Vec3::new(next(), next(), next()) * 2.0 - 1.0;
        let (from, way) = (centre + random() * reach, random().normalize());
        for part in 0..20 {
            let at = from + way * (reach * 0.1 * (part as f32 + next()));
            let weights = field.weights(at, &mut cell);
            assert!(weights.weights.iter().all(|&w| w >= 0.0), "{what}: {weights:?}");
            assert!((weights.weights.iter().sum::<f32>() - 1.0).abs() <= 1e-6, "{what}: {weights:?}");
            // As large a step as the smaller of the cells at both ends allows.
            let height = field.height(at, &mut cell).min(f64::from(reach));
            let there = at + way * (1e-4 * height) as f32;
            let height = height.min(field.height(there, &mut cell));
            let change = |share: f64| {
                let end = at + way * (share * 1e-4 * height) as f32;
                (light(&field.weights(end, &mut Cell::default()), values) - light(&weights, values)).abs()
            };
            // What rounding the place to f32 changes on the way.
            let rounding = f64::from(f32::EPSILON * at.abs().max_element().max(1.0)) * 8.0 / height + 1e-6;
            assert!(change(1.0) <= (1e-3 + rounding) * f64::from(range), "{what} at {at}: {}", change(1.0));
            assert!(change(0.5) <= (0.5e-3 + rounding) * f64::from(range), "{what} at {at}: {}", change(0.5));
        }
    }
}

fn any_values(n: usize) -> Vec<f32> {
    let mut next = noise(7);
    (0..n).map(|_| next()).collect()
}

fn smooth_values(positions: &[Vec3]) -> Vec<f32> {
    positions.iter().map(|p| (1.1 * p.x + 0.3).sin() + (0.9 * p.y - 0.7 * p.z).cos()).collect()
}

#[test]
fn light_is_continuous_along_any_line() {
    let line = turned(boxes([7, 1, 1], 0.6));
    let sets = [
        ("one", vec![Vec3::ONE; 3]),
        ("two", vec![Vec3::ZERO, Vec3::new(1.0, 2.0, 0.5)]),
        ("collinear", line),
        ("coplanar", boxes([5, 4, 1], 0.8)),
        ("a box", boxes([2, 2, 2], 1.5)),
        ("4 x 4 x 4", boxes([4, 4, 4], 0.9)),
        ("two layers", boxes([6, 2, 6], 1.0)),
        ("four", random(4, 3)),
        ("random", random(60, 5)),
    ];
    for (what, positions) in &sets {
        continuous(what, positions, &any_values(positions.len()));
    }
}

/// Where probes are so close that a step passes between them, their light is alike.
#[test]
fn smooth_light_is_continuous_across_slivers() {
    let mut near = random(30, 11);
    near.extend(random(30, 11).iter().map(|p| *p + Vec3::splat(1e-6)));
    let sets = [
        ("a micrometre apart", near),
        ("turned", turned(boxes([5, 4, 3], 0.6))),
        ("turned plane", turned(boxes([5, 4, 1], 0.6))),
    ];
    for (what, positions) in &sets {
        continuous(what, positions, &smooth_values(positions));
    }
}

#[test]
fn a_probe_weighs_1_where_it_stands() {
    for positions in [vec![Vec3::ONE], boxes([4, 4, 4], 0.3), turned(boxes([4, 3, 1], 0.7)), random(50, 2)] {
        let field = ProbeField::new(&transport(&positions));
        for (index, &position) in positions.iter().enumerate() {
            let weights = field.weights(position, &mut Cell::default());
            let of = |k: usize| if weights.probes[k] == index as u32 { weights.weights[k] } else { 0.0 };
            assert!((0..4).map(of).sum::<f32>() > 1.0 - 1e-3, "{index}: {weights:?}");
        }
    }
}

#[test]
fn far_places_and_no_numbers_have_light() {
    for positions in [vec![Vec3::ONE], boxes([4, 4, 4], 0.3), boxes([4, 3, 1], 0.7), boxes([5, 1, 1], 0.7)] {
        let field = ProbeField::new(&transport(&positions));
        let mut cell = Cell::default();
        for far in [1e9, 1e20, f32::MAX] {
            for way in [Vec3::X, Vec3::new(0.6, -0.5, 0.4), Vec3::NEG_Y] {
                let weights = field.weights(way * far, &mut cell).weights;
                assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-6, "{far}: {weights:?}");
            }
        }
        let last = field.weights(Vec3::splat(0.4), &mut cell);
        assert_eq!(field.weights(Vec3::new(0.0, f32::NAN, 0.0), &mut cell), last);
        assert_eq!(field.weights(Vec3::splat(f32::INFINITY), &mut cell), last);
        assert!(!field.weights(Vec3::NAN, &mut Cell::default()).is_none());
    }
}

#[test]
fn invalid_probes_are_not_used_and_doubles_are_told() {
    let mut probes = transport(&[boxes([3, 3, 3], 1.0), boxes([2, 1, 1], 1.0)].concat());
    probes.probes[13].valid = 0.0;
    let field = ProbeField::new(&probes);
    assert_eq!(field.merged, [[27, 0], [28, 1]]);
    let mut cell = Cell::default();
    for at in random(300, 21) {
        let weights = field.weights(at * 0.5, &mut cell);
        assert!((0..4).all(|k| weights.probes[k] != 13 && weights.probes[k] < 27));
    }
    let none = ProbeField::new(&transport(&[]));
    assert!(none.weights(Vec3::ONE, &mut cell.clone()).is_none() || !cell.last.is_none());
    assert!(none.weights(Vec3::ONE, &mut Cell::default()).is_none());
}

#[test]
fn where_one_starts_to_walk_does_not_matter() {
    let field = ProbeField::new(&transport(&random(200, 31)));
    let mut walking = Cell::default();
    for at in random(500, 32) {
        let at = (at - 2.0) * 1.6 + 2.0;
        let (near, fresh) = (field.weights(at, &mut walking), field.weights(at, &mut Cell::default()));
        assert_eq!(light(&near, &any_values(200)), light(&fresh, &any_values(200)), "{at}");
    }
}

/// The slow plain twin of the walk: all tetrahedra and all faces of the hull.
#[test]
fn what_the_walk_finds_is_what_a_search_finds() {
    let positions = random(80, 41);
    let field = ProbeField::new(&transport(&positions));
    let values = smooth_values(&positions);
    let Shape::Space(space) = &field.shape else { panic!() };
    let cells = || 0..space.tetrahedra.cells.len() as u32;
    let value = |blend: Blend| -> f64 {
        blend.iter().map(|&(point, w)| w * f64::from(values[field.probes[point as usize] as usize])).sum()
    };
    let mut cell = Cell::default();
    for at in random(400, 42) {
        let at = (at - 2.0) * 1.8 + 2.0;
        let found = light(&field.weights(at, &mut cell), &values);
        let at = field.grid.at(at.as_dvec3());
        let holds = |cell: &u32, at| (0..4).all(|slot| space.tetrahedra.volume_with(*cell, slot, at) >= 0.0);
        let search = |at| cells().take(space.tetrahedra.solid).find(|cell| holds(cell, at));
        let outer = space.middle + (at - space.middle) / space.size;
        let point = |(point, weight): (u32, f64)| space.tetrahedra.points[point as usize] * weight;
        let at = search(outer).map_or_else(
            || {
                let faces = cells().skip(space.tetrahedra.solid).map(|ghost| space.on_face(outer, ghost));
                let (nearest, _) = faces.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
                let nearest: DVec3 = nearest.map(point).into_iter().sum();
                space.middle + (nearest - space.middle) * space.size
            },
            |_| at,
        );
        let wanted = value(space.inside(at, search(at).unwrap()));
        assert!((found - wanted).abs() < 1e-5, "{at}: {found} {wanted}");
    }
}
