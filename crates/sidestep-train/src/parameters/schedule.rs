//! How learning rates change over a training.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Steps of a stage over which the learning rate rises.
const WARM_UP: f64 = 500.0;
/// Share of the highest learning rate that is left at a stage's end.
const LAST_RATE: f64 = 0.02;

/// How the learning rate falls over the training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Schedule {
    /// Not at all.
    #[default]
    Constant,
    /// lr (1 - progress).
    Linear,
    /// lr (1 + cos(pi progress)) / 2.
    Cosine,
}

impl Schedule {
    /// Factor on the learning rate at `progress` in [0, 1].
    pub fn factor(self, progress: f64) -> f64 {
        match self {
            Self::Constant => 1.0,
            Self::Linear => 1.0 - progress,
            Self::Cosine => 0.5 * (1.0 + (std::f64::consts::PI * progress).cos()),
        }
    }
}

/// Share of the highest learning rate after `done` of `total` steps.
pub fn warm_up_and_cosine(done: f64, total: f64) -> f64 {
    let rise = (done + 1.0) / WARM_UP.min(0.1 * total).max(1.0);
    let cosine = 0.5 * (1.0 + (std::f64::consts::PI * done / total).cos());
    rise.min(1.0) * (LAST_RATE + (1.0 - LAST_RATE) * cosine)
}
