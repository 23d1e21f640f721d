//! An axis-aligned box around something.

use super::vector::Vector;

/// The smallest and the largest coordinate on each axis, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The smallest coordinates.
    pub min: Vector,
    /// The largest coordinates.
    pub max: Vector,
}

impl Bounds {
    /// Around nothing: any union with it is the other.
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

    /// Around points.
    pub fn around(points: impl IntoIterator<Item = Vector>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, p| bounds.union(Self { min: p, max: p }))
    }

    /// Around both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: [0, 1, 2].map(|k| self.min[k].min(other.min[k])),
            max: [0, 1, 2].map(|k| self.max[k].max(other.max[k])),
        }
    }

    /// Larger by `by` metres on every side.
    pub fn grown(self, by: f64) -> Self {
        Self { min: self.min.map(|v| v - by), max: self.max.map(|v| v + by) }
    }

    /// The middle.
    pub fn center(&self) -> Vector {
        [0, 1, 2].map(|k| 0.5 * (self.min[k] + self.max[k]))
    }

    /// Squared distance of `p` from the box; zero inside.
    #[inline(always)]
    pub fn squared_distance(&self, p: Vector) -> f64 {
        let mut sum = 0.0;
        for k in 0..3 {
            let beyond = (self.min[k] - p[k]).max(p[k] - self.max[k]).max(0.0);
            sum += beyond * beyond;
        }
        sum
    }
}
