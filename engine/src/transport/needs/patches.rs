//! Patches that hold no light: black ones, and those in rooms that no source reaches. Their radiosity is 0 whatever else
//! shines, so that neither their rows nor the columns by which others read them do anything.

use glam::Vec3;
use rayon::prelude::*;

use super::look::{Look, entities, told};
use super::saving::{RowSizes, VECTOR};
use super::sources::{emits, lights, sky_shines, sources};
use super::{Finding, Saving};
use crate::scene::{EntityId, Light, Material};
use crate::transport::bvh::{Bvh, Holes};
use crate::transport::direct::{PlacedLight, extent, placed_lights};
use crate::transport::{NONE, Rows, Sample, Transport};

/// Each patch reflects or emits: none is black.
pub fn black_patches(look: &Look<'_>) -> Finding {
    if let Some(black) = black(look) {
        return left_out(look, &black, "black", "every patch reflects or emits");
    }
    let black = look.still().filter(|drawn| {
        let mut materials = look.materials_of(*drawn).peekable();
        materials.peek().is_some() && materials.all(is_black)
    });
    let (names, ids) = entities(&black.collect::<Vec<_>>());
    if ids.is_empty() {
        return Finding::needed("no static surface is all black", Vec::new());
    }
    Finding::not_needed(format!("black: {names}")).led_to(ids)
}

/// By patch: it reflects and emits nothing. None before the bake.
pub fn black(look: &Look<'_>) -> Option<Vec<bool>> {
    let materials = look.patch_materials()?;
    let both = materials.albedo.iter().zip(&materials.exitance);
    Some(both.map(|(&albedo, &exitance)| albedo == Vec3::ZERO && exitance == Vec3::ZERO).collect())
}

/// Whatever its pictures show.
fn is_black(material: &Material) -> bool {
    let metal = material.metallic >= 1.0 && material.metallic_roughness_texture.is_none();
    material.unlit || !emits(material) && (material.albedo.color == Vec3::ZERO || metal)
}

/// Some light, emitter or the sky reaches every patch's room.
pub fn unlit_patches(look: &Look<'_>) -> Finding {
    if let Some(unlit) = unlit(look) {
        return left_out(look, &unlit, "where no light comes to", "light comes to every room");
    }
    if sources(look).is_empty() {
        return Finding::not_needed("nothing shines");
    }
    Finding::needed("the bake will tell where light comes to", Vec::new())
}

/// By patch: it is of a component that no source reaches, each light taken as on. None before the bake.
///
/// A light that moves counts as reaching everything. A light's way is free where rays of the renderer find it free, and
/// also through what has holes or casts no shadow.
pub fn unlit(look: &Look<'_>) -> Option<Vec<bool>> {
    let (transport, materials) = (look.transport?, look.patch_materials()?);
    let components = transport.patches.iter().map(|patch| patch.component as usize + 1).max().unwrap_or(0);
    let mut lit = vec![false; components];
    for (i, patch) in transport.patches.iter().enumerate() {
        let sees_sky = || {
            sky_shines(look)
                && transport
                    .patch_from_patch
                    .row(i)
                    .any(|(column, weight)| column as usize >= transport.patches.len() && weight > 0.0)
        };
        let component = &mut lit[patch.component as usize];
        *component = *component || materials.exitance[i] != Vec3::ZERO || sees_sky();
    }
    if lights(look).any(|(index, ..)| look.carried[index]) {
        lit.fill(true);
    }
    if lit.contains(&false) {
        reach(look, transport, &mut lit);
    }
    Some(transport.patches.iter().map(|patch| !lit[patch.component as usize]).collect())
}

/// Marks components that a light reaches, each by the first of its samples that one is seen from.
fn reach(look: &Look<'_>, transport: &Transport, lit: &mut [bool]) {
    let lights = shining(look, transport);
    if lights.is_empty() {
        return;
    }
    let (bvh, open) = blockers(look, transport);
    let extent = extent(transport);
    let reached = |sample: &Sample| {
        lights.iter().any(|placed| {
            placed.irradiance(sample.position, sample.normal, 0.0) != Vec3::ZERO
                && (!placed.light.casts_shadows
                    || bvh.visible(
                        sample.position,
                        sample.normal,
                        placed.end(sample.position, extent),
                        0.0,
                        &open,
                    ))
        })
    };
    let mut samples: Vec<Vec<&Sample>> = vec![Vec::new(); lit.len()];
    for sample in &transport.samples {
        samples[transport.patches[sample.patch as usize].component as usize].push(sample);
    }
    let dark = lit.par_iter_mut().zip(samples).filter(|(lit, _)| !**lit);
    dark.for_each(|(lit, samples)| *lit = samples.into_par_iter().any(reached));
}

