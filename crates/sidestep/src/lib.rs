//! Optimisation-based motion planning with classical and learned optimizers.

pub mod certificate;
pub mod error;
pub mod geometry;
pub mod kernels;
mod robot;
mod task;
mod trajectory;
mod world;

pub use certificate::{Certifier, Violation, certify};
pub use error::InvalidInput;
pub use robot::Robot;
pub use task::Task;
pub use trajectory::Trajectory;
pub use world::{Grid, MAX_GRID_CELLS, Obstacle, World};
