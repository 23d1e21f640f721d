//! A trajectory: a sequence of configurations joined by straight segments.

use crate::geometry::{Point, distance};

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

    /// Sum of squared second differences of the points: 0 for an evenly spaced straight line.
    pub fn roughness(&self) -> f64 {
        let second = |a: Point, b: Point, c: Point, axis: usize| a[axis] - 2.0 * b[axis] + c[axis];
        self.points()
            .windows(3)
            .map(|w| (0..2).map(|axis| second(w[0], w[1], w[2], axis).powi(2)).sum::<f64>())
            .sum()
    }
}
