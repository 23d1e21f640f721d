//! A trajectory: a sequence of configurations joined by straight segments.

use crate::plane::geometry::{Point, distance, lerp};

/// Points that [`Trajectory::roughness`] looks at.
const ROUGHNESS_POINTS: usize = 64;

/// Configurations from start to goal, both included, as a flat `[points x 2]` buffer in task units.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trajectory {
    values: Vec<f64>,
}

impl Trajectory {
    /// A trajectory through the given points.
    pub fn from_points(points: &[Point]) -> Self {
        Self { values: points.iter().flatten().copied().collect() }
    }

    /// The flat `[points x 2]` buffer.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The points in order.
    pub fn points(&self) -> &[Point] {
        self.values.as_chunks::<2>().0
    }

    /// The segments in order, as `(from, to)`.
    pub fn segments(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        self.points().windows(2).map(|pair| (pair[0], pair[1]))
    }

    /// Total length of the segments.
    pub fn length(&self) -> f64 {
        self.segments().map(|(a, b)| distance(a, b)).sum()
    }

    /// Sum of squared second differences of 64 points spread evenly by length: 0 for a straight line, and
    /// comparable between trajectories of different numbers of points.
    pub fn roughness(&self) -> f64 {
        let even = self.evenly(ROUGHNESS_POINTS);
        let second = |w: &[Point], axis: usize| w[0][axis] - 2.0 * w[1][axis] + w[2][axis];
        even.windows(3).map(|w| (0..2).map(|axis| second(w, axis).powi(2)).sum::<f64>()).sum()
    }

    /// `count` points spread evenly by length, both ends included; the points themselves where there are fewer than two.
    pub fn evenly(&self, count: usize) -> Vec<Point> {
        let points = self.points();
        if points.len() < 2 || count < 2 {
            return points.to_vec();
        }
        let total = self.length();
        let (mut leg, mut passed) = (0, 0.0);
        let mut even = Vec::with_capacity(count);
        for i in 0..count - 1 {
            let target = total * i as f64 / (count - 1) as f64;
            let mut length = distance(points[leg], points[leg + 1]);
            while passed + length < target && leg + 2 < points.len() {
                passed += length;
                leg += 1;
                length = distance(points[leg], points[leg + 1]);
            }
            let t = if length > 0.0 { ((target - passed) / length).clamp(0.0, 1.0) } else { 0.0 };
            even.push(lerp(points[leg], points[leg + 1], t));
        }
        even.push(points[points.len() - 1]);
        even
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evenly_spread_points_keep_the_ends_and_the_distances() {
        let path = Trajectory::from_points(&[[0.1, 0.3], [3.1, 0.3], [3.1, 4.3]]);
        let even = path.evenly(15);
        assert_eq!((even[0], even[14]), ([0.1, 0.3], [3.1, 4.3]));
        assert!((even[6][0] - 3.1).abs() < 1e-12 && (even[6][1] - 0.3).abs() < 1e-12);
        for pair in even.windows(2) {
            assert!((distance(pair[0], pair[1]) - 0.5).abs() < 1e-9);
        }
    }

    #[test]
    fn roughness_does_not_depend_on_how_many_points_a_line_has() {
        let bent = |extra: &[Point]| {
            let points = [&[[0.0, 0.0], [4.0, 0.0]], extra, &[[4.0, 4.0]]].concat();
            Trajectory::from_points(&points).roughness()
        };
        assert!((bent(&[]) - bent(&[[4.0, 1.0], [4.0, 2.5]])).abs() < 1e-9);
        assert!(Trajectory::from_points(&[[0.0, 1.0], [7.0, 3.0]]).roughness() < 1e-20);
        assert!(bent(&[]) > 1e-3);
    }
}
