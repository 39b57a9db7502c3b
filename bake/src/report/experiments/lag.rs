//! Milliseconds a frame against how late the light is: scripted light, every method going on from its last frame.
//!
//! ```text
//! lag = max over frames and patches of |B_t - exact(E_t)|  /  max over the script of exact(E_t)
//! ```
//! Three channels, each with the albedo of the one that reflects most: the three are one problem, so that of the methods
//! one channel is solved and its time counted three times, while the runtime's iteration takes all three at once. Methods
//! are given 1, 2, 4 .. products a frame, until their lag is no more than rounding or a frame takes longer than it lasts;
//! the runtime's rule gives as many as the bound of the frame before the last asks for. Each script has a few frames before
//! it counts, in which the rule gets to know the light.

use std::time::Instant;

use engine::transport::solve::{Channel, Method, Stop, System, solve};
use engine::transport::steering::{Measured, Steering};
use glam::Vec3;

use super::bake_time::timed;
use super::frame::{ROUNDING, milliseconds, products};
use super::lit::Lit;
use super::runtime::Runtime;
use super::script::{Script, WARM, scripts};
use crate::report::Budget;
use crate::report::model::{Axis, Diagram, Error, Floor, Norm, Point, Series};
use crate::{BakeError, Watcher};

/// No frame is given more.
const MOST: u32 = 1024;
/// What a picture may take at 60 a second [ms].
const FRAME: f64 = 1e3 / 60.0;
/// Which are one problem.
const CHANNELS: f64 = 3.0;
/// Within so many times of its floor a curve is followed no further.
const AT_FLOOR: f64 = 2.0;
const METHODS: [Method; 5] =
    [Method::TwoLevel, Method::ConjugateGradients, Method::Jacobi, Method::Chebyshev, Method::GaussSeidel];
/// The truth's bound, of the largest radiosity: far below any lag.
const EXACT: f64 = 1e-7;

/// A script with its E and its solution, frame by frame, one channel.
struct Played {
    name: &'static str,
    moves: bool,
    begins_solved: bool,
    e: Vec<Vec<f64>>,
    exact: Vec<Vec<f64>>,
    largest: f64,
}

/// Light that moves, and light that jumps.
pub fn diagrams(
    lit: &Lit,
    budget: &Budget,
    watcher: &dyn Watcher,
    notes: &mut Vec<String>,
) -> Result<Vec<Diagram>, BakeError> {
    let rho: Vec<Vec3> = stiffest(lit);
    let rows = &lit.transport.patch_from_patch;
    let system = System { rows, patches: &lit.transport.patches, albedo: &rho };
    let channel = Channel::of(&system, 0);
    let scripts = scripts(lit);
    watcher.stage("moving light", scripts.len() as u64);
    let mut played = Vec::new();
    for script in &scripts {
        if budget.is_spent() {
            notes.push(format!("lag: no time for {}", script.name));
            continue;
        }
        match play(lit, &channel, script) {
            Some(one) => played.push(one),
            None => notes.push(format!("lag: {} lights no patch of this scene", script.name)),
        }
        watcher.advance(1, 0);
        if watcher.cancelled() {
            return Err(BakeError::Cancelled);
        }
    }
    let groups = [
        (true, "lag_moving", "Frame time and lag of light that moves"),
        (false, "lag_switching", "Frame time and lag of light that jumps"),
    ];
    let of_group = |&(moves, id, title): &(bool, &str, &str)| {
        let played: Vec<&Played> = played.iter().filter(|played| played.moves == moves).collect();
        let part = budget.part(if moves { 0.5 } else { 1.0 });
        diagram(&system, &channel, &played, id, title, &part)
    };
    Ok(groups.iter().map(of_group).filter(|diagram| !diagram.series.is_empty()).collect())
}

/// The channel that reflects most, in all three.
fn stiffest(lit: &Lit) -> Vec<Vec3> {
    let sum: Vec3 = lit.albedo.iter().sum();
    let channel = (0..3).max_by(|&a, &b| sum[a].total_cmp(&sum[b])).unwrap_or(0);
    lit.albedo.iter().map(|albedo| Vec3::splat(albedo[channel])).collect()
}

