//! Training of the waypoint policy, in the plane and for robots with joints: imitation of experts'
//! routes, then policy gradient on certified success.

mod checkpoint;
mod config;
mod curve;
mod memory;
mod ready;
mod sight;
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
