//! Optimisation-based motion planning with classical and learned optimizers.
//!
//! A [`Task`] asks for a path of a [`Robot`] through a [`World`]; [`plan::plan`] answers with a certified
//! [`Trajectory`] or the reason why there is none. Underneath, an [`objective::Objective`] scores the
//! waypoints of a trajectory and an [`optimizer::Optimizer`] walks them downhill.

pub mod arm;
pub mod error;
pub mod kernels;
pub mod network;
pub mod objective;
pub mod optimizer;
pub mod plan;
pub mod plane;
pub mod policy;
pub mod profile;
pub mod rng;
pub mod scene;
pub mod space;
pub mod suite;
pub mod trajectory;

pub use error::InvalidInput;
pub use plan::rrt_connect::{RrtConnect, RrtRun};
pub use plane::Robot;
pub use plane::certificate::Certifier;
pub use plane::shortest_path::{Route, ShortestPath};
pub use plane::world::{Grid, MAX_GRID_CELLS, Obstacle, World};
pub use scene::{Certified, PlaneTask, Query, Scene, Setting, Task, certify};
pub use trajectory::{Trajectory, Violation};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
