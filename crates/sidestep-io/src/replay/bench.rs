//! Planners measured, as a page: success by suite with intervals, time against success, and each task that some
//! planner failed as a replay.

use serde_json::{Value, json};
use sidestep::plane::geometry::Point;

use super::{Replay, assembled, style};

const PAGE: &str = include_str!("bench.html");

/// What a page shows.
#[derive(Debug, Clone)]
pub struct BenchPage {
    /// Under the title: settings and machine.
    about: String,
    /// A row for each planner on each suite.
    rows: Vec<BenchRow>,
    /// How many tasks were failed, and which of them are here.
    which: String,
    /// Tasks that some planner failed, as the page holds them.
    tasks: Vec<Value>,
}

/// One planner on one suite.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BenchRow {
    /// The planner, as it was named.
    pub planner: String,
    /// Suite or file.
    pub suite: String,
    /// Number of tasks.
    pub tasks: usize,
    /// Share with a certified plan.
    pub success: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// Median and 95th percentile of the time of a plan, in microseconds.
    pub times: [Option<f64>; 2],
}

/// A task that some planner failed.
#[derive(Debug, Clone)]
pub struct FailedTask<'a> {
    /// Whether each planner solved it, in the replay's order.
    pub solved: Vec<bool>,
    /// What the planners did.
    pub replay: Replay<'a>,
}

impl BenchPage {
    /// A page without any task yet.
    pub fn new(about: String, rows: Vec<BenchRow>, which: String) -> Self {
        Self { about, rows, which, tasks: Vec::new() }
    }

    /// Adds a task; `distance` is how far a place is from the obstacles, for a point robot, in task units.
    pub fn add(&mut self, task: &FailedTask<'_>, distance: impl Fn(Point) -> f64) {
        self.tasks.push(json!({"solved": task.solved, "replay": task.replay.data(distance)}));
    }

    /// The page.
    pub fn to_html(&self) -> String {
        let mut planners: Vec<&str> = self.rows.iter().map(|row| row.planner.as_str()).collect();
        planners.dedup();
        let row = |row: &BenchRow| {
            json!({
                "planner": row.planner, "suite": row.suite, "tasks": row.tasks, "success": row.success,
                "interval": row.interval, "median": row.times[0], "late": row.times[1],
            })
        };
        let data = json!({
            "about": self.about,
            "planners": planners.iter().map(|name| style(name)).collect::<Vec<_>>(),
            "rows": self.rows.iter().map(row).collect::<Vec<_>>(),
            "which": self.which,
            "tasks": self.tasks,
        });
        assembled(PAGE, &data)
    }
}
