//! Generalised advantage estimation (Schulman et al. 2016, arXiv:1506.02438, equation 16).
//!
//! ```text
//! delta_t = r_t + gamma (1 - done_t) v_{t+1} - v_t
//! A_t     = delta_t + gamma lambda (1 - done_t) A_{t+1},    return_t = A_t + v_t
//! ```
//!
//! `done_t` says that the step at t ended its episode; what follows then belongs to another one.

/// One environment's steps, each slice `[steps]`.
#[derive(Debug, Clone, Copy)]
pub struct Steps<'a> {
    /// Reward of each step.
    pub rewards: &'a [f32],
    /// Value of the observation that each step began from.
    pub values: &'a [f32],
    /// Whether the step ended its episode.
    pub dones: &'a [bool],
    /// Value of the observation after the last step.
    pub last_value: f32,
}

/// Writes the advantages and returns of one environment, `[steps]` each.
pub fn generalised_advantages(
    steps: Steps,
    gamma: f32,
    lambda: f32,
    advantages: &mut [f32],
    returns: &mut [f32],
) {
    let (mut next_value, mut next_advantage) = (steps.last_value, 0.0);
    for t in (0..steps.rewards.len()).rev() {
        let going_on = if steps.dones[t] { 0.0 } else { 1.0 };
        let delta = steps.rewards[t] + gamma * going_on * next_value - steps.values[t];
        next_advantage = delta + gamma * lambda * going_on * next_advantage;
        next_value = steps.values[t];
        advantages[t] = next_advantage;
        returns[t] = next_advantage + steps.values[t];
    }
}
