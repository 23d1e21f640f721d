//! A waypoint training's complete state as bytes, from which it goes on to the same bits.

use serde::{Deserialize, Serialize};
use sidestep::InvalidInput;
use sidestep::network::WaypointNet;
use sidestep::policy::tensors::{self, Reader, Tensor};

use super::config::WaypointConfig;
use super::trainer::{WaypointBest, WaypointProgress, WaypointTrainer};
use super::validation::WaypointValidation;

/// The version of the checkpoints that this program writes and reads.
pub const FORMAT: &str = "sidestep.waypoint-checkpoint/1";

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
    /// If the state is no JSON, which a diverged training may be.
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

    /// The training that [`WaypointTrainer::checkpoint`] wrote.
    ///
    /// # Errors
    /// If the bytes are no complete checkpoint of this version, or contradict themselves.
    pub fn resume(bytes: &[u8]) -> Result<Self, InvalidInput> {
        let mut reader = Reader::new(bytes, "checkpoint", FORMAT)?;
        let document: Document = reader.document()?;
        let mut trainer = Self::new(document.config)?;
        let count = trainer.average.len();
        let mut read = |name: &str| reader.tensor(name, &[count]);
        trainer.net = WaypointNet::new(trainer.shape(), read("parameters")?)?;
        trainer.average = read("average")?;
        trainer.moments = [read("moments.0")?, read("moments.1")?];
        if let Some(BestCard { validation, updates }) = document.best {
            trainer.best = Some(WaypointBest { parameters: read("best")?, validation, updates });
        }
        reader.finish()?;
        let (_, units) = trainer.units();
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
