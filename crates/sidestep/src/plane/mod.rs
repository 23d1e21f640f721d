//! The plane: worlds of shapes and grids, what is exact about them, and what a policy sees of them.
//!
//! It alone knows what a [`Point`] is; everything above it sees configurations as flat buffers.

mod bit_grid;
pub mod certificate;
pub mod distance;
pub mod ends;
mod explain;
mod frame;
pub mod geometry;
mod near;
mod opened;
mod robot;
mod sampled_check;
mod scene;
pub mod shortest_path;
pub mod surroundings;
mod task;
pub mod view;
pub mod world;

pub use explain::{explain, explain_path};
pub use frame::Frame;
pub use near::place_near;
pub(crate) use opened::opened;
pub use robot::Robot;
pub use scene::{MOST_SHAPES_OF_A_FIELD, PlaneScene, Subject};
pub use task::PlaneTask;

use crate::trajectory::Trajectory;
use geometry::Point;

/// The points of a trajectory in the plane; none of one that is not.
pub fn points(trajectory: &Trajectory) -> &[Point] {
    match trajectory.dof() {
        2 => trajectory.values().as_chunks::<2>().0,
        _ => &[],
    }
}

#[cfg(test)]
mod added_tests;
