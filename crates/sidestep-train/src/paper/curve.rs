//! What the units of a training did: points of its curve, as data, as scalars and in words.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use sidestep::InvalidInput;
use sidestep::policy::Policy;

use super::config::TrainConfig;
use super::stages::ppo::UpdateMetrics;
use super::trainer::Trainer;
use crate::training::{Divergence, Made, Scalar, Training, Units, lines};
use crate::validation::Validation;

/// Which part of the training a unit belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// An epoch of behaviour cloning.
    Cloning,
    /// A round of DAgger: rollouts, then training on all that was met.
    Dagger,
    /// An update of PPO: experience from every environment, then epochs over it.
    Ppo,
}

/// What one unit did: a point of the training curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    /// The unit's stage.
    pub stage: Stage,
    /// Its number within the stage, from 1.
    pub unit: u64,
    /// Units of the stage in all.
    pub units: u64,
    /// Environment steps made so far.
    pub environment_steps: u64,
    /// Loss of each minibatch of cloning or DAgger, in order; empty for PPO.
    pub cloning_losses: Vec<f64>,
    /// What the update of PPO did.
    pub update: Option<UpdateMetrics>,
    /// The result on the validation tasks, where this unit ended with one.
    pub validation: Option<Validation>,
    /// Whether that is the best so far.
    pub is_best: bool,
}

impl Progress {
    /// After cloning, after every so many rounds or updates, and after the last one.
    pub(super) fn validation_is_due(&self, config: &TrainConfig) -> bool {
        match self.stage {
            Stage::Cloning => self.unit == self.units,
            Stage::Dagger | Stage::Ppo => {
                self.unit == self.units || self.unit.is_multiple_of(config.validation.every)
            }
        }
    }

    /// Its numbers, under the tags that CleanRL uses where there are such.
    pub(super) fn scalars(&self) -> Vec<Scalar> {
        let scalar = |tag, value| Scalar { step: self.environment_steps, tag, value };
        let mut scalars = Vec::new();
        if let Some(update) = &self.update {
            scalars.extend([
                scalar("charts/learning_rate", update.learning_rate),
                scalar("charts/episodic_length", update.episode_length),
                scalar("charts/mean_reward", update.mean_reward),
                scalar("losses/policy_loss", update.policy_loss),
                scalar("losses/value_loss", update.value_loss),
                scalar("losses/entropy", update.entropy),
                scalar("losses/approx_kl", update.approx_kl),
                scalar("losses/clipfrac", update.clip_fraction),
                scalar("losses/explained_variance", update.explained_variance),
                scalar("losses/gradient_norm", update.gradient_norm),
            ]);
            if update.failed > 0 {
                scalars.push(scalar("losses/repair_loss", update.repair_loss));
            }
        }
        let losses = self.cloning_losses.iter().enumerate();
        scalars.extend(losses.map(|(index, &value)| Scalar {
            step: index as u64,
            tag: "losses/cloning",
            value,
        }));
        if let Some(validation) = &self.validation {
            scalars.push(scalar("validation/success", validation.success()));
            scalars.push(scalar("validation/iterations", validation.mean_iterations));
        }
        scalars
    }
}

impl Training for Trainer {
    fn units(&self) -> Units {
        Self::units(self)
    }

    fn environment_steps(&self) -> u64 {
        Self::environment_steps(self)
    }

    fn step(&mut self) -> Result<Option<Made>, Divergence> {
        let words = |v: Validation| format!("validation {:.1} %", 100.0 * v.success());
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
            "validation_success": best.map(|best| best.validation.success()),
            "validation_iterations": best.map(|best| best.validation.mean_iterations),
            "best_environment_steps": best.map(|best| best.environment_steps),
        })
    }

    fn scalars(&self) -> Vec<Vec<Scalar>> {
        self.curve().iter().map(Progress::scalars).collect()
    }
}
