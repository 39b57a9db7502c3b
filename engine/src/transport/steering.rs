//! How often light is passed on in a frame: steered by the bound of the error that was measured last.
//!
//! As many products as bring light that stands still to the tolerance, and none once it is there. Light that moves is
//! never solved: there the bound is held at ten times the tolerance, by as many products more or fewer than the measured
//! frame had as the bound says, so that their number is steady where the motion is. Light that changes after it stood
//! still, a switch, gets all that a frame can bear until the first measure of it arrives. How much closer a product
//! brings it, and how many a frame can bear, came with the choice of the method.
//!
//! Light that is gone is gone: where nothing shines B is 0, exactly. Where lamps shine but reach no patch, B falls
//! towards 0 and is taken for 0 once it is a millionth of what it was.

use crate::transport::solve::Choice;

/// Of the largest B; below it the light counts as solved.
pub const TOLERANCE: f32 = 1e-3;
/// Nor is more asked for than f32 has to give: residuals of a few units in the last place, times the cavity gain.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// Products of a frame while light is not solved.
const PRODUCTS: u32 = 2;
/// The bound of light that moves, in tolerances.
const MOVING: f32 = 10.0;
/// Of the largest B while something arrived at patches: below it, what is left is nothing.
const NOTHING: f32 = 1e-6;

/// Of the light before the last product of a frame [W/m2].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Counts changes of what the bounce starts from.
    pub version: u64,
    /// Of the frame.
    pub products: u32,
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
        Self { version, products: 0, residual: 0.0, largest: 0.0, exitance: 0.0 }
    }
}

#[derive(Clone, Debug, Default)]
pub struct Steering {
    version: u64,
    /// The last frame's.
    last_version: u64,
    /// The last frame's light was another than that of the one before it.
    moved: bool,
    /// With it light began to change, after it had stood still.
    began: u64,
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

    /// How many products a frame needs: none once the light is known to be solved. The first frame, which starts from
    /// darkness, may take twice as long as another.
    pub fn products(&mut self, cavity_gain: f32, choice: &Choice) -> u32 {
        self.look_for_a_change();
        let most = choice.most.max(PRODUCTS);
        let Some(last) = self.measured else { return 2 * most };
        let bound = last.bound(cavity_gain);
        let tolerance = TOLERANCE.max(ROUNDING * cavity_gain);
        let stands = last.version == self.version;
        if stands && bound <= tolerance {
            return 0;
        }
        if last.largest == 0.0 || !stands && last.version < self.began {
            return most;
        }
        let steps_to = |wanted: f32| (bound / wanted).ln() / -choice.leaves.ln() as f32;
        let steps =
            if stands { steps_to(tolerance) } else { last.products as f32 + steps_to(MOVING * tolerance) };
        // What is no number needs all that can be had.
        if steps < most as f32 { (steps.ceil() as u32).max(PRODUCTS) } else { most }
    }

    /// Once a frame.
    fn look_for_a_change(&mut self) {
        let moves = self.version != self.last_version;
        if moves && !self.moved {
            self.began = self.version;
        }
        (self.last_version, self.moved) = (self.version, moves);
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
        Measured { version, products: 2, residual, largest: 1.0, exitance: 0.5 }
    }

    fn steering(version: u64, last: Option<Measured>) -> Steering {
        let mut steering = Steering { version, last_version: version, ..Steering::default() };
        last.into_iter().for_each(|last| steering.receive(last));
        steering
    }

    #[test]
    fn products_follow_the_bound() {
        assert_eq!(steering(0, None).products(2.0, &two_level()), 16);
        assert_eq!(steering(3, Some(measured(3, 4e-4))).products(2.0, &two_level()), 0);
        assert_eq!(steering(3, Some(measured(3, 4e-3))).products(2.0, &two_level()), 2);
        assert_eq!(steering(3, Some(measured(3, 0.1))).products(2.0, &two_level()), 5);
        assert_eq!(steering(3, Some(measured(3, 1e3))).products(2.0, &two_level()), 8);
        assert_eq!(steering(3, Some(measured(3, f32::NAN))).products(2.0, &two_level()), 8);
        assert_eq!(steering(3, Some(Measured::dark(2))).products(2.0, &two_level()), 8);
    }

    #[test]
    fn a_switch_gets_all_until_it_is_measured() {
        let mut steering = steering(3, Some(measured(3, 4e-4)));
        assert_eq!(steering.products(2.0, &two_level()), 0);
        steering.change();
        let frames = [(); 3].map(|()| steering.products(2.0, &two_level()));
        assert_eq!(frames, [8; 3]);
        steering.receive(measured(4, 0.01));
        assert_eq!(steering.products(2.0, &two_level()), 3);
    }

    /// Each frame moves the light by so much that its bound is 3 before the first product, and is measured two frames
    /// later.
    #[test]
    fn light_that_moves_steadily_gets_a_steady_number_of_products() {
        let mut steering = steering(3, Some(measured(3, 4e-4)));
        let mut given: Vec<u32> = Vec::new();
        for frame in 0..30_usize {
            steering.change();
            if let Some(products) = frame.checked_sub(2).map(|before| given[before]) {
                let residual = 1.5 * 3.0_f32.powi(1 - products as i32);
                steering.receive(Measured { products, ..measured(steering.version() - 2, residual) });
            }
            given.push(steering.products(2.0, &two_level()));
        }
        assert_eq!(given[..2], [8, 8]);
        assert!(given[4..].iter().all(|&products| products == 7), "{given:?}");
    }

    #[test]
    fn what_brings_less_is_done_more_often_and_what_costs_too_much_is_not() {
        let mut far = steering(3, Some(measured(3, 0.02)));
        assert_eq!(far.products(2.0, &two_level()), 4);
        assert_eq!(far.products(2.0, &Choice { leaves: 0.5, ..two_level() }), 6);
        assert_eq!(far.products(2.0, &Choice { leaves: 0.9, ..two_level() }), 8);
        assert_eq!(far.products(2.0, &Choice { leaves: 0.9, most: 3, ..two_level() }), 3);
        assert_eq!(steering(0, None).products(2.0, &Choice { most: 3, ..two_level() }), 6);
    }

    #[test]
    fn no_more_is_asked_for_than_f32_can_give() {
        let mut near = steering(3, Some(measured(3, 3e-7)));
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
        let left = |largest| Measured { version: 4, products: 2, residual: 0.1, largest, exitance: 0.0 };
        steering.receive(left(1e-3));
        assert!(!steering.has_faded());
        steering.receive(left(9e-7));
        assert!(steering.has_faded());
    }
}
