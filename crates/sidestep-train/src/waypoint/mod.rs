//! Training of the waypoint policy: imitation of exact paths, then policy gradient on certified success.

mod checkpoint;
mod config;
mod stages;
mod trainer;
mod validation;

pub use config::{
    ARCHITECTURE, ImitationConfig, PolicyGradientConfig, StageConfig, StageKind, TaskConfig,
    WaypointConfig, WaypointNetworkConfig, WaypointValidationConfig,
};
pub use trainer::{UPDATES_PER_UNIT, WaypointBest, WaypointProgress, WaypointTrainer};
pub use validation::WaypointValidation;
