//! Light probes of real bakes: any set of them, anywhere asked, in walls, beside a spark, in a furnace.

use std::f64::consts::PI;

use engine::scene::{Entity, EntityId, LightProbeGroup};
use engine::transport::dering::dering;
use engine::transport::probe_field::{Cell, ProbeField};
use engine::transport::sh::{self, COEFFICIENTS};
use engine::transport::solve::gather;
use glam::{DVec3, Vec3};
use tests::project::TestProject;
use tests::room::directions;
use tests::solved::{Solved, WALLS, block, change, paint, rectangle, settings, shell};
use tests::surfaces;

/// A room 4 m wide that one wall lights, with these probes.
fn room(probes: &[Vec3]) -> TestProject {
    let project = surfaces::project(&shell(Vec3::ZERO, Vec3::splat(4.0), WALLS));
    paint(&project, |name, material| {
        material.albedo.color = Vec3::splat(0.5);
        material.emission.color = Vec3::splat(if name == "-x" { 1.0 } else { 0.0 });
    });
    place(&project, probes);
    project
}

fn place(project: &TestProject, probes: &[Vec3]) {
    let light_probes = Some(LightProbeGroup { positions: probes.to_vec() });
    let id = EntityId(500);
    change(project, |scene| scene.entities.push(Entity { id, light_probes, ..Entity::default() }));
}

/// Radiance, as harmonics, by probe.
fn harmonics(light: &Solved) -> Vec<[DVec3; COEFFICIENTS]> {
    let all = gather(&light.transport.probe_from_patch, &light.radiosity);
    all.chunks_exact(COEFFICIENTS).map(|of| std::array::from_fn(|k| of[k])).collect()
}

/// Probes with their light: the mean radiance of each.
struct Field {
    field: ProbeField,
    origin: Vec3,
    light: Vec<f64>,
}

impl Field {
    fn of(light: &Solved) -> Self {
        let mean = |l: &[DVec3; COEFFICIENTS]| l[0].x * f64::from(sh::basis(Vec3::X)[0]);
        Self {
            field: ProbeField::new(&light.transport),
            origin: light.transport.origin.as_vec3(),
            light: harmonics(light).iter().map(mean).collect(),
        }
    }

    /// Weights are shares.
    fn at(&self, point: Vec3, cell: &mut Cell) -> f64 {
        let weights = self.field.weights(point - self.origin, cell);
        let sum: f32 = weights.weights.iter().sum();
        assert!(
            weights.weights.iter().all(|&weight| weight >= 0.0) && (sum - 1.0).abs() <= 1e-6,
            "{weights:?}"
        );
        let shares = weights.probes.iter().zip(weights.weights);
        shares.map(|(&probe, weight)| self.light[probe as usize] * f64::from(weight)).sum()
    }

    fn range(&self) -> f64 {
        let (low, high) =
            self.light.iter().fold((f64::MAX, f64::MIN), |(low, high), &l| (low.min(l), high.max(l)));
        high - low
    }

    /// The largest change of light from step to step along a line, as a share of the range of all light.
    fn jump(&self, from: Vec3, way: Vec3, step: f32, steps: u32) -> f64 {
        let mut cell = Cell::default();
        let light: Vec<f64> =
            (0..=steps).map(|k| self.at(from + way * (k as f32 * step), &mut cell)).collect();
        let jump = light.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        jump / self.range().max(f64::MIN_POSITIVE)
    }
}

fn grid(counts: [u32; 3], step: f32) -> Vec<Vec3> {
    let [x, y, z] = counts;
    let at = |k: u32| Vec3::new((k % x) as f32, (k / x % y) as f32, (k / (x * y)) as f32);
    (0..x * y * z).map(|k| Vec3::splat(0.5) + at(k) * step).collect()
}

// ---- case 48