/// None where nothing is ever lit.
fn play(lit: &Lit, channel: &Channel, script: &Script) -> Option<Played> {
    let of_frame = |light: &Option<engine::transport::direct::PlacedLight>| -> Vec<f64> {
        let lights: Vec<_> = light.iter().cloned().collect();
        let direct = lit.direct(&lights);
        direct.iter().zip(&channel.matrix.albedo).map(|(h, rho)| f64::from(h.x) * rho).collect()
    };
    let mut e: Vec<Vec<f64>> = Vec::new();
    let mut exact: Vec<Vec<f64>> = Vec::new();
    for (t, light) in script.frames.iter().enumerate() {
        // What was there before needs no second solution.
        let same = (0..t).find(|&before| is_same(&script.frames[before], light));
        let (e_t, b_t) = match same {
            Some(before) => (e[before].clone(), exact[before].clone()),
            None => {
                let e_t = of_frame(light);
                let stop = Stop::at(EXACT, 1000.0);
                let method = Method::for_truth(channel.matrix.patches);
                let start = exact.last().map(Vec::as_slice);
                let b_t = solve(method, channel, &e_t, start, &stop, &mut |_| {}).b;
                (e_t, b_t)
            }
        };
        e.push(e_t);
        exact.push(b_t);
    }
    let largest = exact.iter().flatten().fold(0.0_f64, |max, b| max.max(*b));
    let Script { name, moves, begins_solved, .. } = *script;
    (largest > 0.0).then_some(Played { name, moves, begins_solved, e, exact, largest })
}

fn is_same(
    a: &Option<engine::transport::direct::PlacedLight>,
    b: &Option<engine::transport::direct::PlacedLight>,
) -> bool {
    let place = |light: &Option<engine::transport::direct::PlacedLight>| {
        light.as_ref().map(|light| (light.position, light.direction))
    };
    place(a) == place(b)
}

fn diagram(
    system: &System,
    channel: &Channel,
    played: &[&Played],
    id: &str,
    title: &str,
    budget: &Budget,
) -> Diagram {
    let mut series = Vec::new();
    let floor = (ROUNDING * channel.largest_gain).max(EXACT);
    if !played.is_empty() {
        let runtime = Runtime::new(system, channel.largest_gain);
        let name = format!("runtime's rule, {}, f32", runtime.choice.method.name());
        series.push(Series::new(name, vec![of_runtime(&runtime, played)]));
        for (k, method) in METHODS.into_iter().enumerate() {
            let part = budget.part(1.0 / (METHODS.len() - k) as f64);
            let points = followed(method, channel, played, AT_FLOOR * floor, &part);
            let ends = points.last().filter(|last| last.error.max > AT_FLOOR * floor && is_too_long(last));
            let ends = ends.map(|_| "as far as a frame lasts".to_owned());
            series.push(Series { ends, ..Series::new(method.name(), points) });
        }
    }
    series.retain(|series| !series.points.is_empty());
    let scripts: Vec<&str> = played.iter().map(|played| played.name).collect();
    Diagram {
        id: id.to_owned(),
        title: title.to_owned(),
        about: format!(
            "How late is the light? Scripts at 60 frames a second: {}; one lamp or sun that the script puts into the \
             scene's box, all other light off. The worst frame's largest error over the script's largest radiosity, and \
             the median frame; three channels, from the last frame's light. No frame is given \
             longer than it lasts.",
            scripts.join(", ")
        ),
        x: milliseconds(),
        y: Axis { label: "worst lag over largest radiosity".to_owned(), unit: String::new() },
        norm: Norm::Max,
        series,
        floors: vec![Floor { name: "rounding of f32, eps w".to_owned(), y: floor }],
    }
}

/// Twice the products each time.
fn followed(
    method: Method,
    channel: &Channel,
    played: &[&Played],
    enough: f64,
    budget: &Budget,
) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    let mut count = 1;
    let is_done = |point: &Point| point.error.max <= enough || is_too_long(point);
    while count <= MOST && !budget.is_spent() && !points.last().is_some_and(is_done) {
        points.extend(of_method(method, channel, played, count));
        count *= 2;
    }
    points
}

/// Twice its products would take longer than the frame lasts.
fn is_too_long(point: &Point) -> bool {
    2.0 * point.x > FRAME
}

/// The worst of all frames so far, of whichever script.
#[derive(Default)]
struct Worst {
    error: Error,
    script: &'static str,
}

