//! What materials ask for: terms for normal maps, tests for holes, pipelines.

use super::look::{Drawn, Look, entities};
use super::{Finding, Saving};
use crate::scene::{Alpha, Material};

/// A static surface has a normal map: rows for the direction of its light.
pub fn directional(look: &Look<'_>) -> Finding {
    let bumped = look.with_material(look.still(), |material| material.normal_texture.is_some());
    let saving = directional_saving(look, &bumped);
    if bumped.is_empty() {
        return Finding::not_needed("no static surface has a normal map").saves(saving);
    }
    let (names, ids) = entities(&bumped);
    Finding::needed(format!("{names} has a normal map"), ids).saves(saving)
}

/// About: three rows for each receiver of bumped surfaces, as long as its own, out of as many rays again.
fn directional_saving(look: &Look<'_>, bumped: &[Drawn<'_>]) -> Saving {
    let sizes = &look.sizes;
    let all = look.still().count().max(1) as f64;
    let share = if bumped.is_empty() { 1.0 } else { bumped.len() as f64 / all };
    let rows = (sizes.receivers as f64 * share) as u64;
    let entries = (sizes.of_receivers.entries as f64 * share) as u64;
    sizes.of_receivers.part(3 * rows, 3 * entries).saving(&look.cost, 1.0)
        + look.cost.rays(rows * sizes.rays_per_row)
}

/// Light may pass through something that would stop it: a mask or a blended surface, static, or one that casts.
pub fn holes(look: &Look<'_>) -> Finding {
    // In rows everything static blocks, whether or not lights see it cast.
    let casts = look.drawn().filter(|drawn| drawn.entity.is_static || drawn.renderer.casts_shadows);
    let holed = look.with_material(casts, |material| material.alpha != Alpha::Opaque);
    if holed.is_empty() {
        return Finding::not_needed("nothing that stops light has holes or is blended");
    }
    let (names, ids) = entities(&holed);
    Finding::needed(format!("light gets through {names}"), ids)
}

/// Does a material ask for a variant?
type Asks = fn(&Material) -> bool;

/// A material asks for more than an opaque, lit surface without a normal map.
pub fn material_variants(look: &Look<'_>) -> Finding {
    let variants: [(&str, Asks); 4] = [
        ("normal maps", |material| material.normal_texture.is_some()),
        ("holes", |material| matches!(material.alpha, Alpha::Mask { .. })),
        ("blending", |material| material.alpha == Alpha::Blend),
        ("no light", |material| material.unlit),
    ];
    let mut used = Vec::new();
    let mut ids = Vec::new();
    for (variant, is) in variants {
        let (names, by) = entities(&look.with_material(look.drawn(), is));
        if !by.is_empty() {
            used.push(format!("{variant} for {names}"));
            ids.extend(by);
        }
    }
    if used.is_empty() {
        return Finding::not_needed("every surface is opaque and lit, and none has a normal map");
    }
    ids.sort_unstable();
    ids.dedup();
    Finding::needed(used.join("; "), ids)
}

#[cfg(test)]
mod tests {
    use super::super::made::{ball, forced, material, picture, scene, wall, with};
    use super::*;
    use crate::scene::assets::Assets;
    use crate::scene::{Entity, EntityId, Texture};

    fn found(rule: fn(&Look<'_>) -> Finding, entities: Vec<Entity>, materials: Vec<Material>) -> Finding {
        let mut scene = scene(entities);
        scene.materials = materials;
        let (assets, forced) = (Assets::default(), forced());
        rule(&Look::at_scene(&scene, &assets, &forced))
    }

    fn bumped() -> Material {
        Material { normal_texture: Some(Texture::new(picture())), ..material(1) }
    }

    #[test]
    fn directional_rows_are_for_static_surfaces_with_a_normal_map() {
        let found = |entities| found(directional, entities, vec![material(0), bumped()]);
        let wanted = found(vec![wall(1), with(wall(2), 1)]);
        assert!(wanted.needed && wanted.entities == [EntityId(2)], "{wanted:?}");
        assert!(!found(vec![wall(1)]).needed, "a map that nothing has");
        assert!(!found(vec![wall(1), with(ball(2), 1)]).needed, "what moves reads probes");
        assert!(!found(vec![Entity { hidden: true, ..with(wall(2), 1) }]).needed);
    }

    #[test]
    fn holes_are_looked_for_where_what_stops_light_has_some() {
        for alpha in [Alpha::Mask { cutoff: 0.5 }, Alpha::Blend] {
            let found =
                |entities| found(holes, entities, vec![material(0), Material { alpha, ..material(1) }]);
            assert!(!found(vec![wall(1), ball(2)]).needed);
            assert!(found(vec![with(wall(1), 1)]).needed && found(vec![with(ball(1), 1)]).needed);
            let casts_none = |mut entity: Entity| {
                entity.mesh.iter_mut().for_each(|renderer| renderer.casts_shadows = false);
                entity
            };
            assert!(!found(vec![casts_none(with(ball(1), 1))]).needed, "it stops no light");
            assert!(found(vec![casts_none(with(wall(1), 1))]).needed, "in rows it does");
        }
    }

    #[test]
    fn variants_that_are_used_are_named() {
        let of = |material| found(material_variants, vec![with(wall(1), 1)], vec![material]);
        assert!(!of(material(1)).needed);
        for (material, told) in [
            (bumped(), "normal maps for `e1`"),
            (Material { alpha: Alpha::Mask { cutoff: 0.5 }, ..material(1) }, "holes for `e1`"),
            (Material { alpha: Alpha::Blend, ..material(1) }, "blending for `e1`"),
            (Material { unlit: true, ..material(1) }, "no light for `e1`"),
        ] {
            let found = of(material);
            assert!(found.needed && found.why == told, "{found:?}");
        }
    }
}
