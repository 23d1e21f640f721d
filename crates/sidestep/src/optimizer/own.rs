//! An optimizer of one's own, as a closure.

use std::sync::Arc;

use crate::objective::Objective;
use crate::optimizer::Known;

/// One iteration of an optimizer of one's own: updates the waypoints `x [N x dof]`, given U and ∂U there.
pub type Step = Box<dyn FnMut(&mut [f32], Known<'_>, &mut Objective) + Send>;

/// An optimizer of one's own: what begins it on the trajectories of an objective, once for each start.
///
/// ```
/// use sidestep::optimizer::{Method, Own};
/// use sidestep::{Planner, Suite, Options, plan};
///
/// // Gradient descent that forgets nothing: steps shrink with what was seen (AdaGrad).
/// let adagrad = Own::new(|objective| {
///     let mut seen = vec![1e-6; objective.dim()];
///     Box::new(move |x, known, _| {
///         for ((x, g), seen) in x.iter_mut().zip(known.gradient).zip(&mut seen) {
///             *seen += g * g;
///             *x -= 0.2 * g / seen.sqrt();
///         }
///     })
/// });
/// let task = &Suite::Easy.generate(5, 7, &sidestep::Profile::PAPER)[2];
/// let plan = plan(task, &Planner::Optimizer(Method::Own(adagrad)), &Options::default())?;
/// assert!(plan.is_solved());
/// # Ok::<(), sidestep::InvalidInput>(())
/// ```
#[derive(Clone)]
pub struct Own(Arc<dyn Fn(&Objective) -> Step + Send + Sync>);

impl Own {
    /// From a closure that makes the optimizer for trajectories of an objective. It gets ∂U at every iterate.
    pub fn new(begin: impl Fn(&Objective) -> Step + Send + Sync + 'static) -> Self {
        Self(Arc::new(begin))
    }

    pub(super) fn begin(&self, objective: &Objective) -> Steps {
        Steps(self.0(objective))
    }
}

impl std::fmt::Debug for Own {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Own(..)")
    }
}

/// An optimizer of one's own at work.
pub(super) struct Steps(Step);

impl Steps {
    pub fn step(&mut self, x: &mut [f32], known: Known<'_>, objective: &mut Objective) {
        self.0(x, known, objective);
    }
}

impl std::fmt::Debug for Steps {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Steps(..)")
    }
}
