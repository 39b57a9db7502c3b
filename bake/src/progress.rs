//! A bake's progress on stderr: a bar where somebody watches, plain lines where a log does.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::Watcher;

/// How often a log gets a line within one stage.
const BETWEEN_LINES: Duration = Duration::from_secs(5);

/// Shows stage, share, rays per second and the remaining time of the stage.
pub struct Bar {
    /// Hidden where stderr is no terminal.
    bar: ProgressBar,
    plain: bool,
    cancelled: Arc<AtomicBool>,
    rays: AtomicU64,
    stage: Mutex<Stage>,
    /// When all stages together are to be done; none: nobody knows.
    ends: Option<Instant>,
}

struct Stage {
    name: String,
    began: Instant,
    last_line: Instant,
}

impl Bar {
    pub fn new() -> Self {
        let plain = !std::io::stderr().is_terminal();
        let target = if plain { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        bar.set_style(style("{msg}  {eta} left"));
        let now = Instant::now();
        let stage = Stage { name: String::new(), began: now, last_line: now };
        let (cancelled, rays) = (Arc::default(), AtomicU64::new(0));
        Self { bar, plain, cancelled, rays, stage: Mutex::new(stage), ends: None }
    }

    /// Of work that is limited as a whole: shows what is left of that, not of the stage.
    pub fn within(limit: Duration) -> Self {
        let mut bar = Self::new();
        bar.bar.set_style(style("{msg}"));
        bar.ends = Instant::now().checked_add(limit);
        bar
    }

    /// Rays per second, and what is left of the whole where that is limited.
    fn message(&self, rays: u64) -> String {
        let rate = (rays > 0).then(|| rate(rays, self.bar.elapsed()));
        let parts = [rate, self.ends.map(left)];
        parts.into_iter().flatten().collect::<Vec<_>>().join("  ")
    }

    /// The first Ctrl-C (or SIGTERM) asks the bake to stop and keep what it has, the second ends the program,
    /// as any does when the bar is gone. To be called once in a program's life.
    pub fn stop_on_signals(&self) -> Result<(), ctrlc::Error> {
        let cancelled = Arc::downgrade(&self.cancelled);
        ctrlc::set_handler(move || {
            let asked_now =
                cancelled.upgrade().is_some_and(|cancelled| !cancelled.swap(true, Ordering::Relaxed));
            if !asked_now {
                std::process::exit(130); // what a shell reports for SIGINT
            }
            eprintln!("\nstopping; once more stops at once");
        })
    }

    /// A panic elsewhere must not end the display of progress.
    fn current(&self) -> MutexGuard<'_, Stage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn print_line(&self) {
        let mut stage = self.current();
        if stage.last_line.elapsed() < BETWEEN_LINES {
            return;
        }
        stage.last_line = Instant::now();
        let steps = self.bar.length().unwrap_or(0);
        let rays = self.rays.load(Ordering::Relaxed);
        let limit = self.ends.map_or(String::new(), |ends| format!(", {}", left(ends)));
        let line = line(&stage.name, self.bar.position(), steps, rays, stage.began.elapsed());
        eprintln!("{line}{limit}");
    }
}

impl Default for Bar {
    fn default() -> Self {
        Self::new()
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Watcher for Bar {
    fn stage(&self, name: &str, steps: u64) {
        self.rays.store(0, Ordering::Relaxed);
        let now = Instant::now();
        *self.current() = Stage { name: name.to_owned(), began: now, last_line: now };
        self.bar.set_length(steps);
        self.bar.reset();
        self.bar.set_prefix(name.to_owned());
        self.bar.set_message(self.message(0));
        match self.ends.filter(|_| self.plain) {
            Some(ends) => eprintln!("{name}, {}", left(ends)),
            None if self.plain => eprintln!("{name}"),
            None => {}
        }
    }

    fn advance(&self, steps: u64, rays: u64) {
        let rays = self.rays.fetch_add(rays, Ordering::Relaxed) + rays;
        self.bar.inc(steps);
        if self.plain {
            self.print_line();
        } else {
            self.bar.set_message(self.message(rays));
        }
    }

    fn cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

fn style(end: &str) -> ProgressStyle {
    ProgressStyle::with_template(&format!("{{prefix:<14}} {{wide_bar}} {{percent:>3}} %  {end}"))
        .unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// One line of a log.
fn line(stage: &str, done: u64, steps: u64, rays: u64, elapsed: Duration) -> String {
    let share = done as f64 / steps.max(1) as f64;
    let mut line = format!("{stage}: {:.0} %", 100.0 * share);
    if rays > 0 {
        line += &format!(", {}", rate(rays, elapsed));
    }
    if share > 0.0 && share < 1.0 {
        line += &format!(", {:.0} s left", elapsed.as_secs_f64() * (1.0 / share - 1.0));
    }
    line
}

fn left(ends: Instant) -> String {
    let left = ends.saturating_duration_since(Instant::now()).as_secs();
    format!("at most {left} s left of the whole")
}

fn rate(rays: u64, elapsed: Duration) -> String {
    format!("{:.2} Mray/s", rays as f64 / elapsed.as_secs_f64().max(1e-3) * 1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_tells_share_rate_and_remaining_time() {
        let told = line("rays", 25, 100, 3_000_000, Duration::from_secs(2));
        assert_eq!(told, "rays: 25 %, 1.50 Mray/s, 6 s left");
    }

    #[test]
    fn limited_work_tells_what_is_left_of_the_whole() {
        assert_eq!(left(Instant::now()), "at most 0 s left of the whole");
        let bar = Bar::within(Duration::from_secs(100));
        let told = bar.message(1_000_000);
        assert!(told.contains("Mray/s") && told.ends_with("s left of the whole"), "{told}");
        assert_eq!(Bar::new().message(0), "");
    }

    #[test]
    fn a_stage_without_steps_or_rays_is_told_without_them() {
        assert_eq!(line("balance", 0, 0, 0, Duration::ZERO), "balance: 0 %");
    }
}
