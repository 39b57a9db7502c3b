//! What a curve says: how its error falls as its cost grows, and whether it falls all the way to its floor.

use serde::Serialize;

use super::front::{is_measured, place};
use super::model::{Diagram, Series};

/// A curve is at its floor when it is so near.
const AT_FLOOR: f64 = 2.0;
/// A step may rise by so much for noise.
const NOISE: f64 = 1.05;

/// Of one method in a diagram.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trend {
    pub diagram: String,
    pub series: String,
    /// Measured points.
    pub points: usize,
    /// Twice the cost gives the error times this much, above the floor; none for fewer than two points.
    pub per_doubling: Option<f64>,
    /// The method's own floor or else the diagram's highest; without either the least error, and no name.
    pub floor: f64,
    pub floor_name: String,
    /// The least error of all points.
    pub least: f64,
    /// Each point's error is below the one before, as far as the points' standard errors tell, until it is within twice
    /// the floor.
    pub falls: bool,
    /// Some point is within twice a floor that has a name.
    pub reaches: bool,
    /// Why it goes no further, where that is neither its floor nor the budget.
    pub ends: Option<String>,
}

impl Trend {
    /// Whether there is a curve, and something for it to fall to.
    pub fn is_curve(&self) -> bool {
        self.points > 1 && !self.floor_name.is_empty()
    }

    /// Falls until within twice its floor, or as far as anything can.
    pub fn holds(&self) -> bool {
        self.falls && (self.reaches || self.ends.is_some())
    }
}

/// Of all curves.
pub fn trends(diagrams: &[Diagram]) -> Vec<Trend> {
    let of = |diagram: &Diagram| -> Vec<Trend> {
        diagram.series.iter().map(|series| trend(diagram, series)).collect()
    };
    diagrams.iter().flat_map(of).collect()
}

pub fn trend(diagram: &Diagram, series: &Series) -> Trend {
    let measured = || series.points.iter().filter(|point| is_measured(&place(diagram, point)));
    let points: Vec<[f64; 2]> = measured().map(|point| place(diagram, point)).collect();
    let spreads: Vec<f64> = measured().map(|point| point.spread).collect();
    let least = points.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
    let floors = diagram.floors.iter().filter(|floor| floor.y > 0.0);
    let known = series.floor.as_ref().or(floors.max_by(|a, b| a.y.total_cmp(&b.y)));
    let floor = known.map_or(least, |floor| floor.y);
    let until = |enough: f64| {
        let first = points.iter().position(|point| point[1] <= enough);
        &points[..first.map_or(points.len(), |first| first + 1)]
    };
    let rises = |k: usize| {
        let [before, after] = [k, k + 1].map(|k| points[k][1]);
        after > NOISE * before && after - before > spreads[k].hypot(spreads[k + 1])
    };
    // Where no floor is known, the least error is none to stop short of.
    let sloping = until(if known.is_none() { floor } else { AT_FLOOR * floor });
    Trend {
        diagram: diagram.id.clone(),
        series: series.name.clone(),
        points: points.len(),
        per_doubling: slope(sloping).map(f64::exp2),
        floor: if floor.is_finite() { floor } else { 0.0 },
        floor_name: known.map_or(String::new(), |floor| floor.name.clone()),
        least: if least.is_finite() { least } else { 0.0 },
        falls: !(1..until(AT_FLOOR * floor).len()).any(|k| rises(k - 1)),
        reaches: known.is_some() && least <= AT_FLOOR * floor,
        ends: series.ends.clone(),
    }
}