#[test]
fn any_set_of_probes_gives_shares_and_light_without_jumps() {
    let near = Vec3::splat(1e-6);
    let mut twins = grid([2, 2, 2], 2.5);
    twins.push(twins[3]);
    let mut close = grid([2, 2, 2], 2.5);
    close.push(close[0] + near);
    let some = |n: usize| grid([2, 2, 2], 2.5)[..n].to_vec();
    // With the least height of their cells: of a corner of a cube it is its side over the root of 3.
    let corner = 2.5 / 3.0_f32.sqrt();
    let sets: [(&str, Vec<Vec3>, f32); 8] = [
        ("one", some(1), f32::INFINITY),
        ("two", some(2), 2.5),
        ("on a line", grid([4, 1, 1], 1.0), 1.0),
        ("in a plane", grid([3, 3, 1], 1.25), 1.25 / 2.0_f32.sqrt()),
        ("doubled", twins, corner),
        ("a micrometre apart", close, 0.0),
        ("on one sphere", grid([4, 4, 4], 1.0), 1.0 / 3.0_f32.sqrt()),
        (
            "of no order",
            vec![
                Vec3::new(0.5, 0.75, 0.5),
                Vec3::new(3.5, 0.5, 0.75),
                Vec3::new(1.5, 3.25, 1.0),
                Vec3::new(2.0, 1.0, 3.5),
            ],
            1.5,
        ),
    ];
    for (name, probes, height) in sets {
        let light = Solved::of(&room(&probes), &settings(1.0, 256));
        let field = Field::of(&light);
        let way = Vec3::new(0.8, 0.48, 0.36);
        let lines =
            [(Vec3::splat(0.01), way), (Vec3::new(0.2, 3.9, 1.1), Vec3::NEG_Y), (Vec3::splat(0.5), Vec3::X)];
        if height.is_infinite() {
            let all = field.jump(lines[0].0, way, 0.1, 50);
            assert_eq!(all, 0.0, "{name}: one probe is the same everywhere");
            continue;
        }
        // A micrometre between two probes is not less than what floats part in this room: they count as one, or
        // the light between them is steep. Either way it does not jump by more than between any two probes.
        let step = if height > 0.0 { 1e-4 * height } else { 1e-4 };
        for (from, way) in lines {
            let steps = (3.0 / step) as u32;
            let whole = field.jump(from, way, step, steps);
            let half = field.jump(from, way, 0.5 * step, 2 * steps);
            println!("{name}: a step changes {whole:.1e}, half of it {half:.1e}");
            if height > 0.0 {
                assert!(whole <= 1e-3 && half <= 0.55 * whole + 2e-7, "{name}: {whole} {half}");
            } else {
                assert!(whole <= 1e-3, "{name}: {whole}");
            }
        }
    }
    let none = Solved::of(&room(&[]), &settings(1.0, 64));
    assert!(ProbeField::new(&none.transport).weights(Vec3::ONE, &mut Cell::default()).is_none());
}

// ---- case 49

#[test]
fn a_place_may_be_a_probe_a_million_kilometres_away_or_no_number() {
    let probes = grid([3, 3, 3], 1.25);
    let light = Solved::of(&room(&probes), &settings(1.0, 256));
    let field = Field::of(&light);
    // The hull is taken 32 steps of 2^-21 smaller than it is, so that no rounding makes it hollow: at a corner that is
    // as many steps of half the grid in each of three weights. Inside, a probe weighs 1.
    let bound = 3.0 * 32.0 / 2.0_f32.powi(20) * 1.01;
    for (index, &probe) in probes.iter().enumerate() {
        let weights = field.field.weights(probe - field.origin, &mut Cell::default());
        let own = (0..4).filter(|&k| weights.probes[k] == index as u32).map(|k| weights.weights[k]);
        let off = 1.0 - own.sum::<f32>();
        assert!(off <= bound && (index != 13 || off <= 1e-6), "{index}: {weights:?}");
    }
    let mut cell = Cell::default();
    let (low, high) = field.light.iter().fold((f64::MAX, 0.0_f64), |(l, h), &x| (l.min(x), h.max(x)));
    for far in directions(40).map(|way| way * 1e9).chain([Vec3::MAX, Vec3::MIN]) {
        let light = field.at(far, &mut cell);
        assert!((low * 0.999_999..=high * 1.000_001).contains(&light), "{far}: {light}");
    }
    // The hull's nearest point, wherever the way there starts.
    let corner = field.at(Vec3::splat(-1e9), &mut Cell::default());
    assert!((corner - field.light[0]).abs() < f64::from(bound) * high);

    let here = Vec3::new(1.1, 2.3, 0.9) - field.origin;
    let last = field.field.weights(here, &mut cell);
    for wrong in [Vec3::NAN, Vec3::new(1.0, f32::INFINITY, 0.0), Vec3::NEG_INFINITY] {
        assert_eq!(field.field.weights(wrong, &mut cell), last, "{wrong}");
        // Of one that never was anywhere, it is some light all the same.
        let fresh = field.field.weights(wrong, &mut Cell::default());
        assert!((fresh.weights.iter().sum::<f32>() - 1.0).abs() < 1e-6, "{fresh:?}");
    }
}

// ---- case 50

