//! Milliseconds a frame against what solving leaves of the error: static light, from darkness.
//!
//! Every method solves the same stored rows with the same E, three channels, in f64 on this machine's processor, and is
//! looked at after 1, 2, 4, .. products; the runtime's own iteration, in f32, is looked at product by product and where
//! its bound falls below a tolerance. The first run of each is not counted. The truth is the exact solution. What the GPU
//! does has a diagram of its own: its milliseconds are no processor's.

use std::time::Instant;

use engine::transport::solve::{Channel, Method, Stop, cavity_gain, solve};
use engine::transport::steering::{Measured, TOLERANCE};
use glam::{DVec3, Vec3};

use super::bake_time::timed;
use super::lit::Lit;
use super::runtime::Runtime;
use crate::report::Budget;
use crate::report::model::{Axis, Diagram, Error, Floor, Norm, Point, Series};
use crate::report::player::{Played, Swept};
use crate::{BakeError, Watcher};

/// Runs of which the median is taken; more of the runtime's, which last milliseconds.
const RUNS: usize = 3;
const RUNS_OF_RUNTIME: usize = 9;
/// Products at which methods are looked at: powers of two up to this.
const MOST: u32 = 4096;
/// No iterate that is nearer than this, of the largest B, is followed further.
const ENOUGH: f64 = 1e-8;
/// Half a unit in the last place of f32.
pub const ROUNDING: f64 = 0.5 * f32::EPSILON as f64;
/// Tolerances of the runtime's iteration; the last is what it asks for at most: four units in the last place, times w.
const TOLERANCES: [f32; 6] = [1e-1, 1e-2, TOLERANCE, 1e-4, 1e-5, 1e-6];
const FINEST: f32 = 4.0 * f32::EPSILON;
/// Products after which rounding keeps the bound above its tolerance for good.
const PATIENCE: u32 = 256;

/// What is solved, and its solution.
pub struct Problem<'a> {
    pub lit: &'a Lit<'a>,
    pub e: &'a [DVec3],
    pub exact: &'a [DVec3],
}

/// The processor's, then the GPU's where there is one.
pub fn diagrams(
    problem: &Problem,
    played: Option<&Played>,
    budget: &Budget,
    watcher: &dyn Watcher,
) -> Result<Vec<Diagram>, BakeError> {
    watcher.stage("solvers", Method::all().len() as u64 + 1);
    let rows = &problem.lit.transport.patch_from_patch;
    let system = problem.lit.system(rows);
    let channels: [Channel; 3] = std::array::from_fn(|channel| Channel::of(&system, channel));
    let gain = channels.iter().map(|channel| channel.largest_gain).fold(1.0, f64::max);
    let runtime = Runtime::new(&system, gain);
    let mut series = vec![by_product(problem, &runtime), by_tolerance(problem, &runtime)];
    watcher.advance(1, 0);
    // Southwell's looks through all patches for every one that it shoots from, and takes longest: it has the last turn,
    // and with it the time that the others did not use.
    let mut turns = Method::all();
    turns.sort_by_key(|method| *method == Method::Southwell);
    for (k, method) in turns.into_iter().enumerate() {
        if watcher.cancelled() {
            return Err(BakeError::Cancelled);
        }
        let part = budget.part(1.0 / (turns.len() - k) as f64);
        series.push(of_method(problem, &channels, method, &part));
        watcher.advance(1, 0);
    }
    series.retain(|series| !series.points.is_empty());
    let floors = vec![Floor { name: "rounding of f32, eps w".to_owned(), y: ROUNDING * gain }];
    let on_gpu = played.and_then(|played| on_gpu(problem, played, &runtime, floors.clone()));
    let on_cpu = Diagram {
        id: "frame".to_owned(),
        title: "Frame time and the error of solving".to_owned(),
        about: "How near to the solution is the light after so many products, from darkness? Largest error of any patch \
                over the largest radiosity; the rows are the shipped bake's. All three channels: f64 methods take them one \
                after the other, the runtime's iteration all at once in f32."
            .to_owned(),
        x: milliseconds(),
        y: Axis { label: "largest error over largest radiosity".to_owned(), unit: String::new() },
        norm: Norm::Max,
        series,
        floors,
    };
    Ok([on_cpu].into_iter().chain(on_gpu).collect())
}

pub fn milliseconds() -> Axis {
    Axis { label: "frame".to_owned(), unit: "ms".to_owned() }
}

