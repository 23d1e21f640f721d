//! Driven paths as files that robots and their tools read: CSV, `nav_msgs/Path` as YAML, GeoJSON, and MCAP with ROS 2 messages.

mod cdr;
mod csv;
mod mcap;
mod ros;
mod text;

pub use csv::read_csv;
pub use mcap::{Recording, to_mcap};
pub use text::{to_csv, to_geojson, to_nav_path};

/// What a path's end means to nav2's planner action (`nav2_msgs/action/ComputePathToPose`): the error code of a status.
///
/// `solved` is NONE, 0; `unsolvable` and `unsolved` NO_VALID_PATH, 208, unless time ran out: TIMEOUT, 207; an end out
/// of bounds is 203 or 204 and one in collision 205 or 206, the start's first.
pub fn nav2_error_code(status: &sidestep::plan::Status) -> u16 {
    use sidestep::plan::{Reason, Status};
    use sidestep::trajectory::Violation;
    match status {
        Status::Solved(_) => 0,
        Status::Invalid(Violation::StartOutOfBounds) => 203,
        Status::Invalid(Violation::GoalOutOfBounds) => 204,
        Status::Invalid(Violation::StartInCollision { .. }) => 205,
        Status::Invalid(Violation::GoalInCollision { .. }) => 206,
        Status::Unsolved(Reason::BrokenOff { .. } | Reason::SamplingBrokenOff { .. }) => 207,
        _ => 208,
    }
}
