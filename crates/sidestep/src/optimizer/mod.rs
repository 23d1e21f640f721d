//! Optimizers: each turns a gradient into an update of the waypoints.
//!
//! A [`Method`] is a choice with its settings; an [`Optimizer`] is that method at work on one
//! trajectory. Where it makes sense the classical methods follow their publications (named in each
//! file). A learned optimizer is one more method, and nothing around it knows the difference.

mod adam;
mod chomp;
mod gradient_descent;
mod lbfgs;
mod learned;
mod levenberg_marquardt;
mod momentum;
mod own;
mod stomp;

pub use own::{Own, Step};

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use crate::error::InvalidInput;
use crate::objective::{Cost, Objective};
use crate::policy::Policy;
use crate::trajectory::DAMPING;

/// An optimizer and its settings. Steps are in normalised units; a robot with joints has rad and m, and needs smaller ones than
/// the plane (docs/research/arms.md).
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Method {
    /// ξ ← ξ - γ ∂U.
    GradientDescent {
        /// Step γ; where none the profile's, and 0.1 for a robot with joints.
        step: Option<f32>,
    },
    /// Gradient descent with backtracking (Armijo) line search.
    LineSearch {
        /// First step tried.
        step: f32,
    },
    /// Gradient descent with heavy-ball momentum.
    Momentum {
        /// Step γ; where none the profile's, and 0.01 for a robot with joints.
        step: Option<f32>,
        /// Share of the last update that is kept, in [0, 1).
        decay: f32,
    },
    /// Adam.
    Adam {
        /// Step α.
        step: f32,
    },
    /// Covariant gradient descent.
    Chomp {
        /// Step 1 / η; where none a tenth of the profile's, and 0.02 for a robot with joints.
        step: Option<f32>,
    },
    /// Limited-memory BFGS with a strong Wolfe line search.
    Lbfgs {
        /// Number of remembered updates.
        memory: usize,
    },
    /// Gauss-Newton steps with Levenberg-Marquardt damping.
    LevenbergMarquardt {
        /// Damping μ in the covariant metric.
        damping: f32,
    },
    /// Stochastic trajectory optimization.
    Stomp {
        /// Noisy trajectories per iteration.
        rollouts: usize,
        /// Standard deviation of the largest noise component.
        noise: f32,
    },
    /// A trained policy.
    Learned(Arc<Policy>),
    /// One of one's own.
    Own(Own),
}

impl Method {
    /// Levenberg-Marquardt as it is usually set.
    pub const fn levenberg_marquardt() -> Self {
        Self::LevenbergMarquardt { damping: DAMPING }
    }
}

/// What is known of a trajectory when an optimizer steps.
#[derive(Debug, Clone, Copy)]
pub struct Known<'a> {
    /// U; 0 for methods that use no gradient.
    pub cost: Cost,
    /// ∂U `[N x dof]`, for methods that use it.
    pub gradient: &'a [f32],
    /// Which segments are certified `[N + 1]`, for methods that look at it.
    pub free: &'a [bool],
}

/// A method at work on one trajectory.
#[derive(Debug)]
pub struct Optimizer(State);

#[derive(Debug)]
enum State {
    GradientDescent { step: f32 },
    LineSearch(gradient_descent::LineSearch),
    Momentum(momentum::Momentum),
    Adam(adam::Adam),
    Chomp(chomp::Chomp),
    Lbfgs(Box<lbfgs::Lbfgs>),
    LevenbergMarquardt(Box<levenberg_marquardt::LevenbergMarquardt>),
    Stomp(Box<stomp::Stomp>),
    Learned(Box<learned::Learned>),
    Own(own::Steps),
}

impl Optimizer {
    /// Begins `method` on the trajectories of `objective`; `rng` is for methods that sample.
    ///
    /// # Errors
    /// If a learned policy does not fit the task or its number of waypoints.
    pub fn new(
        method: &Method,
        objective: &Objective,
        rng: ChaCha8Rng,
    ) -> Result<Self, InvalidInput> {
        let (n, waypoints, dof) = (objective.dim(), objective.waypoints(), objective.dof());
        let of_profile = objective.scene().profile().gradient_step as f32;
        let is_arm = objective.scene().arm().is_some();
        let default_step = |plane: f32, arm: f32| if is_arm { arm } else { plane };
        Ok(Self(match *method {
            Method::GradientDescent { step } => {
                State::GradientDescent { step: step.unwrap_or(default_step(of_profile, 0.1)) }
            }
            Method::LineSearch { step } => {
                State::LineSearch(gradient_descent::LineSearch::new(step, n))
            }
            Method::Momentum { step, decay } => {
                let step = step.unwrap_or(default_step(of_profile, 0.01));
                State::Momentum(momentum::Momentum::new(step, decay, n))
            }
            Method::Adam { step } => State::Adam(adam::Adam::new(step, n)),
            Method::Chomp { step } => {
                let step = step.unwrap_or(default_step(0.1 * of_profile, 0.02));
                State::Chomp(chomp::Chomp::new(step, waypoints, dof))
            }
            Method::Lbfgs { memory } => State::Lbfgs(Box::new(lbfgs::Lbfgs::new(memory, n))),
            Method::LevenbergMarquardt { damping } => {
                let steps = levenberg_marquardt::LevenbergMarquardt::new(damping, waypoints, dof);
                State::LevenbergMarquardt(Box::new(steps))
            }
            Method::Stomp { rollouts, noise } => {
                State::Stomp(Box::new(stomp::Stomp::new(rollouts, noise, waypoints, dof, rng)?))
            }
            Method::Own(ref own) => State::Own(own.begin(objective)),
            Method::Learned(ref policy) => {
                State::Learned(Box::new(learned::Learned::new(policy.clone(), objective, rng)?))
            }
        }))
    }

    /// One iteration: updates the waypoints `x`, given what is known of them.
    ///
    /// Methods that need more evaluations make them on `objective`.
    pub fn step(&mut self, x: &mut [f32], known: Known<'_>, objective: &mut Objective) {
        let Known { cost, gradient, free } = known;
        match &mut self.0 {
            State::GradientDescent { step } => gradient_descent::step(*step, x, gradient),
            State::LineSearch(search) => search.step(x, cost, gradient, objective),
            State::Momentum(momentum) => momentum.step(x, gradient),
            State::Adam(adam) => adam.step(x, gradient),
            State::Chomp(chomp) => chomp.step(x, gradient),
            State::Lbfgs(lbfgs) => lbfgs.step(x, objective),
            State::LevenbergMarquardt(steps) => steps.step(x, gradient, objective),
            State::Stomp(stomp) => stomp.step(x, objective),
            State::Learned(learned) => learned.step(x, gradient, free, objective),
            State::Own(own) => own.step(x, known, objective),
        }
    }

    /// Makes what a method needs once a task, a policy's map; without this call the first step makes it.
    pub fn prepare(&mut self, objective: &Objective) {
        if let State::Learned(learned) = &mut self.0 {
            learned.prepare(objective);
        }
    }

    /// Whether the method looks at which segments are free.
    pub fn uses_free_segments(&self) -> bool {
        matches!(&self.0, State::Learned(learned) if learned.uses_free_segments())
    }

    /// Whether the method uses the gradient handed to [`Optimizer::step`].
    pub fn uses_gradient(&self) -> bool {
        match &self.0 {
            State::Lbfgs(_) | State::Stomp(_) => false,
            State::Learned(learned) => learned.uses_gradient(),
            _ => true,
        }
    }
}
