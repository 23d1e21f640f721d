//! The paper's training, unit by unit, so that a page can show it and stay awake.

use std::cell::RefCell;

use serde_json::{Value, json};
use sidestep_train::{TrainConfig, Trainer};

/// Most units at a time.
const MOST_UNITS: usize = 1_000;

thread_local! {
    static TRAINING: RefCell<Option<Trainer>> = const { RefCell::new(None) };
}

/// The paper's main training, `experiments/paper-80k.toml`, looked at on 200 validation tasks every other update.
fn config(seed: u64) -> TrainConfig {
    let mut config = TrainConfig { seed, ..TrainConfig::default() };
    config.validation.count = 200;
    config.validation.every = 2;
    config
}

/// Begins a training in place of the last one: `{"units": 123}`.
pub(crate) fn begin(seed: u64) -> Result<Value, String> {
    let trainer = Trainer::new(config(seed)).map_err(|error| error.to_string())?;
    let units = trainer.units().all;
    TRAINING.set(Some(trainer));
    Ok(json!({ "units": units }))
}

/// Makes some units: units done and in all, environment steps, the percentage of the validation tasks that the last unit's policy
/// solves, if it was looked at, and the best policy so far as bytes, if it is.
pub(crate) fn go_on(units: usize) -> Result<Value, String> {
    TRAINING.with_borrow_mut(|trainer| {
        let trainer = trainer.as_mut().ok_or("no training was begun")?;
        let mut solved = None;
        for _ in 0..units.min(MOST_UNITS) {
            match trainer.step().map_err(|error| error.to_string())? {
                Some(made) => solved = made.validation.map(|v| 100.0 * v.success()).or(solved),
                None => break,
            }
        }
        let units = trainer.units();
        let policy = || trainer.best_policy().and_then(|policy| policy.to_safetensors());
        let policy = solved.map(|_| policy()).transpose().map_err(|error| error.to_string())?;
        Ok(json!({
            "done": units.done, "all": units.all, "steps": trainer.environment_steps(), "solved": solved, "policy": policy,
        }))
    })
}
