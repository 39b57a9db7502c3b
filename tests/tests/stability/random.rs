//! What holds of any room: drawn by lot, the same in every run, and made smaller until the least that fails is left.

use std::f64::consts::PI;

use engine::scene::{LightKind, SkyKind};
use engine::transport::solve::exact;
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use tests::project::TestProject;
use tests::room::light;
use tests::solved::{Solved, WALLS, apart, block, change, largest, paint, settings, shell};
use tests::surfaces::{self, Faces, entities, form_factor};

/// The same seed in every run.
fn seeded(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(0x0480_1a0f),
        failure_persistence: None,
        max_shrink_iters: 64,
        ..ProptestConfig::default()
    }
}

/// A room of whole quarters of a metre with blocks in it; without a ceiling under a sky.
#[derive(Clone, Debug)]
struct Room {
    /// Quarters of a metre, along x, y, z.
    size: [u8; 3],
    /// Low corner and size, as shares of what is free.
    blocks: Vec<[u8; 6]>,
    /// By surface, cyclic: albedo and emitted radiance.
    paints: Vec<([f32; 3], [f32; 3])>,
    /// Where a lamp hangs, in eighths of the room.
    lamp: Option<[u8; 3]>,
    open: bool,
}

const UNIT: f32 = 0.25;

fn rooms(open: bool) -> impl Strategy<Value = Room> {
    let block = prop::array::uniform6(0_u8..=3);
    let color = |most: f32| prop::array::uniform3((0_u8..=8).prop_map(move |k| most * f32::from(k) / 8.0));
    let paint = (color(0.96), prop_oneof![2 => Just([0.0; 3]), 1 => color(4.0)]);
    let lamp = prop::option::of(prop::array::uniform3(1_u8..=7));
    let (blocks, paints) = (prop::collection::vec(block, 0..3), prop::collection::vec(paint, 1..6));
    (prop::array::uniform3(3_u8..=8), blocks, paints, lamp)
        .prop_map(move |(size, blocks, paints, lamp)| Room { size, blocks, paints, lamp, open })
}

impl Room {
    fn high(&self) -> Vec3 {
        Vec3::from(self.size.map(|side| f32::from(side) * UNIT))
    }

    /// Between a quarter of the room's corner and its middle, or from there on: no two overlap.
    fn block(&self, index: usize) -> Faces {
        let (high, [x, y, z, w, h, d]) = (self.high(), self.blocks[index].map(f32::from));
        let start = Vec3::new(if index == 0 { 0.125 } else { 0.5625 }, 0.0, 0.125);
        let low = start + Vec3::new(x * 0.03125, y * 0.0625, z * 0.0625);
        let size = Vec3::new(0.125 + w * 0.0625, 0.125 + h * 0.125, 0.125 + d * 0.125);
        let mut faces = block(low * high, (low + size) * high);
        if y == 0.0 {
            faces.remove(2); // what stands on the floor has no face in it
        }
        faces
    }

    fn surfaces(&self) -> Vec<(&'static str, Faces)> {
        let mut all = shell(Vec3::ZERO, self.high(), WALLS);
        if self.open {
            all.retain(|(name, _)| *name != "+y");
        }
        all.extend((0..self.blocks.len()).map(|index| (["block a", "block b"][index], self.block(index))));
        all
    }

    fn project(&self) -> TestProject {
        self.project_of(&self.surfaces())
    }

    fn project_of(&self, surfaces: &[(&str, Faces)]) -> TestProject {
        let project = surfaces::project(surfaces);
        let names: Vec<&str> = self.surfaces().iter().map(|(name, _)| *name).collect();
        paint(&project, |name, material| {
            let at = names.iter().position(|other| *other == name).unwrap_or(0);
            let (albedo, glow) = self.paints[at % self.paints.len()];
            material.albedo.color = Vec3::from(albedo);
            material.emission.color = Vec3::from(glow);
        });
        if let Some(lamp) = self.lamp {
            let at = (Vec3::from(lamp.map(f32::from)) / 8.0 * self.high()).as_dvec3();
            change(&project, |scene| {
                scene.entities.push(light(900, LightKind::Point, 1.0, at, DVec3::ZERO));
            });
        }
        if self.open {
            change(&project, |scene| {
                scene.sky.kind = SkyKind::Constant { radiance: Vec3::new(0.5, 0.75, 1.0) }
            });
        }
        project
    }

    fn solved(&self) -> Solved {
        Solved::of(&self.project(), &settings(0.5, RAYS))
    }
}

const RAYS: u32 = 128;

