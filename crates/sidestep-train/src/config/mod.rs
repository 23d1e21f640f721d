//! The training configuration: plain data with the paper's values as defaults, checked once.
//!
//! A file may name only what differs from the defaults. An unknown key is an error that suggests the nearest known one; a value
//! out of range is an error that names the field, the value and the range.

mod check;
pub(crate) mod range;
pub mod toml_file;

use serde::{Deserialize, Serialize};
use sidestep::InvalidInput;

use crate::cloning::CloningConfig;
use crate::dagger::DaggerConfig;
use crate::expert::ExpertConfig;
use crate::initialization::Initialization;
use crate::ppo::{PpoConfig, RepairConfig};

pub(crate) use check::Setup;

/// Everything that decides a training; the same configuration gives the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrainConfig {
    /// Seed of parameters, noise and shuffles.
    pub seed: u64,
    /// Profile of the objective: `paper` or `default`.
    pub profile: String,
    /// Environment steps of PPO in all (the paper's "training epochs"), rounded up to whole updates; 0 for cloning alone.
    pub environment_steps: u64,
    /// Names of the observation's parts, in order.
    pub observation: Vec<String>,
    /// The tasks to train on.
    pub training: TrainingConfig,
    /// The networks.
    pub network: NetworkConfig,
    /// Reward, end of an episode, and what an action means.
    pub environment: EnvironmentConfig,
    /// Cloning of gradient descent, before PPO.
    pub cloning: CloningConfig,
    /// Imitation on the policy's own states, after cloning and before PPO.
    pub dagger: DaggerConfig,
    /// What DAgger and the repair of episodes imitate.
    pub expert: ExpertConfig,
    /// PPO.
    pub ppo: PpoConfig,
    /// Repair of failed episodes by an expert during PPO.
    pub repair: RepairConfig,
    /// The tasks that choose the best policy.
    pub validation: ValidationConfig,
}

/// The tasks to train on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrainingConfig {
    /// `easy`, `hard` (in the training version) or `mix`.
    pub suite: String,
    /// How many tasks.
    pub count: usize,
    /// Their seed: 0, or 1000 and above; the others are for validation and tests.
    pub seed: u64,
}

/// Both networks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NetworkConfig {
    /// Units in each of the two hidden layers.
    pub hidden: usize,
    /// How weights begin.
    pub initialization: Initialization,
}

/// The decision process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentConfig {
    /// Factor mu on the reward of the step that finds a feasible trajectory.
    pub mu: f32,
    /// Added to that reward; 0 in the paper. It makes success matter more than U.
    pub feasible_bonus: f32,
    /// Normalised units per unit of the network's output.
    pub action_scale: f32,
    /// Largest update of a coordinate, in normalised units (1 is 10 px of the paper's field).
    pub action_limit: f32,
    /// Whether waypoints are clipped to the field.
    pub keep_inside: bool,
    /// Steps after which an episode is cut off; left out for never.
    pub episode_limit: Option<u32>,
}

/// The tasks that choose the best policy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ValidationConfig {
    /// A suite that `Suite::named` knows.
    pub suite: String,
    /// How many tasks; 0 for no validation.
    pub count: usize,
    /// Their seed: 7 or 17.
    pub seed: u64,
    /// Updates from one validation to the next; the last update always has one.
    pub every: u64,
    /// Iterations that a policy gets per task.
    pub steps: usize,
}

impl Default for TrainConfig {
    fn default() -> Self {
        Self {
            seed: 0,
            profile: "paper".into(),
            environment_steps: 80_000,
            observation: vec!["gradient".into()],
            training: TrainingConfig::default(),
            network: NetworkConfig::default(),
            environment: EnvironmentConfig::default(),
            cloning: CloningConfig::default(),
            dagger: DaggerConfig::default(),
            expert: ExpertConfig::default(),
            ppo: PpoConfig::default(),
            repair: RepairConfig::default(),
            validation: ValidationConfig::default(),
        }
    }
}

impl Default for TrainingConfig {
    fn default() -> Self {
        Self { suite: "easy".into(), count: 100, seed: 0 }
    }
}

impl Default for NetworkConfig {
    fn default() -> Self {
        Self { hidden: 64, initialization: Initialization::default() }
    }
}

impl Default for EnvironmentConfig {
    fn default() -> Self {
        Self {
            mu: 0.1,
            feasible_bonus: 0.0,
            action_scale: 1.0,
            action_limit: 1.0,
            keep_inside: true,
            episode_limit: None,
        }
    }
}

impl Default for ValidationConfig {
    fn default() -> Self {
        Self { suite: "easy".into(), count: 200, seed: 7, every: 1, steps: 200 }
    }
}

impl TrainConfig {
    /// Reads a TOML file's text and checks it.
    ///
    /// # Errors
    /// If it is no TOML, has an unknown key or a value of the wrong kind or out of range.
    pub fn from_toml(text: &str) -> Result<Self, InvalidInput> {
        let config: Self = toml_file::parse(text)?;
        config.check()?;
        Ok(config)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// If one is out of range; the message names the field, the value and the range.
    pub fn check(&self) -> Result<(), InvalidInput> {
        Setup::new(self.clone()).map(|_| ())
    }

    /// Updates of PPO in all: enough for `environment_steps`, the last one whole.
    pub fn updates(&self) -> u64 {
        self.environment_steps.div_ceil((self.ppo.environments * self.ppo.steps).max(1) as u64)
    }
}
