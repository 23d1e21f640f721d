//! How good a waypoint policy is on tasks that it was not trained on: certified success from the
//! straight line.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sidestep::network::{WaypointNet, WaypointScratch};
use sidestep::objective::Objective;
use sidestep::plane::view::ViewParts;
use sidestep::policy::ActionRule;
use sidestep::profile::Profile;
use sidestep::suite::Suite;
use sidestep::{Route, Task};

use super::config::WaypointValidationConfig;
use super::ready::Ready;
use crate::validation::Validation;

/// The results on the solvable tasks of the suites easy and hard.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaypointValidation {
    /// On easy tasks.
    pub easy: Validation,
    /// On hard tasks.
    pub hard: Validation,
}

impl WaypointValidation {
    /// The number that the best policy has most of: the share of solved tasks, easy and hard
    /// weighed alike.
    pub fn score(&self) -> f64 {
        0.5 * (self.easy.success() + self.hard.success())
    }

    /// Whether this is better than `other`.
    pub fn beats(&self, other: &Self) -> bool {
        self.score() > other.score()
    }
}

/// Solvable validation tasks made ready.
pub(super) struct Tasks {
    view: ViewParts,
    easy: Vec<Ready>,
    hard: Vec<Ready>,
}

impl Tasks {
    pub fn new(config: &WaypointValidationConfig, view: &ViewParts) -> Self {
        let ready = |suite: Suite| {
            let tasks = suite.generate(config.count, config.seed, &Profile::PAPER);
            let ready = |task: &Task| {
                let query = Ready::query(task);
                let route = query.scene().exact(query.start(), query.goal(), &|| true);
                let Some(Route::Found { .. }) = route else { return None };
                Ready::new(view, Objective::new(&query, Profile::DEFAULT.waypoints).ok()?)
            };
            tasks.par_iter().filter_map(ready).collect()
        };
        Self { view: view.clone(), easy: ready(Suite::Easy), hard: ready(Suite::Hard) }
    }

    /// The policy on every task, from the straight line, for at most `steps` iterations.
    pub fn validate(
        &self,
        net: &WaypointNet,
        rule: ActionRule,
        steps: usize,
    ) -> WaypointValidation {
        let first_free = |scratch: &mut WaypointScratch, ready: &Ready| {
            let mut ready = ready.clone();
            ready.read_map(net);
            let mut x = vec![0.0; ready.objective.dim()];
            ready.objective.straight_line(&mut x);
            ready.first_free(ready.view(&self.view)?, x, (net, &rule), steps, scratch)
        };
        let run = |tasks: &[Ready]| {
            let firsts: Vec<Option<usize>> =
                tasks.par_iter().map_init(WaypointScratch::default, first_free).collect();
            Validation::of(&firsts)
        };
        WaypointValidation { easy: run(&self.easy), hard: run(&self.hard) }
    }
}