/// Of a row: to sky and patches; of all light that leaves: what is kept.
fn assert_rows(light: &Solved) -> Result<(), TestCaseError> {
    let (rows, n) = (&light.transport.patch_from_patch, light.patches());
    let exchange = |i: usize, j: usize| {
        let entry = rows.row(i).find(|entry| entry.0 as usize == j);
        light.area(i) * entry.map_or(0.0, |entry| f64::from(entry.1))
    };
    let mut most = 0.0_f64;
    for (i, patch) in light.transport.patches.iter().enumerate() {
        let (sum, target) = (rows.sum(i), f64::from(patch.target));
        prop_assert!(sum <= target && sum >= target - 2e-7 && target <= 1.0, "row {i}: {sum} of {target}");
        most = rows.row(i).map(|(_, share)| light.area(i) * f64::from(share)).fold(most, f64::max);
    }
    for i in 0..n {
        for (j, share) in rows.row(i).filter(|&(j, _)| (j as usize) < n) {
            let there = light.area(i) * f64::from(share);
            let back = exchange(j as usize, i);
            prop_assert!((there - back).abs() <= 1e-6 * most, "{i} to {j}: {there:e}, back {back:e}");
        }
    }
    Ok(())
}

fn assert_light(light: &Solved) -> Result<(), TestCaseError> {
    for (b, e) in light.b().iter().zip(&light.exitance) {
        // What rounding of the solution leaves.
        let slack = 1e-9 * largest(light.b());
        prop_assert!(b.is_finite() && (*b - *e).min_element() >= -slack, "B {b} is below E {e}");
    }
    let [gone, given] = light.balance();
    prop_assert!((gone - given).abs().max_element() <= 1e-4 * given.max_element(), "{gone} of {given}");
    Ok(())
}

/// The solution for another E or another albedo over the same rows.
fn solved(light: &Solved, albedo: &[Vec3], e: &[DVec3]) -> Vec<DVec3> {
    exact(&tests::solved::system(&light.transport, albedo), e, 1e-12)
}

proptest! {
    #![proptest_config(seeded(24))]

    #[test]
    fn rows_close_are_reciprocal_and_no_light_is_made_or_lost_in_closed_rooms(room in rooms(false)) {
        let light = room.solved();
        assert_rows(&light)?;
        assert_light(&light)?;
        prop_assert_eq!(light.transport.certificate.escaped, 0.0);
    }

    #[test]
    fn rows_close_are_reciprocal_and_no_light_is_made_or_lost_under_the_sky(room in rooms(true)) {
        let light = room.solved();
        assert_rows(&light)?;
        assert_light(&light)?;
        prop_assert!(light.transport.certificate.escaped > 0.0);
        // Nothing in a room without lamps is brighter than the sky over white walls.
        let sky = vec![Vec3::ONE; light.patches()];
        let h = engine::transport::solve::gather(&light.transport.patch_from_patch, &sky_alone(&light));
        let b = solved(&light, &sky, &h);
        prop_assert!(b.iter().all(|b| b.max_element() <= PI * 1.0001), "{}", largest(&b));
    }

    #[test]
    fn light_adds_up_and_grows_with_what_is_given_and_reflected(
        room in rooms(true),
        share in 0.0_f64..1.0,
        darker in 0.0_f32..1.0,
    ) {
        let light = room.solved();
        let (albedo, e) = (&light.materials.albedo, &light.exitance);
        let scale = largest(light.b()).max(f64::MIN_POSITIVE);
        // Two parts, each of which shines where the other does not.
        let part = |which: usize| -> Vec<DVec3> {
            let of = |(i, e): (usize, &DVec3)| if i % 3 == which { *e * share } else { *e * (1.0 - share) };
            e.iter().enumerate().map(of).collect()
        };
        let rest: Vec<DVec3> = e.iter().zip(part(1)).map(|(e, part)| *e - part).collect();
        let sum: Vec<DVec3> = solved(&light, albedo, &part(1)).iter()
            .zip(solved(&light, albedo, &rest)).map(|(a, b)| *a + b).collect();
        prop_assert!(apart(&sum, light.b()) <= 1e-8 * scale, "superposition: {:e}", apart(&sum, light.b()));
        let below = |less: &[DVec3]| {
            less.iter().zip(light.b()).all(|(less, b)| (*b - *less).min_element() >= -1e-8 * scale)
        };
        prop_assert!(below(&solved(&light, albedo, &part(1))), "less is given");
        let darker: Vec<Vec3> = albedo.iter().map(|albedo| *albedo * darker).collect();
        prop_assert!(below(&solved(&light, &darker, e)), "less is reflected");
    }
}

/// By column: the sky's share of light alone, of radiance 1.
fn sky_alone(light: &Solved) -> Vec<DVec3> {
    let mut values = vec![DVec3::ZERO; light.transport.columns()];
    values[light.patches()..].fill(DVec3::splat(PI));
    values
}

