//! What a bake would be, without baking it: counts from the layout, rays and bytes from a few rows of the scene itself,
//! and what is left out.

use std::path::Path;

use engine::scene::Warning;
use engine::transport::directional::AXES;
use engine::transport::key::{inputs, transport_key};
use engine::transport::needs::{Cost, Look, Needs, RowSizes, Sizes};
use engine::transport::{Transport, file, packed};

use crate::{BakeError, Opened, Settings, Silent, layout, pipeline, settings};

/// What would be baked, without baking it.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Plan {
    pub scene: String,
    pub quality: String,
    /// Metres.
    pub patch_length: f64,
    pub patches: usize,
    pub receivers: usize,
    pub probes: usize,
    pub sky_patches: usize,
    pub triangles: usize,
    pub rays: u64,
    /// Of those, how many are on disk already.
    pub rays_kept: u64,
    /// Estimated by tracing a few thousand rays.
    pub seconds: f64,
    pub bytes: u64,
    /// Of what the player loads, by section of its file: where there is a bake of these settings.
    pub sections: Vec<(String, u64)>,
    /// What is there, what is left out, and why.
    pub needs: Needs,
    /// The needs are those of the bake on disk, which is current; else they are about.
    pub exact: bool,
    pub left_out: Vec<String>,
    pub warnings: Vec<String>,
}

/// What [`bake`] would do.
pub fn plan(project: &Path, scene: Option<&str>, settings: &Settings) -> Result<Plan, BakeError> {
    let opened = Opened::open(project, scene)?;
    let (with, _) =
        settings::settle(&opened.settings, &opened.name, settings, layout::area(&opened.surface))?;
    let key = transport_key(&inputs(&opened.scene, &opened.assets, &with, opened.forced()));
    let file = file::path(project, &opened.name);
    let is_current = file::load_certificate(&file).is_ok_and(|certificate| certificate.key == key);
    let layout = layout::layout(&opened.scene, &opened.assets, &opened.surface, with.length, &Silent)?;
    let transport = &layout.transport;
    let rows = transport.patches.len() + transport.receivers.len();
    let rays =
        rows as u64 * u64::from(with.rays) + transport.probes.len() as u64 * u64::from(pipeline::PROBE_RAYS);
    let rays = rays + layout.directional as u64 * u64::from(with.rays);
    let kept = if is_current { rays } else { 0 };
    let measured = pipeline::measure(&layout, &opened.scene, &opened.assets, with.rays);
    // Entries of patches take eight bytes, others four where columns are few enough.
    let entries = |rows: usize| rows as f64 * measured.per_row;
    let of_probes = 9.0 * transport.probes.len() as f64 * measured.per_probe_row;
    let short = if transport.columns() <= packed::MOST_COLUMNS { 4.0 } else { 8.0 };
    let bytes = entries(transport.patches.len()) * 8.0
        + (entries(transport.receivers.len() + AXES * layout.directional) + of_probes) * short;
    let seconds_per_ray = measured.per_ray / rayon::current_num_threads() as f64;
    let cost = Cost { seconds_per_ray, ..Cost::measured() };
    let full = || file::load_full_uncertified(project, &opened.name);
    let baked = if is_current { Some(full()?) } else { None };
    let needs = match &baked {
        Some(baked) => Look::at_transport(&opened.authored, &opened.assets, baked, opened.forced()),
        None => Look::at_scene(&opened.authored, &opened.assets, opened.forced()).sized(sizes(
            transport,
            with.rays,
            &measured,
            short as u64,
        )),
    };
    let needs = needs.costing(cost).needs();
    Ok(Plan {
        scene: opened.name,
        quality: with.quality.to_string(),
        patch_length: with.length,
        patches: transport.patches.len(),
        receivers: transport.receivers.len(),
        probes: transport.probes.len(),
        sky_patches: transport.sky_patches as usize,
        triangles: transport.surface.triangles.len(),
        rays,
        rays_kept: kept,
        seconds: (rays - kept) as f64 * seconds_per_ray,
        bytes: file::length(transport) + bytes as u64,
        sections: if is_current { file::sections(&file)? } else { Vec::new() },
        left_out: needs.left_out().collect(),
        exact: is_current,
        needs,
        warnings: opened.warnings.iter().chain(&layout.warnings).map(Warning::to_string).collect(),
    })
}

/// About, of rows that are not there yet: entries of a row, bytes of an entry that is no patch's.
fn sizes(transport: &Transport, rays: u32, measured: &pipeline::Measured, bytes: u64) -> Sizes {
    let rows = |rows: usize, per_row: f64, bytes| RowSizes {
        rows: rows as u64,
        entries: (rows as f64 * per_row) as u64,
        bytes,
    };
    let pipeline::Measured { per_row, per_probe_row, .. } = *measured;
    Sizes {
        of_patches: rows(transport.patches.len(), per_row, 8),
        of_receivers: rows(transport.receivers.len(), per_row, bytes),
        of_probes: rows(9 * transport.probes.len(), per_probe_row, bytes),
        rays_per_row: u64::from(rays),
        ..Sizes::of(transport)
    }
}
