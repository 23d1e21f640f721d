//! The answer to a planning question.

use crate::plane::shortest_path::{Doubt, Proof};
use crate::scene::{Certified, Query, Refused};
use crate::trajectory::{Trajectory, Violation};

/// How a planning question was answered.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Status {
    /// A trajectory that is certified free of collision.
    Solved(Certified),
    /// No certified plan was found, which proves nothing.
    Unsolved(Reason),
    /// It is proved that there is no path.
    Unsolvable(Proof),
    /// The start or the goal itself is not free.
    Invalid(Violation),
}

impl Status {
    /// `solved`, `unsolved`, `unsolvable` or `invalid`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Solved(_) => "solved",
            Self::Unsolved(_) => "unsolved",
            Self::Unsolvable(_) => "unsolvable",
            Self::Invalid(_) => "invalid",
        }
    }

    /// Why it is not solved, in words; empty where it is.
    pub fn reason(&self) -> String {
        match self {
            Self::Solved(_) => String::new(),
            Self::Unsolved(reason) => reason.to_string(),
            Self::Unsolvable(proof) => proof.to_string(),
            Self::Invalid(violation) => violation.to_string(),
        }
    }
}

/// Why no certified plan was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Reason {
    /// The optimizer spent its steps on a trajectory that still collides.
    #[error("{steps} steps from {starts} start(s) spent; {violation}")]
    StepsSpent {
        /// Steps of the last attempt.
        steps: usize,
        /// Start trajectories tried.
        starts: usize,
        /// What is wrong with the straight-line start's last iterate.
        violation: Violation,
    },
    /// The optimizer left for infinity.
    #[error("the optimizer diverged after {steps} steps; before that, {violation}")]
    Diverged {
        /// Steps made.
        steps: usize,
        /// What is wrong with the last iterate before.
        violation: Violation,
    },
    /// The caller broke off.
    #[error("the time budget is spent after {steps} steps; {violation}")]
    BrokenOff {
        /// Steps made.
        steps: usize,
        /// What is wrong with the last iterate.
        violation: Violation,
    },
    /// The sampling planner spent its samples.
    #[error("{samples} samples spent without joining start and goal")]
    SamplesSpent {
        /// Samples drawn.
        samples: usize,
    },
    /// The caller broke the sampling planner off.
    #[error("the time budget is spent after {samples} samples")]
    SamplingBrokenOff {
        /// Samples drawn.
        samples: usize,
    },
    /// What a planner found is refused by the certificate.
    #[error("the planner's path is not certified; {violation}")]
    NotCertified {
        /// What is wrong with it.
        violation: Violation,
    },
    /// The exact search could not decide.
    #[error("undecided: {0}")]
    Undecided(Doubt),
}

impl Reason {
    /// What is wrong with the last attempt, where there is one.
    pub fn violation(&self) -> Option<&Violation> {
        match self {
            Self::StepsSpent { violation, .. }
            | Self::Diverged { violation, .. }
            | Self::BrokenOff { violation, .. }
            | Self::NotCertified { violation } => Some(violation),
            Self::SamplesSpent { .. } | Self::SamplingBrokenOff { .. } | Self::Undecided(_) => None,
        }
    }
}

/// The answer to a planning question.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// A certified trajectory, or why there is none.
    pub status: Status,
    /// Where not solved, the last attempt of an optimizer.
    pub attempt: Option<Trajectory>,
    /// Optimizer steps to the plan, from the start that it came from.
    pub steps: usize,
    /// What made the plan.
    pub origin: Origin,
}

impl Plan {
    /// Whether there is a certified trajectory.
    pub fn is_solved(&self) -> bool {
        self.certified().is_some()
    }

    /// The certified trajectory, where there is one.
    pub fn certified(&self) -> Option<&Trajectory> {
        match &self.status {
            Status::Solved(certified) => Some(certified.trajectory()),
            _ => None,
        }
    }

    /// The certified trajectory; where there is none, the last attempt.
    pub fn trajectory(&self) -> Option<&Trajectory> {
        self.certified().or(self.attempt.as_ref())
    }

    /// The answer of a planner that says that the trajectory is one; the certificate has the last word.
    pub(super) fn of(query: &Query, trajectory: Trajectory, steps: usize, origin: Origin) -> Self {
        match query.certify(trajectory) {
            Ok(certified) => {
                Self { status: Status::Solved(certified), attempt: None, steps, origin }
            }
            Err(Refused { violation, trajectory }) => {
                let status = Status::Unsolved(Reason::NotCertified { violation });
                Self { status, attempt: Some(trajectory), steps, origin }
            }
        }
    }

    /// The straight line with so many waypoints, unless rounding puts one of them too close to an obstacle; where it is not
    /// certified, time did not allow for more.
    pub(super) fn straight(query: &Query, waypoints: usize) -> Self {
        let (steps, origin) = (0, Origin::FirstStart);
        let line = query.line();
        let even = query.certify(line.evenly(waypoints.saturating_add(2)));
        match even.or_else(|_| query.certify(line)) {
            Ok(certified) => {
                Self { status: Status::Solved(certified), attempt: None, steps, origin }
            }
            Err(Refused { violation, trajectory }) => {
                let status = Status::Unsolved(Reason::BrokenOff { steps, violation });
                Self { status, attempt: Some(trajectory), steps, origin }
            }
        }
    }

    /// An answer without any trajectory.
    pub(super) fn none(status: Status, origin: Origin) -> Self {
        Self { status, attempt: None, steps: 0, origin }
    }
}

/// Where a plan comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Origin {
    /// An optimizer from the straight line or the given warm start.
    FirstStart,
    /// An optimizer from a random start of this number, from 1.
    RandomStart(usize),
    /// The given warm start itself, which is still certified.
    WarmStart,
    /// The given warm start, with a way round what blocks it now.
    MendedWarmStart,
    /// The exact shortest path, made smooth.
    SmoothShortestPath,
    /// The exact shortest path itself.
    ShortestPath,
    /// A tree of random samples, made smooth.
    SmoothTree,
    /// A tree of random samples.
    Tree,
}

impl std::fmt::Display for Origin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::FirstStart => f.write_str("optimized from the first start"),
            Self::RandomStart(start) => write!(f, "optimized from random start {start}"),
            Self::WarmStart => f.write_str("the warm start, still free"),
            Self::MendedWarmStart => f.write_str("the warm start, mended where it was blocked"),
            Self::SmoothShortestPath => f.write_str("smoothed from the shortest path"),
            Self::ShortestPath => f.write_str("the shortest path"),
            Self::SmoothTree => f.write_str("smoothed from a random tree"),
            Self::Tree => f.write_str("a random tree"),
        }
    }
}
