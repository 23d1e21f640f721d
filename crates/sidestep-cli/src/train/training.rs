//! The two trainings behind one verb: the paper's (cloning and PPO of a perceptron) and the waypoint policy's.

use serde::Serialize;
use serde_json::{Value, json};
use sidestep::InvalidInput;
use sidestep::policy::Policy;
use sidestep_train::config::toml_file;
use sidestep_train::waypoint::ARCHITECTURE;
use sidestep_train::{TrainConfig, Trainer, WaypointConfig, WaypointTrainer};

use crate::failure::Failure;

/// A configuration of either.
#[derive(Debug, Clone, PartialEq)]
pub enum Config {
    /// The paper's.
    Mlp(Box<TrainConfig>),
    /// The waypoint policy's.
    Waypoint(Box<WaypointConfig>),
}

impl Config {
    /// Reads and checks a TOML text; its key `architecture` says which it is.
    pub fn from_toml(text: &str) -> Result<Self, InvalidInput> {
        match toml_file::architecture(text).as_deref() {
            Some(ARCHITECTURE) => Ok(Self::Waypoint(Box::new(WaypointConfig::from_toml(text)?))),
            Some(other) => {
                let allowed = format!("{ARCHITECTURE}, or leave the key out for the paper's");
                Err(InvalidInput::new("architecture", other, allowed))
            }
            None => Ok(Self::Mlp(Box::new(TrainConfig::from_toml(text)?))),
        }
    }

    /// Replaces the seed.
    pub fn set_seed(&mut self, seed: u64) {
        match self {
            Self::Mlp(config) => config.seed = seed,
            Self::Waypoint(config) => config.seed = seed,
        }
    }

    /// The whole configuration as TOML.
    pub fn to_toml(&self) -> Result<String, Failure> {
        match self {
            Self::Mlp(config) => toml::to_string(config),
            Self::Waypoint(config) => toml::to_string(config),
        }
        .map_err(|error| Failure::at("configuration", error))
    }
}

