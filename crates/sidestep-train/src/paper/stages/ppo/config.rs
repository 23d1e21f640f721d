//! Settings of PPO; the defaults are the paper's.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::parameters::Schedule;

/// Settings of PPO. The defaults are the paper's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PpoConfig {
    /// Environments side by side.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub environments: usize,
    /// Steps of each environment per update (the paper's buffer).
    #[schemars(range(min = 1, max = 1_000_000))]
    pub steps: usize,
    /// Discount gamma.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub gamma: f32,
    /// Lambda of the advantage estimate.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub lambda: f32,
    /// Learning rate at the start.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1.0))]
    pub learning_rate: f64,
    /// How the learning rate falls.
    pub schedule: Schedule,
    /// Steps per minibatch.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub minibatch: usize,
    /// Passes over the steps of an update.
    #[schemars(range(min = 1, max = 1000))]
    pub epochs: usize,
    /// Coefficient c_e of the entropy.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub entropy: f32,
    /// Coefficient c_v of the value loss.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub value: f32,
    /// Largest norm of the gradient.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1_000_000.0))]
    pub max_gradient_norm: f32,
    /// Clip range c of the ratio.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1.0))]
    pub clip: f32,
    /// Whether advantages are normalised per minibatch.
    pub normalise_advantages: bool,
    /// An update ends when the approximate KL exceeds 1.5 times this; left out for never.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1000.0))]
    pub target_kl: Option<f64>,
    /// Log-std of the actions at the start.
    #[schemars(range(min = -10.0, max = 3.0))]
    pub initial_log_std: f32,
}

impl Default for PpoConfig {
    fn default() -> Self {
        Self {
            environments: 100,
            steps: 40,
            gamma: 1.0,
            lambda: 0.95,
            learning_rate: 3e-4,
            schedule: Schedule::Constant,
            minibatch: 64,
            epochs: 10,
            entropy: 0.0,
            value: 0.5,
            max_gradient_norm: 0.5,
            clip: 0.2,
            normalise_advantages: true,
            target_kl: None,
            initial_log_std: 0.0,
        }
    }
}
