//! A trajectory: a sequence of configurations joined by straight segments, of any number of coordinates.

mod action;
mod bends;
mod block_tridiagonal;
mod covariant;
pub mod driving;
pub mod timing;
mod violation;
pub mod waypoints;

pub use action::ActionRule;
pub(crate) use block_tridiagonal::{BlockTridiagonal, DAMPING};
pub(crate) use covariant::Covariant;
pub use violation::{ObstacleId, Violation};

/// Points that [`Trajectory::roughness`] looks at.
const ROUGHNESS_POINTS: usize = 64;

/// Configurations from start to goal, both included, as a flat `[points x dof]` buffer in task units.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    dof: usize,
    values: Vec<f64>,
}

impl Trajectory {
    /// A trajectory through the flat `[points x dof]` buffer.
    ///
    /// # Panics
    /// If `dof` is 0 or the buffer's length is no multiple of it.
    pub fn new(dof: usize, values: Vec<f64>) -> Self {
        assert!(dof > 0 && values.len().is_multiple_of(dof), "configurations of {dof} numbers");
        Self { dof, values }
    }

    /// A trajectory through the given points of `D` coordinates each.
    pub fn from_points<const D: usize>(points: &[[f64; D]]) -> Self {
        Self::new(D, points.as_flattened().to_vec())
    }

    /// Coordinates of a configuration.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// The flat `[points x dof]` buffer.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Number of configurations.
    pub fn len(&self) -> usize {
        self.values.len() / self.dof
    }

    /// Whether there is no configuration at all.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The configurations in order, `[dof]` each.
    pub fn configurations(&self) -> std::slice::ChunksExact<'_, f64> {
        self.values.chunks_exact(self.dof)
    }

    /// The segments in order, as `(from, to)`.
    pub fn segments(&self) -> impl Iterator<Item = (&[f64], &[f64])> + '_ {
        self.configurations().zip(self.configurations().skip(1))
    }

    /// Total length of the segments, Euclidean in the coordinates.
    pub fn length(&self) -> f64 {
        self.segments().map(|(a, b)| distance(a, b)).sum()
    }

    /// Sum of squared second differences of 64 points spread evenly by length: 0 for a straight line, and
    /// comparable between trajectories of different numbers of points.
    pub fn roughness(&self) -> f64 {
        let even = self.evenly(ROUGHNESS_POINTS);
        let (dof, values) = (self.dof, even.values());
        let second = |i: usize| values[i] - 2.0 * values[i + dof] + values[i + 2 * dof];
        let inner = even.len().saturating_sub(2);
        let square = |point: usize| (0..dof).map(|k| second(point * dof + k).powi(2)).sum::<f64>();
        (0..inner).map(square).sum()
    }

    /// `count` points spread evenly by length, both ends included; the points themselves where there are fewer than two.
    pub fn evenly(&self, count: usize) -> Self {
        if self.len() < 2 || count < 2 {
            return self.clone();
        }
        let total = self.length();
        let at = |point: usize| &self.values[point * self.dof..][..self.dof];
        let (mut leg, mut passed) = (0, 0.0);
        let mut even = Vec::with_capacity(count * self.dof);
        for i in 0..count - 1 {
            let target = total * i as f64 / (count - 1) as f64;
            let mut length = distance(at(leg), at(leg + 1));
            while passed + length < target && leg + 2 < self.len() {
                passed += length;
                leg += 1;
                length = distance(at(leg), at(leg + 1));
            }
            let t = if length > 0.0 { ((target - passed) / length).clamp(0.0, 1.0) } else { 0.0 };
            even.extend(at(leg).iter().zip(at(leg + 1)).map(|(a, b)| a + t * (b - a)));
        }
        even.extend_from_slice(at(self.len() - 1));
        Self { dof: self.dof, values: even }
    }
}

/// The Euclidean distance between two configurations `[dof]`.
#[inline]
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + (b - a) * (b - a)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evenly_spread_points_keep_the_ends_and_the_distances() {
        let path = Trajectory::from_points(&[[0.1, 0.3], [3.1, 0.3], [3.1, 4.3]]);
        let even = path.evenly(15);
        let points: Vec<_> = even.configurations().collect();
        assert_eq!((points[0], points[14]), (&[0.1, 0.3][..], &[3.1, 4.3][..]));
        assert!((points[6][0] - 3.1).abs() < 1e-12 && (points[6][1] - 0.3).abs() < 1e-12);
        for (from, to) in even.segments() {
            assert!((distance(from, to) - 0.5).abs() < 1e-9);
        }
    }

    #[test]
    fn roughness_does_not_depend_on_how_many_points_a_line_has() {
        let bent = |extra: &[[f64; 2]]| {
            let points = [&[[0.0, 0.0], [4.0, 0.0]], extra, &[[4.0, 4.0]]].concat();
            Trajectory::from_points(&points).roughness()
        };
        assert!((bent(&[]) - bent(&[[4.0, 1.0], [4.0, 2.5]])).abs() < 1e-9);
        assert!(Trajectory::from_points(&[[0.0, 1.0], [7.0, 3.0]]).roughness() < 1e-20);
        assert!(bent(&[]) > 1e-3);
    }

    #[test]
    fn a_line_of_three_coordinates_is_as_long_as_its_diagonal() {
        let path = Trajectory::from_points(&[[0.0, 0.0, 0.0], [2.0, 3.0, 6.0]]);
        assert_eq!((path.dof(), path.len(), path.length()), (3, 2, 7.0));
        assert_eq!(path.evenly(3).values()[3..6], [1.0, 1.5, 3.0]);
    }
}
