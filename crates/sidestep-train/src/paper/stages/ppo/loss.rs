//! The clipped surrogate, the value loss and the entropy of one minibatch, with their gradient.

use super::PpoConfig;
use crate::paper::agent::{Agent, Gradient, Sums, Worker};
use crate::paper::gaussian::{self, Density};

/// Steps drawn for one optimizer step, gathered row by row.
#[derive(Debug, Clone, Default)]
pub struct Minibatch {
    /// `[rows x observations]`.
    pub observations: Vec<f32>,
    /// `[rows x actions]`, as drawn.
    pub actions: Vec<f32>,
    /// ln pi_old(action), `[rows]`.
    pub old_log_probs: Vec<f32>,
    /// `[rows]`, not normalised.
    pub advantages: Vec<f32>,
    /// `[rows]`.
    pub returns: Vec<f32>,
}

impl Minibatch {
    /// Shift and factor that normalise the advantages: mean, and 1 / (std + 1e-8) with n - 1.
    fn normaliser(&self, wanted: bool) -> (f32, f32) {
        let n = self.advantages.len() as f64;
        if !wanted || self.advantages.len() < 2 {
            return (0.0, 1.0);
        }
        let mean = self.advantages.iter().map(|&a| f64::from(a)).sum::<f64>() / n;
        let squares = self.advantages.iter().map(|&a| (f64::from(a) - mean).powi(2)).sum::<f64>();
        (mean as f32, (1.0 / ((squares / (n - 1.0)).sqrt() + 1e-8)) as f32)
    }
}

/// The loss of a minibatch and its diagnostics; means over the rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Losses {
    /// The clipped surrogate, negated.
    pub policy: f64,
    /// Mean squared error of the values.
    pub value: f64,
    /// Entropy of the policy.
    pub entropy: f64,
    /// mean((ratio - 1) - ln ratio).
    pub approx_kl: f64,
    /// Share of ratios outside the clip range.
    pub clip_fraction: f64,
    /// policy + c_v value - c_e entropy.
    pub total: f64,
}

/// The loss at the agent's parameters; its gradient is left in `gradient`.
pub fn loss_and_gradient(
    agent: &Agent,
    batch: &Minibatch,
    config: &PpoConfig,
    gradient: &mut Gradient,
) -> Losses {
    let (wide, acts, rows) = (agent.observations(), agent.actions(), batch.returns.len());
    let (shift, factor) = batch.normaliser(config.normalise_advantages);
    let share = 1.0 / rows as f32;
    let density = Density::new(&agent.log_std);
    let sums = gradient.accumulate(agent, rows, |range, worker: &mut Worker| {
        let observations = &batch.observations[range.start * wide..range.end * wide];
        agent.evaluate(observations, &mut worker.policy, &mut worker.value);
        worker.mean_gradient.resize(range.len() * acts, 0.0);
        worker.value_gradient.resize(range.len(), 0.0);
        let mut log_std_gradient = vec![-config.entropy * share * range.len() as f32; acts];
        let mut sums = Sums::default();
        for (local, row) in range.enumerate() {
            let action = &batch.actions[row * acts..][..acts];
            let mean = worker.policy.output(local);
            let log_ratio = density.log_prob(action, mean) - batch.old_log_probs[row];
            let ratio = log_ratio.exp();
            let advantage = (batch.advantages[row] - shift) * factor;
            let clipped = ratio.clamp(1.0 - config.clip, 1.0 + config.clip);
            let (free, bound) = (ratio * advantage, clipped * advantage);
            // d ratio / d log_prob = ratio. Where the bound is lower its derivative is 0; at a tie
            // inside the range both agree.
            let slope = if free <= bound { -free * share } else { 0.0 };
            let mean_gradient = &mut worker.mean_gradient[local * acts..][..acts];
            let stds = &mut log_std_gradient;
            density.log_prob_gradient(action, mean, slope, mean_gradient, stds);
            let error = worker.value.output(local)[0] - batch.returns[row];
            worker.value_gradient[local] = 2.0 * config.value * error * share;
            sums[0] -= f64::from(free.min(bound));
            sums[1] += f64::from(error * error);
            sums[2] += f64::from(ratio) - 1.0 - f64::from(log_ratio);
            sums[3] += f64::from(u8::from((ratio - 1.0).abs() > config.clip));
        }
        worker.log_std_gradient(agent).copy_from_slice(&log_std_gradient);
        worker.backward(agent);
        sums
    });
    let [policy, value, approx_kl, clip_fraction] = sums.map(|sum| sum / rows as f64);
    let entropy = f64::from(gaussian::entropy(&agent.log_std));
    let total = policy + f64::from(config.value) * value - f64::from(config.entropy) * entropy;
    Losses { policy, value, entropy, approx_kl, clip_fraction, total }
}