impl Worst {
    fn see(&mut self, played: &Played, t: usize, b: impl Iterator<Item = f64>) {
        let exact = &played.exact[t];
        let mut far: Vec<f64> = b.zip(exact).map(|(b, exact)| (b - exact) / played.largest).collect();
        let n = far.len().max(1) as f64;
        let bias = far.iter().sum::<f64>() / n;
        let rms = (far.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
        far.iter_mut().for_each(|e| *e = e.abs());
        far.sort_by(f64::total_cmp);
        let max = far.last().copied().unwrap_or(0.0);
        if max >= self.error.max {
            let p99 = far[((0.99 * n) as usize).min(far.len() - 1)];
            *self = Self { error: Error { rms, bias, p99, max }, script: played.name };
        }
    }

    fn point(self, what: String, times: &[f64]) -> Point {
        let setting = format!("{what}, worst: {}", self.script);
        Point { setting, error: self.error, ..timed(times) }
    }
}

/// From light that was solved the frame before. None where the method's first step takes more products.
fn of_method(method: Method, channel: &Channel, played: &[&Played], count: u32) -> Option<Point> {
    let (mut worst, mut times) = (Worst::default(), Vec::new());
    for played in played {
        let mut b = played.exact[WARM - 1].clone();
        for (t, e) in played.e.iter().enumerate().skip(WARM) {
            times.push(CHANNELS * 1e3 * step(method, channel, e, &mut b, count)?);
            worst.see(played, t, b.iter().copied());
        }
    }
    Some(worst.point(products(count), &times))
}

/// One frame: so many products from the last one's light. Returns seconds; none where it did not come to a step.
fn step(method: Method, channel: &Channel, e: &[f64], b: &mut [f64], count: u32) -> Option<f64> {
    let start = b.to_owned();
    let (mut began, mut seconds) = (Instant::now(), None);
    let stop = Stop::at(0.0, f64::from(count) + 1.0);
    solve(method, channel, e, Some(&start), &stop, &mut |iterate| {
        if iterate.products == 0.0 {
            began = Instant::now();
        } else if iterate.products <= f64::from(count) + 1e-9 {
            seconds = Some(began.elapsed().as_secs_f64());
            b.copy_from_slice(iterate.b);
        }
    });
    seconds
}

/// Products by the bound that was measured two frames before, as the runtime has it.
fn of_runtime(runtime: &Runtime, played: &[&Played]) -> Point {
    let (mut worst, mut times, mut spent, mut frames) = (Worst::default(), Vec::new(), 0, 0_u32);
    let splat = |values: &[f64]| -> Vec<Vec3> { values.iter().map(|&x| Vec3::splat(x as f32)).collect() };
    for played in played {
        let dark = vec![0.0; played.e[0].len()];
        let mut b = splat(if played.begins_solved { &played.exact[0] } else { &dark });
        let mut steering = Steering::default();
        // By frame, what its last product measured; it is known two frames later.
        let mut measured: Vec<Option<Measured>> = Vec::new();
        for (t, e) in played.e.iter().enumerate() {
            if t == 0 || played.e[t - 1] != *e {
                steering.change();
            }
            t.checked_sub(2).and_then(|t| measured[t]).into_iter().for_each(|known| steering.receive(known));
            let wanted = if t == 0 && played.begins_solved {
                2
            } else {
                steering.products(runtime.gain, &runtime.choice)
            };
            let e = splat(e);
            let started = Instant::now();
            let now = runtime.frame(&e, &mut b, wanted, steering.version());
            let milliseconds = 1e3 * started.elapsed().as_secs_f64();
            measured.push((wanted > 0).then_some(now));
            if t < WARM {
                continue;
            }
            frames += 1;
            spent += wanted;
            times.extend((wanted > 0).then(|| milliseconds / f64::from(wanted)));
            worst.see(played, t, b.iter().map(|b| f64::from(b.x)));
        }
    }
    let mean = f64::from(spent) / f64::from(frames.max(1));
    // A product's median, and as many as a frame had in the mean: the rule gives some frames many and some none.
    times.iter_mut().for_each(|time| *time *= mean);
    let point = worst.point(format!("{mean:.1} products a frame"), &times);
    Point { preset: Some("runtime".to_owned()), ..point }
}
