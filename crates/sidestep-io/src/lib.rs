//! File formats and pictures: bytes and strings on one side, the core's values on the other.
//!
//! Nothing here opens a file, reads a clock or writes to a terminal; where a file names another
//! file (a ROS map its image), the caller passes a function that loads it.

mod error;
mod json;
pub mod task_json;

pub use error::{FormatError, Place};
pub use task_json::{TaskFormat, read_tasks, write_task, write_tasks};