/// The most that two bakes differ in a form factor between entities, in sigmas of as many independent rays: of the
/// smaller patch's own, as both directions are pooled.
fn sigmas_apart(a: &Solved, b: &Solved) -> f64 {
    let of = entities(&a.transport);
    let entity_count = of.iter().copied().max().unwrap_or(0);
    let rays = |entity: u64| f64::from(RAYS) * of.iter().filter(|&&other| other == entity).count() as f64;
    let mut worst = 0.0_f64;
    for from in 1..=entity_count {
        for to in (1..=entity_count).filter(|&to| to != from) {
            let [f, g] = [a, b].map(|light| form_factor(&light.transport, from, to));
            let mean = 0.5 * (f + g);
            // A count of N rays has a sigma of its root; what chance finds once in all is no measure.
            let sigma = (2.0 * mean * (1.0 - mean).max(0.0) / rays(from)).sqrt() + 1.0 / rays(from);
            worst = worst.max((f - g).abs() / sigma);
        }
    }
    worst
}

fn mapped(
    surfaces: &[(&'static str, Faces)],
    map: impl Fn(Vec3) -> Vec3,
    turn: bool,
) -> Vec<(&'static str, Faces)> {
    let face = |face: &Vec<Vec3>| -> Vec<Vec3> {
        let mut corners: Vec<Vec3> = face.iter().map(|&corner| map(corner)).collect();
        if turn {
            corners.reverse();
        }
        corners
    };
    surfaces.iter().map(|(name, faces)| (*name, faces.iter().map(face).collect())).collect()
}

/// Sides of a rectangle cut in two triangles, along one diagonal or the other, or with a corner more.
fn split(surfaces: &[(&'static str, Faces)], how: u8) -> Vec<(&'static str, Faces)> {
    let cut = |face: &Vec<Vec3>| -> Faces {
        let [a, b, c, d] = face[..] else { return vec![face.clone()] };
        let middle = (a + c) * 0.5;
        match how {
            0 => vec![vec![a, b, c], vec![a, c, d]],
            1 => vec![vec![b, c, d], vec![b, d, a]],
            _ => vec![vec![a, b, middle], vec![b, c, middle], vec![c, d, middle], vec![d, a, middle]],
        }
    };
    surfaces.iter().map(|(name, faces)| (*name, faces.iter().flat_map(cut).collect())).collect()
}

proptest! {
    #![proptest_config(seeded(16))]

    #[test]
    fn a_scene_scaled_by_a_power_of_two_has_the_same_light_to_the_last_bit(room in rooms(true), k in -10_i32..=10) {
        let plain = room.solved();
        let project = room.project();
        let factor = f64::from(k).exp2();
        change(&project, |scene| {
            for entity in &mut scene.entities {
                entity.transform.scale *= factor;
                entity.transform.translation *= factor;
                entity.light.iter_mut().for_each(|light| light.intensity *= (factor * factor) as f32);
            }
        });
        let scaled = Solved::of(&project, &settings(0.5 * factor, RAYS));
        prop_assert_eq!(&scaled.transport.patch_from_patch, &plain.transport.patch_from_patch);
        prop_assert_eq!(&scaled.transport.receiver_from_patch, &plain.transport.receiver_from_patch);
        prop_assert_eq!(&scaled.radiosity, &plain.radiosity);
        for (a, b) in plain.transport.patches.iter().zip(&scaled.transport.patches) {
            prop_assert_eq!(f64::from(a.area) * factor * factor, f64::from(b.area));
        }
    }

    /// Statistical: other places give other random shifts, and a division turned is another division.
    #[test]
    fn a_room_that_is_turned_or_mirrored_has_the_same_form_factors_within_their_noise(room in rooms(false)) {
        let plain = room.solved();
        let surfaces = room.surfaces();
        let turned = mapped(&surfaces, |p| Vec3::new(p.z, p.y, -p.x), false);
        let mirrored = mapped(&surfaces, |p| Vec3::new(-p.x, p.y, p.z), true);
        for (what, surfaces) in [("turned", turned), ("mirrored", mirrored)] {
            let other = Solved::of(&room.project_of(&surfaces), &settings(0.5, RAYS));
            let sigmas = sigmas_apart(&plain, &other);
            prop_assert!(sigmas <= 4.0, "{what}: {sigmas} sigma");
        }
    }

    /// A division follows the surface: into which triangles it was cut changes where patches lie, but not what
    /// surfaces exchange, within the noise of their rays.
    #[test]
    fn cutting_faces_into_other_triangles_changes_no_form_factor_beyond_its_noise(room in rooms(false), how in 0_u8..3) {
        let plain = room.solved();
        let other = Solved::of(&room.project_of(&split(&room.surfaces(), how)), &settings(0.5, RAYS));
        let area = |light: &Solved| (0..light.patches()).map(|i| light.area(i)).sum::<f64>();
        prop_assert!((area(&plain) / area(&other) - 1.0).abs() < 1e-6);
        let sigmas = sigmas_apart(&plain, &other);
        prop_assert!(sigmas <= 4.0, "{sigmas} sigma");
    }
}