/// Those that may shine, at full brightness.
fn shining(look: &Look<'_>, transport: &Transport) -> Vec<PlacedLight> {
    let may: Vec<EntityId> = lights(look).map(|(_, entity, _)| entity.id).collect();
    let mut placed = placed_lights(look.scene, &look.world, transport.origin);
    placed.retain(|light| may.contains(&light.entity));
    for PlacedLight { light, .. } in &mut placed {
        *light = Light { on: true, color: Vec3::ONE, intensity: 1.0, ..light.clone() };
    }
    placed
}

/// Of what holes may let light through, every hit does.
struct Open;

impl Holes for Open {
    fn passes(&self, _: u32, _: [f32; 2], _: f32) -> bool {
        true
    }
}

fn blockers(look: &Look<'_>, transport: &Transport) -> (Bvh, Open) {
    let surface = &transport.surface;
    let mut open = vec![false; surface.triangles.len()];
    for batch in &surface.batches {
        let entity = look.scene.entity(batch.entity());
        let casts =
            entity.and_then(|entity| entity.mesh.as_ref()).is_some_and(|renderer| renderer.casts_shadows);
        let material = look.scene.material(crate::scene::MaterialId(batch.material));
        let solid = material.is_none_or(|material| material.alpha == crate::scene::Alpha::Opaque);
        open[batch.first as usize..][..batch.count as usize].fill(!casts || !solid);
    }
    let corners: Vec<[Vec3; 3]> = (0..surface.triangles.len()).map(|t| surface.positions(t)).collect();
    (Bvh::new(&corners, open), Open)
}

/// Patches that hold no light, and what their rows and columns take.
fn left_out(look: &Look<'_>, dark: &[bool], what: &str, none: &str) -> Finding {
    let Some(transport) = look.transport else { return Finding::needed(none, Vec::new()) };
    let count = dark.iter().filter(|dark| **dark).count();
    if count == 0 {
        return Finding::needed(none, Vec::new());
    }
    let (names, ids) = told(of_patches(look, transport, dark));
    let (all, is) = (dark.len(), if count == 1 { "patch" } else { "patches" });
    Finding::not_needed(format!("{what}: {names} ({count} {is} of {all})"))
        .led_to(ids)
        .saves(saving(look, transport, dark))
}

fn of_patches<'l>(look: &'l Look<'_>, transport: &Transport, dark: &[bool]) -> Vec<&'l crate::scene::Entity> {
    let batches = transport.patches.iter().zip(dark).filter(|(_, dark)| **dark).map(|(patch, _)| patch.batch);
    let mut entities: Vec<EntityId> = batches
        .map(|batch| &transport.surface.batches[batch as usize])
        .filter(|batch| batch.material != NONE)
        .map(|batch| batch.entity())
        .collect();
    entities.sort_unstable();
    entities.dedup();
    entities.into_iter().filter_map(|id| look.scene.entity(id)).collect()
}

fn saving(look: &Look<'_>, transport: &Transport, dark: &[bool]) -> Saving {
    let count = dark.iter().filter(|dark| **dark).count() as u64;
    let kinds = [
        (&transport.patch_from_patch, look.sizes.of_patches, Some(dark)),
        (&transport.receiver_from_patch, look.sizes.of_receivers, None),
        (&transport.probe_from_patch, look.sizes.of_probes, None),
    ];
    let of_rows = kinds.map(|(rows, sizes, dark_rows): (&Rows, RowSizes, Option<&[bool]>)| {
        let is_dark_row = |row: usize| dark_rows.is_some_and(|dark| dark[row]);
        let is_dark = |column: u32| dark.get(column as usize) == Some(&true);
        let entries = (0..rows.len()).map(|row| {
            rows.row(row).filter(|&(column, _)| is_dark_row(row) || is_dark(column)).count() as u64
        });
        let gone = if dark_rows.is_some() { count } else { 0 };
        sizes.part(gone, entries.sum()).saving(&look.cost, 1.0)
    });
    of_rows.into_iter().fold(look.cost.memory(7 * VECTOR * count, 0), |sum, saving| sum + saving)
}

#[cfg(test)]
mod tests {
    use super::super::made::{emitter, forced, lamp, material, never, scene, two_rooms, wall, with};
    use super::*;
    use crate::scene::assets::Assets;
    use crate::scene::{Albedo, Changes, Entity, Scene, Transform};
    use glam::DVec3;

