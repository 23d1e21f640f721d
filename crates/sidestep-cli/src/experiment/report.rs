//! The report of an experiment: one cell per policy or baseline and measurement.

use serde::{Deserialize, Serialize};

use super::config::Experiment;
use crate::machine::Provenance;

/// The format's name and version.
pub const FORMAT: &str = "sidestep.experiment-report/1";

/// An experiment's results, with the whole experiment.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ExperimentReport {
    /// [`FORMAT`].
    pub format: String,
    /// Machine, commit, command and duration.
    pub provenance: Provenance,
    /// What was asked for.
    pub experiment: Experiment,
    /// The results.
    pub cells: Vec<Cell>,
}

/// One policy (over its training seeds) or baseline in one measurement. Every list has one entry
/// per training seed, each a mean over all task seeds; baselines have one entry per task seed.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Cell {
    /// Row of the table: the policy's, or the baseline's planner name.
    pub row: String,
    /// Column of the table; empty for a baseline.
    pub column: String,
    /// Name of the measurement.
    pub measure: String,
    /// Start trajectories of the measurement.
    #[serde(default = "one")]
    pub starts: usize,
    /// Whether runs were broken off once solved; `end` is empty then.
    #[serde(default)]
    pub until_solved: bool,
    /// The paper's percentage.
    pub paper: Option<f64>,
    /// Share feasible by the profile's check at any iterate.
    pub any: Vec<f64>,
    /// Share feasible by the profile's check at the last iterate.
    pub end: Vec<f64>,
    /// Share certified by the exact check at any iterate.
    pub certified: Vec<f64>,
    /// `certified` over solvable tasks.
    pub certified_of_solvable: Vec<f64>,
    /// Mean index of the first feasible iterate.
    pub iterations: Vec<f64>,
    /// Median microseconds per iteration, objective, gradient and checks included, one task after
    /// the other on one thread.
    pub us_per_iteration: Vec<f64>,
    /// Seconds of training.
    pub training_seconds: Vec<f64>,
    /// Environment steps of the policy that was kept.
    pub kept_at_steps: Vec<u64>,
    /// Of each training, its validations: environment steps made before, and the share of the tasks
    /// that was solved.
    #[serde(default)]
    pub curves: Vec<Vec<[f64; 2]>>,
    /// What the curves count: [`STEPS`], in reports from before units of training.
    #[serde(default = "units")]
    pub curves_over: String,
    /// Of every task in order, seed by seed, `1` where it is feasible by the profile's check at any
    /// iterate, else `0`: for tests on pairs of methods.
    #[serde(default)]
    pub solved: Vec<String>,
    /// On the tasks of the suite `time` that this policy and gradient descent (0.1) both solve
    /// within 100 steps: iterations of the policy and of gradient descent with steps 0.1 and 0.5.
    pub time: Vec<[f64; 3]>,
}

/// What curves count.
pub const STEPS: &str = "environment steps";

/// What curves counted at first.
fn units() -> String {
    "units of training".into()
}

/// Starts of cells in reports from before there was a choice.
fn one() -> usize {
    1
}
