//! What the overlay says: time by pass, light, work, memory, what is left out; and the keys.

use std::time::Duration;

use super::world::World;
use crate::render::{Drawn, Eye, Renderer};
use crate::scene::{Feature, ToneCurve};

pub const KEYS: [&str; 9] = [
    "W A S D Q E   fly, with Shift faster; the wheel sets the speed",
    "right mouse   look        C   the scene's camera",
    "P, Space      pause       N   one picture on",
    "1..9          switch lights",
    "V             next view   + - exposure",
    "F1, Tab       overlay     H   these keys",
    "F2            vsync       F12 screenshot",
    "F9            loses the GPU device, to see it come back",
    "Esc           quit",
];

/// How long a picture took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Took {
    /// From the start of the last picture to that of this one.
    pub frame: Duration,
    /// To prepare and to send it, without waiting for the display.
    pub cpu: Option<Duration>,
}

/// Lines about the picture drawn last.
pub fn told(
    title: &str,
    took: Took,
    drawn: &Drawn,
    eye: &Eye,
    renderer: &Renderer,
    world: &World,
) -> Vec<String> {
    let milliseconds = |duration: Duration| duration.as_secs_f64() * 1e3;
    let frame = milliseconds(took.frame);
    let cpu = took.cpu.map_or(String::new(), |cpu| format!(", CPU {:.2} ms", milliseconds(cpu)));
    let mut lines =
        vec![title.to_owned(), format!("frame {frame:.2} ms, {:.1} a second{cpu}", 1e3 / frame.max(1e-3))];
    lines.extend(passes(renderer));
    lines.extend(work(drawn));
    lines.push(exposure(eye, renderer));
    lines.extend(memory(renderer));
    lines.extend(world.needs.told());
    lines.extend(left_out(world, renderer).map(|what| format!("left out: {what}")));
    lines.push(renderer.gpu().name());
    lines
}

/// Besides what the needs tell.
pub fn left_out<'a>(world: &'a World, renderer: &Renderer) -> impl Iterator<Item = String> + use<'a> {
    let told: Vec<&str> = Feature::ALL.iter().map(|feature| feature.name()).collect();
    let is_told = move |line: &String| line.split_once(':').is_some_and(|(what, _)| told.contains(&what));
    world.left_out.iter().cloned().chain(renderer.left_out()).filter(move |line| !is_told(line))
}

fn passes(renderer: &Renderer) -> Vec<String> {
    let by = if renderer.timer.on_gpu() { "GPU" } else { "CPU, to record" };
    let mut lines = vec![format!("passes [ms, {by}]")];
    lines.extend(renderer.timer.recent().iter().map(|(name, time)| format!("  {name:<18}{time:8.3}")));
    lines
}

fn work(drawn: &Drawn) -> [String; 2] {
    let bound = drawn.bound.map_or("unknown".to_owned(), |bound| format!("{:.3} %", bound * 100.0));
    [
        format!(
            "light within {bound}, light bounces {}, dispatches {}",
            drawn.products, drawn.transport_dispatches
        ),
        format!(
            "draws {}, of these shadows {}; captured faces {}",
            drawn.draws, drawn.shadow_draws, drawn.captures
        ),
    ]
}

fn exposure(eye: &Eye, renderer: &Renderer) -> String {
    let curve = match eye.tonemap {
        ToneCurve::Neutral => "neutral",
        ToneCurve::Agx => "AgX",
    };
    match (eye.auto_exposure, renderer.metered()) {
        (None, _) => format!("exposure {:+.2} EV, {curve}", eye.exposure),
        (Some(_), Some(stops)) => format!("exposure {stops:+.2} EV automatic, {curve}"),
        (Some(_), None) => format!("exposure automatic, {curve}"),
    }
}

fn memory(renderer: &Renderer) -> Vec<String> {
    let megabytes = |bytes: u64| bytes as f64 / 1e6;
    let bytes = renderer.bytes();
    let all: u64 = bytes.iter().map(|(_, bytes)| bytes).sum();
    let mut lines = vec![format!("memory on the GPU {:.1} MB", megabytes(all))];
    let used = bytes.iter().filter(|(_, bytes)| *bytes > 0);
    lines.extend(used.map(|&(kind, bytes)| format!("  {kind:<18}{:8.2}", megabytes(bytes))));
    lines
}
