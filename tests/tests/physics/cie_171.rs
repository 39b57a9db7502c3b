//! CIE 171:2006, test cases to assess the accuracy of lighting computer programs, as far as closed forms go. Its tables
//! are not copied (that of 5.7 is known to be wrong: Ashdown): every value is computed from configuration factors.
//! Light is in lumens here, which change nothing.
//!
//! Limits: a punctual light is exact to f32. A gather and a row of a meter may be off by 4 sigma of as many independent
//! rays, sqrt(F (1 - F) / N) of what the surface they look for gives off; the path tracer by 4 of its standard errors.

use std::f64::consts::PI;

use bake::{Irradiance, Method, Point};
use engine::scene::{Entity, LightKind, SkyKind};
use glam::{DVec3, Vec3};
use tests::closed_forms::{point_parallel, point_perpendicular};
use tests::lit::{BLACK, Lit, Paint, meter, point};
use tests::room::{Rectangle, light, walls};
use tests::surfaces::{Faces, face, quad};

const RAYS: u32 = 1 << 14;
const METHODS: [Method; 2] = [Method::Receivers, Method::Gather];
const UP: [f64; 3] = [0.0, 1.0, 0.0];
const DOWN: [f64; 3] = [0.0, -1.0, 0.0];
const RIGHT: [f64; 3] = [1.0, 0.0, 0.0];

/// All witnesses against configuration factors of surfaces with radiosity 1.
fn assert_factors(lit: &Lit, points: &[(Point, f64)], of: impl Fn(&Irradiance) -> f64) {
    let (points, wanted): (Vec<Point>, Vec<f64>) = points.iter().copied().unzip();
    for method in METHODS {
        for (found, wanted) in lit.query(&points, method).iter().zip(&wanted) {
            let limit = 4.0 * (wanted * (1.0 - wanted) / f64::from(RAYS)).sqrt();
            println!("{method:?}: {:.6}, {wanted:.6} wanted, limit {limit:.1e}", of(found));
            assert!((of(found) - wanted).abs() <= limit, "{method:?}: {}, not {wanted}", of(found));
        }
    }
    for (found, wanted) in lit.traced(&points, 1 << 13).iter().zip(&wanted) {
        let limit = 4.0 * found.standard_error.x;
        let found = of(&Irradiance { direct: found.direct, indirect: found.indirect });
        println!("path tracer: {found:.6}, {wanted:.6} wanted, limit {limit:.1e}");
        assert!((found - wanted).abs() <= limit, "path tracer: {found}, not {wanted}");
    }
}

fn room(low: Vec3, high: Vec3, paint: Paint) -> Vec<(&'static str, Faces, Paint)> {
    let names = ["-x", "+x", "-y", "+y", "-z", "+z"];
    names.into_iter().zip(walls(low, high)).map(|(name, wall)| (name, face(&wall), paint)).collect()
}

/// 5.2: a point source, the inverse square and the cosine.
#[test]
fn a_point_source_in_a_black_room_gives_the_inverse_square() {
    let (low, high) = (Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0));
    let lamp = DVec3::new(0.0, 2.99, 0.0);
    let intensity = 10_000.0 / (4.0 * PI);
    let lit = Lit::new(
        &room(low, high, BLACK),
        vec![light(50, LightKind::Point, intensity as f32, lamp, DVec3::ZERO)],
    );
    lit.bake(0.5, 256);
    let points: Vec<Point> = (0..8).map(|k| point([-1.75 + 0.5 * f64::from(k), 0.0, 0.3], UP)).collect();
    let found = METHODS.map(|method| lit.query(&points, method));
    for (k, traced) in lit.traced(&points, 16).iter().enumerate() {
        let way = lamp - points[k].position;
        let wanted = intensity * way.y / way.length().powi(3);
        for found in [found[0][k].direct.x, found[1][k].direct.x, traced.direct.x] {
            assert!((found / wanted - 1.0).abs() <= 2e-6, "{found}, not {wanted}");
        }
    }
}

/// 5.3: a diffuse luminaire of 1 m x 1 m in the ceiling.
#[test]
fn an_area_source_in_a_black_room_gives_its_configuration_factor() {
    let ceiling = quad(Vec3::new(-0.5, 3.0, -0.5), Vec3::X, Vec3::Z);
    let at = |x: f64, z: f64| {
        (point([x, 0.0, z], UP), point_parallel([-0.5 - x, 0.5 - x], [-0.5 - z, 0.5 - z], 3.0))
    };
    let points = [at(0.0, 0.0), at(0.5, 0.5), at(1.5, 0.25), at(-1.75, -1.75)];
    let meters: Faces = points.iter().flat_map(|(point, _)| meter(point, 0.02)).collect();
    let lit = Lit::new(
        &[("meters", meters, BLACK), ("lamp", ceiling, Paint { albedo: 0.0, exitance: 1.0 })],
        Vec::new(),
    );
    lit.bake(0.25, RAYS);
    assert_factors(&lit, &points, |found| found.direct.x);
}

