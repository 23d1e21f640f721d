//! Training of the waypoint policy: imitation of exact paths, then policy gradient on certified
//! success.

mod checkpoint;
mod config;
mod curve;
mod memory;
mod ready;
mod stages;
mod trainer;
mod validation;

pub use config::{
    ARCHITECTURE, ImitationConfig, PolicyGradientConfig, StageConfig, StageKind, TaskConfig,
    WaypointConfig, WaypointNetworkConfig, WaypointValidationConfig,
};
pub use curve::WaypointProgress;
pub use trainer::{UPDATES_PER_UNIT, WaypointBest, WaypointTrainer};
pub use validation::WaypointValidation;
