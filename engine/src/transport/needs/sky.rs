//! The sky: whether there is one, and whether all of it is one column.

use super::look::Look;
use super::saving::VECTOR;
use super::{Finding, Saving};
use crate::scene::{Changes, Feature, SkyKind};
use crate::transport::sky;

/// There is one.
pub fn sky(look: &Look<'_>) -> Finding {
    let kind = match look.scene.sky.kind {
        SkyKind::None => return Finding::not_needed("the scene has none").saves(saving(look)),
        SkyKind::Constant { .. } => "is a constant",
        SkyKind::Gradient { .. } => "is a gradient",
        SkyKind::Picture { .. } => "is a picture",
    };
    Finding::needed(format!("the scene has one, which {kind}"), Vec::new()).saves(saving(look))
}

/// Its radiance may differ from direction to direction.
pub fn sky_patches(look: &Look<'_>) -> Finding {
    let sky = &look.scene.sky;
    let is_constant = matches!(sky.kind, SkyKind::Constant { .. });
    if !look.has(Feature::Sky) {
        Finding::not_needed("the scene has no sky")
    } else if is_constant && sky.changes != Changes::Anything {
        Finding::not_needed("the sky is constant and stays so: all of it is one column").saves(folding(look))
    } else if is_constant {
        Finding::needed("the sky may become any other", Vec::new()).saves(folding(look))
    } else {
        Finding::needed("the sky differs from direction to direction", Vec::new())
    }
}

/// Entries of sky patches in rows of patches, receivers and probes; and rows that have some.
fn entries(look: &Look<'_>) -> [[u64; 2]; 3] {
    let Some(transport) = look.transport else { return [[0; 2]; 3] };
    let first = transport.patches.len() as u32;
    let rows = [&transport.patch_from_patch, &transport.receiver_from_patch, &transport.probe_from_patch];
    rows.map(|rows| {
        let of_sky =
            (0..rows.len()).map(|row| rows.row(row).filter(|&(column, _)| column >= first).count() as u64);
        of_sky.fold([0; 2], |[entries, some], count| [entries + count, some + u64::from(count > 0)])
    })
}

fn saving(look: &Look<'_>) -> Saving {
    let sizes = &look.sizes;
    let light = look.cost.memory(3 * VECTOR * u64::from(sky::COUNT), VECTOR * u64::from(sky::COUNT));
    let kinds = [sizes.of_patches, sizes.of_receivers, sizes.of_probes];
    let rows = kinds
        .iter()
        .zip(entries(look))
        .map(|(kind, [entries, _])| kind.part(0, entries).saving(&look.cost, 1.0));
    rows.fold(light, |sum, saving| sum + saving)
}

/// All columns but one.
fn folding(look: &Look<'_>) -> Saving {
    let sizes = &look.sizes;
    let columns = u64::from(sky::COUNT) - 1;
    let kinds = [sizes.of_patches, sizes.of_receivers, sizes.of_probes];
    let folded = |(kind, [entries, some]): (&super::saving::RowSizes, [u64; 2])| {
        kind.part(0, entries - some).saving(&look.cost, 1.0)
    };
    let rows = kinds.iter().zip(entries(look)).map(folded);
    rows.fold(look.cost.memory(3 * VECTOR * columns, 0), |sum, saving| sum + saving)
}

#[cfg(test)]
mod tests {
    use super::super::made::{constant, forced, gradient, scene};
    use super::*;
    use crate::scene::assets::Assets;
    use crate::scene::{Forced, Sky};
    use crate::transport::Transport;

    fn found(kind: SkyKind, changes: Changes, says: Option<Forced>) -> [bool; 2] {
        let mut scene = scene(vec![]);
        scene.sky = Sky { kind, changes };
        let (assets, mut forced) = (Assets::default(), forced());
        says.map(|says| forced.insert(Feature::Sky, says));
        let look = Look::at_scene(&scene, &assets, &forced);
        [sky(&look).needed, sky_patches(&look).needed]
    }

    #[test]
    fn without_a_sky_there_are_no_sky_patches() {
        assert_eq!(found(SkyKind::None, Changes::Anything, None), [false, false]);
        assert_eq!(found(gradient(), Changes::Never, None), [true, true]);
        assert!(!found(gradient(), Changes::Never, Some(Forced::Out))[1]);
    }

    #[test]
    fn a_constant_sky_is_one_column_unless_it_may_become_another() {
        assert_eq!(found(constant(), Changes::Never, None), [true, false]);
        assert_eq!(found(constant(), Changes::Intensity, None), [true, false]);
        assert_eq!(found(constant(), Changes::Anything, None), [true, true]);
    }

    #[test]
    fn folding_leaves_one_entry_to_each_row_that_sees_the_sky() {
        let mut scene = scene(vec![]);
        scene.sky = Sky { kind: constant(), changes: Changes::Never };
        let mut transport = Transport { sky_patches: sky::COUNT, ..Transport::default() };
        transport.receiver_from_patch.push((0..10).map(|column| (column, 1.0 / 16.0)));
        transport.receiver_from_patch.push([]);
        let (assets, forced) = (Assets::default(), forced());
        let look = Look::at_transport(&scene, &assets, &transport, &forced);
        assert_eq!(sky_patches(&look).saving.file_bytes, 9 * 4);
        assert_eq!(sky(&look).saving.file_bytes, 10 * 4);
    }
}
