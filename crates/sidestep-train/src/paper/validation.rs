//! How good a policy is on tasks that it was not trained on: success by the profile's check from the straight line.

use rayon::prelude::*;
use sidestep::network::{Network, Scratch};
use sidestep::policy::ActionRule;

use crate::environment::Problem;
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
    let solved = firsts.iter().flatten().count();
    let iterations: usize = firsts.iter().flatten().sum();
    let mean_iterations = iterations as f64 / solved.max(1) as f64;
    Validation { tasks: problems.len(), solved, mean_iterations }
}

fn first_feasible(
    network: &Network,
    rule: ActionRule,
    mut problem: Problem,
    steps: usize,
    scratch: &mut Scratch,
) -> Option<usize> {
    let dim = problem.objective.dim();
    let (mut x, mut gradient, mut action) = (vec![0.0; dim], vec![0.0; dim], vec![0.0; dim]);
    let mut observation = vec![0.0; problem.encoder.len(&problem.objective)];
    problem.objective.straight_line(&mut x);
    problem.encoder.reset();
    for index in 0..=steps {
        if problem.objective.is_feasible(&x) {
            return Some(index);
        }
        problem.observe(&x, &mut gradient, &mut observation);
        network.forward(&observation, scratch, &mut action);
        rule.apply(&action, problem.objective.scene().normalised_limits(), &mut x);
    }
    None
}
