//! From a network's output to an update of waypoints.

use serde::{Deserialize, Serialize};

use crate::error::InvalidInput;

/// From a network's output to an update of the trajectory.
///
/// ```text
/// x <- keep_inside(x + clamp(scale * output, -limit, limit))
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActionRule {
    /// Normalised units per unit of output; the paper's is 1.
    pub scale: f32,
    /// Largest update of a coordinate, in normalised units; the paper's is 1 (10 px).
    pub limit: f32,
    /// Whether waypoints are clipped to the field, as in the paper's code.
    pub keep_inside: bool,
}

impl ActionRule {
    /// The paper's rule.
    pub const PAPER: Self = Self { scale: 1.0, limit: 1.0, keep_inside: true };

    /// Moves the waypoints `x [N x dof]` by the network output `action [N x dof]`, `limits [dof]` being the least and greatest
    /// value of each coordinate, all in normalised units. Training and planning both call this. A NaN in `action` counts as 0.
    pub fn apply(&self, action: &[f32], limits: &[[f32; 2]], x: &mut [f32]) {
        let dof = limits.len();
        for (x, action) in x.chunks_exact_mut(dof).zip(action.chunks_exact(dof)) {
            for ((x, &output), &[least, most]) in x.iter_mut().zip(action).zip(limits) {
                let update = (self.scale * output).clamp(-self.limit, self.limit);
                *x += if update.is_nan() { 0.0 } else { update };
                if self.keep_inside {
                    *x = x.max(least).min(most);
                }
            }
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// If one is not above 0 and at most 1e6.
    pub fn check(&self) -> Result<(), InvalidInput> {
        for (name, value) in [("scale", self.scale), ("limit", self.limit)] {
            if !(value > 0.0 && value <= 1e6) {
                let field = format!("policy.action.{name}");
                return Err(InvalidInput::new(field, value, "a number above 0 and up to 1e6"));
            }
        }
        Ok(())
    }
}
