//! How far a bake is: stage, share, remaining time. The baker tells it from its threads, a panel reads it.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bake::Watcher;

/// Stages of a bake in their order, and the share of its time that each takes in an ordinary room. An unordinary scene
/// makes the whole bar run unevenly, one that does without a stage makes it jump; it never runs backwards.
const STAGES: [(&str, f64); 10] = [
    ("reading", 0.02),
    ("patches and receivers", 0.05),
    ("patch rows", 0.25),
    ("patches towards emitters", 0.03),
    ("receiver rows", 0.37),
    ("receivers towards emitters", 0.05),
    ("directional rows", 0.03),
    ("light probes", 0.04),
    ("balance", 0.12),
    ("certificate", 0.04),
];

/// What a panel shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Progress {
    pub stage: String,
    /// 0..1 of the stage.
    pub stage_share: f64,
    /// 0..1 of all stages.
    pub share: f64,
    /// As fast as it has been so far; `None`: too early to say.
    pub remaining: Option<Duration>,
    pub rays: u64,
    pub elapsed: Duration,
}

/// Told by the bake, and asked whether it is to stop.
pub struct Meter {
    began: Instant,
    stage: Mutex<Stage>,
    done: AtomicU64,
    rays: AtomicU64,
    cancelled: AtomicBool,
}

#[derive(Default)]
struct Stage {
    name: String,
    steps: u64,
    /// Share of all that lies behind the stage's start.
    behind: f64,
}

impl Default for Meter {
    fn default() -> Self {
        let [done, rays] = [AtomicU64::new(0), AtomicU64::new(0)];
        Self { began: Instant::now(), stage: Mutex::default(), done, rays, cancelled: AtomicBool::new(false) }
    }
}

impl Meter {
    /// How long such a stage takes is known.
    pub fn knows(stage: &str) -> bool {
        length(stage) > 0.0
    }

    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    pub fn progress(&self) -> Progress {
        self.after(self.began.elapsed())
    }

    fn after(&self, elapsed: Duration) -> Progress {
        let stage = self.current();
        let done = self.done.load(Ordering::Relaxed);
        let stage_share = stage.share(done);
        let share = stage.behind + stage_share * length(&stage.name);
        let remaining = (share > 0.05).then(|| elapsed.mul_f64((1.0 / share - 1.0).max(0.0)));
        let rays = self.rays.load(Ordering::Relaxed);
        Progress { stage: stage.name.clone(), stage_share, share, remaining, rays, elapsed }
    }

    fn current(&self) -> MutexGuard<'_, Stage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Stage {
    /// 0..1, of so many steps.
    fn share(&self, done: u64) -> f64 {
        if self.steps == 0 { 0.0 } else { (done as f64 / self.steps as f64).min(1.0) }
    }
}

/// Of a stage among all; one that is not known takes no time.
fn length(name: &str) -> f64 {
    STAGES.iter().find(|(known, _)| *known == name).map_or(0.0, |(_, length)| *length)
}

impl Watcher for Meter {
    fn stage(&self, name: &str, steps: u64) {
        let mut stage = self.current();
        let before =
            STAGES.iter().take_while(|(known, _)| *known != name).map(|(_, length)| length).sum::<f64>();
        let is_known = length(name) > 0.0;
        let done = stage.share(self.done.load(Ordering::Relaxed));
        let so_far = stage.behind + done * length(&stage.name);
        stage.behind = if is_known { so_far.max(before) } else { so_far };
        stage.name = name.to_owned();
        stage.steps = steps;
        self.done.store(0, Ordering::Relaxed);
    }

    fn advance(&self, steps: u64, rays: u64) {
        self.done.fetch_add(steps, Ordering::Relaxed);
        self.rays.fetch_add(rays, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_never_runs_backwards_and_ends_at_one() {
        let meter = Meter::default();
        let mut last = 0.0;
        for (stage, _) in STAGES {
            Watcher::stage(&meter, stage, 4);
            for _ in 0..4 {
                meter.advance(1, 10);
                let progress = meter.progress();
                assert!(progress.share >= last, "{progress:?}");
                assert_eq!(progress.stage, stage);
                last = progress.share;
            }
        }
        assert!((last - 1.0).abs() < 1e-12);
        assert_eq!(meter.progress().rays, 400);
    }

    #[test]
    fn a_stage_that_nobody_knows_takes_nothing_back() {
        let meter = Meter::default();
        Watcher::stage(&meter, "patch rows", 2);
        meter.advance(2, 0);
        let before = meter.progress().share;
        Watcher::stage(&meter, "something new", 5);
        meter.advance(1, 0);
        assert_eq!(meter.progress().share, before);
    }

    #[test]
    fn what_remains_follows_from_how_long_it_took_so_far() {
        let meter = Meter::default();
        assert_eq!(meter.after(Duration::from_secs(1)).remaining, None);
        Watcher::stage(&meter, "receiver rows", 100);
        meter.advance(50, 0); // 0.35 + 0.5 * 0.37
        let remaining = meter.after(Duration::from_secs(10)).remaining.unwrap().as_secs_f64();
        assert!((remaining - (10.0 / 0.535 - 10.0)).abs() < 1e-6, "{remaining}");
        assert!(!Watcher::cancelled(&meter));
        meter.cancel();
        assert!(Watcher::cancelled(&meter));
    }
}
