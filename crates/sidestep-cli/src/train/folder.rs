//! The folder of a training: what it holds, and in which order it is written.
//!
//! `config.toml`, `checkpoint.safetensors` (the complete state), `policy.safetensors` (the best on
//! the validation tasks), `metrics.jsonl` and a TensorBoard event file (the curve), and
//! `summary.json` at the end. Logs are written anew from the checkpoint's own curve, so a training
//! that was killed at any moment and resumed ends with the same files but for times.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::Value;
use sidestep_train::{Recipe, Training};

use super::tensorboard::Events;
use crate::failure::Failure;
use crate::lock::Lock;
use crate::output;

/// A folder that this training alone writes into.
pub struct Folder {
    path: PathBuf,
    _lock: Lock,
}

impl Folder {
    /// Makes the folder where it is missing, and locks it.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        Ok(Self { path: path.into(), _lock: Lock::folder(path)? })
    }

    /// The file of the complete state.
    pub fn checkpoint(&self) -> PathBuf {
        self.path.join("checkpoint.safetensors")
    }

    /// The file of the best policy.
    pub fn policy(&self) -> PathBuf {
        self.path.join("policy.safetensors")
    }

    /// The file of the whole configuration.
    pub fn config(&self) -> PathBuf {
        self.path.join("config.toml")
    }

    /// The complete state that is stored, if there is one.
    pub fn read_checkpoint(&self) -> Result<Option<Vec<u8>>, Failure> {
        let path = self.checkpoint();
        if !path.exists() {
            return Ok(None);
        }
        std::fs::read(&path)
            .map(Some)
            .map_err(|error| Failure::file(&path, format!("cannot be read ({error})")))
    }

    /// Writes the whole configuration.
    pub fn write_config(&self, recipe: &Recipe) -> Result<(), Failure> {
        output::write_file(&self.config(), recipe.to_toml()?.as_bytes())
    }

    /// Writes the best policy, the logs and last the state, of a training that this run has worked
    /// on for so many seconds.
    pub fn save(&self, training: &dyn Training, seconds: f64) -> Result<(), Failure> {
        output::write_file(&self.policy(), &training.best_policy()?.to_safetensors()?)?;
        output::write_file(&self.path.join("metrics.jsonl"), training.lines().as_bytes())?;
        let events = events(training, seconds);
        output::write_file(&self.path.join("events.out.tfevents.0.sidestep"), events.bytes())?;
        output::write_file(&self.checkpoint(), &training.checkpoint()?)
    }

    /// Writes the summary.
    pub fn write_summary(&self, summary: &Value) -> Result<(), Failure> {
        output::write_json(&self.path.join("summary.json"), summary)
    }
}

/// The curve as TensorBoard events.
fn events(training: &dyn Training, seconds: f64) -> Events {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64());
    let units = training.scalars();
    let begin = now - seconds;
    let mut events = Events::new(begin);
    for (index, scalars) in units.iter().enumerate() {
        // Only the whole duration is known; units are spread evenly over it.
        let time = begin + seconds * (index + 1) as f64 / units.len() as f64;
        for scalar in scalars {
            events.scalar(time, scalar.step, scalar.tag, scalar.value);
        }
        if let (Some(last), true) = (scalars.last(), seconds > 0.0) {
            let rate = training.environment_steps() as f64 / seconds;
            events.scalar(time, last.step, "charts/SPS", rate);
        }
    }
    events
}
