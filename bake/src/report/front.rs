//! The Pareto front: the points that nothing beats, of all methods; how far from it another point is; and whether the
//! shipped presets lie on it.
//!
//! A point beats another where it costs no more and is no more wrong, and one of both is less. Between the front's
//! points others could be measured: there the front is interpolated, log of the error over log of the cost.

use serde::Serialize;

use super::model::{Diagram, Point};

/// A preset is on the front when it is so near: its cost at the same error, or its error at the same cost.
pub const NEAR: f64 = 1.15;

/// Points [cost, error] that nothing beats, by rising cost.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Front(pub Vec<[f64; 2]>);

/// Of a shipped preset in a diagram.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    pub diagram: String,
    pub series: String,
    pub setting: String,
    pub preset: String,
    /// Its error over the front's at the same cost, its cost over the front's at the same error.
    pub error_factor: f64,
    pub x_factor: f64,
    pub on_front: bool,
    /// Of which its cost is the median.
    pub runs: usize,
}

impl Front {
    pub fn of(diagram: &Diagram) -> Self {
        let points = diagram.series.iter().flat_map(|series| &series.points);
        let mut all: Vec<[f64; 2]> = points.map(|point| place(diagram, point)).filter(is_measured).collect();
        all.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let mut front: Vec<[f64; 2]> = Vec::new();
        for point in all {
            if front.last().is_none_or(|last| point[1] < last[1]) {
                front.push(point);
            }
        }
        Self(front)
    }

    pub fn contains(&self, point: [f64; 2]) -> bool {
        self.0.contains(&point)
    }

    /// Least error at most at this cost; what costs less than all others is compared with the cheapest.
    pub fn error_at(&self, x: f64) -> f64 {
        let after = self.0.partition_point(|point| point[0] <= x);
        match (after.checked_sub(1).map(|before| self.0[before]), self.0.get(after)) {
            (Some(before), Some(next)) if next[1] > 0.0 => along(x, before, *next),
            (Some(before), _) => before[1],
            (None, next) => next.map_or(f64::NAN, |next| next[1]),
        }
    }

    /// Least cost of an error at most like this; what is less wrong than all others is compared with the best.
    pub fn x_at(&self, error: f64) -> f64 {
        let after = self.0.partition_point(|point| point[1] > error);
        match (after.checked_sub(1).map(|before| self.0[before]), self.0.get(after)) {
            (Some(before), Some(next)) if next[1] > 0.0 => {
                along(error, [before[1], before[0]], [next[1], next[0]])
            }
            (before, next) => next.copied().or(before).map_or(f64::NAN, |point| point[0]),
        }
    }
}

/// Where a point lies in its diagram.
pub fn place(diagram: &Diagram, point: &Point) -> [f64; 2] {
    [point.x, point.error.by(diagram.norm)]
}

/// Whether a point has a cost and an error.
pub fn is_measured([x, error]: &[f64; 2]) -> bool {
    *x > 0.0 && x.is_finite() && *error >= 0.0 && error.is_finite()
}

/// All presets of all diagrams.
pub fn verdicts(diagrams: &[Diagram]) -> Vec<Verdict> {
    diagrams.iter().flat_map(verdicts_of).collect()
}

fn verdicts_of(diagram: &Diagram) -> Vec<Verdict> {
    let front = Front::of(diagram);
    let presets = diagram.series.iter().flat_map(|series| {
        let marked = |point: &Point| Some((series.name.clone(), point.clone(), point.preset.clone()?));
        series.points.iter().filter_map(marked).collect::<Vec<_>>()
    });
    let verdict = |(series, point, preset): (String, Point, String)| {
        let [x, error] = place(diagram, &point);
        let error_factor = ratio(error, front.error_at(x));
        let x_factor = ratio(x, front.x_at(error));
        let on_front = error_factor.min(x_factor) <= NEAR;
        let (diagram, setting, runs) = (diagram.id.clone(), point.setting, point.runs);
        Verdict { diagram, series, setting, preset, error_factor, x_factor, on_front, runs }
    };
    presets.map(verdict).collect()
}

