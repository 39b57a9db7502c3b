//! Whether light has a colour: what shines, and what it meets.

use glam::Vec3;

use super::Finding;
use super::look::Look;
use super::saving::{CHANNEL, VECTOR};
use super::sources::{Source, emitters, lights, sky_shines, sources};
use crate::scene::assets::{Picture, Pixels};
use crate::scene::{Changes, Feature, Material, SkyKind, Texture};

/// Something static, a light or the sky is not grey, or may take a colour. What moves may have any: light is read there
/// and comes from nowhere.
pub fn colour(look: &Look<'_>) -> Finding {
    // Of sixteen bytes' vectors a channel stays, four: of what is solved, if it is, and of what is read.
    let sizes = &look.sizes;
    let solved = u64::from(look.has(Feature::Matrix)) * (6 * sizes.patches + 3 * sizes.sky_patches);
    let vectors = solved + 2 * sizes.receivers + 18 * sizes.probes;
    let bytes = (VECTOR - CHANNEL) * vectors;
    let saving = look.cost.memory(bytes, bytes);
    coloured_source(look)
        .or_else(|| coloured_surface(look))
        .unwrap_or_else(|| Finding::not_needed("all albedo and all that shines is grey and stays so"))
        .saves(saving)
}

fn coloured_source(look: &Look<'_>) -> Option<Finding> {
    let free = sources(look).into_iter().find(|source| source.changes == Changes::Anything);
    if let Some(Source { name, entities, .. }) = free {
        return Some(Finding::needed(format!("{name} may take any colour"), entities));
    }
    if let Some((_, entity, _)) = lights(look).find(|(.., light)| !is_grey(light.color)) {
        return Some(Finding::needed(format!("light `{}` is coloured", entity.name), vec![entity.id]));
    }
    let is_coloured = |material: &Material| {
        !is_grey(material.emission.color) || is_picture_coloured(look, &material.emission.texture)
    };
    if let Some((material, entities)) = emitters(look).into_iter().find(|(material, _)| is_coloured(material))
    {
        return Some(Finding::needed(
            format!("the emission of material `{}` is coloured", material.name),
            entities,
        ));
    }
    let is_coloured = match &look.scene.sky.kind {
        SkyKind::None => false,
        SkyKind::Constant { radiance } => !is_grey(*radiance),
        SkyKind::Gradient { zenith, horizon, ground, .. } => {
            ![*zenith, *horizon, *ground].into_iter().all(is_grey)
        }
        SkyKind::Picture { image, .. } => {
            look.assets.images.get(image).is_some_and(|picture| !is_grey_picture(picture))
        }
    };
    (is_coloured && sky_shines(look)).then(|| Finding::needed("the sky is coloured", Vec::new()))
}

/// After the bake by what patches hold, before it by materials, pictures and colours of vertices.
fn coloured_surface(look: &Look<'_>) -> Option<Finding> {
    if let (Some(transport), Some(materials)) = (look.transport, look.patch_materials()) {
        let patch = materials.albedo.iter().position(|&albedo| !is_grey(albedo))?;
        let entity = transport.surface.batches[transport.patches[patch].batch as usize].entity();
        return Some(Finding::needed(format!("`{}` is coloured", look.name(entity)), vec![entity]));
    }
    let is_coloured = |material: &Material| {
        !material.unlit
            && (!is_grey(material.albedo.color) || is_picture_coloured(look, &material.albedo.texture))
    };
    let painted = look.still().find(|drawn| {
        let mesh = look.assets.meshes.get(&drawn.renderer.mesh);
        let colors = mesh.and_then(|mesh| mesh.colors.as_ref());
        colors.is_some_and(|colors| colors.iter().any(|color| !is_grey(color.truncate())))
    });
    let found = painted.or_else(|| look.with_material(look.still(), is_coloured).first().copied())?;
    Some(Finding::needed(format!("`{}` is coloured", found.entity.name), vec![found.entity.id]))
}

fn is_grey(color: Vec3) -> bool {
    color.x == color.y && color.y == color.z
}

fn is_picture_coloured(look: &Look<'_>, texture: &Option<Texture>) -> bool {
    let picture = texture.as_ref().and_then(|texture| look.assets.images.get(&texture.image));
    picture.is_some_and(|picture| !is_grey_picture(picture))
}

fn is_grey_picture(picture: &Picture) -> bool {
    match &picture.pixels {
        Pixels::Rgba8(pixels) => pixels.iter().all(|[r, g, b, _]| r == g && g == b),
        Pixels::Rgb32f(pixels) => pixels.iter().all(|&pixel| is_grey(Vec3::from(pixel))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::made::{
        ball, constant, emitter, forced, gradient, lamp, material, moved, never, scene, wall, with,
    };
    use super::super::sources::matrix;
    use super::*;
    use crate::scene::assets::Assets;
    use crate::scene::{Albedo, EntityId, Light, Scene, Sky};

    fn found(rule: fn(&Look<'_>) -> Finding, scene: &Scene) -> Finding {
        let (assets, forced) = (Assets::default(), forced());
        rule(&Look::at_scene(scene, &assets, &forced))
    }

    /// A wall and a lamp that never changes.
    fn room() -> Scene {
        scene(vec![wall(1), lamp(2, never())])
    }

    #[test]
    fn a_grey_scene_has_one_channel() {
        let grey = found(colour, &room());
        assert!(!grey.needed, "{grey:?}");
        let mut scene = room();
        scene.sky = Sky { kind: constant(), changes: Changes::Never };
        assert!(!found(colour, &scene).needed);
        scene.entities.push(moved(lamp(3, never())));
        assert!(found(matrix, &scene).needed && !found(colour, &scene).needed, "solved while it plays");
    }

    #[test]
    fn any_colour_anywhere_that_light_meets_needs_three() {
        let red = Vec3::new(1.0, 0.0, 0.0);
        let lamp_of = |light| scene(vec![wall(1), lamp(2, light)]);
        assert!(found(colour, &lamp_of(Light { color: red, ..never() })).needed);
        assert!(found(colour, &lamp_of(Light { changes: Changes::Anything, ..never() })).needed);
        let mut walls = room();
        walls.materials =
            vec![Material { albedo: Albedo { color: red, ..Albedo::default() }, ..material(0) }];
        assert_eq!(found(colour, &walls).entities, [EntityId(1)]);
        walls.entities.push(with(ball(3), 1));
        walls.materials[0].id = crate::scene::MaterialId(1);
        assert!(!found(colour, &walls).needed, "what moves shows light and gives none");
        let mut glowing = room();
        glowing.materials = vec![emitter(0, Changes::Never)];
        assert!(!found(colour, &glowing).needed);
        glowing.materials[0].emission.color = red;
        assert!(found(colour, &glowing).needed);
        let mut under = room();
        under.sky = Sky { kind: gradient(), changes: Changes::Never };
        assert_eq!(found(colour, &under).why, "the sky is coloured");
    }
}
