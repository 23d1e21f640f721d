//! Task JSON, version 1: one planning task as one JSON object.
//!
//! ```json
//! {
//!   "format": "sidestep.task/1",
//!   "name": "two walls",
//!   "bounds": [[0, 0], [64, 48]],
//!   "obstacles": [
//!     {"rect": [[10, 0], [14, 30]]},
//!     {"circle": {"center": [40, 20], "radius": 6.5}},
//!     {"polygon": [[50, 30], [60, 30], [55, 40]]}
//!   ],
//!   "grid": {"resolution": 1, "origin": [0, 0], "rows": ["..#", "3."]},
//!   "robot": {"disc": {"radius": 0.5}},
//!   "start": [2, 2],
//!   "goal": [60, 5]
//! }
//! ```
//!
//! `format`, `bounds`, `start` and `goal` must be there. Without `name` the name is empty, without
//! `obstacles` there are none, without `grid` (or with `null`) there is no grid, and without `robot`
//! the robot is a `"point"`. An unknown field is an error.
//!
//! A grid's `rows` run from the top of the field to its bottom; `.` is free and `#` occupied, and a
//! number before either repeats it, so `"3.2#"` is `"...##"`. `resolution` is the side of a cell in
//! task units, `origin` (default `[0, 0]`) the lower left corner of the lower left cell.
//!
//! A `.json` file holds one task or an array of tasks; a `.jsonl` file one task a line. The JSON Schema
//! is `schemas/task-1.schema.json` in the repository; what it cannot say (that a rectangle's second
//! corner lies above its first, that a polygon is convex, that rows are equally long) the reader checks.

mod read;
mod rows;
mod write;

pub use read::read_tasks;
pub use write::{write_task, write_tasks};

/// What `format` says in a task of this version.
pub const TASK_FORMAT: &str = "sidestep.task/1";

/// The format's name in errors.
const FORMAT: &str = "task JSON";

/// How tasks lie in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TaskFormat {
    /// One JSON document: a task or an array of tasks (`.json`).
    Json,
    /// One task a line; empty lines are skipped (`.jsonl`).
    JsonLines,
}

impl TaskFormat {
    /// The format of a file name, by its extension (in any case).
    pub fn from_file_name(name: &str) -> Option<Self> {
        let (_, extension) = name.rsplit_once('.')?;
        match extension.to_ascii_lowercase().as_str() {
            "json" => Some(Self::Json),
            "jsonl" | "ndjson" => Some(Self::JsonLines),
            _ => None,
        }
    }
}
