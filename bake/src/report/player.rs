//! What only the player can say: the scene's picture, milliseconds on the GPU, and the light that the GPU solved.
//!
//! It is run from beside this program's own executable, without a window: for the light, for the picture, for a few frames
//! with all motion, and twice for every number of products (a single frame from darkness for the light, several for the
//! time). What every report has to show comes first; what refines it takes the time that is left, and more frames where
//! frames are quick. Where the player is missing or cannot draw, the report says so and goes on.

mod child;
mod light;

use std::path::Path;

use engine::transport::Transport;
use serde::Deserialize;

pub use self::light::GpuLight;
pub use super::model::PassTime;

use self::child::{Child, Ended};
use super::Budget;
use crate::{BakeError, Watcher};

/// Of the picture; it is small enough for the page and for a GPU that is none.
const SIZE: &str = "960x540";
/// Where the picture does not matter.
const SMALL: &str = "16x16";
/// Until light has settled, and reflections, too.
const SOLVED_FRAMES: u32 = 4;
const STILL_FRAMES: u32 = 16;
/// With all motion: at least, and half a second of it where that takes no more than so much of what is left.
const FEW_FRAMES: usize = 6;
const LIVE_FRAMES: usize = 30;
const FOR_LIVE: f64 = 0.25;
const TIMED_FRAMES: usize = 8;
/// The widest spread first: what the time does not allow for is missing between them.
const PRODUCTS: [u32; 9] = [1, 16, 4, 8, 2, 3, 6, 12, 24];
/// So many of them in any case.
const LEAST: usize = 3;

/// Of the time that is left when its turn comes, what each may take.
const FOR_LIGHT: f64 = 0.5;
const FOR_PICTURE: f64 = 0.5;
const FOR_MOTION: f64 = 0.4;

/// What the player showed and said.
#[derive(Clone, Debug, Default)]
pub struct Played {
    /// As it draws the scene at its start, PNG.
    pub picture: Option<Vec<u8>>,
    pub adapter: String,
    /// Whether its passes were timed by the GPU; else these are the times to record them on the CPU.
    pub on_gpu: bool,
    /// While everything moves that the scene moves.
    pub passes: Vec<PassTime>,
    /// From picture to picture by the clock, waiting for the GPU.
    pub frame: Option<PassTime>,
    /// The error of B is at most this share of the largest B, as the last frame said.
    pub bound: Option<f64>,
    /// Solved, the scene as it is at the start.
    pub light: Option<GpuLight>,
    /// From darkness, one frame of so many products, by number of products.
    pub sweep: Vec<Swept>,
}

/// So many products in one frame, from darkness.
#[derive(Clone, Debug, Default)]
pub struct Swept {
    pub products: u32,
    /// Of the bounce in a frame of so many products: the median of `frames`, and from it to the 99th percentile [ms].
    pub milliseconds: f64,
    pub range: [f64; 2],
    pub frames: usize,
    pub light: GpuLight,
}

/// What the player said, and what it did not say and why.
pub fn play(
    project: &Path,
    scene: &str,
    transport: &Transport,
    budget: &Budget,
    watcher: &dyn Watcher,
) -> Result<(Option<Played>, Vec<String>), BakeError> {
    watcher.stage("player", 4 + 2 * PRODUCTS.len() as u64);
    let child = match Child::new(project, scene) {
        Ok(child) => child,
        Err(why) => return Ok((None, vec![format!("no picture and no times on the GPU: {why}")])),
    };
    let run = Run { child, transport, watcher };
    let mut played = match run.solved(&budget.part(FOR_LIGHT))? {
        Ok(played) => played,
        Err(why) => return Ok((None, vec![format!("no picture and no times on the GPU: {why}")])),
    };
    let mut notes = Vec::new();
    match run.picture(&budget.part(FOR_PICTURE))? {
        Ok(picture) => played.picture = Some(picture),
        Err(why) => notes.push(format!("no picture: {why}")),
    }
    let (few, rest) = PRODUCTS.split_at(LEAST);
    let began = budget.spent();
    match run.live(FEW_FRAMES, &budget.part(FOR_MOTION))? {
        Ok(said) => said.times(&mut played),
        Err(why) => notes.push(format!("no times of the moving scene on the GPU: {why}")),
    }
    let seconds = (budget.spent() - began) * (LIVE_FRAMES / FEW_FRAMES) as f64;
    run.sweep(few, &mut played.sweep, &mut notes, budget)?;
    if seconds < FOR_LIVE * budget.left()
        && let Ok(said) = run.live(LIVE_FRAMES, budget)?
    {
        said.times(&mut played);
    }
    run.sweep(rest, &mut played.sweep, &mut notes, budget)?;
    played.sweep.sort_by_key(|swept| swept.products);
    Ok((Some(played), notes))
}

struct Run<'a> {
    child: Child<'a>,
    transport: &'a Transport,
    watcher: &'a dyn Watcher,
}

/// Done, or why not; the outer error ends the report.
type Said<T> = Result<Result<T, String>, BakeError>;

