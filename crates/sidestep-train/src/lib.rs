//! Training of learned optimizers, in two rooms of one shape: [`paper`] (behaviour cloning of gradient descent, then PPO;
//! section II) and [`waypoint`] (the policy that is shipped: imitation of exact paths, then policy gradient).
//!
//! Each room has a configuration, stages, a trainer that makes them unit by unit, and a checkpoint; what both need lies beside them.
//! Everything here is pure: no files, no clock, no terminal. The same seed gives the same bits for every number of threads,
//! because each environment and each purpose has its own counter-based stream and sums over rows are taken in a fixed order
//! ([`paper::agent`]).

pub mod config;
pub mod environment;
pub mod paper;
pub mod parameters;
pub mod routes;
pub mod validation;
pub mod waypoint;

pub use paper::{Progress, Stage, TrainConfig, Trainer};
pub use waypoint::{WaypointConfig, WaypointTrainer};

/// Licence of the weights that training makes.
const LICENCE: &str = "MIT OR Apache-2.0";
