//! A waypoint training's complete state as bytes, from which it goes on to the same bits.

use serde::{Deserialize, Serialize};
use sidestep::InvalidInput;
use sidestep::network::WaypointNet;
use sidestep::policy::tensors::{self, Reader, Tensor};

use super::config::WaypointConfig;
use super::curve::WaypointProgress;
use super::trainer::{WaypointBest, WaypointTrainer};
use super::validation::WaypointValidation;
use crate::config::check_same;

/// The version of the checkpoints that this program writes and reads.
pub const FORMAT: &str = "sidestep.waypoint-checkpoint/2";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    format: String,
    config: WaypointConfig,
    units: u64,
    trajectory_steps: u64,
    best: Option<BestCard>,
    curve: Vec<WaypointProgress>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BestCard {
    validation: WaypointValidation,
    updates: u64,
}

impl WaypointTrainer {
    /// The complete state.
    ///
    /// # Errors
    /// Never: everything in it is finite.
    pub fn checkpoint(&self) -> Result<Vec<u8>, InvalidInput> {
        let best =
            |best: &WaypointBest| BestCard { validation: best.validation, updates: best.updates };
        let document = Document {
            format: FORMAT.into(),
            config: self.config.clone(),
            units: self.units,
            trajectory_steps: self.trajectory_steps,
            best: self.best.as_ref().map(best),
            curve: self.curve.clone(),
        };
        let mut vectors: Vec<(&str, &[f32])> = vec![
            ("parameters", self.net.parameters()),
            ("average", &self.average),
            ("moments.0", &self.moments[0]),
            ("moments.1", &self.moments[1]),
        ];
        if let Some(best) = &self.best {
            vectors.push(("best", &best.parameters));
        }
        let tensors: Vec<Tensor> = vectors
            .into_iter()
            .map(|(name, values)| (name.to_string(), vec![values.len()], values))
            .collect();
        tensors::write(&document, &tensors)
    }

    /// Goes on from a checkpoint of this configuration, whose last stage may ask for more updates
    /// than before.
    ///
    /// # Errors
    /// If the bytes are no checkpoint of this version, damaged, contradict themselves, or belong to
    /// another configuration.
    pub fn resume(config: WaypointConfig, bytes: &[u8]) -> Result<Self, InvalidInput> {
        let mut reader = Reader::new(bytes, "checkpoint", FORMAT)?;
        reader.require_checksum()?;
        let document: Document = reader.document()?;
        let mut stored = document.config;
        if let (true, Some(last), Some(given)) = (
            stored.stages.len() == config.stages.len(),
            stored.stages.last_mut(),
            config.stages.last(),
        ) {
            last.updates = last.updates.max(given.updates);
        }
        check_same(&stored, &config)?;
        let mut trainer = Self::new(config)?;
        let count = trainer.average.len();
        let mut read = |name: &str| reader.tensor(name, &[count]);
        trainer.net = WaypointNet::new(trainer.shape(), read("parameters")?)?;
        trainer.average = read("average")?;
        trainer.moments = [read("moments.0")?, read("moments.1")?];
        if let Some(BestCard { validation, updates }) = document.best {
            trainer.best = Some(WaypointBest { parameters: read("best")?, validation, updates });
        }
        reader.finish()?;
        let units = trainer.units().all;
        if document.units > units {
            let allowed = format!("up to {units}, as the configuration says");
            return Err(InvalidInput::new("checkpoint.units", document.units, allowed));
        }
        trainer.units = document.units;
        trainer.trajectory_steps = document.trajectory_steps;
        trainer.curve = document.curve;
        Ok(trainer)
    }
}
