//! Readers of what training writes and reads, and of the names and settings of the command line.

use sidestep::InvalidInput;
use sidestep::plan::planner_name::parse_planner;
use sidestep::plan::starts::StartStrategy;
use sidestep::policy::Policy;
use sidestep::profile::Profile;
use sidestep_train::{TrainConfig, Trainer, WaypointConfig, WaypointTrainer};

use crate::readers::told;

pub fn policy(bytes: &[u8]) {
    told(Policy::from_safetensors(bytes));
}

/// The first byte says of which kind of training it is.
pub fn checkpoint(bytes: &[u8]) {
    let Some((&first, rest)) = bytes.split_first() else { return };
    if first % 2 == 0 {
        told(Trainer::resume(rest));
    } else {
        told(WaypointTrainer::resume(rest));
    }
}

pub fn train_config(bytes: &[u8]) {
    told(TrainConfig::from_toml(&String::from_utf8_lossy(bytes)));
}

pub fn waypoint_config(bytes: &[u8]) {
    told(WaypointConfig::from_toml(&String::from_utf8_lossy(bytes)));
}

/// Planners with their settings, profiles and start strategies by name.
pub fn names(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let none = |_: &str| Err(InvalidInput::new("policy", "none", "a file"));
    told(parse_planner(&text, &mut { none }));
    told(Profile::named(&text));
    told(StartStrategy::named(&text));
}
