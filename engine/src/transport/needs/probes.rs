//! Light probes are read by what moves, and by nothing else.

use super::look::{Look, entities, told};
use super::saving::{PROBE_RAYS, VECTOR};
use super::{Finding, Saving};
use crate::transport::Probe;

/// Something moves, or may, and light probes are placed. What moves is what the renderer draws without a bake: all that
/// is drawn and not static.
pub fn light_probes(look: &Look<'_>) -> Finding {
    let groups = || look.visible().filter_map(|(_, entity)| Some((entity, entity.light_probes.as_ref()?)));
    let groups: Vec<_> = groups().filter(|(_, group)| !group.positions.is_empty()).collect();
    let (placed, places) = told(groups.iter().map(|(entity, _)| *entity));
    let saving = saving(look, groups.iter().map(|(_, group)| group.positions.len() as u64).sum());
    let movers: Vec<_> = look.movers().collect();
    let (names, reads) = entities(&movers);
    match (groups.is_empty(), movers.is_empty()) {
        (true, true) => Finding::not_needed("nothing moves, and no light probes are placed"),
        (true, false) => {
            Finding::not_needed(format!("no light probes are placed; {names} would read them")).led_to(reads)
        }
        (false, true) => {
            Finding::not_needed(format!("nothing moves that would read those of {placed}")).led_to(places)
        }
        (false, false) => Finding::needed(format!("read by what may move: {names}"), reads),
    }
    .saves(saving)
}

fn saving(look: &Look<'_>, placed: u64) -> Saving {
    let (sizes, cost) = (&look.sizes, &look.cost);
    let probes = if sizes.probes > 0 { sizes.probes } else { placed };
    if probes == 0 {
        return Saving::default();
    }
    let rows = if sizes.of_probes.rows > 0 { sizes.of_probes } else { sizes.rows_of_probes(probes) };
    let places = size_of::<Probe>() as u64 * probes;
    let depths = look
        .transport
        .map_or(0, |transport| 4 * (transport.depths.probes.len() + transport.depths.nearness.len()) as u64);
    rows.saving(cost, 2.0)
        + cost.memory(18 * VECTOR * probes, 0)
        + cost.rays(probes * u64::from(PROBE_RAYS))
        + Saving { file_bytes: places + depths, ..Saving::default() }
}

#[cfg(test)]
mod tests {
    use super::super::made::{ball, forced, moved, probes, scene, wall};
    use super::*;
    use crate::scene::assets::Assets;
    use crate::scene::{Entity, EntityId};

    fn found(entities: Vec<Entity>) -> Finding {
        let (scene, assets, forced) = (scene(entities), Assets::default(), forced());
        light_probes(&Look::at_scene(&scene, &assets, &forced))
    }

    #[test]
    fn light_probes_are_for_what_moves_or_may() {
        let out = found(vec![wall(1), probes(2)]);
        assert!(!out.needed && out.entities == [EntityId(2)] && out.why.contains("nothing moves"), "{out:?}");
        let may = found(vec![wall(1), probes(2), ball(3)]);
        assert!(may.needed && may.entities == [EntityId(3)] && may.why.contains("`e3`"), "{may:?}");
        assert!(found(vec![probes(2), moved(ball(3))]).needed);
    }

    #[test]
    fn without_probes_what_moves_does_without() {
        let none = found(vec![wall(1), ball(3)]);
        assert!(!none.needed && none.why.contains("no light probes are placed"), "{none:?}");
        let mut empty = probes(2);
        empty.light_probes = Some(Default::default());
        assert!(!found(vec![empty, ball(3)]).needed, "a group without probes");
    }

    #[test]
    fn what_is_hidden_itself_or_by_a_parent_counts_for_nothing() {
        let hidden = |entity| Entity { hidden: true, ..entity };
        assert!(!found(vec![probes(2), hidden(ball(3))]).needed);
        assert!(!found(vec![hidden(probes(2)), ball(3)]).needed);
        let parent = hidden(Entity { id: EntityId(9), ..Entity::default() });
        let child = Entity { parent: Some(EntityId(9)), ..ball(3) };
        assert!(!found(vec![probes(2), parent, child]).needed);
    }
}
