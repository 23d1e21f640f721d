//! A task made ready for policies that see the trajectory as a whole, and the one loop that walks
//! it: see, answer, move, until feasible.

use sidestep::objective::{Cost, Objective};
use sidestep::policy::ActionRule;
use sidestep::policy::observation::{Encoder, ObservationPart};
use sidestep::profile::Profile;
use sidestep::scene::Query;
use sidestep::{InvalidInput, Task};

/// A task made ready: its objective and its encoder.
#[derive(Debug, Clone)]
pub struct Problem {
    /// U, its gradient and the feasibility check.
    pub objective: Objective,
    /// The observation of this task.
    pub encoder: Encoder,
}

impl Problem {
    /// Prepares `task` for trajectories of `waypoints` free points.
    ///
    /// # Errors
    /// If the observation does not fit the task, or the number of waypoints is out of range.
    pub fn new(
        task: &Task,
        profile: &Profile,
        waypoints: usize,
        parts: &[ObservationPart],
    ) -> Result<Self, InvalidInput> {
        let objective = Objective::new(&Query::of(task, profile), waypoints)?;
        let encoder = Encoder::new(parts, &objective)?;
        Ok(Self { objective, encoder })
    }

    /// U at `x [N x dof]`, with `gradient [N x dof]` and `observation` written.
    pub fn observe(&mut self, x: &[f32], gradient: &mut [f32], observation: &mut [f32]) -> Cost {
        let cost = self.objective.cost_and_gradient(x, gradient);
        self.encoder.encode(&self.objective, x, gradient, observation);
        cost
    }

    /// Walks from `x [N x dof]`, which is left where the walk ends: `answer` sees the place and
    /// writes an action `[N x dof]`, or says false to end the walk. Returns the index of the first
    /// iterate that is feasible, of `steps` at most; 0 is `x` itself.
    pub fn walk(
        &mut self,
        x: &mut [f32],
        steps: usize,
        rule: ActionRule,
        mut answer: impl FnMut(Place, &mut [f32]) -> bool,
    ) -> Option<usize> {
        let dim = self.objective.dim();
        let (mut gradient, mut action, mut memory) = (vec![0.0; dim], vec![0.0; dim], Vec::new());
        let mut observation = vec![0.0; self.encoder.len(&self.objective)];
        for index in 0..=steps {
            if self.objective.is_feasible(x) {
                return Some(index);
            }
            if index == steps {
                break;
            }
            memory.clear();
            memory.extend_from_slice(self.encoder.memory());
            self.observe(x, &mut gradient, &mut observation);
            let place = Place {
                problem: self,
                x,
                gradient: &gradient,
                observation: &observation,
                memory: &memory,
            };
            if !answer(place, &mut action) {
                return None;
            }
            rule.apply(&action, self.objective.scene().normalised_limits(), x);
        }
        None
    }
}

/// Where a walk is, before its next step.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// The task.
    pub problem: &'a Problem,
    /// The waypoints, `[N x dof]`.
    pub x: &'a [f32],
    /// The gradient of U there, `[N x dof]`.
    pub gradient: &'a [f32],
    /// What the policy sees.
    pub observation: &'a [f32],
    /// What the encoder remembered before it saw that.
    pub memory: &'a [f32],
}