/// Nothing is as good as nothing.
fn ratio(found: f64, best: f64) -> f64 {
    if found == best { 1.0 } else { found / best }
}

/// y at x on the line through two points in logarithms.
fn along(x: f64, from: [f64; 2], to: [f64; 2]) -> f64 {
    let span = (to[0] / from[0]).ln();
    let share = if span == 0.0 { 0.0 } else { (x / from[0]).ln() / span };
    from[1] * ((to[1] / from[1]).ln() * share).exp()
}

#[cfg(test)]
mod tests {
    use super::super::model::{Error, Series};
    use super::*;

    fn diagram(points: &[[f64; 2]]) -> Diagram {
        let point =
            |[x, rms]: [f64; 2]| Point { x, error: Error { rms, ..Error::default() }, ..Point::default() };
        let points = points.iter().copied().map(point).collect();
        Diagram { series: vec![Series::new("rays", points)], ..Diagram::default() }
    }

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let all = [
            [4.0, 0.1],
            [1.0, 1.0],
            [2.0, 2.0],
            [2.0, 0.5],
            [3.0, 0.5],
            [8.0, 0.1],
            [9.0, f64::NAN],
            [0.0, 0.0],
        ];
        assert_eq!(Front::of(&diagram(&all)).0, [[1.0, 1.0], [2.0, 0.5], [4.0, 0.1]]);
        assert_eq!(Front::of(&diagram(&[])).0, [[0.0; 2]; 0]);
    }

    #[test]
    fn the_distance_is_measured_along_both_axes() {
        // error = 1 / x
        let front = Front::of(&diagram(&[[1.0, 1.0], [4.0, 0.25], [16.0, 0.0625]]));
        for x in [1.0, 1.7, 4.0, 9.0, 16.0] {
            assert!((front.error_at(x) * x - 1.0).abs() < 1e-12, "{x}");
            assert!((front.x_at(1.0 / x) / x - 1.0).abs() < 1e-12, "{x}");
        }
        assert_eq!((front.error_at(0.5), front.error_at(100.0)), (1.0, 0.0625));
        assert_eq!((front.x_at(7.0), front.x_at(1e-9)), (1.0, 16.0));
    }

    #[test]
    fn an_error_of_nothing_is_reached_at_its_point_and_not_before() {
        let front = Front::of(&diagram(&[[1.0, 1.0], [2.0, 0.0]]));
        assert_eq!((front.error_at(1.9), front.error_at(2.0)), (1.0, 0.0));
        assert_eq!((front.x_at(0.5), front.x_at(0.0)), (2.0, 2.0));
    }

    #[test]
    fn presets_near_the_front_are_on_it() {
        let mut diagram = diagram(&[[1.0, 1.0], [2.0, 1.1 / 2.0], [2.0, 0.9], [4.0, 0.25]]);
        for (k, preset) in [(0, "draft"), (1, "standard"), (2, "off")] {
            diagram.series[0].points[k].preset = Some(preset.to_owned());
        }
        let verdicts = verdicts(&[diagram]);
        let told: Vec<_> =
            verdicts.iter().map(|verdict| (verdict.preset.as_str(), verdict.on_front)).collect();
        assert_eq!(told, [("draft", true), ("standard", true), ("off", false)]);
        assert!((verdicts[2].error_factor - 0.9 / 0.55).abs() < 1e-12, "{verdicts:?}");
    }

    #[test]
    fn what_is_no_number_is_on_no_front() {
        let mut diagram = diagram(&[[f64::NAN, 1.0], [1.0, f64::NAN]]);
        diagram.series[0].points.iter_mut().for_each(|point| point.preset = Some("runtime".to_owned()));
        assert!(verdicts(&[diagram]).iter().all(|verdict| !verdict.on_front));
    }
}
