//! Requests as clients write them.

use serde::Deserialize;
use serde_json::Value;
use sidestep::plane::geometry::Point;

/// One request: an object with `op`, and an `id` that comes back with the answer.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Request {
    /// A certified plan.
    Plan {
        #[serde(default)]
        id: Value,
        start: Point,
        goal: Point,
        /// Time for the answer; without it as long as the planner takes.
        #[serde(default)]
        budget_ms: Option<f64>,
        /// Planner, as `sidestep plan --planner` names it; `auto` where none.
        #[serde(default)]
        planner: Option<String>,
        /// Whether to begin from this client's last plan.
        #[serde(default)]
        warm: bool,
        /// Whether iterates are sent while planning.
        #[serde(default)]
        stream: bool,
        /// Sharpest corner that is wished, in degrees.
        #[serde(default)]
        max_turn: Option<f64>,
        /// Least turning radius that is wished, in task units.
        #[serde(default)]
        min_radius: Option<f64>,
        /// How far a start or goal that is not free may be moved, in task units.
        #[serde(default)]
        snap: Option<f64>,
    },
    /// An obstacle by a name of the client's choice, new or moved.
    Set {
        #[serde(default)]
        id: Value,
        name: String,
        obstacle: String,
    },
    /// Takes an obstacle away.
    Remove {
        #[serde(default)]
        id: Value,
        name: String,
    },
    /// Takes all obstacles of the client away.
    Clear {
        #[serde(default)]
        id: Value,
    },
    /// Ends the plan that is being made, with the best so far.
    Cancel {
        #[serde(default)]
        id: Value,
    },
    /// Bounds, robot and obstacles.
    Info {
        #[serde(default)]
        id: Value,
    },
}
