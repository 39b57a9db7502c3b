//! Where a label goes, so that it covers neither data nor another label: of a few places, the one with the least below.

use super::sheet::At;

/// Upper left and lower right corner.
pub type Box2 = [At; 2];

/// What is on the sheet already.
#[derive(Clone, Debug, Default)]
pub struct Taken {
    points: Vec<At>,
    labels: Vec<Box2>,
}

/// How far apart a line is looked at [points].
const STEP: f64 = 5.0;
/// Around a label.
const ROOM: f64 = 3.0;

impl Taken {
    pub fn add_line(&mut self, points: &[At]) {
        self.points.extend(points);
        for pair in points.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let steps = ((to[0] - from[0]).hypot(to[1] - from[1]) / STEP) as u32;
            let at = |k: u32| {
                let share = f64::from(k) / f64::from(steps + 1);
                [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
            };
            self.points.extend((1..=steps).map(at));
        }
    }

    pub fn add_label(&mut self, label: Box2) {
        self.labels.push(label);
    }

    /// The first of the best places inside `within`, which is then taken.
    pub fn place(&mut self, places: &[Box2], within: Box2) -> Option<usize> {
        let costs = places.iter().map(|place| self.cost(*place, within));
        let best = costs.enumerate().min_by_key(|(_, cost)| *cost)?.0;
        self.add_label(places[best]);
        Some(best)
    }

    fn cost(&self, place: Box2, within: Box2) -> usize {
        let outside = (0..2).filter(|&k| place[0][k] < within[0][k] || place[1][k] > within[1][k]).count();
        let [low, high] = place;
        let covered = |at: &&At| (0..2).all(|k| at[k] > low[k] - ROOM && at[k] < high[k] + ROOM);
        let overlaps = |other: &&Box2| (0..2).all(|k| other[0][k] < high[k] && other[1][k] > low[k]);
        1000 * outside
            + 20 * self.labels.iter().filter(overlaps).count()
            + self.points.iter().filter(covered).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_avoid_lines_borders_and_each_other() {
        let mut taken = Taken::default();
        taken.add_line(&[[0.0, 50.0], [100.0, 50.0]]);
        let place = |x: f64, y: f64| [[x, y], [x + 20.0, y + 10.0]];
        let places = [place(40.0, 45.0), place(90.0, 10.0), place(40.0, 10.0), place(10.0, 80.0)];
        let within = [[0.0; 2], [100.0; 2]];
        assert_eq!(taken.place(&places, within), Some(2));
        assert_eq!(taken.place(&places, within), Some(3));
        assert_eq!(taken.place(&[], within), None);
    }
}
