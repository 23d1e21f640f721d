//! Training of learned optimizers, in two rooms of one shape: [`paper`] (behaviour cloning of
//! gradient descent, then PPO; section II) and [`waypoint`] (the policy that is shipped: imitation
//! of exact paths, then policy gradient).
//!
//! ```
//! let recipe = sidestep_train::Recipe::from_toml(
//!     "environment_steps = 200
//!      training.count = 4
//!      cloning.samples_per_task = 4
//!      ppo = { environments = 5, steps = 20 }
//!      validation = { count = 4, steps = 10 }",
//! )?;
//! let mut training = recipe.begin(None)?;
//! while training.step()?.is_some() {}
//! let policy = training.best_policy()?.to_safetensors()?;
//! # assert!(policy.len() > 10_000);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Each room has a configuration, stages, a trainer that makes them unit by unit, and a checkpoint;
//! what both need lies beside them. Everything here is pure: no files, no clock, no terminal. The
//! same seed gives the same bits for every number of threads, because each environment and each
//! purpose has its own counter-based stream and sums over rows are taken in a fixed order
//! ([`paper::agent`]).

pub mod config;
pub mod environments;
pub mod paper;
pub mod parameters;
mod recipe;
pub mod routes;
pub mod training;
pub mod validation;
pub mod waypoint;

pub use paper::{Progress, Stage, TrainConfig, Trainer};
pub use recipe::Recipe;
pub use training::{Divergence, Training};
pub use waypoint::{WaypointConfig, WaypointTrainer};

/// Licence of the weights that training makes.
const LICENCE: &str = "MIT OR Apache-2.0";
