//! L-BFGS (Liu & Nocedal 1989) with Moré-Thuente line search, from the argmin crate.
//!
//! U has kinks where the nearest obstacle changes, and the line search can search there for ever.
//! It is cut off after [`MAX_EVALUATIONS`]; the method then goes on from the best point seen, with
//! an empty memory, and stays where it is once no point seen was better.

use std::cell::RefCell;

use argmin::core::{CostFunction, Error, Gradient, IterState, Problem, Solver as _, State};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;

use crate::objective::Objective;

type Vector = Vec<f64>;
type LineSearch = MoreThuenteLineSearch<Vector, Vector, f64>;
type Solver = LBFGS<LineSearch, Vector, Vector, f64>;
type Iterate = IterState<Vector, Vector, (), (), (), f64>;

/// Evaluations that one iteration may take.
const MAX_EVALUATIONS: usize = 40;

pub(super) struct Lbfgs {
    memory: usize,
    problem: Problem<Adapter>,
    running: Option<(Solver, Iterate)>,
    /// No better point was found from here.
    stuck: bool,
}

impl std::fmt::Debug for Lbfgs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Lbfgs").field("memory", &self.memory).field("stuck", &self.stuck).finish()
    }
}

impl Lbfgs {
    pub fn new(memory: usize, objective: &Objective) -> Self {
        let adapter =
            Adapter { objective: RefCell::new(objective.clone()), tries: RefCell::default() };
        Self { memory, problem: Problem::new(adapter), running: None, stuck: false }
    }

    pub fn step(&mut self, x: &mut [f32]) {
        if self.stuck {
            return;
        }
        if let Some(adapter) = &self.problem.problem {
            *adapter.tries.borrow_mut() = Tries::default();
        }
        if let Some((solver, state)) = self.iterate(x) {
            if let Some(param) = state.get_param() {
                x.iter_mut().zip(param).for_each(|(x, &p)| *x = p as f32);
            }
            self.running = Some((solver, state));
            return;
        }
        let Some(adapter) = &self.problem.problem else { return };
        let tries = adapter.tries.borrow();
        let here = adapter.objective.borrow_mut().cost(x).total;
        self.stuck = tries.best.is_empty() || tries.best_cost >= here;
        if !self.stuck {
            x.copy_from_slice(&tries.best);
        }
    }

    /// One iteration, begun afresh at `x` where none is running; nothing where it fails.
    fn iterate(&mut self, x: &[f32]) -> Option<(Solver, Iterate)> {
        let (mut solver, state) = match self.running.take() {
            Some(running) => running,
            None => {
                let mut solver = Solver::new(LineSearch::new(), self.memory);
                let start = Iterate::new().param(x.iter().map(|&v| f64::from(v)).collect());
                let (state, _) = solver.init(&mut self.problem, start).ok()?;
                (solver, state)
            }
        };
        let (mut state, _) = solver.next_iter(&mut self.problem, state).ok()?;
        state.increment_iter();
        let finite = state.get_param()?.iter().all(|v| v.is_finite());
        finite.then_some((solver, state))
    }
}

/// What the current iteration has evaluated.
#[derive(Default)]
struct Tries {
    count: usize,
    best: Vec<f32>,
    best_cost: f32,
}

/// The objective as argmin sees it; evaluations past the limit are errors, which end a line search.
struct Adapter {
    objective: RefCell<Objective>,
    tries: RefCell<Tries>,
}

impl Adapter {
    fn evaluate(&self, param: &Vector, gradient: Option<&mut [f32]>) -> Result<f64, Error> {
        let x: Vec<f32> = param.iter().map(|&v| v as f32).collect();
        let mut tries = self.tries.borrow_mut();
        tries.count += 1;
        if tries.count > MAX_EVALUATIONS {
            return Err(Error::msg("the line search found no step"));
        }
        let mut objective = self.objective.borrow_mut();
        let cost = match gradient {
            Some(gradient) => objective.cost_and_gradient(&x, gradient).total,
            None => objective.cost(&x).total,
        };
        if tries.best.is_empty() || cost < tries.best_cost {
            tries.best_cost = cost;
            tries.best = x;
        }
        Ok(f64::from(cost))
    }
}

impl CostFunction for Adapter {
    type Param = Vector;
    type Output = f64;

    fn cost(&self, param: &Vector) -> Result<f64, Error> {
        self.evaluate(param, None)
    }
}

impl Gradient for Adapter {
    type Param = Vector;
    type Gradient = Vector;

    fn gradient(&self, param: &Vector) -> Result<Vector, Error> {
        let mut gradient = vec![0.0; param.len()];
        self.evaluate(param, Some(&mut gradient))?;
        Ok(gradient.iter().map(|&g| f64::from(g)).collect())
    }
}
