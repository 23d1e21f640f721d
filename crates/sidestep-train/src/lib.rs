//! Training of learned optimizers: behaviour cloning of gradient descent, then PPO (paper, section II).
//!
//! Everything here is pure: no files, no clock, no terminal. The same seed gives the same bits for every number
//! of threads, because each environment and each purpose has its own counter-based stream and sums over
//! rows are taken in a fixed order ([`agent`]).

pub mod advantage;
pub mod agent;
pub mod checkpoint;
pub mod cloning;
pub mod config;
pub mod dagger;
pub mod environment;
pub mod expert;
pub mod gaussian;
pub mod initialization;
pub mod optimizer;
pub mod ppo;
pub mod trainer;
pub mod validation;
pub mod waypoint;

pub use agent::Agent;
pub use config::TrainConfig;
pub use initialization::Initialization;
pub use trainer::{Progress, Stage, Trainer};
pub use waypoint::{WaypointConfig, WaypointTrainer};
