//! L-BFGS (Liu & Nocedal 1989) with Moré-Thuente line search, from the argmin crate.
//!
//! U has kinks where the nearest obstacle changes, so the line search can fail; the method then
//! forgets its memory once and, if that does not help, stays where it is.

use std::cell::RefCell;

use argmin::core::{CostFunction, Error, Gradient, IterState, Problem, Solver, State};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;

use crate::objective::Objective;

type Vector = Vec<f64>;
type LineSearch = MoreThuenteLineSearch<Vector, Vector, f64>;
type Iterate = IterState<Vector, Vector, (), (), (), f64>;

pub(super) struct Lbfgs {
    memory: usize,
    problem: Problem<Adapter>,
    running: Option<(LBFGS<LineSearch, Vector, Vector, f64>, Iterate)>,
    /// The start of the last try that failed; trying there again would fail again.
    stuck: bool,
}

impl std::fmt::Debug for Lbfgs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Lbfgs").field("memory", &self.memory).field("stuck", &self.stuck).finish()
    }
}

impl Lbfgs {
    pub fn new(memory: usize, objective: &Objective) -> Self {
        let adapter = Adapter(RefCell::new(objective.clone()));
        Self { memory, problem: Problem::new(adapter), running: None, stuck: false }
    }

    pub fn step(&mut self, x: &mut [f32]) {
        if self.stuck {
            return;
        }
        let running = self.running.take();
        let continued = running.and_then(|(solver, state)| self.iterate(solver, state));
        let outcome = continued.or_else(|| {
            let solver = LBFGS::new(LineSearch::new(), self.memory);
            let start = Iterate::new().param(x.iter().map(|&v| f64::from(v)).collect());
            let mut solver = solver;
            let (state, _) = solver.init(&mut self.problem, start).ok()?;
            self.iterate(solver, state)
        });
        match outcome {
            Some((solver, state)) => {
                if let Some(param) = state.get_param() {
                    x.iter_mut().zip(param).for_each(|(x, &p)| *x = p as f32);
                }
                self.running = Some((solver, state));
            }
            None => self.stuck = true,
        }
    }

    fn iterate(
        &mut self,
        mut solver: LBFGS<LineSearch, Vector, Vector, f64>,
        state: Iterate,
    ) -> Option<(LBFGS<LineSearch, Vector, Vector, f64>, Iterate)> {
        let (mut state, _) = solver.next_iter(&mut self.problem, state).ok()?;
        state.increment_iter();
        let finite = state.get_param()?.iter().all(|v| v.is_finite());
        finite.then_some((solver, state))
    }
}

/// The objective as argmin sees it.
struct Adapter(RefCell<Objective>);

impl CostFunction for Adapter {
    type Param = Vector;
    type Output = f64;

    fn cost(&self, param: &Vector) -> Result<f64, Error> {
        let x: Vec<f32> = param.iter().map(|&v| v as f32).collect();
        Ok(f64::from(self.0.borrow_mut().cost(&x).total))
    }
}

impl Gradient for Adapter {
    type Param = Vector;
    type Gradient = Vector;

    fn gradient(&self, param: &Vector) -> Result<Vector, Error> {
        let x: Vec<f32> = param.iter().map(|&v| v as f32).collect();
        let mut gradient = vec![0.0; x.len()];
        self.0.borrow_mut().cost_and_gradient(&x, &mut gradient);
        Ok(gradient.iter().map(|&g| f64::from(g)).collect())
    }
}
