//! How long each pass takes on the GPU, by timestamps; where those are missing, how long it takes to record.

use std::collections::BTreeMap;
use std::time::Instant;

use super::Gpu;
use super::buffer::{Readback, empty};

/// Passes with a timestamp in one frame; what comes after goes untimed.
const MOST: u32 = 256;

/// Frames whose times are remembered: the last half hour, at least.
const KEPT: usize = 1 << 18;

/// Times of passes by name; passes of one name in one frame add up.
pub struct Timer {
    stamps: Option<Stamps>,
    /// This frame's passes with stamps, in order.
    stamped: Vec<&'static str>,
    recorded: Vec<(&'static str, f64)>,
    open: Option<(&'static str, Instant)>,
    /// This frame's passes, timed or not.
    counted: Passes,
    /// Milliseconds of every frame that has arrived.
    frames: BTreeMap<&'static str, Vec<f64>>,
}

/// How many passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Passes {
    pub render: u32,
    pub compute: u32,
}

struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: Readback<Vec<&'static str>>,
    sending: Option<usize>,
    nanoseconds: f64,
}

impl Timer {
    pub fn new(gpu: &Gpu) -> Self {
        let stamps = gpu.has(wgpu::Features::TIMESTAMP_QUERY).then(|| Stamps::new(gpu));
        Self {
            stamps,
            stamped: Vec::new(),
            recorded: Vec::new(),
            open: None,
            counted: Passes::default(),
            frames: BTreeMap::new(),
        }
    }

    /// Whether times are the GPU's own.
    pub fn on_gpu(&self) -> bool {
        self.stamps.is_some()
    }

    fn begin(&mut self, name: &'static str) -> Option<(&wgpu::QuerySet, u32)> {
        self.end();
        self.open = Some((name, Instant::now()));
        let stamps = self.stamps.as_ref()?;
        let index = self.stamped.len() as u32;
        if index >= MOST {
            return None;
        }
        self.stamped.push(name);
        Some((&stamps.queries, index * 2))
    }

    pub fn compute(&mut self, name: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        self.counted.compute += 1;
        let (query_set, first) = self.begin(name)?;
        Some(wgpu::ComputePassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    pub fn render(&mut self, name: &'static str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        self.counted.render += 1;
        let (query_set, first) = self.begin(name)?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    /// The pass that was begun last is recorded.
    fn end(&mut self) {
        if let Some((name, since)) = self.open.take() {
            self.recorded.push((name, since.elapsed().as_secs_f64() * 1e3));
        }
    }

    /// The passes of this frame so far; the next ones are counted from 0.
    pub fn count(&mut self) -> Passes {
        std::mem::take(&mut self.counted)
    }

    /// At the end of the frame's commands.
    pub fn resolve(&mut self, encoder: &mut wgpu::CommandEncoder) {
        self.end();
        let names = std::mem::take(&mut self.stamped);
        let Some(stamps) = &mut self.stamps else {
            let recorded = std::mem::take(&mut self.recorded);
            add(&mut self.frames, recorded);
            return;
        };
        self.recorded.clear();
        if names.is_empty() {
            return;
        }
        encoder.resolve_query_set(&stamps.queries, 0..names.len() as u32 * 2, &stamps.resolved, 0);
        stamps.sending = stamps.readback.copy(encoder, &stamps.resolved, names);
    }

    /// After the submit.
    pub fn sent(&mut self) {
        if let Some(stamps) = &mut self.stamps {
            stamps.readback.send(stamps.sending.take());
        }
    }

    /// Takes in what has arrived.
    pub fn receive(&mut self) {
        let Some(stamps) = &mut self.stamps else { return };
        for (names, times) in stamps.readback.receive::<u64>() {
            let spans = names.iter().zip(times.chunks_exact(2)).map(|(name, times)| {
                (*name, times[1].saturating_sub(times[0]) as f64 * stamps.nanoseconds * 1e-6)
            });
            add(&mut self.frames, spans);
        }
    }

    /// Milliseconds of each pass, mean of the last frames in which it ran.
    pub fn recent(&self) -> Vec<(&'static str, f64)> {
        const LAST: usize = 30;
        let mean = |times: &Vec<f64>| {
            let last = &times[times.len().saturating_sub(LAST)..];
            last.iter().sum::<f64>() / last.len().max(1) as f64
        };
        self.frames.iter().map(|(name, times)| (*name, mean(times))).collect()
    }

    /// Median and 99th percentile of the frames in which a pass ran, milliseconds.
    pub fn summary(&self) -> BTreeMap<&'static str, [f64; 2]> {
        let of = |times: &Vec<f64>| {
            let mut sorted = times.clone();
            sorted.sort_by(f64::total_cmp);
            let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
            [at(0.5), at(0.99)]
        };
        self.frames.iter().map(|(name, times)| (*name, of(times))).collect()
    }
}

fn add(frames: &mut BTreeMap<&'static str, Vec<f64>>, spans: impl IntoIterator<Item = (&'static str, f64)>) {
    let mut sums: BTreeMap<&'static str, f64> = BTreeMap::new();
    for (name, milliseconds) in spans {
        *sums.entry(name).or_default() += milliseconds;
    }
    for (name, milliseconds) in sums {
        let times = frames.entry(name).or_default();
        times.push(milliseconds);
        if times.len() > KEPT {
            times.drain(..KEPT / 2);
        }
    }
}

impl Stamps {
    fn new(gpu: &Gpu) -> Self {
        let bytes = u64::from(MOST) * 2 * 8;
        Self {
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("timing"),
                ty: wgpu::QueryType::Timestamp,
                count: MOST * 2,
            }),
            resolved: empty(gpu, "timing", bytes, wgpu::BufferUsages::QUERY_RESOLVE),
            readback: Readback::new(gpu, bytes),
            sending: None,
            nanoseconds: f64::from(gpu.queue.get_timestamp_period()),
        }
    }
}
