//! Optimisation-based motion planning with classical and learned optimizers.
//!
//! A [`Task`] asks for a path of a [`Robot`] through a [`World`]; [`plan::plan`] answers with a certified
//! [`Trajectory`] or the reason why there is none. Underneath, an [`objective::Objective`] scores the
//! waypoints of a trajectory and an [`optimizer::Optimizer`] walks them downhill.

mod bit_grid;
pub mod certificate;
pub mod distance;
pub mod error;
pub mod geometry;
pub mod kernels;
pub mod network;
pub mod objective;
pub mod objective_reference;
pub mod observation;
pub mod optimizer;
pub mod plan;
pub mod planner_name;
pub mod policy;
pub mod profile;
pub mod queries;
pub mod rng;
mod robot;
pub mod rrt_connect;
pub mod run;
mod sampled_check;
pub mod shipped;
pub mod shortest_path;
pub mod smooth;
pub mod starts;
pub mod suite;
mod task;
pub mod tensors;
mod trajectory;
pub mod waypoint_view;
mod world;

pub use certificate::{Certifier, Violation, certify};
pub use error::InvalidInput;
pub use robot::Robot;
pub use rrt_connect::{RrtConnect, RrtRun};
pub use shortest_path::{Route, ShortestPath};
pub use task::Task;
pub use trajectory::Trajectory;
pub use world::{Grid, MAX_GRID_CELLS, Obstacle, World};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