/// Of log error over log cost: least squares.
fn slope(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> =
        points.iter().filter(|point| point[1] > 0.0).map(|[x, y]| [x.ln(), y.ln()]).collect();
    let count = logs.len() as f64;
    let mean = |axis: usize| logs.iter().map(|log| log[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let spread: f64 = logs.iter().map(|log| (log[0] - x).powi(2)).sum();
    let both: f64 = logs.iter().map(|log| (log[0] - x) * (log[1] - y)).sum();
    (logs.len() > 1 && spread > 1e-6).then_some(both / spread)
}

#[cfg(test)]
mod tests {
    use super::super::model::{Error, Floor, Point};
    use super::*;

    fn trend_of(points: &[[f64; 2]], floors: &[f64]) -> Trend {
        let point =
            |[x, rms]: [f64; 2]| Point { x, error: Error { rms, ..Error::default() }, ..Point::default() };
        let series = Series::new("rays", points.iter().copied().map(point).collect());
        let floors = floors.iter().map(|y| Floor { name: "noise".to_owned(), y: *y }).collect();
        let diagram = Diagram { series: vec![series.clone()], floors, ..Diagram::default() };
        trend(&diagram, &series)
    }

    #[test]
    fn a_rise_within_the_standard_error_says_nothing_and_what_is_left_above_a_floor_is_left() {
        let trend_with = |spread: f64| {
            let point = |[x, rms]: [f64; 2]| Point {
                x,
                spread,
                error: Error { rms, ..Error::default() },
                ..Point::default()
            };
            let series = Series::new("patches", [[1.0, 1.0], [2.0, 1.2], [4.0, 0.5]].map(point).to_vec());
            let floors = vec![Floor { name: "noise".to_owned(), y: 0.2 }];
            let diagram = Diagram { series: vec![series.clone()], floors, ..Diagram::default() };
            trend(&diagram, &series)
        };
        assert!(trend_with(0.15).falls && !trend_with(0.05).falls);
        assert!(!trend_with(0.15).reaches);
    }

    #[test]
    fn monte_carlo_halves_the_error_for_four_times_the_time() {
        let trend = trend_of(&[[1.0, 1.0], [4.0, 0.5], [16.0, 0.25]], &[1e-9]);
        assert!((trend.per_doubling.unwrap() - 0.5_f64.sqrt()).abs() < 1e-12 && trend.falls);
    }

    #[test]
    fn a_curve_may_rise_at_its_floor_and_nowhere_else() {
        assert!(trend_of(&[[1.0, 1.0], [2.0, 0.19], [3.0, 0.3]], &[0.1]).falls);
        assert!(!trend_of(&[[1.0, 1.0], [2.0, 0.3], [3.0, 0.4]], &[0.1]).falls);
    }

    #[test]
    fn a_curve_that_ends_above_twice_its_floor_does_not_hold() {
        let ends = |error: f64| trend_of(&[[1.0, 1.0], [2.0, error]], &[0.1]);
        assert!(ends(0.19).holds() && !ends(0.21).holds() && ends(0.21).falls);
        assert!(!trend_of(&[[1.0, 1.0], [2.0, 0.5]], &[]).is_curve());
        // Of two floors the higher one is met first.
        assert!(trend_of(&[[1.0, 1.0], [2.0, 0.21]], &[0.01, 0.11]).holds());
    }

    #[test]
    fn a_curve_that_can_go_no_further_holds_if_it_falls() {
        let point =
            |[x, rms]: [f64; 2]| Point { x, error: Error { rms, ..Error::default() }, ..Point::default() };
        let of = |points: [[f64; 2]; 2]| Series {
            ends: Some("as far as a frame lasts".to_owned()),
            ..Series::new("products", points.map(point).to_vec())
        };
        let floors = vec![Floor { name: "rounding".to_owned(), y: 0.01 }];
        let diagram = Diagram { floors, ..Diagram::default() };
        assert!(trend(&diagram, &of([[1.0, 1.0], [2.0, 0.5]])).holds());
        assert!(!trend(&diagram, &of([[1.0, 1.0], [2.0, 1.5]])).holds());
    }

    #[test]
    fn a_single_point_has_no_slope() {
        for points in [&[][..], &[[1.0, 1.0]], &[[1.0, 1.0], [1.0, 0.5]], &[[1.0, f64::NAN], [2.0, 0.0]]] {
            assert_eq!(trend_of(points, &[]).per_doubling, None, "{points:?}");
        }
    }
}
