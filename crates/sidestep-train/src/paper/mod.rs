//! Training as in the paper: behaviour cloning of gradient descent, then PPO (section II), with DAgger between them.

pub mod agent;
mod checkpoint;
pub mod config;
pub mod expert;
pub mod gaussian;
pub mod stages;
mod trainer;
pub mod validation;

pub use agent::Agent;
pub use checkpoint::FORMAT;
pub use config::TrainConfig;
pub use trainer::{Best, Progress, Stage, Trainer};