    fn found(rule: fn(&Look<'_>) -> Finding, scene: &Scene, transport: Option<&Transport>) -> Finding {
        let (assets, forced) = (Assets::default(), forced());
        match transport {
            Some(transport) => rule(&Look::at_transport(scene, &assets, transport, &forced)),
            None => rule(&Look::at_scene(scene, &assets, &forced)),
        }
    }

    fn black_material(id: u32) -> Material {
        Material { albedo: Albedo { color: Vec3::ZERO, ..Albedo::default() }, ..material(id) }
    }

    /// The two rooms, entities 1 and 2, with a lamp at a place.
    fn rooms(x: f64, light: Light) -> Scene {
        let at = Transform { translation: DVec3::new(x, 0.0, 0.0), ..Transform::default() };
        let lamp = Entity { transform: at, ..lamp(3, light) };
        Scene { materials: vec![material(0), material(1)], ..scene(vec![wall(1), with(wall(2), 1), lamp]) }
    }

    #[test]
    fn black_patches_are_those_that_neither_reflect_nor_emit() {
        let mut scene = rooms(-2.0, never());
        let rooms = two_rooms();
        assert!(found(black_patches, &scene, Some(&rooms)).needed);
        scene.materials[1] = black_material(1);
        let out = found(black_patches, &scene, Some(&rooms));
        assert!(!out.needed && out.entities == [EntityId(2)], "{out:?}");
        assert_eq!(out.why, "black: `e2` (6 patches of 12)");
        scene.materials[1].emission.color = Vec3::ONE;
        assert!(found(black_patches, &scene, Some(&rooms)).needed, "it shines");
    }

    #[test]
    fn before_the_bake_materials_tell_what_is_black() {
        let mut scene = rooms(-2.0, never());
        assert!(found(black_patches, &scene, None).needed);
        for black in [
            black_material(1),
            Material { metallic: 1.0, ..material(1) },
            Material { unlit: true, ..material(1) },
        ] {
            scene.materials[1] = black;
            assert_eq!(found(black_patches, &scene, None).entities, [EntityId(2)]);
        }
        scene.materials[1] = emitter(1, Changes::Never);
        assert!(found(black_patches, &scene, None).needed);
    }

    #[test]
    fn black_patches_save_their_rows_and_columns() {
        let mut scene = rooms(-2.0, never());
        scene.materials[1] = black_material(1);
        let mut rooms = two_rooms();
        rooms.receiver_from_patch.push([(0, 0.25), (7, 0.25), (8, 0.25)]);
        // Each patch sees all six of its room; a receiver two black ones.
        let saving = found(black_patches, &scene, Some(&rooms)).saving;
        let of_patches = Look::at_transport(&scene, &Assets::default(), &rooms, &forced()).sizes.of_patches;
        assert_eq!(saving.file_bytes, 36 * of_patches.bytes + 6 * 8 + 2 * 4);
    }

    #[test]
    fn a_closed_room_without_light_is_left_out() {
        let rooms_of = two_rooms();
        let out = found(unlit_patches, &rooms(-2.0, never()), Some(&rooms_of));
        assert!(!out.needed && out.entities == [EntityId(2)], "{out:?}");
        let other = found(unlit_patches, &rooms(2.0, never()), Some(&rooms_of));
        assert_eq!(other.entities, [EntityId(1)]);
        let outside = found(unlit_patches, &rooms(20.0, never()), Some(&rooms_of));
        assert_eq!(outside.entities, [EntityId(1), EntityId(2)]);
    }

    #[test]
    fn lights_count_as_on_and_those_that_move_or_cast_none_reach_through_walls() {
        let rooms_of = two_rooms();
        let off = Light { on: false, changes: Changes::Intensity, ..never() };
        assert_eq!(found(unlit_patches, &rooms(-2.0, off), Some(&rooms_of)).entities, [EntityId(2)]);
        let ghost = Light { casts_shadows: false, ..never() };
        assert!(found(unlit_patches, &rooms(-2.0, ghost), Some(&rooms_of)).needed);
        let mut carried = rooms(-2.0, never());
        carried.entities[2] = super::super::made::moved(carried.entities[2].clone());
        assert!(found(unlit_patches, &carried, Some(&rooms_of)).needed);
    }

    #[test]
    fn an_emitter_lights_its_room_and_a_wall_that_casts_none_lets_light_through() {
        let rooms_of = two_rooms();
        let mut glowing = rooms(-2.0, never());
        glowing.materials[1] = emitter(1, Changes::Never);
        assert!(found(unlit_patches, &glowing, Some(&rooms_of)).needed);
        let mut thin = rooms(-2.0, never());
        thin.entities[0].mesh.iter_mut().for_each(|renderer| renderer.casts_shadows = false);
        thin.entities[1].mesh.iter_mut().for_each(|renderer| renderer.casts_shadows = false);
        assert!(found(unlit_patches, &thin, Some(&rooms_of)).needed);
    }

    #[test]
    fn before_the_bake_it_is_known_only_that_nothing_shines() {
        assert!(found(unlit_patches, &rooms(0.0, never()), None).needed);
        assert!(!found(unlit_patches, &scene(vec![wall(1)]), None).needed);
    }
}