/// rms and bias as everywhere, by area; 99th percentile and largest as shares of the largest value, as bounds are.
pub fn error_of(found: &[DVec3], exact: &[DVec3], areas: &[f64]) -> Error {
    let flat = |values: &[DVec3]| super::lit::field(values.iter().copied());
    let (found, exact) = (flat(found), flat(exact));
    let weights: Vec<f64> = (0..3).flat_map(|_| areas.iter().copied()).collect();
    let largest = exact.iter().fold(0.0_f64, |max, b| max.max(b.abs()));
    if largest == 0.0 {
        return Error::default();
    }
    let mut far: Vec<f64> = found.iter().zip(&exact).map(|(a, b)| (a - b).abs() / largest).collect();
    far.sort_by(f64::total_cmp);
    let p99 = far[((0.99 * far.len() as f64) as usize).min(far.len() - 1)];
    Error { p99, max: far[far.len() - 1], ..Error::of(&found, &exact, &weights) }
}

impl Problem<'_> {
    fn error(&self, found: &[DVec3]) -> Error {
        error_of(found, self.exact, &self.areas())
    }

    fn areas(&self) -> Vec<f64> {
        self.lit.transport.patches.iter().map(|patch| f64::from(patch.area)).collect()
    }
}

/// The first iterate at or above a rung of the ladder of products, and when it was reached [s].
struct Rung {
    products: f64,
    seconds: f64,
    b: Vec<f64>,
}

/// One channel's iterates, and whether it went on until it was near enough.
struct Climbed {
    rungs: Vec<Rung>,
    reached: bool,
}

impl Climbed {
    /// What it had on a rung: above its last one, the last.
    fn at(&self, k: usize) -> Option<&Rung> {
        self.rungs.get(k).or(self.rungs.last())
    }
}

fn of_method(problem: &Problem, channels: &[Channel; 3], method: Method, budget: &Budget) -> Series {
    let mut runs: Vec<[Climbed; 3]> = Vec::new();
    while runs.len() <= RUNS && (runs.is_empty() || budget.left() > budget.spent() / runs.len() as f64) {
        runs.push(std::array::from_fn(|c| {
            let e: Vec<f64> = problem.e.iter().map(|e| e[c]).collect();
            climb(method, &channels[c], &e, &budget.part(1.0 / (3 - c) as f64))
        }));
    }
    if runs.len() > 1 {
        runs.remove(0);
    }
    let point = |k: usize| {
        let of = |c: usize, i: usize| runs[0][c].at(k).map_or(0.0, |rung| rung.b[i]);
        let b: Vec<DVec3> =
            (0..problem.e.len()).map(|i| DVec3::from_array(std::array::from_fn(|c| of(c, i)))).collect();
        let seconds =
            |run: &[Climbed; 3]| run.iter().filter_map(|one| one.at(k)).map(|rung| rung.seconds).sum::<f64>();
        let times: Vec<f64> = runs.iter().map(|run| 1e3 * seconds(run)).collect();
        let most = runs[0].iter().filter_map(|one| one.rungs.get(k)).map(|rung| rung.products);
        let setting = products(most.fold(0.0, f64::max).round() as u32);
        Point { setting, error: problem.error(&b), ..timed(&times) }
    };
    let height = runs.iter().map(height).min().unwrap_or(0);
    Series::new(method.name(), (0..height).map(point).collect())
}

/// Rungs on which every channel was, or was done before.
fn height(run: &[Climbed; 3]) -> usize {
    let highest = run.iter().map(|one| one.rungs.len()).max().unwrap_or(0);
    run.iter().filter(|one| !one.reached).map(|one| one.rungs.len()).fold(highest, usize::min)
}

/// Follows one channel's iterates from darkness; looking at them takes no time.
fn climb(method: Method, channel: &Channel, e: &[f64], budget: &Budget) -> Climbed {
    let mut rungs: Vec<Rung> = Vec::new();
    let (mut seconds, mut resumed, mut next, mut last) = (0.0, Instant::now(), 1.0, 0.0);
    let stop = Stop { tolerance: ENOUGH, products: f64::from(MOST) + 1.0, cancelled: &|| budget.is_spent() };
    let solved = solve(method, channel, e, None, &stop, &mut |iterate| {
        seconds += resumed.elapsed().as_secs_f64();
        if iterate.products == 0.0 {
            seconds = 0.0; // what is prepared once an albedo is no frame's
        } else if iterate.products + 1e-9 >= next {
            rungs.push(Rung { products: iterate.products, seconds, b: iterate.b.to_vec() });
            while next <= iterate.products + 1e-9 {
                next *= 2.0;
            }
        }
        last = iterate.products;
        resumed = Instant::now();
    });
    // The one that is near enough lies between two rungs, or on the highest.
    if solved.reached && rungs.last().is_none_or(|rung| rung.products < last) {
        rungs.push(Rung { products: last, seconds, b: solved.b });
    }
    Climbed { rungs, reached: solved.reached }
}

