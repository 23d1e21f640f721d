//! Gradient descent: fixed step, and with backtracking line search (Armijo 1966; Nocedal & Wright,
//! Numerical Optimization, algorithm 3.1).

use crate::objective::{Cost, Objective};

/// ξ ← ξ - γ ∂U.
pub(super) fn step(step: f32, x: &mut [f32], gradient: &[f32]) {
    for (x, g) in x.iter_mut().zip(gradient) {
        *x -= step * g;
    }
}

/// Halves the step until U falls by at least a small share of what the slope promises.
#[derive(Debug)]
pub(super) struct LineSearch {
    first_step: f32,
    trial: Vec<f32>,
}

/// Share of the promised decrease that is asked for.
const SUFFICIENT_DECREASE: f32 = 1e-4;
const MAX_HALVINGS: usize = 20;

impl LineSearch {
    pub fn new(first_step: f32, n: usize) -> Self {
        Self { first_step, trial: vec![0.0; n] }
    }

    pub fn step(&mut self, x: &mut [f32], cost: Cost, gradient: &[f32], objective: &mut Objective) {
        let slope: f32 = gradient.iter().map(|g| g * g).sum();
        let mut step = self.first_step;
        for _ in 0..MAX_HALVINGS {
            for ((trial, x), g) in self.trial.iter_mut().zip(&*x).zip(gradient) {
                *trial = x - step * g;
            }
            if objective.cost(&self.trial).total <= cost.total - SUFFICIENT_DECREASE * step * slope
            {
                x.copy_from_slice(&self.trial);
                return;
            }
            step *= 0.5;
        }
    }
}
