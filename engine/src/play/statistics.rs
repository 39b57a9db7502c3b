//! What a run cost, as JSON. It is written whatever ends the run.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::overlay::{self, Took};
use super::{PlayError, World};
use crate::render::{Drawn, Renderer};
use crate::scene::file::write_atomically;

/// Of every frame, where somebody wants to know.
pub struct Statistics<'a> {
    to: Option<&'a Path>,
    frames: Vec<Drawn>,
    took: Vec<Took>,
}

impl<'a> Statistics<'a> {
    pub fn new(to: Option<&'a Path>) -> Self {
        Self { to, frames: Vec::new(), took: Vec::new() }
    }

    pub fn add(&mut self, drawn: &Drawn, took: Took) {
        if self.to.is_some() {
            self.frames.push(drawn.clone());
            self.took.push(took);
        }
    }

    /// At the end, however it came: what ended the run is what is returned, and stands in the file.
    pub fn finish(
        &self,
        ended: Result<(), PlayError>,
        renderer: Option<&Renderer>,
        world: &World,
        size: [u32; 2],
    ) -> Result<(), PlayError> {
        let Some(path) = self.to else { return ended };
        let failed = ended.as_ref().err().map(PlayError::to_string);
        let mut all = self.of_frames(size, failed);
        all.extend(renderer.map_or(Map::new(), |renderer| of_renderer(renderer, world)));
        let text = format!("{:#}\n", Value::Object(all));
        let written = write_atomically(path, text.as_bytes()).map_err(PlayError::from);
        ended.and(written)
    }

    /// ```text
    /// frames, size, failed: null or what ended the run
    /// frame, cpu: { median_ms, p99_ms } by the clock, null where nothing was measured: from picture to picture,
    ///     and to prepare and send one
    /// dispatches, products, captures, draws, shadow_draws, render_passes, compute_passes, bound: one a frame; bound
    ///     is null until it is known
    /// ```
    fn of_frames(&self, size: [u32; 2], failed: Option<String>) -> Map<String, Value> {
        let each = |value: fn(&Drawn) -> Value| self.frames.iter().map(value).collect::<Vec<_>>();
        let seconds = |took: &Took| took.frame.as_secs_f64();
        let cpu: Vec<f64> = self.took.iter().filter_map(|took| Some(took.cpu?.as_secs_f64())).collect();
        object(json!({
            "frames": self.frames.len(),
            "size": size,
            "failed": failed,
            "frame": spread(self.took.iter().map(seconds).collect()),
            "cpu": spread(cpu),
            "dispatches": each(|frame| json!(frame.transport_dispatches)),
            "products": each(|frame| json!(frame.products)),
            "draws": each(|frame| json!(frame.draws)),
            "captures": each(|frame| json!(frame.captures)),
            "shadow_draws": each(|frame| json!(frame.shadow_draws)),
            "render_passes": each(|frame| json!(frame.passes.render)),
            "compute_passes": each(|frame| json!(frame.passes.compute)),
            "bound": each(|frame| json!(frame.bound)),
        }))
    }
}

/// ```text
/// adapter, timing: "gpu" or "cpu" (time to record)
/// passes   { NAME: { median_ms, p99_ms } }
/// patches, receivers, probes, sky_patches, rows, entries
/// bytes    { KIND: bytes on the GPU }
/// pipelines [ NAME ], in the order in which they were compiled
/// needs    [ { feature, is_in, forced: null, "in" or "out", why, entities: [ id ],
///              saving: { file_bytes, gpu_bytes, milliseconds, seconds } } ]
/// left_out [ what, and why ]
/// ```
fn of_renderer(renderer: &Renderer, world: &World) -> Map<String, Value> {
    let transport = renderer.transport();
    let rows = [
        &transport.patch_from_patch,
        &transport.receiver_from_patch,
        &transport.probe_from_patch,
        &transport.directional_from_patch,
    ];
    let passes: Map<String, Value> = renderer
        .timer
        .summary()
        .into_iter()
        .map(|(name, [median, p99])| (name.to_owned(), json!({ "median_ms": median, "p99_ms": p99 })))
        .collect();
    let bytes: Map<String, Value> =
        renderer.bytes().into_iter().map(|(kind, bytes)| (kind.to_owned(), json!(bytes))).collect();
    let left_out: Vec<String> = world.needs.left_out().chain(overlay::left_out(world, renderer)).collect();
    object(json!({
        "adapter": renderer.gpu().name(),
        "timing": if renderer.timer.on_gpu() { "gpu" } else { "cpu" },
        "passes": passes,
        "patches": transport.patches.len(),
        "receivers": transport.receivers.len(),
        "probes": transport.probes.len(),
        "sky_patches": transport.sky_patches,
        "rows": rows.iter().map(|rows| rows.len()).sum::<usize>(),
        "entries": rows.iter().map(|rows| rows.entries()).sum::<usize>(),
        "bytes": bytes,
        "pipelines": renderer.gpu().pipelines(),
        "needs": world.needs.verdicts,
        "left_out": left_out,
    }))
}

fn object(value: Value) -> Map<String, Value> {
    if let Value::Object(map) = value { map } else { Map::new() }
}

/// Null where there is nothing.
fn spread(mut seconds: Vec<f64>) -> Value {
    seconds.sort_by(f64::total_cmp);
    let at = |share: f64| seconds.get((seconds.len().saturating_sub(1) as f64 * share).round() as usize);
    match (at(0.5), at(0.99)) {
        (Some(median), Some(p99)) => json!({ "median_ms": median * 1e3, "p99_ms": p99 * 1e3 }),
        _ => Value::Null,
    }
}
