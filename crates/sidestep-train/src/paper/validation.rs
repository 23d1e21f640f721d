//! How good a policy is on tasks that it was not trained on: success by the profile's check from
//! the straight line.

use rayon::prelude::*;
use sidestep::network::{Network, Scratch};
use sidestep::policy::ActionRule;

use crate::environments::Problem;
use crate::validation::Validation;

/// Runs the policy on every problem for at most `steps` iterations, or until feasible.
pub fn validate(
    network: &Network,
    rule: ActionRule,
    problems: &[Problem],
    steps: usize,
) -> Validation {
    let firsts: Vec<Option<usize>> = problems
        .par_iter()
        .map_init(Scratch::default, |scratch, problem| {
            first_feasible(network, rule, problem.clone(), steps, scratch)
        })
        .collect();
    Validation::of(&firsts)
}

fn first_feasible(
    network: &Network,
    rule: ActionRule,
    mut problem: Problem,
    steps: usize,
    scratch: &mut Scratch,
) -> Option<usize> {
    let mut x = vec![0.0; problem.objective.dim()];
    problem.objective.straight_line(&mut x);
    problem.encoder.reset();
    problem.walk(&mut x, steps, rule, |place, action| {
        network.forward(place.observation, scratch, action);
        true
    })
}
