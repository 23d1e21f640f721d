//! What the units of a training did: points of its curve, as data, as scalars and in words.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use sidestep::InvalidInput;
use sidestep::policy::Policy;

use super::config::StageKind;
use super::trainer::WaypointTrainer;
use super::validation::WaypointValidation;
use crate::training::{Divergence, Made, Scalar, Training, Units, lines};

/// What one unit did: a point of the training curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaypointProgress {
    /// Index of the stage.
    pub stage: usize,
    /// What the stage does.
    pub kind: StageKind,
    /// Units so far, over all stages.
    pub unit: u64,
    /// Optimizer steps so far.
    pub updates: u64,
    /// Steps of trajectories so far.
    pub trajectory_steps: u64,
    /// Learning rate of the last update.
    pub learning_rate: f64,
    /// Mean loss per trajectory and step (imitation), or minus the mean return of a walk (policy
    /// gradient).
    pub loss: f64,
    /// Share of the tasks that the straight start (imitation) or a walk (policy gradient) solved.
    pub solved: f64,
    /// Mean gradient norm before clipping.
    pub gradient_norm: f64,
    /// The result on the validation tasks, where this unit ended with one.
    pub validation: Option<WaypointValidation>,
    /// Whether that is the best so far.
    pub is_best: bool,
}

impl WaypointProgress {
    /// Its numbers, under the tags that CleanRL uses where there are such.
    pub(super) fn scalars(&self) -> Vec<Scalar> {
        let scalar = |tag, value| Scalar { step: self.trajectory_steps, tag, value };
        let mut scalars = vec![
            scalar("charts/learning_rate", self.learning_rate),
            scalar("charts/solved", self.solved),
            scalar("losses/loss", self.loss),
            scalar("losses/gradient_norm", self.gradient_norm),
        ];
        if let Some(validation) = &self.validation {
            scalars.extend([
                scalar("validation/success_easy", validation.easy.success()),
                scalar("validation/success_hard", validation.hard.success()),
                scalar("validation/iterations_easy", validation.easy.mean_iterations),
                scalar("validation/iterations_hard", validation.hard.mean_iterations),
            ]);
        }
        scalars
    }
}

impl Training for WaypointTrainer {
    fn units(&self) -> Units {
        Self::units(self)
    }

    fn environment_steps(&self) -> u64 {
        self.trajectory_steps()
    }

    fn step(&mut self) -> Result<Option<Made>, Divergence> {
        let words = |v: WaypointValidation| {
            let [easy, hard] = [v.easy, v.hard].map(|suite| 100.0 * suite.success());
            format!("validation {easy:.1} % easy, {hard:.1} % hard")
        };
        Ok(Self::step(self)?.map(|progress| Made { validation: progress.validation.map(words) }))
    }

    fn best_policy(&self) -> Result<Policy, InvalidInput> {
        Self::best_policy(self)
    }

    fn checkpoint(&self) -> Result<Vec<u8>, InvalidInput> {
        Self::checkpoint(self)
    }

    fn lines(&self) -> String {
        lines(self.curve())
    }

    fn summary(&self) -> Value {
        let best = self.best();
        json!({
            "validation_success": best.map(|best| best.validation.easy.success()),
            "validation_success_hard": best.map(|best| best.validation.hard.success()),
            "validation_iterations": best.map(|best| best.validation.easy.mean_iterations),
            "best_updates": best.map(|best| best.updates),
        })
    }

    fn scalars(&self) -> Vec<Vec<Scalar>> {
        self.curve().iter().map(WaypointProgress::scalars).collect()
    }
}
