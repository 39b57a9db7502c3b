//! What each source of light comes to by itself: the light of a scene in which nothing else shines.
//!
//! ```text
//! (I - R P) B_s = E_s        E_s = M_s + R (H_dir,s + S L_s)        H_s = G B_s        L_s = Q B_s
//! ```
//! solved to ten digits in double precision on the CPU ([`exact`]), direct light by shadow rays at the samples of
//! patches, as frames sample it.

use std::f64::consts::PI;

use engine::scene::assets::Assets;
use engine::scene::{Changes, EntityId, Scene, SkyKind, world_from_local};
use engine::transport::direct::{irradiance_of_patches, placed_lights};
use engine::transport::materials::of_patches;
use engine::transport::solve::{System, exact, gather};
use engine::transport::solved::{Response, Solved, Source, Spread, at_brightness_one};
use engine::transport::{Rows, Transport, sky};
use glam::{DVec3, Vec3};

use super::lit::{Blockers, Sources};

/// One response for all that never changes, and one for each source whose brightness may.
pub fn solve(transport: &Transport, sources: &Sources) -> Solved {
    let blockers = Blockers::new(sources);
    let albedo = sources.albedo();
    let response = |source| {
        let scene = alone(sources.scene, source);
        Response { source, spread: light_of(transport, &scene, sources.assets, &albedo, &blockers) }
    };
    let responses = sources_of(sources.scene).into_iter().map(response);
    let shines = |response: &Response| response.spread != Spread::default();
    Solved { responses: responses.filter(shines).collect() }
}

/// The light of a whole scene, solved in one piece.
pub fn light_of(
    transport: &Transport,
    scene: &Scene,
    assets: &Assets,
    albedo: &[Vec3],
    blockers: &Blockers,
) -> Spread {
    let n = transport.patches.len();
    let exitance = of_patches(transport, scene, assets).exitance;
    let lights = placed_lights(scene, &world_from_local(scene), transport.origin);
    let from_lights = irradiance_of_patches(transport, &lights, &|a, b, c| blockers.visible(a, b, c));

    let mut from = vec![DVec3::ZERO; transport.columns()];
    let radiance = sky::radiance_of_patches(&scene.sky, assets);
    from[n..].iter_mut().zip(radiance).for_each(|(column, radiance)| *column = radiance.as_dvec3() * PI);
    let from_sky = gather(&transport.patch_from_patch, &from);
    let e: Vec<DVec3> = (0..n)
        .map(|i| {
            let arrives = from_lights[i].as_dvec3() + from_sky[i];
            exitance[i].as_dvec3() + albedo[i].as_dvec3() * arrives
        })
        .collect();
    let b =
        exact(&System { rows: &transport.patch_from_patch, patches: &transport.patches, albedo }, &e, 1e-10);

    let mut bounced = vec![DVec3::ZERO; transport.columns()];
    for (i, exitance) in exitance.iter().enumerate() {
        from[i] = exitance.as_dvec3();
        bounced[i] = b[i] - from[i];
    }
    let both = |rows: &Rows| [&from, &bounced].map(|values| light(gather(rows, values)));
    Spread {
        radiosity: light(b),
        receivers: both(&transport.receiver_from_patch),
        probes: both(&transport.probe_from_patch),
        directional: both(&transport.directional_from_patch),
    }
}

/// In single precision; empty where it is dark.
fn light(values: Vec<DVec3>) -> Vec<Vec3> {
    if values.iter().all(|value| *value == DVec3::ZERO) {
        return Vec::new();
    }
    values.into_iter().map(DVec3::as_vec3).collect()
}

/// Of a scene in which nothing but brightness changes. What may change in other ways counts as if it did not: the
/// author says so, or nobody would ask.
pub fn sources_of(scene: &Scene) -> Vec<Source> {
    let lights = scene.entities.iter().filter(|entity| !entity.hidden && own_light(scene, entity.id));
    let emissions = scene.materials.iter().filter(|material| {
        material.emission.changes != Changes::Never && material.emission.color != Vec3::ZERO
    });
    let mut sources = vec![Source::Never];
    sources.extend(lights.map(|entity| Source::Light(entity.id)));
    sources.extend(emissions.map(|material| Source::Emission(material.id)));
    let own_sky = scene.sky.changes != Changes::Never && scene.sky.kind != SkyKind::None;
    sources.extend(own_sky.then_some(Source::Sky));
    sources
}

/// Has its brightness a life of its own: by hand or by the clock?
fn own_light(scene: &Scene, entity: EntityId) -> bool {
    let light = scene.entity(entity).and_then(|entity| entity.light.as_ref());
    light.is_some_and(|light| light.changes != Changes::Never || light.switching.is_some())
}

/// The scene with no other source than this one, at intensity 1; what never changes shines as authored.
pub fn alone(scene: &Scene, source: Source) -> Scene {
    let mut alone = scene.clone();
    let is_never = source == Source::Never;
    for entity in &mut alone.entities {
        let stays = is_never && !own_light(scene, entity.id);
        let shines = source == Source::Light(entity.id);
        let Some(light) = &mut entity.light else { continue };
        light.on = if shines { true } else { stays && light.on };
        light.intensity = if shines { 1.0 } else { light.intensity };
    }
    for material in &mut alone.materials {
        let stays = is_never && material.emission.changes == Changes::Never;
        let strength = if stays { material.emission.strength } else { 0.0 };
        material.emission.strength = if source == Source::Emission(material.id) { 1.0 } else { strength };
    }
    alone.sky = match source {
        Source::Sky => at_brightness_one(&scene.sky),
        Source::Never if scene.sky.changes == Changes::Never => scene.sky.clone(),
        _ => Default::default(),
    };
    alone
}
