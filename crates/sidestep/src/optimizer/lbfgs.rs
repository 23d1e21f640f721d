//! L-BFGS (Liu & Nocedal 1989) with Moré-Thuente line search, from the argmin crate.
//!
//! U has kinks where the nearest obstacle changes, and the line search can search there for ever.
//! It is cut off after [`MAX_EVALUATIONS`]; the method then goes on from the best point seen, with
//! an empty memory, and stays where it is once no point seen was better.

use std::sync::{Arc, Mutex, PoisonError};

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
    adapter: Adapter,
    running: Option<Running>,
    /// No better point was found from here.
    stuck: bool,
}

/// A solver between two iterations; argmin keeps the problem when a line search fails, so a failed
/// one is dropped as a whole.
struct Running {
    problem: Problem<Adapter>,
    solver: Solver,
    state: Iterate,
}

impl std::fmt::Debug for Lbfgs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Lbfgs").field("memory", &self.memory).field("stuck", &self.stuck).finish()
    }
}

impl Lbfgs {
    pub fn new(memory: usize, objective: &Objective) -> Self {
        let evaluator = Evaluator {
            objective: objective.clone(),
            evaluations: 0,
            best: Vec::new(),
            best_cost: f32::INFINITY,
        };
        let adapter = Adapter(Arc::new(Mutex::new(evaluator)));
        Self { memory, adapter, running: None, stuck: false }
    }

    pub fn step(&mut self, x: &mut [f32]) {
        if self.stuck {
            return;
        }
        self.adapter.with(|evaluator| {
            evaluator.evaluations = 0;
            evaluator.best_cost = f32::INFINITY;
        });
        self.running = self.iterate(x);
        if let Some(param) = self.running.as_ref().and_then(|running| running.state.get_param()) {
            x.iter_mut().zip(param).for_each(|(x, &p)| *x = p as f32);
            return;
        }
        self.stuck = self.adapter.with(|evaluator| {
            let better = evaluator.best_cost < evaluator.objective.cost(x).total;
            if better {
                x.copy_from_slice(&evaluator.best);
            }
            !better
        });
    }

    /// One iteration, begun afresh at `x` where none is running; nothing where it fails.
    fn iterate(&mut self, x: &[f32]) -> Option<Running> {
        let Running { mut problem, mut solver, state } = match self.running.take() {
            Some(running) => running,
            None => {
                let mut problem = Problem::new(self.adapter.clone());
                let mut solver = Solver::new(LineSearch::new(), self.memory);
                let start = Iterate::new().param(x.iter().map(|&v| f64::from(v)).collect());
                let (state, _) = solver.init(&mut problem, start).ok()?;
                Running { problem, solver, state }
            }
        };
        let (mut state, _) = solver.next_iter(&mut problem, state).ok()?;
        state.increment_iter();
        let finite = state.get_param()?.iter().all(|v| v.is_finite());
        finite.then_some(Running { problem, solver, state })
    }
}

/// The objective with what the current iteration has seen of it.
struct Evaluator {
    objective: Objective,
    evaluations: usize,
    best: Vec<f32>,
    best_cost: f32,
}

/// The objective as argmin sees it; evaluations past the limit are errors, which end a line search.
#[derive(Clone)]
struct Adapter(Arc<Mutex<Evaluator>>);

impl Adapter {
    fn with<T>(&self, use_it: impl FnOnce(&mut Evaluator) -> T) -> T {
        use_it(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn evaluate(&self, param: &Vector, gradient: Option<&mut [f32]>) -> Result<f64, Error> {
        self.with(|evaluator| {
            evaluator.evaluations += 1;
            if evaluator.evaluations > MAX_EVALUATIONS {
                return Err(Error::msg("the line search found no step"));
            }
            let x: Vec<f32> = param.iter().map(|&v| v as f32).collect();
            let cost = match gradient {
                Some(gradient) => evaluator.objective.cost_and_gradient(&x, gradient).total,
                None => evaluator.objective.cost(&x).total,
            };
            if cost < evaluator.best_cost {
                evaluator.best_cost = cost;
                evaluator.best = x;
            }
            Ok(f64::from(cost))
        })
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
