//! What of a bake a player needs: the full transport, less what its scene can do without.
//!
//! ```text
//! matrix          where nothing but brightness may change: light that is solved stands in its place
//! sky patches     one column for a sky that is the same everywhere
//! black patches   B is 0 there: their rows come to nothing, their columns add nothing
//! unlit patches   likewise in rooms that no light comes to
//! ```
//! What no ray is traced for (light probes that nothing reads, a sky that is not there) the full transport lacks too.
//! Indices of patches, receivers and probes stay. What is left gives the same picture as the full transport does for
//! every scene that differs in nothing that the omissions rely on ([`Omission::relied_on`]).

mod lit;
mod prune;
pub mod responses;

use engine::scene::assets::Assets;
use engine::scene::{Feature, Scene};
use engine::transport::needs::{Needs, dark_patches, grounds};
use engine::transport::{Omission, Rows, Transport};

use lit::Sources;

/// A player's transport; `None` where it is the full one. Of a scene as authored, and as it was baked.
pub fn ship(
    full: &Transport,
    [authored, scene]: [&Scene; 2],
    assets: &Assets,
    needs: &Needs,
    unlimited_gain: bool,
) -> Option<Transport> {
    let mut shipped = full.clone();
    let mut left_out = Vec::new();
    let sources = Sources { scene, assets, full, unlimited_gain };
    let [black, unlit] = dark_patches(authored, assets, full);
    for feature in FOLDED.into_iter().filter(|&feature| !needs.has(feature)) {
        let is_gone = match feature {
            Feature::Matrix => leave_out_matrix(&mut shipped, &sources),
            _ if shipped.solved.is_some() => false, // it has no rows
            Feature::SkyPatches => prune::sky_patches(&mut shipped),
            Feature::BlackPatches => prune::patches(&mut shipped, &sources, &black),
            Feature::UnlitPatches => prune::patches(&mut shipped, &sources, &unlit),
            _ => false,
        };
        left_out.extend(is_gone.then_some(feature));
    }
    shipped.omissions = omissions(left_out, authored, assets);
    (!shipped.omissions.is_empty()).then_some(shipped)
}

/// What is folded away here, in this order; other features are left out elsewhere.
const FOLDED: [Feature; 4] =
    [Feature::Matrix, Feature::SkyPatches, Feature::BlackPatches, Feature::UnlitPatches];

fn omissions(features: Vec<Feature>, scene: &Scene, assets: &Assets) -> Vec<Omission> {
    let omission = |feature| Omission { feature, relied_on: grounds(feature, scene, assets) };
    features.into_iter().map(omission).collect()
}

/// Those whose grounds are not what they were.
pub fn changed(omissions: &[Omission], scene: &Scene, assets: &Assets) -> Vec<Omission> {
    let holds = |omission: &&Omission| omission.relied_on == grounds(omission.feature, scene, assets);
    omissions.iter().filter(|omission| !holds(omission)).cloned().collect()
}

/// A name for all that [`ship`] depends on besides the full transport: while it is the same, so is what is shipped.
pub fn made_for(scene: &Scene, assets: &Assets, needs: &Needs, unlimited_gain: bool) -> String {
    let out = FOLDED.into_iter().filter(|&feature| !needs.has(feature));
    let grounds: Vec<_> = out.map(|feature| (feature, grounds(feature, scene, assets))).collect();
    let all = format!("{:?}", (grounds, needs.has(Feature::Columns), unlimited_gain));
    blake3::hash(all.as_bytes()).to_hex().to_string()
}

fn leave_out_matrix(shipped: &mut Transport, sources: &Sources) -> bool {
    if shipped.patches.is_empty() {
        return false;
    }
    shipped.solved = Some(responses::solve(shipped, sources));
    let rows = [
        &mut shipped.patch_from_patch,
        &mut shipped.receiver_from_patch,
        &mut shipped.probe_from_patch,
        &mut shipped.directional_from_patch,
    ];
    rows.into_iter().for_each(|rows| *rows = Rows::default());
    shipped.sky_patches = 0;
    // Direct light is sampled at patches no more.
    shipped.samples.clear();
    shipped.patches.iter_mut().for_each(|patch| (patch.first_sample, patch.sample_count) = (0, 0));
    true
}