/// The runtime's iteration, product by product.
fn by_product(problem: &Problem, runtime: &Runtime) -> Series {
    let first = runtime.first();
    let mut ladder = vec![1, 2, 4, 8, 16, 32, first];
    ladder.sort_unstable();
    ladder.dedup();
    let point = |&count: &u32| {
        let (b, times) = run(problem, runtime, |step, _| step >= count);
        let setting =
            if count == first { format!("{} (a first frame)", products(count)) } else { products(count) };
        Point { setting, error: problem.error(&b), ..timed(&times) }
    };
    let name = format!("runtime's {}, f32", runtime.choice.method.name());
    Series::new(name, ladder.iter().map(point).collect())
}

/// The same until its bound is small enough, as the runtime asks.
fn by_tolerance(problem: &Problem, runtime: &Runtime) -> Series {
    let point = |tolerance: f32| {
        let mut taken = 0;
        let (b, times) = run(problem, runtime, |step, measured| {
            taken = step;
            step >= PATIENCE || (step > 0 && measured.bound(runtime.gain) <= tolerance)
        });
        let preset = (tolerance == TOLERANCE).then(|| "runtime".to_owned());
        let setting = format!("tolerance {tolerance:.0e}, {}", products(taken));
        Point { setting, error: problem.error(&b), preset, ..timed(&times) }
    };
    let finest = FINEST * runtime.gain;
    let coarser = TOLERANCES.into_iter().filter(|tolerance| *tolerance > 2.0 * finest);
    let points = coarser.chain([finest]).map(point).collect();
    Series::new("runtime's, until its bound says so", points)
}

/// Until told to stop after so many products and with what the last one measured; milliseconds of every run.
fn run(
    problem: &Problem,
    runtime: &Runtime,
    mut stop: impl FnMut(u32, Measured) -> bool,
) -> (Vec<DVec3>, Vec<f64>) {
    let e: Vec<Vec3> = problem.e.iter().map(|e| e.as_vec3()).collect();
    let mut times = Vec::new();
    let mut b = Vec::new();
    for _ in 0..=RUNS_OF_RUNTIME {
        b = e.clone();
        let started = Instant::now();
        let mut measured = runtime.frame(&e, &mut b, 0, 0);
        let mut step = 0;
        while !stop(step, measured) {
            measured = runtime.frame(&e, &mut b, 1, 0);
            step += 1;
        }
        times.push(1e3 * started.elapsed().as_secs_f64());
    }
    times.remove(0);
    (b.iter().map(|b| b.as_dvec3()).collect(), times)
}

/// The player's sweep: its bounce, from darkness. Its E is its own, and so is the solution it is compared with.
fn on_gpu(problem: &Problem, played: &Played, runtime: &Runtime, floors: Vec<Floor>) -> Option<Diagram> {
    let lit = problem.lit;
    let n = problem.e.len();
    let point = |swept: &Swept| {
        let light = &swept.light;
        if light.exitance.len() != n || light.radiosity.len() < n {
            return None;
        }
        let from_sky = lit.sky_on_patches();
        let e: Vec<DVec3> =
            (0..n).map(|i| light.exitance[i] + lit.albedo[i].as_dvec3() * from_sky[i]).collect();
        let exact = lit.solve(&lit.transport.patch_from_patch, &e);
        let error = error_of(&light.radiosity[..n], &exact, &problem.areas());
        let preset = (swept.products == runtime.first()).then(|| "runtime".to_owned());
        let x = Point { x: swept.milliseconds, x_range: swept.range, runs: swept.frames, ..Point::default() };
        Some(Point { setting: products(swept.products), error, preset, ..x })
    };
    let points: Vec<Point> = played.sweep.iter().filter_map(point).collect();
    let timing = if played.on_gpu { "by the GPU's clock" } else { "to record it" };
    (!points.is_empty()).then(|| Diagram {
        id: "frame_gpu".to_owned(),
        title: "Frame time on the GPU and the error of solving".to_owned(),
        about: format!(
            "The same for the player's bounce, {timing}: one frame of so many products, from darkness, against the exact \
             solution of the stored rows under the light that the GPU had. Marked is what the player takes in its first \
             frame."
        ),
        x: milliseconds(),
        y: Axis { label: "largest error over largest radiosity".to_owned(), unit: String::new() },
        norm: Norm::Max,
        series: vec![Series::new(format!("{}, f32, {}", runtime.choice.method.name(), played.adapter), points)],
        floors,
    })
}

/// w, the largest of all channels.
pub fn largest_gain(lit: &Lit) -> f64 {
    let w = cavity_gain(&lit.system(&lit.transport.patch_from_patch));
    w.iter().map(|w| w.max_element()).fold(1.0, f64::max)
}

pub fn products(count: u32) -> String {
    if count == 1 { "1 product".to_owned() } else { format!("{count} products") }
}
