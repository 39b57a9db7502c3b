//! How often light is passed on in a frame: steered by the bound of the error that was measured last.
//!
//! Two products while light moves, more while the bound is ten times too large (a switch), none once the light is
//! solved. How much closer a product brings it, and how many a frame can bear, came with the choice of the method.
//!
//! Light that is gone is gone: where nothing shines B is 0, exactly. Where lamps shine but reach no patch, B falls
//! towards 0 and is taken for 0 once it is a millionth of what it was.

use crate::transport::solve::Choice;

/// Of the largest B; below it the light counts as solved.
pub const TOLERANCE: f32 = 1e-3;
/// Nor is more asked for than f32 has to give: residuals of a few units in the last place, times the cavity gain.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// Products of a frame while light changes.
const PRODUCTS: u32 = 2;
/// Of the largest B while something arrived at patches: below it, what is left is nothing.
const NOTHING: f32 = 1e-6;

/// Of the light before the last product of a frame [W/m2].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Counts changes of what the bounce starts from.
    pub version: u64,
    /// Largest |E + rho P B - B|.
    pub residual: f32,
    /// Largest radiosity.
    pub largest: f32,
    /// Largest E.
    pub exitance: f32,
}

impl Measured {
    /// The error is at most this share of the largest B. A NaN is never below a tolerance.
    pub fn bound(&self, cavity_gain: f32) -> f32 {
        if self.largest == 0.0 && self.residual == 0.0 {
            return 0.0;
        }
        cavity_gain * self.residual / self.largest
    }

    fn dark(version: u64) -> Self {
        Self { version, residual: 0.0, largest: 0.0, exitance: 0.0 }
    }
}

#[derive(Clone, Debug, Default)]
pub struct Steering {
    version: u64,
    measured: Option<Measured>,
    /// Largest B while E was not 0.
    peak: f32,
}

impl Steering {
    /// What the bounce starts from has changed.
    pub fn change(&mut self) {
        self.version += 1;
    }

    pub fn version(&self) -> u64 {
        self.version
    }

    /// What the last frame that came back said.
    pub fn measured(&self) -> Option<Measured> {
        self.measured
    }

    /// Of what still bounces [W/m2].
    pub fn brightest(&self) -> f32 {
        self.measured.map_or(0.0, |last| last.largest)
    }

    /// Frames arrive in order; one from before the light was put out says nothing.
    pub fn receive(&mut self, measured: Measured) {
        if self.measured.is_some_and(|last| last.version > measured.version) {
            return;
        }
        if measured.exitance > 0.0 {
            self.peak = measured.largest;
        }
        self.measured = Some(measured);
    }

    /// Is what is left of the light nothing?
    pub fn has_faded(&self) -> bool {
        self.measured.is_some_and(|last| {
            last.version == self.version
                && last.exitance == 0.0
                && last.largest > 0.0
                && last.largest <= NOTHING * self.peak
        })
    }

    /// B was set to 0, which is the solution. Returns whether it was not known to be 0 before.
    pub fn put_out(&mut self) -> bool {
        if self.is_out() {
            return false;
        }
        self.version += 1;
        self.measured = Some(Measured::dark(self.version));
        true
    }

    fn is_out(&self) -> bool {
        self.measured == Some(Measured::dark(self.version))
    }

    /// How many products the light needs now: none once it is known to be solved. The first frame, which starts from
    /// darkness, may take twice as long as another.
    pub fn products(&self, cavity_gain: f32, choice: &Choice) -> u32 {
        let most = choice.most.max(PRODUCTS);
        let Some(last) = self.measured else { return 2 * most };
        let bound = last.bound(cavity_gain);
        let tolerance = TOLERANCE.max(ROUNDING * cavity_gain);
        if last.version == self.version && bound <= tolerance {
            return 0;
        }
        if last.largest == 0.0 {
            return most;
        }
        if bound <= 10.0 * tolerance {
            return PRODUCTS;
        }
        let steps = (bound / tolerance).ln() / -choice.leaves.ln() as f32;
        // What is no number needs all that can be had.
        if steps < most as f32 { (steps.ceil() as u32).max(PRODUCTS) } else { most }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::solve::{Case, choose};

    fn two_level() -> Choice {
        choose(&Case { gain: 20.0, patches: 1000, entries: 300_000, aggregates: 15, budget: 1e9 })
    }

    fn measured(version: u64, residual: f32) -> Measured {
        Measured { version, residual, largest: 1.0, exitance: 0.5 }
    }

    fn steering(version: u64, last: Option<Measured>) -> Steering {
        let mut steering = Steering { version, ..Steering::default() };
        last.into_iter().for_each(|last| steering.receive(last));
        steering
    }

    #[test]
    fn products_follow_the_bound() {
        assert_eq!(steering(0, None).products(2.0, &two_level()), 16);
        assert_eq!(steering(3, Some(measured(3, 4e-4))).products(2.0, &two_level()), 0);
        assert_eq!(steering(4, Some(measured(3, 4e-4))).products(2.0, &two_level()), 2);
        assert_eq!(steering(3, Some(measured(3, 4e-3))).products(2.0, &two_level()), 2);
        assert_eq!(steering(3, Some(measured(3, 0.1))).products(2.0, &two_level()), 5);
        assert_eq!(steering(3, Some(measured(3, 1e3))).products(2.0, &two_level()), 8);
        assert_eq!(steering(3, Some(measured(3, f32::NAN))).products(2.0, &two_level()), 8);
        assert_eq!(steering(3, Some(Measured::dark(2))).products(2.0, &two_level()), 8);
    }

    #[test]
    fn what_brings_less_is_done_more_often_and_what_costs_too_much_is_not() {
        let far = steering(3, Some(measured(3, 0.02)));
        assert_eq!(far.products(2.0, &two_level()), 4);
        assert_eq!(far.products(2.0, &Choice { leaves: 0.5, ..two_level() }), 6);
        assert_eq!(far.products(2.0, &Choice { leaves: 0.9, ..two_level() }), 8);
        assert_eq!(far.products(2.0, &Choice { leaves: 0.9, most: 3, ..two_level() }), 3);
        assert_eq!(steering(0, None).products(2.0, &Choice { most: 3, ..two_level() }), 6);
    }

    #[test]
    fn no_more_is_asked_for_than_f32_can_give() {
        let near = steering(3, Some(measured(3, 3e-7)));
        assert_eq!(near.products(1e4, &two_level()), 0);
        assert_eq!(steering(3, Some(measured(3, 3e-6))).products(1e3, &two_level()), 2);
    }

    #[test]
    fn what_is_put_out_stays_out_whatever_comes_back_late() {
        let mut steering = steering(3, Some(measured(3, 0.1)));
        assert!(steering.put_out() && !steering.put_out());
        steering.receive(measured(3, 0.01));
        assert_eq!(steering.products(9.0, &two_level()), 0);
        steering.change();
        assert_eq!(steering.products(9.0, &two_level()), 8);
    }

    #[test]
    fn light_has_faded_at_a_millionth_of_what_it_was() {
        let mut steering = steering(3, Some(measured(3, 0.1)));
        steering.change();
        let left = |largest| Measured { version: 4, residual: 0.1, largest, exitance: 0.0 };
        steering.receive(left(1e-3));
        assert!(!steering.has_faded());
        steering.receive(left(9e-7));
        assert!(steering.has_faded());
    }
}
