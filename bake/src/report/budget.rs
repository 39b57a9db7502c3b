//! Seconds that a report may take. Every part gets a share of what is left when its turn comes: what one part does not
//! use is the next one's.

use std::time::{Duration, Instant};

use crate::Watcher;

/// The most that counts [s]: more than a year is as good as no limit.
const MOST: f64 = 4e7;

/// A slice of time that has begun.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    began: Instant,
    ends: Instant,
}

impl Budget {
    /// So many seconds from now; what is no number is none.
    pub fn new(seconds: f64) -> Self {
        let began = Instant::now();
        let seconds = if seconds.is_nan() { 0.0 } else { seconds.clamp(0.0, MOST) };
        Self { began, ends: began + Duration::from_secs_f64(seconds) }
    }

    /// Seconds; 0 where it is spent.
    pub fn left(&self) -> f64 {
        self.ends.saturating_duration_since(Instant::now()).as_secs_f64()
    }

    pub fn spent(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// A share (0 to 1) of what is left, from now on.
    pub fn part(&self, share: f64) -> Self {
        self.first(self.left() * share)
    }

    /// All that is left but so many seconds, from now on.
    pub fn but(&self, seconds: f64) -> Self {
        self.first(self.left() - seconds)
    }

    fn first(&self, seconds: f64) -> Self {
        let slice = Self::new(seconds);
        Self { ends: slice.ends.min(self.ends), ..slice }
    }

    pub fn is_spent(&self) -> bool {
        self.left() == 0.0
    }
}

/// Watches on for another, and stops the work when the time is up.
pub struct Within<'a> {
    pub watcher: &'a dyn Watcher,
    pub budget: Budget,
}

impl Watcher for Within<'_> {
    fn stage(&self, name: &str, steps: u64) {
        self.watcher.stage(name, steps);
    }

    fn advance(&self, steps: u64, rays: u64) {
        self.watcher.advance(steps, rays);
    }

    fn cancelled(&self) -> bool {
        self.watcher.cancelled() || self.budget.is_spent()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Silent;

    #[test]
    fn a_part_ends_no_later_than_the_whole() {
        let whole = Budget::new(1000.0);
        for share in [0.0, 0.3, 1.0, 7.0, f64::NAN] {
            assert!(whole.part(share).ends <= whole.ends, "{share}");
        }
        assert!(whole.part(0.5).left() > 400.0 && whole.part(0.5).left() <= 500.0);
        assert!(whole.but(100.0).left() <= 900.0 && whole.but(1e4).is_spent());
    }

    #[test]
    fn what_is_no_time_is_spent_at_once_and_what_is_endless_is_long() {
        for nothing in [0.0, -5.0, f64::NAN, f64::NEG_INFINITY] {
            assert!(Budget::new(nothing).is_spent(), "{nothing}");
        }
        assert!(Budget::new(f64::INFINITY).left() > 1e7);
    }

    #[test]
    fn work_that_is_watched_within_a_budget_stops_when_it_is_spent() {
        let within = |seconds| Within { watcher: &Silent, budget: Budget::new(seconds) };
        assert!(within(0.0).cancelled() && !within(1000.0).cancelled());
    }
}
