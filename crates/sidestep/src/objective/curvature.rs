//! The Gauss-Newton curvature of U, from one evaluation with its gradient.
//!
//! The obstacle cost c of a configuration is taken as half the square of one residual r = √(2c), whose slope is ∂c/∂q / r:
//! where a single distance is within the clearance that is the Gauss-Newton matrix of the distance itself, and it needs nothing
//! beside the costs and slopes that are there. Configurations between two waypoints reach both, so the matrix is
//! block-tridiagonal in the waypoints. J. Nocedal, S. Wright, Numerical Optimization, 2006, chapter 10.

use super::Objective;
use crate::trajectory::BlockTridiagonal;

impl Objective {
    /// Writes the curvature of U at the last trajectory whose cost and gradient were evaluated; costs of one's own count as flat.
    pub(crate) fn curvature(&self, out: &mut BlockTridiagonal) {
        let period = self.fractions.substeps + 1;
        let factor = self.scene().profile().obstacle_gradient_factor as f32;
        let block = &self.block;
        out.clear();
        for at in (0..block.count).filter(|&at| block.costs[at] > 0.0) {
            // Slopes hold weight times factor times ∂c/∂q.
            let scale = 1.0 / (2.0 * block.costs[at] * block.weights[at] * factor);
            let t = (at % period + 1) as f32 / period as f32;
            let slope = |k: usize| block.slopes[k * block.padded + at];
            out.add_square(at / period, t, scale, slope);
        }
        out.add_metric(2.0 * self.lambda);
    }
}
