//! The scene's time. It goes in whole steps, and what is shown lies between two of them.
//!
//! All motion (spins, paths, imported clips, lights that switch) is a function of time alone. So nothing is
//! stepped that could drift, and between two steps motion is evaluated, which is exact at 20 pictures a second as
//! at 144, where blending two steps would cut corners. With a fixed time from picture to picture, time is a
//! product of two numbers, and pictures repeat.

pub const STEP: f64 = 1.0 / 240.0;
/// Of the key that goes on by one picture.
const SINGLE: u64 = 4;
/// Seconds. A window that was hidden for long does not jump.
const MOST: f64 = 0.25;

pub struct Clock {
    fixed_dt: Option<f64>,
    /// Whole steps; with a fixed time from picture to picture: pictures.
    steps: u64,
    /// Seconds beyond the last whole step.
    left: f64,
    pub paused: bool,
    /// One picture is due though time stands.
    single: bool,
    started: bool,
}

impl Clock {
    pub fn new(fixed_dt: Option<f64>) -> Self {
        Self { fixed_dt, steps: 0, left: 0.0, paused: false, single: false, started: false }
    }

    /// Goes on to the next picture, so many seconds after the last one. The first shows the start. Returns the
    /// seconds that count.
    pub fn advance(&mut self, passed: f64) -> f64 {
        // What is no number is no time.
        let passed = if self.started && passed > 0.0 { passed.min(MOST) } else { 0.0 };
        let stands = self.paused && !self.single || !self.started;
        self.started = true;
        match (stands, self.fixed_dt.is_some(), std::mem::take(&mut self.single)) {
            (true, ..) => {}
            (false, true, _) => self.steps += 1,
            (false, false, true) => self.steps += SINGLE,
            (false, false, false) => self.flow(passed),
        }
        passed
    }

    fn flow(&mut self, passed: f64) {
        let whole = ((self.left + passed) / STEP).floor();
        self.left = (self.left + passed - whole * STEP).max(0.0);
        self.steps += whole as u64;
    }

    /// Stops, and shows one more picture.
    pub fn step(&mut self) {
        (self.paused, self.single) = (true, true);
    }

    /// Seconds since the start.
    pub fn time(&self) -> f64 {
        self.fixed_dt.map_or(self.steps as f64 * STEP + self.left, |dt| self.steps as f64 * dt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_display_shows_the_time_that_it_is() {
        for rate in [20.0, 59.94, 60.0, 144.0, 1000.0] {
            let mut clock = Clock::new(None);
            for picture in 0..3000 {
                clock.advance(1.0 / rate);
                let expected = f64::from(picture) / rate;
                assert!((clock.time() - expected).abs() < 1e-9, "{rate} Hz: {} {expected}", clock.time());
                assert!((0.0..STEP).contains(&clock.left));
            }
        }
    }

    #[test]
    fn fixed_time_is_what_it_says_whatever_the_clock_says() {
        let mut clock = Clock::new(Some(0.1));
        let times: Vec<f64> =
            [0.0, 3.0, 0.001, 0.5].map(|passed| (clock.advance(passed), clock.time()).1).into();
        assert_eq!(times, [0.0, 0.1, 0.2, 0.1 * 3.0]);
    }

    #[test]
    fn it_stands_while_paused_and_goes_on_by_single_pictures() {
        let mut clock = Clock::new(None);
        clock.advance(0.0);
        clock.advance(0.1);
        clock.step();
        clock.advance(0.1);
        clock.advance(0.1);
        assert!((clock.time() - 0.1 - 1.0 / 60.0).abs() < 1e-9);
        clock.paused = false;
        clock.advance(10.0);
        assert!((clock.time() - 0.35 - 1.0 / 60.0).abs() < 1e-9, "no jump: {}", clock.time());
    }
}
