//! How the matrix is read: with a coarse correction or without, with columns or as all weights in order.

use super::look::Look;
use super::{Finding, Saving};
use crate::scene::Feature;
use crate::transport::NONE;
use crate::transport::solve::{Method, choose_for_frames};

/// Patches below which a matrix may be dense.
pub const SMALL: u64 = 1500;

/// Light lasts so long that plain products would take many.
pub fn coarse_correction(look: &Look<'_>) -> Finding {
    if !look.has(Feature::Matrix) {
        return Finding::not_needed("nothing is solved while the scene plays");
    }
    let Some(transport) = look.transport else {
        return Finding::needed("the bake will tell how long light lasts", Vec::new());
    };
    let gain = transport.certificate.cavity_gain;
    let choice = choose_for_frames(&transport.patch_from_patch, &transport.patches, gain);
    let why = format!("{} (cavity gain {gain:.1})", choice.why);
    let aggregates =
        transport.patches.iter().map(|patch| patch.aggregate).filter(|&aggregate| aggregate != NONE);
    let aggregates = aggregates.max().map_or(0, |last| u64::from(last) + 1);
    let bytes = 16 * aggregates * (look.sizes.patches + aggregates);
    let saving = look.cost.memory(bytes, 2 * bytes);
    let finding = match choice.method {
        Method::TwoLevel => Finding::needed(why, Vec::new()),
        _ => Finding::not_needed(why),
    };
    finding.saves(saving)
}

/// Weights without columns would take more bytes than weights with them, or there are too many patches for it.
pub fn columns(look: &Look<'_>) -> Finding {
    if !look.has(Feature::Matrix) {
        return Finding::not_needed("there is no matrix while the scene plays");
    }
    let sizes = &look.sizes;
    if sizes.of_patches.rows == 0 {
        return Finding::needed("the bake will tell how full the matrix is", Vec::new());
    }
    let [sparse, dense] = [sparse_bytes(look), dense_bytes(look)];
    let share = 100.0 * sizes.of_patches.entries as f64
        / (sizes.of_patches.rows * (sizes.patches + sizes.sky_patches)) as f64;
    if sizes.patches >= SMALL {
        return Finding::needed(format!("{} patches are not few", sizes.patches), Vec::new());
    }
    if dense >= sparse {
        return Finding::needed(format!("{share:.0} % of the matrix is there"), Vec::new());
    }
    let bytes = sparse - dense;
    let saving = Saving { file_bytes: bytes, gpu_bytes: bytes, ..look.cost.memory(0, bytes) };
    Finding::not_needed(format!(
        "{} patches are few, and {share:.0} % of their matrix is there",
        sizes.patches
    ))
    .saves(saving)
}

/// Weights of all pairs, and of all patches with the sky's.
fn dense_bytes(look: &Look<'_>) -> u64 {
    4 * look.sizes.of_patches.rows * (look.sizes.patches + look.sizes.sky_patches)
}

fn sparse_bytes(look: &Look<'_>) -> u64 {
    let rows = look.sizes.of_patches;
    rows.entries * rows.bytes + (rows.rows + 1) * 8
}

#[cfg(test)]
mod tests {
    use super::super::made::{forced, lamp, never, scene, wall};
    use super::*;
    use crate::scene::Light;
    use crate::scene::assets::Assets;
    use crate::transport::{Batch, Patch, Transport};

    /// So many patches of which each sees every `step`th, in two aggregates, whose light lasts.
    fn transport(patches: u32, step: usize, gain: f64) -> Transport {
        let mut transport = Transport::default();
        transport.surface.batches = vec![Batch { entity: [1, 0], ..Batch::default() }];
        for i in 0..patches {
            transport.patches.push(Patch { aggregate: i % 2, area: 1.0, ..Patch::default() });
            let weight = 0.9 * step as f32 / patches as f32;
            transport.patch_from_patch.push((0..patches).step_by(step).map(|column| (column, weight)));
        }
        transport.certificate.cavity_gain = gain;
        transport
    }

    fn found(rule: fn(&Look<'_>) -> Finding, light: Light, transport: &Transport) -> Finding {
        let (scene, assets, forced) = (scene(vec![wall(1), lamp(2, light)]), Assets::default(), forced());
        rule(&Look::at_transport(&scene, &assets, transport, &forced))
    }

    #[test]
    fn the_coarse_correction_is_for_light_that_lasts() {
        let large = |gain| transport(1200, 1, gain);
        let lasting = found(coarse_correction, Light::default(), &large(100.0));
        assert!(lasting.needed && lasting.saving.gpu_bytes == 16 * 2 * 1202, "{lasting:?}");
        let dim = found(coarse_correction, Light::default(), &large(1.1));
        assert!(!dim.needed && dim.why.starts_with("few bounces count"), "{dim:?}");
        assert!(!found(coarse_correction, never(), &large(100.0)).needed, "nothing is solved");
    }

    #[test]
    fn a_small_matrix_that_is_nearly_full_has_weights_alone() {
        let full = found(columns, Light::default(), &transport(100, 1, 1.0));
        assert!(!full.needed && full.saving.gpu_bytes == 100 * 100 * 4 + 101 * 8, "{full:?}");
        assert!(found(columns, Light::default(), &transport(100, 3, 1.0)).needed, "a third of it");
        assert!(found(columns, Light::default(), &transport(1500, 1, 1.0)).needed, "too many");
        assert!(!found(columns, never(), &transport(100, 3, 1.0)).needed, "no matrix");
    }

    #[test]
    fn before_the_bake_both_are_kept() {
        let (scene, assets, forced) =
            (scene(vec![wall(1), lamp(2, Light::default())]), Assets::default(), forced());
        let look = Look::at_scene(&scene, &assets, &forced);
        assert!(coarse_correction(&look).needed && columns(&look).needed);
    }
}
