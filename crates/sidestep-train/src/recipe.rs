//! A training of either room as data: what `sidestep train` and experiments read.

use serde_json::Value;
use sidestep::InvalidInput;
use sidestep::policy::Policy;
use toml::Table;

use crate::config::toml_file;
use crate::paper::{TrainConfig, Trainer};
use crate::training::Training;
use crate::waypoint::{ARCHITECTURE, WaypointConfig, WaypointTrainer};

/// A checked configuration of either room. The same one gives the same bits.
#[derive(Debug, Clone, PartialEq)]
pub enum Recipe {
    /// The paper's system: perceptrons and convolutional networks over the whole trajectory.
    Paper(Box<TrainConfig>),
    /// The waypoint policy.
    Waypoint(Box<WaypointConfig>),
}

impl Recipe {
    /// Reads and checks a TOML text; its key `architecture` says which room it is for.
    ///
    /// # Errors
    /// If it is no TOML, has an unknown key or a value of the wrong kind or out of range.
    pub fn from_toml(text: &str) -> Result<Self, InvalidInput> {
        Self::read(&toml_file::table(text)?, text)
    }

    /// The same of a table that was put together.
    ///
    /// # Errors
    /// As [`Recipe::from_toml`].
    pub fn from_table(table: &Table) -> Result<Self, InvalidInput> {
        Self::read(table, "")
    }

    /// `text` is what the table was read from, for the lines that errors name.
    fn read(table: &Table, text: &str) -> Result<Self, InvalidInput> {
        match table.get("architecture") {
            None => {
                let config: TrainConfig = toml_file::parse(table, text)?;
                config.check()?;
                Ok(Self::Paper(Box::new(config)))
            }
            Some(name) if name.as_str() == Some(ARCHITECTURE) => {
                let config: WaypointConfig = toml_file::parse(table, text)?;
                config.check()?;
                Ok(Self::Waypoint(Box::new(config)))
            }
            Some(other) => {
                let allowed = format!("\"{ARCHITECTURE}\", or leave the key out for the paper's");
                Err(InvalidInput::new("architecture", other, allowed))
            }
        }
    }

    /// The seed of parameters, noise and shuffles.
    pub fn seed(&self) -> u64 {
        match self {
            Self::Paper(config) => config.seed,
            Self::Waypoint(config) => config.seed,
        }
    }

    /// The same with another seed.
    pub fn with_seed(mut self, seed: u64) -> Self {
        match &mut self {
            Self::Paper(config) => config.seed = seed,
            Self::Waypoint(config) => config.seed = seed,
        }
        self
    }

    /// The whole configuration as TOML.
    ///
    /// # Errors
    /// Never for a checked configuration.
    pub fn to_toml(&self) -> Result<String, InvalidInput> {
        match self {
            Self::Paper(config) => toml::to_string(config),
            Self::Waypoint(config) => toml::to_string(config),
        }
        .map_err(|error| InvalidInput::new("config", error, "a configuration as TOML"))
    }

    /// The whole configuration as JSON: what a policy's card says of its training.
    pub fn to_json(&self) -> Value {
        match self {
            Self::Paper(config) => serde_json::to_value(config),
            Self::Waypoint(config) => serde_json::to_value(config),
        }
        .unwrap_or_default()
    }

    /// The training at its beginning, from the weights of `init` if there is one.
    ///
    /// # Errors
    /// If a value is out of range, or `init` has another observation, other sizes or another
    /// meaning of its output.
    pub fn begin(&self, init: Option<&Policy>) -> Result<Box<dyn Training>, InvalidInput> {
        Ok(match self {
            Self::Paper(config) => {
                let mut trainer = Trainer::new((**config).clone())?;
                init.map_or(Ok(()), |policy| trainer.begin_from(policy))?;
                Box::new(trainer)
            }
            Self::Waypoint(config) => {
                let mut trainer = WaypointTrainer::new((**config).clone())?;
                init.map_or(Ok(()), |policy| trainer.begin_from(policy))?;
                Box::new(trainer)
            }
        })
    }

    /// Goes on from what [`Training::checkpoint`] wrote. The configuration may ask for more steps
    /// than the one that the checkpoint was made with, and for nothing else.
    ///
    /// # Errors
    /// If the bytes are damaged, or no checkpoint of this configuration; the message names the key
    /// that differs.
    pub fn resume(&self, bytes: &[u8]) -> Result<Box<dyn Training>, InvalidInput> {
        Ok(match self {
            Self::Paper(config) => Box::new(Trainer::resume((**config).clone(), bytes)?),
            Self::Waypoint(config) => Box::new(WaypointTrainer::resume((**config).clone(), bytes)?),
        })
    }
}
