//! The memory that a training of the waypoint policy takes.

use sidestep::InvalidInput;
use sidestep::network::WaypointShape;
use sidestep::profile::Profile;

use super::config::WaypointConfig;
use super::stages::imitation::{MEMBERS, TASKS_PER_PART};
use crate::config::memory::{NUMBER, Part, TASK, check as check_parts};

/// Checks counts times sizes, for networks of this shape.
pub(super) fn check(config: &WaypointConfig, shape: &WaypointShape) -> Result<(), InvalidInput> {
    let WaypointConfig { network, tasks, imitation, policy_gradient: walks, validation, .. } =
        config;
    let parameters = shape.parameter_count()? as f64 * NUMBER;
    // Rows are padded to the kernels' lanes.
    let row = NUMBER * (shape.inputs + 16) as f64;
    let waypoints = tasks.waypoints[1].max(Profile::DEFAULT.waypoints) as f64;
    let map = shape.map.as_ref().map_or(0.0, |map| {
        let border = map.dilations.iter().max().copied().unwrap_or(0);
        let cells = ((map.cells + 2 * border) * map.channels * (map.cells + 2 * border)) as f64;
        // Features and slopes of each layer, and the ways round obstacles behind them.
        2.0 * NUMBER * cells * (map.dilations.len() + 2) as f64 + 200e3
    });
    let task = TASK + map;
    let layers = (2 * shape.dilations.len() + 2) as f64 * NUMBER * 2.0 * shape.width as f64;
    let parts = |tasks: usize| tasks.div_ceil(TASKS_PER_PART) as f64 * parameters;
    let case = task + MEMBERS as f64 * waypoints * (row + layers);
    let walk = walks.steps as f64 * waypoints * (row + layers + 6.0 * NUMBER);
    let walked = walks.tasks as f64 * (task + walks.walks as f64 * walk);
    let part = |key, value, bytes| Part { key, value, bytes };
    check_parts(&[
        part("validation.count", validation.count, 2.0 * validation.count as f64 * task),
        // Parameters, average and two moments, again as they were before a unit, the best, and
        // their bytes in a checkpoint.
        part("network.width", network.width, 14.0 * parameters),
        part(
            "imitation.tasks",
            imitation.tasks,
            imitation.tasks as f64 * case + parts(imitation.tasks),
        ),
        part("policy_gradient.walks", walks.walks, walked + parts(walks.tasks)),
    ])
}
