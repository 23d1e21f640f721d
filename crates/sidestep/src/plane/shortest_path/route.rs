//! Answers of the exact search.

use crate::trajectory::Trajectory;
use crate::trajectory::Violation;

/// The answer to one shortest-path query.
#[derive(Debug, Clone, PartialEq)]
pub enum Route {
    /// There is a path.
    Found {
        /// A certified path, shortest but for the approximation of arcs.
        trajectory: Trajectory,
        /// Its length, in task units.
        length: f64,
        /// No path that keeps three tolerances more than the robot's radius from every obstacle
        /// is shorter. Equal to the length where nothing is round.
        lower_bound: f64,
    },
    /// There is no path that the certificate would pass, proved.
    Unsolvable(Proof),
    /// The search was given up.
    Undecided(Doubt),
}

impl Route {
    /// The length of the path, where there is one.
    pub fn length(&self) -> Option<f64> {
        match self {
            Self::Found { length, .. } => Some(*length),
            _ => None,
        }
    }
}

/// Why there can be no path.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Proof {
    /// The robot cannot stand at the start or at the goal.
    #[error("{0}")]
    End(Violation),
    /// Obstacles and walls separate start and goal.
    #[error("obstacles separate the start from the goal")]
    Disconnected,
}

/// Why the search did not decide.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Doubt {
    /// More edges would have had to be checked.
    #[error("gave up after {checks} edge checks")]
    OutOfWork {
        /// How many were allowed.
        checks: usize,
    },
    /// The caller broke the search off.
    #[error("the time budget is spent and the exact search not through")]
    BrokenOff,
    /// Whether the robot fits a passage depends on a few tolerances, or on arcs finer than were tried.
    #[error("a passage is as narrow as the robot to within what can be decided")]
    NarrowPassage {
        /// No path is shorter than this.
        lower_bound: f64,
    },
}
