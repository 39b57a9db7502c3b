//! What a run cost, as JSON.

use std::path::Path;
use std::time::Duration;

use serde_json::{Map, Value, json};

use super::PlayError;
use crate::render::{Drawn, Renderer};

/// Of every frame.
#[derive(Default)]
pub struct Statistics {
    frames: Vec<Drawn>,
    seconds: Vec<f64>,
}

impl Statistics {
    pub fn add(&mut self, drawn: Drawn, took: Duration) {
        self.frames.push(drawn);
        self.seconds.push(took.as_secs_f64());
    }

    pub fn write(&self, path: &Path, renderer: &Renderer, size: [u32; 2]) -> Result<(), PlayError> {
        let text = format!("{:#}\n", self.json(renderer, size));
        std::fs::write(path, text)
            .map_err(|error| PlayError::Write { path: path.to_owned(), message: error.to_string() })
    }

    /// ```text
    /// adapter, frames, size, timing: "gpu" or "cpu" (time to record)
    /// passes   { NAME: { median_ms, p99_ms } }       frame { median_ms, p99_ms }, by the clock
    /// patches, receivers, probes, sky_patches, rows, entries
    /// bytes    { KIND: bytes on the GPU }
    /// dispatches, products, draws, shadow_draws, bound   one a frame; bound is null where nothing was measured
    /// left_out [ what, and why ]
    /// ```
    fn json(&self, renderer: &Renderer, size: [u32; 2]) -> Value {
        let transport = renderer.transport();
        let rows = [&transport.patch_from_patch, &transport.receiver_from_patch, &transport.probe_from_patch];
        let passes: Map<String, Value> = renderer
            .timer
            .summary()
            .into_iter()
            .map(|(name, [median, p99])| (name.to_owned(), json!({ "median_ms": median, "p99_ms": p99 })))
            .collect();
        let bytes: Map<String, Value> =
            renderer.bytes().into_iter().map(|(kind, bytes)| (kind.to_owned(), json!(bytes))).collect();
        let each = |value: fn(&Drawn) -> Value| self.frames.iter().map(value).collect::<Vec<_>>();
        json!({
            "adapter": renderer.gpu().name(),
            "frames": self.frames.len(),
            "size": size,
            "timing": if renderer.timer.on_gpu() { "gpu" } else { "cpu" },
            "passes": passes,
            "frame": { "median_ms": self.milliseconds(0.5), "p99_ms": self.milliseconds(0.99) },
            "patches": transport.patches.len(),
            "receivers": transport.receivers.len(),
            "probes": transport.probes.len(),
            "sky_patches": transport.sky_patches,
            "rows": rows.iter().map(|rows| rows.len()).sum::<usize>(),
            "entries": rows.iter().map(|rows| rows.entries()).sum::<usize>(),
            "bytes": bytes,
            "dispatches": each(|frame| json!(frame.transport_dispatches)),
            "products": each(|frame| json!(frame.products)),
            "draws": each(|frame| json!(frame.draws)),
            "shadow_draws": each(|frame| json!(frame.shadow_draws)),
            "bound": each(|frame| json!(frame.bound)),
            "left_out": renderer.left_out(),
        })
    }

    fn milliseconds(&self, share: f64) -> f64 {
        let mut sorted = self.seconds.clone();
        sorted.sort_by(f64::total_cmp);
        let at = (sorted.len().saturating_sub(1) as f64 * share).round() as usize;
        sorted.get(at).map_or(0.0, |seconds| seconds * 1e3)
    }
}
