//! Training as in the paper: behaviour cloning of gradient descent, then PPO (section II), with
//! DAgger between them.

pub mod agent;
mod checkpoint;
pub mod config;
mod curve;
pub mod expert;
pub mod gaussian;
pub mod stages;
mod trainer;
pub mod validation;

pub use agent::Agent;
pub use checkpoint::FORMAT;
pub use config::TrainConfig;
pub use curve::{Progress, Stage};
pub use trainer::{Best, Trainer};
