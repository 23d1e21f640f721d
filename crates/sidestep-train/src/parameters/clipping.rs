//! Limits on the norm of a whole gradient.

/// Factor that brings a gradient of this norm within the limit.
pub fn clip_factor(norm: f32, limit: f32) -> f32 {
    (limit / (norm + 1e-6)).min(1.0)
}