#[test]
fn a_probe_in_a_wall_is_told_and_used_by_nothing() {
    let mut surfaces = shell(Vec3::ZERO, Vec3::splat(4.0), WALLS);
    surfaces.push(("wall", block(Vec3::new(1.5, 0.5, 1.5), Vec3::new(2.5, 3.5, 2.5))));
    let project = surfaces::project(&surfaces);
    // All glows and reflects alike: what is seen is the same from everywhere.
    paint(&project, |_, material| {
        material.albedo.color = Vec3::splat(0.5);
        material.emission.color = Vec3::splat(0.5);
    });
    let mut probes = grid([2, 2, 2], 3.0);
    probes.push(Vec3::splat(2.0));
    place(&project, &probes);
    let light = Solved::of(&project, &settings(1.0, 512));
    let valid: Vec<f32> = light.transport.probes.iter().map(|probe| probe.valid).collect();
    assert_eq!(valid, [vec![1.0; 8], vec![0.0]].concat());
    let told = &light.transport.certificate.left_out;
    assert!(told.iter().any(|line| line.contains("inside solids")), "{told:?}");
    let field = Field::of(&light);
    let mut cell = Cell::default();
    for k in 0..=40 {
        let point = Vec3::splat(0.1 * k as f32);
        let weights = field.field.weights(point - field.origin, &mut cell);
        assert!((0..4).all(|k| weights.weights[k] == 0.0 || weights.probes[k] != 8), "{weights:?}");
        let radiance = field.at(point, &mut cell);
        assert!((radiance - 1.0).abs() < 1e-3, "{point}: {radiance}");
    }
}

// ---- case 51

#[test]
fn a_tiny_bright_patch_rings_nowhere_below_nothing() {
    let mut surfaces = shell(Vec3::ZERO, Vec3::splat(4.0), WALLS);
    surfaces.push(("spark", rectangle(Vec3::new(2.0, 3.9, 2.0), Vec3::X * 0.02, Vec3::Z * 0.02)));
    let project = surfaces::project(&surfaces);
    paint(&project, |name, material| {
        material.albedo.color = Vec3::ZERO;
        material.emission.color = Vec3::splat(if name == "spark" { 1e6 } else { 0.0 });
        material.emission.sampled = name == "spark";
    });
    place(&project, &[Vec3::new(1.0, 1.0, 1.5), Vec3::new(2.0, 2.0, 2.0), Vec3::new(3.5, 0.2, 3.0)]);
    let light = Solved::of(&project, &settings(1.0, 256));
    for l in harmonics(&light) {
        let before = l.map(|l| l.as_vec3());
        let mut l = before;
        let mean = sh::COSINE[0] * sh::basis(Vec3::X)[0] * before[0].x;
        let least = |l: &[Vec3; COEFFICIENTS]| {
            directions(642).map(|n| sh::irradiance(l, n).x / mean).fold(f32::INFINITY, f32::min)
        };
        assert!(mean > 0.0 && least(&before) < -0.05, "it rings: {}", least(&before));
        dering(&mut l);
        println!("least irradiance {:.3} of the mean, {:.1e} when windowed", least(&before), least(&l));
        assert!(least(&l) >= 0.0, "{}", least(&l));
        assert_eq!(l[0], before[0], "the mean stays");
    }
}

// ---- case 52

#[test]
fn in_a_furnace_a_probe_has_the_furnaces_radiance_and_nothing_else() {
    let (albedo, glow) = (0.8, 0.25);
    let project = surfaces::project(&shell(Vec3::ZERO, Vec3::splat(4.0), WALLS));
    paint(&project, |_, material| {
        material.albedo.color = Vec3::splat(albedo);
        material.emission.color = Vec3::splat(glow);
    });
    place(&project, &[Vec3::splat(2.0), Vec3::new(0.3, 3.8, 1.0)]);
    let light = Solved::of(&project, &settings(1.0, 512));
    let radiance = f64::from(glow) / (1.0 - f64::from(albedo));
    for l in harmonics(&light) {
        // Every ray brings the same: band 0 has no noise.
        let mean = l[0].x / (2.0 * PI.sqrt() * radiance) - 1.0;
        // Of independent rays sigma is sqrt(4 pi / R) L, with R = 4096.
        let sigma = (4.0 * PI / 4096.0).sqrt() * radiance;
        let other = l[1..].iter().map(|l| l.x.abs() / sigma).fold(0.0, f64::max);
        println!("mean {mean:+.1e}, other bands {other:.3} sigma");
        assert!(mean.abs() < 1e-5 && other <= 4.0, "{mean} {other}");
        // E(n) = pi L: the bands' sigmas, each with its share of the cosine.
        let single = l.map(|l| l.as_vec3());
        let share: f64 = sh::COSINE[1..].iter().map(|a| f64::from(a * a)).sum::<f64>() / (4.0 * PI);
        for n in directions(100) {
            let off = f64::from(sh::irradiance(&single, n).x) - PI * radiance;
            assert!(off.abs() <= 4.0 * share.sqrt() * sigma, "{n}: {off}");
        }
    }
}