/// A scalar of the training curve: step, tag, value.
pub type Scalar = (u64, &'static str, f64);

/// A training of either.
pub enum Training {
    /// The paper's.
    Mlp(Box<Trainer>),
    /// The waypoint policy's.
    Waypoint(Box<WaypointTrainer>),
}

impl Training {
    pub fn new(config: Config) -> Result<Self, InvalidInput> {
        Ok(match config {
            Config::Mlp(config) => Self::Mlp(Box::new(Trainer::new(*config)?)),
            Config::Waypoint(config) => Self::Waypoint(Box::new(WaypointTrainer::new(*config)?)),
        })
    }

    /// Goes on from a checkpoint of the kind that `config` trains.
    pub fn resume(config: &Config, bytes: &[u8]) -> Result<Self, InvalidInput> {
        Ok(match config {
            Config::Mlp(_) => Self::Mlp(Box::new(Trainer::resume(bytes)?)),
            Config::Waypoint(_) => Self::Waypoint(Box::new(WaypointTrainer::resume(bytes)?)),
        })
    }

    pub fn config(&self) -> Config {
        match self {
            Self::Mlp(trainer) => Config::Mlp(Box::new(trainer.config().clone())),
            Self::Waypoint(trainer) => Config::Waypoint(Box::new(trainer.config().clone())),
        }
    }

    /// Units done, and in all.
    pub fn units(&self) -> (u64, u64) {
        match self {
            Self::Mlp(trainer) => trainer.units(),
            Self::Waypoint(trainer) => trainer.units(),
        }
    }

    /// Steps of environments or trajectories so far.
    pub fn environment_steps(&self) -> u64 {
        match self {
            Self::Mlp(trainer) => trainer.environment_steps(),
            Self::Waypoint(trainer) => trainer.trajectory_steps(),
        }
    }

    /// Makes the next unit and says how it went; `None` when all are done.
    pub fn step(&mut self) -> Result<Option<String>, InvalidInput> {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        Ok(match self {
            Self::Mlp(trainer) => trainer.step()?.map(|progress| {
                let validation = progress.validation;
                validation.map_or(String::new(), |v| format!("validation {}", percent(v.success())))
            }),
            Self::Waypoint(trainer) => trainer.step()?.map(|progress| match progress.validation {
                Some(v) => format!(
                    "validation {} easy, {} hard",
                    percent(v.easy.success()),
                    percent(v.hard.success())
                ),
                None => String::new(),
            }),
        })
    }

    pub fn best_policy(&self) -> Result<Policy, InvalidInput> {
        match self {
            Self::Mlp(trainer) => trainer.best_policy(),
            Self::Waypoint(trainer) => trainer.best_policy(),
        }
    }

    pub fn checkpoint(&self) -> Result<Vec<u8>, InvalidInput> {
        match self {
            Self::Mlp(trainer) => trainer.checkpoint(),
            Self::Waypoint(trainer) => trainer.checkpoint(),
        }
    }

    /// The curve as JSON lines.
    pub fn lines(&self) -> Result<String, Failure> {
        match self {
            Self::Mlp(trainer) => lines(trainer.curve()),
            Self::Waypoint(trainer) => lines(trainer.curve()),
        }
    }

    /// The best result on the validation tasks, for the summary.
    pub fn best(&self) -> Value {
        match self {
            Self::Mlp(trainer) => {
                let best = trainer.best();
                json!({
                    "validation_success": best.map(|best| best.validation.success()),
                    "validation_iterations": best.map(|best| best.validation.mean_iterations),
                    "best_environment_steps": best.map(|best| best.environment_steps),
                })
            }
            Self::Waypoint(trainer) => {
                let best = trainer.best();
                json!({
                    "validation_success": best.map(|best| best.validation.easy.success()),
                    "validation_success_hard": best.map(|best| best.validation.hard.success()),
                    "validation_iterations": best.map(|best| best.validation.easy.mean_iterations),
                    "best_updates": best.map(|best| best.updates),
                })
            }
        }
    }

    /// The curve unit by unit, under the tags that CleanRL uses where there are such.
    pub fn scalars(&self) -> Vec<Vec<Scalar>> {
        match self {
            Self::Mlp(trainer) => trainer.curve().iter().map(mlp_scalars).collect(),
            Self::Waypoint(trainer) => trainer.curve().iter().map(waypoint_scalars).collect(),
        }
    }
}

fn lines<T: Serialize>(curve: &[T]) -> Result<String, Failure> {
    let mut lines = String::new();
    for progress in curve {
        let line =
            serde_json::to_string(progress).map_err(|error| Failure::at("metrics", error))?;
        lines += &(line + "\n");
    }
    Ok(lines)
}

fn mlp_scalars(progress: &sidestep_train::Progress) -> Vec<Scalar> {
    let step = progress.environment_steps;
    let mut scalars = Vec::new();
    if let Some(update) = &progress.update {
        scalars.extend([
            (step, "charts/learning_rate", update.learning_rate),
            (step, "charts/episodic_length", update.episode_length),
            (step, "charts/mean_reward", update.mean_reward),
            (step, "losses/policy_loss", update.policy_loss),
            (step, "losses/value_loss", update.value_loss),
            (step, "losses/entropy", update.entropy),
            (step, "losses/approx_kl", update.approx_kl),
            (step, "losses/clipfrac", update.clip_fraction),
            (step, "losses/explained_variance", update.explained_variance),
            (step, "losses/gradient_norm", update.gradient_norm),
        ]);
    }
    let losses = progress.cloning_losses.iter().enumerate();
    scalars.extend(losses.map(|(index, loss)| (index as u64, "losses/cloning", *loss)));
    if let Some(validation) = &progress.validation {
        scalars.push((step, "validation/success", validation.success()));
        scalars.push((step, "validation/iterations", validation.mean_iterations));
    }
    scalars
}

fn waypoint_scalars(progress: &sidestep_train::waypoint::WaypointProgress) -> Vec<Scalar> {
    let step = progress.trajectory_steps;
    let mut scalars = vec![
        (step, "charts/learning_rate", progress.learning_rate),
        (step, "charts/solved", progress.solved),
        (step, "losses/loss", progress.loss),
        (step, "losses/gradient_norm", progress.gradient_norm),
    ];
    if let Some(validation) = &progress.validation {
        scalars.extend([
            (step, "validation/success_easy", validation.easy.success()),
            (step, "validation/success_hard", validation.hard.success()),
            (step, "validation/iterations_easy", validation.easy.mean_iterations),
            (step, "validation/iterations_hard", validation.hard.mean_iterations),
        ]);
    }
    scalars
}