impl Run<'_> {
    /// The light of the scene as it is at the start, without what moves (the reference knows static surfaces alone), and
    /// what it was solved with.
    fn solved(&self, budget: &Budget) -> Said<Played> {
        let args = ["--still", "--stats", "stats.json", "--light", "light.csv", "--size", SMALL];
        Ok(self.still(SOLVED_FRAMES, &args, budget)?.and_then(|()| {
            let said = self.statistics()?;
            Ok(Played {
                bound: said.bound.iter().rev().copied().flatten().next(),
                on_gpu: said.timing == "gpu",
                adapter: said.adapter,
                light: Some(self.light()?),
                ..Played::default()
            })
        }))
    }

    fn picture(&self, budget: &Budget) -> Said<Vec<u8>> {
        let last = STILL_FRAMES.to_string();
        let args = ["--out", "pictures", "--every", &last, "--size", SIZE];
        let file = self.child.file(&format!("pictures/frame_{:05}.png", STILL_FRAMES - 1));
        let read = || std::fs::read(file).map_err(|error| error.to_string());
        Ok(self.still(STILL_FRAMES, &args, budget)?.and_then(|()| read()))
    }

    /// The scene as it is at the start, until nothing changes any more.
    fn still(&self, frames: u32, args: &[&str], budget: &Budget) -> Said<()> {
        let frames = frames.to_string();
        self.run(&[&["--frames", &frames, "--fixed-dt", "0"], args].concat(), budget)
    }

    /// Frames of a sixtieth of a second in which everything moves that does.
    fn live(&self, frames: usize, budget: &Budget) -> Said<Statistics> {
        let frames = frames.to_string();
        let args =
            ["--frames", &frames, "--fixed-dt", "0.016666667", "--size", SIZE, "--stats", "stats.json"];
        Ok(self.run(&args, budget)?.and_then(|()| self.statistics()))
    }

    /// One number of products after the other, until the time is up.
    fn sweep(
        &self,
        counts: &[u32],
        swept: &mut Vec<Swept>,
        notes: &mut Vec<String>,
        budget: &Budget,
    ) -> Result<(), BakeError> {
        for (k, &products) in counts.iter().enumerate() {
            match self.swept(products, budget)? {
                Ok(found) => swept.push(found),
                Err(why) => {
                    let missing: Vec<String> = counts[k..].iter().map(u32::to_string).collect();
                    notes.push(format!("on the GPU no frames of {} products: {why}", missing.join(", ")));
                    break;
                }
            }
        }
        Ok(())
    }

    fn swept(&self, products: u32, budget: &Budget) -> Said<Swept> {
        let (count, frames) = (products.to_string(), TIMED_FRAMES.to_string());
        let args = ["--products", &count, "--size", SMALL, "--fixed-dt", "0", "--still"];
        let once = ["--frames", "1", "--light", "light.csv"];
        let light = match self.run(&[&args[..], &once[..]].concat(), budget)?.and_then(|()| self.light()) {
            Ok(light) => light,
            Err(why) => return Ok(Err(why)),
        };
        let often = ["--frames", &frames, "--stats", "stats.json"];
        let said = self.run(&[&args[..], &often[..]].concat(), budget)?.and_then(|()| self.statistics());
        Ok(said.and_then(|said| {
            let bounce = said.passes.get("bounce").ok_or("nothing bounces in this scene")?;
            let (milliseconds, range) = (bounce.median_ms, [bounce.median_ms, bounce.p99_ms]);
            Ok(Swept { products, milliseconds, range, frames: TIMED_FRAMES, light })
        }))
    }

    fn run(&self, args: &[&str], budget: &Budget) -> Said<()> {
        let ended = self.child.run(args, budget, self.watcher)?;
        self.watcher.advance(1, 0);
        Ok(match ended {
            Ended::Well => Ok(()),
            Ended::Badly(said) => Err(format!("the player said: {said}")),
            Ended::Stopped(seconds) => {
                Err(format!("the budget had {seconds:.0} s for it, which was too short"))
            }
        })
    }

    fn statistics(&self) -> Result<Statistics, String> {
        let text = std::fs::read(self.child.file("stats.json")).map_err(|error| error.to_string())?;
        serde_json::from_slice(&text).map_err(|error| format!("its statistics are not understood: {error}"))
    }

    fn light(&self) -> Result<GpuLight, String> {
        let text = std::fs::read(self.child.file("light.csv")).map_err(|error| error.to_string())?;
        let light = GpuLight::read(&text).map_err(|error| format!("its light is not understood: {error}"))?;
        light.fits(self.transport).then_some(light).ok_or_else(|| "its light is of another bake".to_owned())
    }
}

/// What is read of `--stats`.
#[derive(Debug, Deserialize)]
struct Statistics {
    adapter: String,
    timing: String,
    passes: std::collections::BTreeMap<String, Spread>,
    frame: Option<Spread>,
    bound: Vec<Option<f64>>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
struct Spread {
    median_ms: f64,
    p99_ms: f64,
}

impl Statistics {
    fn times(self, played: &mut Played) {
        let time = |(name, spread): (String, Spread)| PassTime {
            name,
            median: spread.median_ms,
            p99: spread.p99_ms,
        };
        played.adapter = self.adapter;
        played.on_gpu = self.timing == "gpu";
        played.frame = self.frame.map(|spread| time(("frame".to_owned(), spread)));
        played.passes = self.passes.into_iter().map(time).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_are_read_whatever_else_they_hold() {
        let text = r#"{ "adapter": "A", "timing": "gpu", "frames": 2, "left_out": [],
            "passes": { "bounce": { "median_ms": 0.5, "p99_ms": 0.7 } },
            "frame": null, "bound": [null, 0.25] }"#;
        let said: Statistics = serde_json::from_str(text).unwrap();
        assert_eq!(said.bound, [None, Some(0.25)]);
        let mut played = Played::default();
        said.times(&mut played);
        assert_eq!(played.passes, [PassTime { name: "bounce".to_owned(), median: 0.5, p99: 0.7 }]);
        assert!(played.on_gpu && played.frame.is_none());
    }
}
