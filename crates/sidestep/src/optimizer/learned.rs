//! The learned optimizer: a trained policy turned into an ordinary optimizer.
//!
//! ξ ← ξ + clip(π(o)), as the policy was trained: the update clipped per coordinate, positions kept
//! inside the field where the policy's card says so.

use std::sync::Arc;

use crate::error::InvalidInput;
use crate::network::Scratch;
use crate::objective::Objective;
use crate::observation::Encoder;
use crate::policy::Policy;
use crate::task::Task;

#[derive(Debug)]
pub(super) struct Learned {
    policy: Arc<Policy>,
    encoder: Encoder,
    observation: Vec<f32>,
    action: Vec<f32>,
    scratch: Scratch,
}

impl Learned {
    pub fn new(
        policy: Arc<Policy>,
        task: &Task,
        objective: &Objective,
    ) -> Result<Self, InvalidInput> {
        policy.check_waypoints(objective.waypoints())?;
        let profile = objective.scene().profile().name;
        if policy.card().profile != profile {
            let allowed = format!("{}, which the policy was trained in", policy.card().profile);
            return Err(InvalidInput::new("profile", profile, allowed));
        }
        let encoder = Encoder::new(policy.observation(), objective, &task.world)?;
        Ok(Self {
            observation: vec![0.0; encoder.len(objective)],
            action: vec![0.0; objective.dim()],
            scratch: Scratch::default(),
            encoder,
            policy,
        })
    }

    pub fn step(&mut self, x: &mut [f32], gradient: &[f32], objective: &Objective) {
        self.encoder.encode(objective, x, gradient, &mut self.observation);
        let field = objective.scene().field_size();
        self.policy.step(&self.observation, &mut self.scratch, field, &mut self.action, x);
    }
}