/// 5.4: what a luminaire gives arrives on the walls, all of it.
#[test]
fn a_closed_room_receives_the_flux_of_its_lamp() {
    let (low, high) = (Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0));
    let (position, flux) = (DVec3::new(0.4, 1.7, -0.3), 10_000.0);
    let lamp = light(50, LightKind::Point, (flux / (4.0 * PI)) as f32, position, DVec3::ZERO);
    let lit = Lit::new(&room(low, high, BLACK), vec![lamp]);
    lit.bake(0.5, 256);
    let (points, areas) = grid(&walls(low, high), 8);
    let found = lit.query(&points, Method::Receivers);
    let received: f64 = found.iter().zip(&areas).map(|(found, area)| found.direct.x * area).sum();
    println!("{received:.2} lm of {flux}");
    assert!((received / flux - 1.0).abs() <= 1e-3, "{received} lm");
}

/// 4 m x 4 m at x 0..4, z -2..2 under a light from straight above that lights nothing else: radiosity 1, and black
/// meters about the points.
fn lit_floor(points: &[(Point, f64)], others: &[(&'static str, Faces, Paint)]) -> Lit {
    const ALBEDO: f32 = 0.8;
    let floor = quad(Vec3::new(0.0, 0.0, -2.0), Vec3::Z * 4.0, Vec3::X * 4.0);
    let meters: Faces = points.iter().flat_map(|(point, _)| meter(point, 0.02)).collect();
    let mut surfaces =
        vec![("floor", floor, Paint { albedo: ALBEDO, exitance: 0.0 }), ("meters", meters, BLACK)];
    surfaces.extend_from_slice(others);
    let mut sun: Entity = light(50, LightKind::Sun, 1.0 / ALBEDO, DVec3::Y, DVec3::ZERO);
    sun.light.as_mut().expect("a light").casts_shadows = false;
    let lit = Lit::new(&surfaces, vec![sun]);
    lit.bake(0.5, RAYS);
    lit
}

/// What a point of the wall x = 0 or of the ceiling sees of the floor between these x.
fn from_wall(height: f64, x: [f64; 2]) -> f64 {
    point_perpendicular(x, [-2.0, 2.0], height)
}

fn from_ceiling(at: f64, x: [f64; 2]) -> f64 {
    point_parallel([x[0] - at, x[1] - at], [-2.0, 2.0], 3.0)
}

/// 5.6: light reflected by a diffuse floor to the wall beside it and to the ceiling.
#[test]
fn light_reflected_by_a_floor_arrives_as_configuration_factors_say() {
    let on_wall =
        [0.5, 1.0, 2.0, 3.0].map(|y| (point([-0.001, y, 0.0], RIGHT), from_wall(y, [0.001, 4.001])));
    let on_ceiling = [0.5, 2.0, 3.5].map(|x| (point([x, 3.0, 0.0], DOWN), from_ceiling(x, [0.0, 4.0])));
    let points: Vec<(Point, f64)> = on_wall.into_iter().chain(on_ceiling).collect();
    assert_factors(&lit_floor(&points, &[]), &points, |found| found.indirect.x);
}

/// 5.7: the same with a black screen, 1 m high, across the middle of the floor: what it hides of the floor is a strip.
#[test]
fn light_reflected_past_a_screen_arrives_as_configuration_factors_say() {
    let plane = Rectangle { corner: Vec3::new(2.0, 0.0, -2.0), edges: [Vec3::Y, Vec3::Z * 4.0] };
    let screen = face(&plane);
    let on_wall = [0.5, 1.5, 2.5, 4.0].map(|y: f64| {
        let hidden_to = if y > 1.0 { (2.0 * y / (y - 1.0)).min(4.0) } else { 4.0 };
        let behind = if hidden_to < 4.0 { from_wall(y, [hidden_to, 4.0]) } else { 0.0 };
        (point([0.0, y, 0.0], RIGHT), from_wall(y, [0.0, 2.0]) + behind)
    });
    // A line over the screen's top, 2 m below the ceiling, reaches the floor 1.5 times as far from the point.
    let on_ceiling = [0.5, 1.0].map(|x: f64| {
        let hidden_to = x + 1.5 * (2.0 - x);
        (point([x, 3.0, 0.0], DOWN), from_ceiling(x, [0.0, 2.0]) + from_ceiling(x, [hidden_to, 4.0]))
    });
    let points: Vec<(Point, f64)> = on_wall.into_iter().chain(on_ceiling).collect();
    assert_factors(&lit_floor(&points, &[("screen", screen, BLACK)]), &points, |found| found.indirect.x);
}

/// 5.8: the mean illuminance by reflection in a cube of 4 m of one albedo, Phi rho / (A (1 - rho)).
#[test]
fn the_light_reflected_in_a_cube_is_on_average_what_its_flux_and_albedo_say() {
    let (low, high) = (Vec3::splat(-2.0), Vec3::splat(2.0));
    let flux = 10_000.0;
    let lamp = light(50, LightKind::Point, (flux / (4.0 * PI)) as f32, DVec3::ZERO, DVec3::Y);
    let lit = Lit::new(&room(low, high, BLACK), vec![lamp]);
    lit.bake(0.5, 4096);
    // An eighth of a wall stands for all of them: of 16 x 16 points those with i <= j < 8. Their mean is the wall's
    // within 0.02 %.
    const OF_POINTS: f64 = 2e-4;
    let (all, _) = grid(&walls(low, high)[..1], 8);
    let eighth = || (0..8).flat_map(|j| (0..=j).map(move |i| (i, j)));
    let points: Vec<Point> = eighth().map(|(i, j)| all[j * 16 + i]).collect();
    let weights: Vec<f64> = eighth().map(|(i, j)| if i == j { 1.0 / 64.0 } else { 2.0 / 64.0 }).collect();
    let mean = |values: &mut dyn Iterator<Item = f64>| values.zip(&weights).map(|(e, w)| e * w).sum::<f64>();
    for (albedo, wanted) in [(0.05, 5.48), (0.5, 104.17), (0.8, 416.67), (0.9, 937.5), (0.95, 1979.17)] {
        let exact = flux * albedo / (96.0 * (1.0 - albedo));
        assert!((exact / wanted - 1.0).abs() < 1e-3, "{exact}");
        lit.paint(&[Paint { albedo: albedo as f32, exitance: 0.0 }; 6]);
        // Patches hold one value over half a metre, and between receivers light is taken to be linear: at the edges of
        // a room it is neither. A gather reads that of its second bounce.
        for (method, limit) in [(Method::Receivers, 8e-3), (Method::Gather, 4e-3)] {
            let found = mean(&mut lit.query(&points, method).iter().map(|found| found.indirect.x));
            println!("albedo {albedo}, {method:?}: {found:.3} lx, {exact:.3} wanted");
            assert!(
                (found / exact - 1.0).abs() <= limit,
                "albedo {albedo}, {method:?}: {found}, not {exact}"
            );
        }
        let traced = lit.traced(&points, 512);
        let found = mean(&mut traced.iter().map(|point| point.indirect.x));
        let errors =
            traced.iter().zip(&weights).map(|(point, weight)| (point.standard_error.x * weight).powi(2));
        let error = errors.sum::<f64>().sqrt();
        println!("albedo {albedo}, path tracer: {found:.3} lx, error {error:.3}");
        assert!(
            (found - exact).abs() <= 4.0 * error + OF_POINTS * exact,
            "albedo {albedo}: {found}, not {exact}"
        );
    }
}

/// 5.9, with a sky that is alike all over: a black room under an opening in its roof.
#[test]
fn an_opening_in_a_roof_gives_the_skys_configuration_factor() {
    // 4 m x 4 m at 3 m, but for 1 m x 1 m about the middle.
    let part = |x: [f32; 2], z: [f32; 2]| {
        quad(Vec3::new(x[0], 3.0, z[0]), Vec3::X * (x[1] - x[0]), Vec3::Z * (z[1] - z[0]))
    };
    let mut roof = part([-2.0, 2.0], [-2.0, -0.5]);
    roof.extend(part([-2.0, 2.0], [0.5, 2.0]));
    roof.extend(part([-2.0, -0.5], [-0.5, 0.5]));
    roof.extend(part([0.5, 2.0], [-0.5, 0.5]));
    let (low, high) = (Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 3.0, 2.0));
    let mut surfaces: Vec<_> = room(low, high, BLACK).into_iter().filter(|wall| wall.0 != "+y").collect();
    surfaces.push(("roof", roof, BLACK));
    let lit = Lit::new(&surfaces, Vec::new());
    lit.change(|scene| {
        scene.sky.kind = SkyKind::Constant { radiance: Vec3::splat(1.0 / std::f32::consts::PI) }
    });
    lit.bake(0.5, RAYS);
    let at = |x: f64, z: f64| {
        (point([x, 0.0, z], UP), point_parallel([-0.5 - x, 0.5 - x], [-0.5 - z, 0.5 - z], 3.0))
    };
    assert_factors(&lit, &[at(0.0, 0.0), at(0.5, 0.5), at(1.5, 0.5), at(-1.5, 1.5)], |found| found.direct.x);
}

/// Gauss's points of so many cells a side on rectangles (two by two in each), and the area that each stands for.
fn grid(rectangles: &[Rectangle], cells: u32) -> (Vec<Point>, Vec<f64>) {
    let place = |k: u32| {
        let within = 0.5 + (f64::from(k % 2) - 0.5) / 3.0_f64.sqrt();
        ((f64::from(k / 2) + within) / f64::from(cells)) as f32
    };
    let (mut points, mut areas) = (Vec::new(), Vec::new());
    for rectangle in rectangles {
        for k in 0..4 * cells * cells {
            let position = rectangle.at(place(k % (2 * cells)), place(k / (2 * cells))).as_dvec3();
            points.push(Point { position, normal: rectangle.normal().as_dvec3() });
            areas.push(f64::from(rectangle.area()) / f64::from(4 * cells * cells));
        }
    }
    (points, areas)
}
