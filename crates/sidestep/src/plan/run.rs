//! One optimizer on one start: the loop that everything above is made of.

use std::ops::ControlFlow;

use crate::objective::{Cost, Objective};
use crate::optimizer::{Known, Optimizer};

/// When a run ends before its budget of steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Until {
    /// At the first iterate that the profile calls feasible.
    Feasible,
    /// At the first iterate that the exact certificate passes.
    Certified,
    /// Never: both checks are made at every iterate.
    Spent,
}

/// One iterate, as a watcher sees it.
#[derive(Debug, Clone, Copy)]
pub struct Iteration<'a> {
    /// Which start of a batch this is; 0 is the straight line.
    pub start: usize,
    /// Index of the iterate; 0 is the start trajectory itself.
    pub index: usize,
    /// U at the iterate, where the method or the end of the run asks for it.
    pub cost: Option<Cost>,
    /// The waypoints, `[N x dof]`, normalised units.
    pub waypoints: &'a [f32],
    /// Whether the check that ends the run passed.
    pub solved: bool,
}

/// What a run found. Iterates are counted from 0, the start trajectory.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Run {
    /// Optimizer steps made.
    pub steps: usize,
    /// First iterate that the profile's check passes.
    pub first_feasible: Option<usize>,
    /// Whether the last iterate passes the profile's check.
    pub feasible_at_end: bool,
    /// First iterate that the exact certificate passes.
    pub first_certified: Option<usize>,
    /// The certified iterate of least U.
    pub best: Option<Best>,
    /// Whether the run ended because the next iterate would have had a coordinate that is no number or
    /// further out than [`FARTHEST`].
    pub diverged: bool,
}

/// Iterates further out than this, in normalised units, do not come back: some 150,000 fields.
pub const FARTHEST: f32 = 1e6;

/// A certified iterate.
#[derive(Debug, Clone, PartialEq)]
pub struct Best {
    /// U there.
    pub cost: f32,
    /// The waypoints, `[N x dof]`, normalised units.
    pub waypoints: Vec<f32>,
}

/// Walks `x` downhill for at most `steps` steps; `x` ends at the last iterate, and is finite if it was
/// before. `watch` sees each iterate and may break off.
pub fn run(
    objective: &mut Objective,
    optimizer: &mut Optimizer,
    x: &mut [f32],
    steps: usize,
    until: Until,
    mut watch: impl FnMut(&Iteration<'_>) -> ControlFlow<()>,
) -> Run {
    let mut gradient = vec![0.0; x.len()];
    let mut last = x.to_vec();
    let mut run = Run::default();
    let exact_profile = objective.feasible_means_certified();
    let sees_segments = optimizer.uses_free_segments();
    let mut free = vec![false; if sees_segments { objective.waypoints() + 1 } else { 0 }];
    for index in 0..=steps {
        // Asked once: what ends the run, and what the optimizer sees.
        let known = sees_segments.then(|| objective.free_segments(x, &mut free));
        let is_certified = || known.unwrap_or_else(|| objective.is_certified(x));
        let is_feasible = || if exact_profile { is_certified() } else { objective.is_feasible(x) };
        let feasible = until != Until::Certified && is_feasible();
        let certified = match until {
            Until::Feasible => feasible && exact_profile,
            Until::Certified => is_certified(),
            // What the samples refuse, the exact check refuses too.
            Until::Spent => feasible && (exact_profile || is_certified()),
        };
        let solved = if until == Until::Feasible { feasible } else { certified };
        let ends = solved && until != Until::Spent || index == steps;
        let cost = if optimizer.uses_gradient() {
            Some(objective.cost_and_gradient(x, &mut gradient))
        } else {
            certified.then(|| objective.cost(x))
        };
        run.steps = index;
        run.feasible_at_end = feasible;
        if feasible {
            run.first_feasible.get_or_insert(index);
        }
        if let (true, Some(cost)) = (certified, cost) {
            run.first_certified.get_or_insert(index);
            keep_best(&mut run.best, cost.total, x);
        }
        let seen = Iteration { start: 0, index, cost, waypoints: x, solved };
        if watch(&seen).is_break() || ends {
            break;
        }
        let cost = cost.unwrap_or_default();
        last.copy_from_slice(x);
        optimizer.step(x, Known { cost, gradient: &gradient, free: &free }, objective);
        if !x.iter().all(|value| value.abs() <= FARTHEST) {
            x.copy_from_slice(&last);
            run.diverged = true;
            break;
        }
    }
    run
}

fn keep_best(best: &mut Option<Best>, cost: f32, x: &[f32]) {
    match best {
        None => *best = Some(Best { cost, waypoints: x.to_vec() }),
        Some(best) if cost < best.cost => {
            best.cost = cost;
            best.waypoints.copy_from_slice(x);
        }
        Some(_) => {}
    }
}
