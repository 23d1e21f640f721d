//! The clearance cost c(D) of the objective over lanes, and its slope, for a block of configurations.
//!
//! ```text
//! t = clamp(ε - D, 0, ε)      c = t² / 2ε + max(-D, 0)      c' = -t / ε
//! ```

use super::{LANES, least, most};

/// Configurations in lanes with what they cost: coordinate k of configuration j lies at `k * padded + j`, in normalised units.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    /// Configurations that count; the others are padding of weight 0.
    pub count: usize,
    /// Room of a lane: a multiple of [`LANES`], at least seven more than `count`, so that eight can be written at any.
    pub padded: usize,
    /// `[dof x padded]`.
    pub points: Vec<f32>,
    /// Each configuration's share in the obstacle cost, `[padded]`.
    pub weights: Vec<f32>,
    /// Signed distances, for a scene to work in, `[padded]`.
    pub distances: Vec<f32>,
    /// c, `[padded]`.
    pub costs: Vec<f32>,
    /// Weight times factor times ∂c/∂q, `[dof x padded]`.
    pub slopes: Vec<f32>,
}

impl Block {
    /// A block for configurations of these weights.
    pub fn new(dof: usize, mut weights: Vec<f32>) -> Self {
        let count = weights.len();
        let padded = (count + 7).next_multiple_of(LANES);
        weights.resize(padded, 0.0);
        Self {
            count,
            padded,
            points: vec![0.0; dof * padded],
            weights,
            distances: vec![0.0; padded],
            costs: vec![0.0; padded],
            slopes: vec![0.0; dof * padded],
        }
    }

    /// The weighted sum of the costs.
    #[inline(always)]
    pub(crate) fn total(&self) -> f32 {
        let mut sums = [0.0f32; LANES];
        for first in (0..self.padded).step_by(LANES) {
            let weights = &self.weights[first..first + LANES];
            let costs = &self.costs[first..first + LANES];
            for l in 0..LANES {
                sums[l] += weights[l] * costs[l];
            }
        }
        sums.iter().sum()
    }
}

/// c at a distance.
#[inline(always)]
pub(crate) fn cost(epsilon: f32, distance: f32) -> f32 {
    let t = least(most(epsilon - distance, 0.0), epsilon);
    0.5 * (1.0 / epsilon) * t * t + most(-distance, 0.0)
}

/// c' at a distance.
#[inline(always)]
pub(crate) fn slope(epsilon: f32, distance: f32) -> f32 {
    let t = least(most(epsilon - distance, 0.0), epsilon);
    -t * (1.0 / epsilon)
}
