//! The report that a measurement leaves: rows of figures with where they come from.

use serde::{Deserialize, Serialize};

use crate::machine::Provenance;

/// The format's name and version.
pub const FORMAT: &str = "sidestep.report/1";

/// A measurement.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Report {
    /// [`FORMAT`].
    pub format: String,
    /// What was measured: `bench`, or the name of an experiment.
    pub kind: String,
    /// Machine, commit, command and duration.
    pub provenance: Provenance,
    /// What all rows share.
    pub settings: Settings,
    /// One row per planner.
    pub rows: Vec<Row>,
}

/// Settings of a bench.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Settings {
    /// Objective profile.
    pub profile: String,
    /// Optimizer steps per start.
    pub steps: usize,
    /// Waypoints between start and goal.
    pub waypoints: usize,
    /// How starts after the first are drawn.
    pub start_strategy: String,
    /// Seeds of the suite; empty for task files.
    pub task_seeds: Vec<u64>,
    /// Seed of random starts and planners.
    pub planning_seed: u64,
    /// Distance that plans keep from everything, in task units.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub margin: f64,
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// A task without a certified plan.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Failed {
    /// The task's name.
    pub task: String,
    /// `unsolved`, `unsolvable` or `invalid`.
    pub status: String,
    /// Why, in words.
    pub reason: String,
}

/// One planner on one set of tasks. Shares are of all tasks unless named otherwise.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Row {
    /// Planner name as given.
    pub planner: String,
    /// Suite or files.
    pub suite: String,
    /// Start trajectories.
    pub starts: usize,
    /// Number of tasks, over all seeds or files.
    pub tasks: usize,
    /// Tasks that the exact search calls solvable.
    pub solvable: usize,
    /// Tasks that it could not decide.
    pub undecided: usize,
    /// Share feasible by the profile's check at any iterate.
    pub solved_any: Option<f64>,
    /// Share feasible by the profile's check at the last iterate.
    pub solved_end: Option<f64>,
    /// Share certified by the exact check at any iterate.
    pub certified: f64,
    /// Share with a certified plan: the same as `certified`, by the planner as it is used.
    pub success: f64,
    /// 95 % confidence interval of `success`: Student's t over three or more seeds or files, else Wilson's.
    pub success_ci95: [f64; 2],
    /// `success` of each seed or file.
    pub success_by_group: Vec<f64>,
    /// Each task of each seed or file, in order: `1` where there is a certified plan, `0` where not. So that
    /// planners can be compared task by task.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outcomes: Vec<String>,
    /// Certified plans over solvable tasks, where there are any.
    pub success_of_solvable: Option<f64>,
    /// Plans called solved on tasks that are proved unsolvable; anything but 0 is a fault.
    pub contradictions: usize,
    /// Mean index of the first feasible iterate, over tasks that have one.
    pub iterations_mean: Option<f64>,
    /// Median of the same.
    pub iterations_median: Option<f64>,
    /// Microseconds per optimizer iteration with objective, gradient and both checks, on one thread: the median over the
    /// timed tasks.
    pub us_per_iteration: Option<f64>,
    /// Median microseconds from task to answer, one thread. Where tasks share a world, without what
    /// is prepared once for the world. None where no task is timed.
    pub us_per_plan_median: Option<f64>,
    /// 95th percentile of the same.
    pub us_per_plan_p95: Option<f64>,
    /// Median microseconds to prepare a world that several tasks share.
    #[serde(default)]
    pub us_per_world_median: Option<f64>,
    /// Tasks whose start or goal is itself not free; only of robots with joints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub invalid: Option<usize>,
    /// Mean length of certified plans in joint space; only of robots with joints, where no optimal length is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_mean: Option<f64>,
    /// Tasks without a certified plan, and why; only of robots with joints.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failures: Vec<Failed>,
    /// Median length of certified plans over the optimal length.
    pub length_ratio_median: Option<f64>,
    /// Median sum of squared second differences of certified plans, over the squared optimal length.
    pub roughness_median: Option<f64>,
    /// Median sharpest corner of certified plans, in degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_median_deg: Option<f64>,
    /// The sharpest corner of all certified plans, in degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_most_deg: Option<f64>,
    /// Median clearance of certified plans, in task units: from the robot itself, the margin included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance_median: Option<f64>,
}
