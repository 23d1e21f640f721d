//! The training configuration: plain data with the paper's values as defaults, checked once.
//!
//! A file may name only what differs from the defaults. An unknown key is an error that suggests
//! the nearest known one; a value out of range is an error that names the field, the value and the
//! range.

mod check;
mod memory;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sidestep::InvalidInput;

use crate::config::toml_file;
use crate::paper::expert::ExpertConfig;
use crate::paper::stages::cloning::CloningConfig;
use crate::paper::stages::dagger::DaggerConfig;
use crate::paper::stages::ppo::{PpoConfig, RepairConfig};
use crate::parameters::Initialization;

pub(crate) use check::Setup;

/// Everything that decides a training; the same configuration gives the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrainConfig {
    /// Seed of parameters, noise and shuffles.
    pub seed: u64,
    /// Profile of the objective: `paper` or `default`.
    pub profile: String,
    /// Environment steps of PPO in all (the paper's "training epochs"), rounded up to whole
    /// updates; 0 for cloning alone.
    #[schemars(range(min = 0, max = 1_000_000_000_000_u64))]
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrainingConfig {
    /// `easy`, `hard-training` (the training version of hard; `hard` says the same) or `mix`.
    pub suite: String,
    /// How many tasks.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub count: usize,
    /// Seed of the training tasks: 0, or 1000 and above; the others are for validation and tests.
    pub seed: u64,
}

/// Both networks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NetworkConfig {
    /// Units in each of the two hidden layers.
    #[schemars(range(min = 1, max = 4096))]
    pub hidden: usize,
    /// How weights begin.
    pub initialization: Initialization,
}

/// The decision process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EnvironmentConfig {
    /// Factor mu on the reward of the step that finds a feasible trajectory.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub mu: f32,
    /// Added to the reward of a feasible step; 0 in the paper. It makes success matter more than U.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub feasible_bonus: f32,
    /// Normalised units per unit of the network's output.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1_000_000.0))]
    pub action_scale: f32,
    /// Largest update of a coordinate, in normalised units (1 is 10 px of the paper's field).
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1_000_000.0))]
    pub action_limit: f32,
    /// Whether waypoints are clipped to the field.
    pub keep_inside: bool,
    /// Steps after which an episode is cut off; left out for never.
    #[schemars(range(min = 1, max = 4_294_967_295_u32))]
    pub episode_limit: Option<u32>,
}

/// The tasks that choose the best policy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ValidationConfig {
    /// `easy`, `hard`, `hard-training`, `mix`, `time`, `varied`, `rooms`, `blobs` or `scans`.
    pub suite: String,
    /// How many tasks; 0 for no validation.
    #[schemars(range(min = 0, max = 100_000))]
    pub count: usize,
    /// Seed of the validation tasks: 7 or 17.
    pub seed: u64,
    /// Updates from one validation to the next; the last update always has one.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub every: u64,
    /// Iterations that a policy gets per task.
    #[schemars(range(min = 1, max = 100_000))]
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
        let config: Self = toml_file::parse(&toml_file::table(text)?, text)?;
        config.check()?;
        Ok(config)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// If one is out of range; the message names the field, the value and the range.
    pub fn check(&self) -> Result<(), InvalidInput> {
        Setup::new(self.clone(), &[]).map(|_| ())
    }

    /// Updates of PPO in all: enough for `environment_steps`, the last one whole.
    pub fn updates(&self) -> u64 {
        self.environment_steps.div_ceil((self.ppo.environments * self.ppo.steps).max(1) as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::TrainConfig;

    #[test]
    fn what_is_left_out_keeps_the_papers_value() {
        assert_eq!(TrainConfig::from_toml("").unwrap(), TrainConfig::default());
        let text = "seed = 3\nenvironment_steps = 10_000\n[network]\nhidden = 128\n[ppo]\ntarget_kl = 0.02";
        let config = TrainConfig::from_toml(text).unwrap();
        assert_eq!((config.seed, config.network.hidden), (3, 128));
        assert_eq!((config.ppo.target_kl, config.ppo.epochs), (Some(0.02), 10));
        assert_eq!(config.updates(), 3);
    }

    #[test]
    fn a_written_configuration_reads_back() {
        let config = TrainConfig::default();
        assert_eq!(TrainConfig::from_toml(&toml::to_string(&config).unwrap()).unwrap(), config);
    }

    #[test]
    fn errors_name_field_value_and_range() {
        let check = |text: &str, expected: &str| {
            let message = TrainConfig::from_toml(text).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        };
        check(
            "[ppo]\nlearning_rat = 1",
            "ppo.learning_rat: an unknown key is not allowed; expected learning_rate",
        );
        check("sede = 1", "expected seed");
        check("[pp0]\nsteps = 1", "expected ppo");
        check("[network]\nxyzzy = 1", "[network] knows hidden, initialization");
        check("environment_steps = -5", "environment_steps: -5");
        check("environment_steps = 1e5", "expected a whole number of at least 0");
        check("[ppo]\nclip = \"wide\"", "ppo.clip: \"wide\" is not allowed; expected a number");
        check(
            "[ppo]\nclip = 0",
            "ppo.clip: 0 is not allowed; expected a number above 0 and up to 1",
        );
        check("[ppo]\ngamma = nan", "ppo.gamma: NaN");
        check("[ppo]\ntarget_kl = -1", "ppo.target_kl: -1");
        check("[ppo]\nschedule = \"linaer\"", "config, line 2: unknown variant `linaer`");
        check("[ppo]\nsteps = 1000000\nenvironments = 1000000", "ppo.steps: 1000000");
        check("training.count = 1000000\ncloning.epochs = 0", "training.count: 1000000");
        check("ppo.environments = 1000000\nppo.steps = 1", "ppo.environments: 1000000");
        check("cloning.samples_per_task = 1000000", "cloning.samples_per_task: 1000000");
        check("network.hidden = 4096\nppo.minibatch = 1000", "network.hidden: 4096");
        check("validation.count = 100000", "validation.count: 100000");
        check("[ppo]\nenvironments = 0", "ppo.environments: 0");
        check("profile = \"papr\"", "profile: `papr`");
        check("observation = [\"gradent\"]", "observation: gradent");
        check("observation = []", "at least one part");
        check("observation = [1]", "a list of texts");
        check("[training]\nseed = 2", "training.seed: 2");
        check(
            "[training]\nsuite = \"time\"",
            "easy, hard-training (or hard, the same here) or mix",
        );
        check("[validation]\nseed = 2", "validation.seed: 2");
        check("[validation]\nsuite = \"eazy\"", "validation.suite: `eazy`");
        check("[cloning]\nstarts = \"lnie\"", "cloning.starts: `lnie`");
        check("observation = [\"image\", \"image\"]", "each kind of part once");
        check("observation = [\"image\", \"waypoint-image\"]", "one image");
        check("[dagger]\nexpert = \"shortest\"", "unknown variant `shortest`");
        check(
            "[dagger]\nbeta = 1.5",
            "dagger.beta: 1.5 is not allowed; expected a number from 0 to 1",
        );
        check("[dagger]\nstarts = \"lnie\"", "dagger.starts: `lnie`");
        check("[expert]\nrate = 0", "expert.rate: 0");
        check("[repair]\nafter = 0", "repair.after: 0");
        check(
            "environment_steps = 0\nrepair.expert = \"shortest-path\"",
            "repair.expert: an expert, with environment_steps = 0 is not allowed",
        );
        check("ppo = 3", "ppo: 3 is not allowed; expected a table");
        check("seed = ", "config, line 1");
    }
}
