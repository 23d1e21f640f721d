//! How good a waypoint policy is on tasks that it was not trained on: certified success from the straight line.

use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sidestep::Route;
use sidestep::network::{WaypointNet, WaypointScratch};
use sidestep::objective::Objective;
use sidestep::plane::view::{Look, TaskMap, ViewParts, WaypointView};
use sidestep::policy::ActionRule;
use sidestep::profile::Profile;
use sidestep::scene::Scene;
use sidestep::suite::Suite;

use super::config::WaypointValidationConfig;
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
    /// The number that the best policy has most of: the share of solved tasks, easy and hard weighed alike.
    pub fn score(&self) -> f64 {
        0.5 * (self.easy.success() + self.hard.success())
    }

    /// Whether this is better than `other`.
    pub fn beats(&self, other: &Self) -> bool {
        self.score() > other.score()
    }
}

/// A task made ready.
struct Problem {
    objective: Objective,
    view: WaypointView,
    map: Option<TaskMap>,
}

/// Solvable validation tasks made ready.
pub(super) struct Tasks {
    easy: Vec<Problem>,
    hard: Vec<Problem>,
}

impl Tasks {
    pub fn new(config: &WaypointValidationConfig, view: &ViewParts) -> Self {
        let ready = |suite: Suite| {
            let tasks = suite.generate(config.count, config.seed, &Profile::PAPER);
            let problem = |task: &sidestep::Task| {
                let scene = Arc::new(Scene::of(task, &Profile::DEFAULT));
                let route = scene.shortest_path().find(task.start, task.goal);
                let Route::Found { .. } = route else { return None };
                let objective = Objective::new(task, scene, Profile::DEFAULT.waypoints).ok()?;
                let map = view.map.as_ref().map(|shape| TaskMap::new(view, shape, &objective));
                Some(Problem {
                    view: WaypointView::new(view, &objective, Look::default()),
                    map,
                    objective,
                })
            };
            tasks.par_iter().filter_map(problem).collect()
        };
        Self { easy: ready(Suite::Easy), hard: ready(Suite::Hard) }
    }

    pub fn validate(
        &self,
        net: &WaypointNet,
        rule: ActionRule,
        steps: usize,
    ) -> WaypointValidation {
        let run = |tasks: &[Problem]| {
            let firsts: Vec<Option<usize>> = tasks
                .par_iter()
                .map_init(WaypointScratch::default, |scratch, problem| {
                    problem.first_free(net, rule, steps, scratch)
                })
                .collect();
            let solved = firsts.iter().flatten().count();
            let iterations: usize = firsts.iter().flatten().sum();
            let mean_iterations = iterations as f64 / solved.max(1) as f64;
            Validation { tasks: tasks.len(), solved, mean_iterations }
        };
        WaypointValidation { easy: run(&self.easy), hard: run(&self.hard) }
    }
}

impl Problem {
    /// The first iterate from the straight line that is free.
    fn first_free(
        &self,
        net: &WaypointNet,
        rule: ActionRule,
        steps: usize,
        scratch: &mut WaypointScratch,
    ) -> Option<usize> {
        let Self { objective, view, map } = self;
        let (mut view, mut map) = (view.clone(), map.clone());
        if let Some(map) = &mut map {
            net.read_map(map.scratch());
        }
        let mut x = vec![0.0; objective.dim()];
        objective.straight_line(&mut x);
        view.reset();
        let (waypoints, stride) = (objective.waypoints(), net.input_stride());
        for step in 0..=steps {
            let rows = scratch.input(waypoints, stride);
            view.encode(objective, &x, map.as_ref(), rows, stride);
            if view.is_free() {
                return Some(step);
            }
            net.forward(scratch, waypoints);
            view.apply(&rule, |i| scratch.output(i), &mut x);
        }
        None
    }
}
