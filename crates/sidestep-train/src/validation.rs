//! How good a policy is: success and iterations on tasks that it was not trained on. Which check
//! decides is the rooms' own.

use serde::{Deserialize, Serialize};

/// The result on a set of tasks, each from the straight line, without noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Validation {
    /// Tasks tried.
    pub tasks: usize,
    /// Tasks with a feasible iterate within the allowed iterations.
    pub solved: usize,
    /// Mean index of the first feasible iterate, over the tasks solved; 0 is the straight line.
    pub mean_iterations: f64,
}

impl Validation {
    /// Of the first feasible iterate of each task.
    pub(crate) fn of(firsts: &[Option<usize>]) -> Self {
        let solved = firsts.iter().flatten().count();
        let iterations: usize = firsts.iter().flatten().sum();
        let mean_iterations = iterations as f64 / solved.max(1) as f64;
        Self { tasks: firsts.len(), solved, mean_iterations }
    }

    /// Share of the tasks that was solved.
    pub fn success(&self) -> f64 {
        self.solved as f64 / self.tasks.max(1) as f64
    }

    /// Whether this beats `other`: more solved, or as many in fewer iterations.
    pub fn beats(&self, other: &Self) -> bool {
        (self.solved, -self.mean_iterations) > (other.solved, -other.mean_iterations)
    }
}
