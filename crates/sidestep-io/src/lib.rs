//! File formats and pictures: bytes and strings on one side, the core's values on the other.
//!
//! Nothing here opens a file, reads a clock or writes to a terminal; where a file names another
//! file (a ROS map its image), the caller passes a function that loads it.

pub mod arm_page;
pub mod benchmarks;
pub mod drawing;
pub mod drive;
mod error;
pub mod input;
pub mod joint_trajectory;
mod json;
pub mod movingai;
pub mod picture;
pub mod plan_json;
pub mod replay;
pub mod robots;
pub mod ros_map;
pub mod scenes;
pub mod task_json;

use std::sync::Arc;

use sidestep::{Grid, World};

pub use error::{FormatError, Place};
pub use task_json::{TaskFormat, read_tasks, write_task, write_tasks};

/// Cells that any file may ask for, however it packs them: 8192 x 8192.
const PACKED_CELLS: usize = 1 << 26;

/// Most cells of a grid from a file of so many bytes: what rows that repeat and compressed images unpack
/// to is bounded, by [`PACKED_CELLS`] or by eight a byte.
fn most_cells(bytes: usize) -> usize {
    bytes.saturating_mul(8).clamp(PACKED_CELLS, sidestep::plane::world::MAX_GRID_CELLS)
}

/// A world that holds one grid and is as large as it.
pub fn grid_world(grid: Grid) -> Arc<World> {
    Arc::new(World::new(grid.rect(), Vec::new(), Some(grid)))
}
