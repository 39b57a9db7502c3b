//! Probes on one line: the two beside the nearest point of the line.

use glam::DVec3;

use super::Blend;

#[derive(Clone, Debug)]
pub struct Line {
    start: DVec3,
    /// Unit.
    way: DVec3,
    /// Along it, ascending, with their points.
    stops: Vec<(f64, u32)>,
}

impl Line {
    pub fn new(points: &[DVec3], [a, b]: [u32; 2]) -> Self {
        let start = points[a as usize];
        let way = (points[b as usize] - start).normalize();
        let mut stops: Vec<(f64, u32)> =
            (0..).zip(points).map(|(index, &point)| ((point - start).dot(way), index)).collect();
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { start, way, stops }
    }

    pub fn blend(&self, at: DVec3) -> Blend {
        let along = (at - self.start).dot(self.way);
        let next = self.stops.partition_point(|stop| stop.0 <= along).clamp(1, self.stops.len() - 1);
        let ((low, a), (high, b)) = (self.stops[next - 1], self.stops[next]);
        let t = ((along - low) / (high - low).max(1e-300)).clamp(0.0, 1.0);
        [(a, 1.0 - t), (b, t), (a, 0.0), (a, 0.0)]
    }

    pub fn edges(&self) -> Vec<([u32; 2], bool)> {
        self.stops.windows(2).map(|pair| ([pair[0].1, pair[1].1], true)).collect()
    }
}
