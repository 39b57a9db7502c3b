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
    /// Twice the cost gives the error times this much, above the floor; none for fewer than two points.
    pub per_doubling: Option<f64>,
    /// The lowest floor of the diagram, or else the least error.
    pub floor: f64,
    /// Each point's error is below the one before, until it is within twice the floor.
    pub falls: bool,
}

pub fn trends(diagrams: &[Diagram]) -> Vec<Trend> {
    let of = |diagram: &Diagram| -> Vec<Trend> {
        diagram.series.iter().map(|series| trend(diagram, series)).collect()
    };
    diagrams.iter().flat_map(of).collect()
}

pub fn trend(diagram: &Diagram, series: &Series) -> Trend {
    let points: Vec<[f64; 2]> =
        series.points.iter().map(|point| place(diagram, point)).filter(is_measured).collect();
    let least = points.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
    let floors = diagram.floors.iter().map(|floor| floor.y).filter(|floor| *floor > 0.0);
    let floor = floors.fold(f64::INFINITY, f64::min);
    let floor = if floor.is_finite() { floor } else { least };
    let until = |enough: f64| {
        let first = points.iter().position(|point| point[1] <= enough);
        &points[..first.map_or(points.len(), |first| first + 1)]
    };
    // Where no floor is known, the least error is none to stop short of.
    let sloping = until(if diagram.floors.is_empty() { floor } else { AT_FLOOR * floor });
    Trend {
        diagram: diagram.id.clone(),
        series: series.name.clone(),
        per_doubling: slope(sloping).map(f64::exp2),
        floor: if floor.is_finite() { floor } else { 0.0 },
        falls: until(AT_FLOOR * floor).windows(2).all(|pair| pair[1][1] <= NOISE * pair[0][1]),
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
        let series = Series { name: "rays".to_owned(), points: points.iter().copied().map(point).collect() };
        let floors = floors.iter().map(|y| Floor { name: "noise".to_owned(), y: *y }).collect();
        let diagram = Diagram { series: vec![series.clone()], floors, ..Diagram::default() };
        trend(&diagram, &series)
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
    fn a_single_point_has_no_slope() {
        for points in [&[][..], &[[1.0, 1.0]], &[[1.0, 1.0], [1.0, 0.5]], &[[1.0, f64::NAN], [2.0, 0.0]]] {
            assert_eq!(trend_of(points, &[]).per_doubling, None, "{points:?}");
        }
    }
}
