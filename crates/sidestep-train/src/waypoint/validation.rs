//! How good a waypoint policy is on tasks that it was not trained on: certified success from the
//! straight line.

use std::ops::ControlFlow;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sidestep::Task;
use sidestep::network::{WaypointNet, WaypointScratch};
use sidestep::objective::Objective;
use sidestep::optimizer::{Method, Optimizer};
use sidestep::plan::run::{Until, run};
use sidestep::policy::ActionRule;
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::suite::Suite;

use super::config::{WaypointValidationConfig, jointed_task};
use super::ready::{Ready, is_solvable};
use super::sight::Sight;
use crate::validation::Validation;

/// The results on the solvable tasks of the suites easy and hard. Of robots with joints: on those whose
/// straight line is not free, and on those of them that CHOMP leaves unsolved.
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
    sight: Sight,
    easy: Vec<Ready>,
    hard: Vec<Ready>,
}

impl Tasks {
    pub fn new(config: &WaypointValidationConfig, sight: &Sight) -> Self {
        let ready = |(index, task): (usize, &Task)| {
            let query = Ready::query(task);
            let mut rng = stream(config.seed, Purpose::Planner, index as u64, 0);
            if !is_solvable(&query, &mut rng) {
                return None;
            }
            Ready::new(sight, Objective::new(&query, Profile::DEFAULT.waypoints).ok()?)
        };
        let all = |tasks: Vec<Task>| -> Vec<Ready> {
            tasks.par_iter().enumerate().filter_map(ready).collect()
        };
        let (easy, hard) = match sight {
            Sight::Plane(_) => {
                let draw =
                    |suite: Suite| suite.generate(config.count, config.seed, &Profile::PAPER);
                (all(draw(Suite::Easy)), all(draw(Suite::Hard)))
            }
            Sight::Joints(_, arm) => {
                let tasks = (0..config.count as u64).into_par_iter();
                let drawn = tasks.filter_map(|index| jointed_task(arm, config.seed, index));
                let mut easy = all(drawn.collect());
                easy.retain(|ready| !is_direct(ready));
                let hard = easy.par_iter().filter(|ready| !chomp_solves(ready)).cloned().collect();
                (easy, hard)
            }
        };
        Self { sight: sight.clone(), easy, hard }
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
            ready.first_free(ready.view(&self.sight)?, x, (net, &rule), steps, scratch)
        };
        let run = |tasks: &[Ready]| {
            let firsts: Vec<Option<usize>> =
                tasks.par_iter().map_init(WaypointScratch::default, first_free).collect();
            Validation::of(&firsts)
        };
        WaypointValidation { easy: run(&self.easy), hard: run(&self.hard) }
    }
}

fn is_direct(ready: &Ready) -> bool {
    let query = ready.objective.query();
    query.scene().motion_is_free(query.start(), query.goal())
}

/// Whether CHOMP solves a task of a robot with joints from the straight line.
fn chomp_solves(ready: &Ready) -> bool {
    let mut objective = ready.objective.clone();
    let mut x = vec![0.0; objective.dim()];
    objective.straight_line(&mut x);
    let method = Method::Chomp { step: Some(0.02) };
    let unused = stream(0, Purpose::Planner, 0, 0);
    let Ok(mut optimizer) = Optimizer::new(&method, &objective, unused) else { return false };
    let done = run(&mut objective, &mut optimizer, &mut x, 100, Until::Certified, |_| {
        ControlFlow::Continue(())
    });
    done.first_certified.is_some()
}
