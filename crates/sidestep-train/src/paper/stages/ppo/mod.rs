//! Proximal policy optimisation (Schulman et al. 2017, arXiv:1707.06347), top to bottom.
//!
//! ```text
//! ratio  = pi(a|s) / pi_old(a|s)
//! loss   = -mean(min(ratio A, clip(ratio, 1 - c, 1 + c) A)) + c_v mean((v - return)^2) - c_e mean(entropy)
//! ```
//!
//! The details that decide whether it works, numbered as in Huang et al., "The 37 Implementation
//! Details of Proximal Policy Optimization" (ICLR blog track 2022; 1-13 of all PPO, c1-c9 of
//! continuous actions), with the choices of the paper's code (Stable-Baselines3):
//!
//! 1. Environments run side by side and go on over updates ([`collect()`]).
//! 2. Initialisation: see [`crate::parameters::Initialization`].
//! 3. Adam's epsilon is 1e-5 ([`crate::parameters::Optimizer`]).
//! 4. Learning rate constant, or falling to 0 over the training
//!    ([`Schedule`](crate::parameters::Schedule)).
//! 5. Generalised advantages; returns are advantage + value ([`advantage`]).
//! 6. Minibatches are a new shuffle of all steps in each epoch; the last one may be short.
//! 7. Advantages are normalised per minibatch, with n - 1 in the variance.
//! 8. The clipped surrogate; the gradient is 0 where the clip decides.
//! 9. No clipping of the value loss (left out in Stable-Baselines3 too; Huang et al. find no gain).
//! 10. The loss has a value coefficient and an entropy coefficient; squared error without the
//!     factor 1/2.
//! 11. The norm of the whole gradient (policy, value, log-std together) is clipped.
//! 12. Diagnostics: approximate KL as mean((ratio - 1) - ln ratio), clip fraction, explained
//!     variance.
//! 13. Policy and value share no layer (also c4).
//!
//! c1-c3: a diagonal Gaussian with a free log-std ([`crate::paper::gaussian`]). c5: the update is
//! clipped on its way into the trajectory, while the unclipped action and its probability are kept.
//! c6-c9: observations and rewards are not normalised (paper). Beyond the 37: an optional stop at a
//! target KL (Stable-Baselines3: 1.5 times the target, checked before each step).

pub mod advantage;
mod config;
mod loss;
pub mod repair;
mod rollout;

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::paper::agent::{Agent, Gradient};
use crate::paper::gaussian;
use crate::paper::stages::cloning::{self, Samples};
use crate::parameters::{Optimizer, clip_factor, finite, norm, shuffle_in_place, told_norm};

pub use config::PpoConfig;
pub use loss::{Losses, Minibatch, loss_and_gradient};
pub use repair::{RepairBy, RepairConfig, Repaired};
pub use rollout::{Rollout, collect};

/// What an update saw and did.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct UpdateMetrics {
    /// Mean reward of a step.
    pub mean_reward: f64,
    /// Episodes that ended.
    pub episodes: usize,
    /// Those that ended solved.
    pub solved: usize,
    /// Their mean number of steps.
    pub episode_length: f64,
    /// Means over all minibatches: the clipped surrogate's loss.
    pub policy_loss: f64,
    /// The value loss, before its coefficient.
    pub value_loss: f64,
    /// The policy's entropy after the update.
    pub entropy: f64,
    /// Approximate KL from the old policy.
    pub approx_kl: f64,
    /// Share of the steps whose ratio was outside the clip range.
    pub clip_fraction: f64,
    /// Norm of the gradient before clipping.
    pub gradient_norm: f64,
    /// 1 - var(return - value) / var(return), with the values before the update.
    pub explained_variance: f64,
    /// Learning rate used.
    pub learning_rate: f64,
    /// Optimizer steps made; fewer than planned where the target KL ended the update.
    pub minibatches: usize,
    /// Failed episodes that an expert was asked to repair, and those that it did.
    #[serde(default)]
    pub failed: usize,
    /// See `failed`.
    #[serde(default)]
    pub repaired: usize,
    /// Mean squared error against the repaired episodes; 0 without any.
    #[serde(default)]
    pub repair_loss: f64,
}

/// `config.epochs` passes of optimizer steps over what [`collect`] gathered, with `demonstrations`
/// from repaired episodes and the weight of their loss.
pub fn update(
    agent: &mut Agent,
    optimizer: &mut Optimizer,
    rollouts: &[Rollout],
    (demonstrations, weight): (&Repaired, f32),
    config: &PpoConfig,
    learning_rate: f64,
    shuffle: &mut ChaCha8Rng,
) -> UpdateMetrics {
    let mut metrics = UpdateMetrics { learning_rate, ..rollout::summary(rollouts) };
    (metrics.failed, metrics.repaired) = (demonstrations.failed, demonstrations.repaired);
    let mut teacher = Teacher::new(demonstrations, agent, config.minibatch);
    let (mut batch, mut gradient) = (Minibatch::default(), Gradient::default());
    let mut order: Vec<u32> = (0..(rollouts.len() * config.steps) as u32).collect();
    'epochs: for _ in 0..config.epochs {
        shuffle_in_place(&mut order, shuffle);
        for rows in order.chunks(config.minibatch) {
            rollout::gather(&mut batch, rollouts, config.steps, rows, agent);
            let losses = loss_and_gradient(agent, &batch, config, &mut gradient);
            if config.target_kl.is_some_and(|target| losses.approx_kl > 1.5 * target) {
                break 'epochs;
            }
            metrics.repair_loss += teacher.add_gradient(agent, weight, shuffle, &mut gradient);
            let norm = norm(gradient.values());
            let scale = clip_factor(norm, config.max_gradient_norm);
            agent.step(optimizer, learning_rate, scale, gradient.values());
            metrics.minibatches += 1;
            metrics.policy_loss += losses.policy;
            metrics.value_loss += losses.value;
            metrics.approx_kl += losses.approx_kl;
            metrics.clip_fraction += losses.clip_fraction;
            metrics.gradient_norm += match norm.is_finite() {
                true => f64::from(norm),
                false => told_norm(norm, gradient.values()),
            };
        }
    }
    let count = metrics.minibatches.max(1) as f64;
    for mean in [
        &mut metrics.policy_loss,
        &mut metrics.value_loss,
        &mut metrics.approx_kl,
        &mut metrics.clip_fraction,
        &mut metrics.gradient_norm,
        &mut metrics.repair_loss,
    ] {
        *mean = finite(*mean / count);
    }
    metrics.entropy = f64::from(gaussian::entropy(&agent.log_std));
    metrics
}

/// Hands out demonstrations, as many per minibatch as the minibatch has steps, in a new order each
/// time they are through.
struct Teacher<'a> {
    samples: &'a Samples,
    order: Vec<u32>,
    next: usize,
    minibatch: usize,
    batch: Samples,
    gradient: Gradient,
}

impl<'a> Teacher<'a> {
    fn new(demonstrations: &'a Repaired, agent: &Agent, minibatch: usize) -> Self {
        let samples = &demonstrations.samples;
        let order: Vec<u32> = (0..(samples.targets.len() / agent.actions()) as u32).collect();
        let next = order.len();
        Self {
            samples,
            order,
            next,
            minibatch,
            batch: Samples::default(),
            gradient: Gradient::default(),
        }
    }

    /// Adds `weight` times the gradient of the demonstrations' loss to `gradient`; returns the
    /// loss.
    fn add_gradient(
        &mut self,
        agent: &Agent,
        weight: f32,
        shuffle: &mut ChaCha8Rng,
        gradient: &mut Gradient,
    ) -> f64 {
        if self.order.is_empty() {
            return 0.0;
        }
        if self.next >= self.order.len() {
            shuffle_in_place(&mut self.order, shuffle);
            self.next = 0;
        }
        let end = self.order.len().min(self.next + self.minibatch);
        self.samples.gather(&self.order[self.next..end], agent, &mut self.batch);
        self.next = end;
        let loss = cloning::loss_and_gradient(agent, &self.batch, &[], &mut self.gradient);
        let added = self.gradient.values().iter();
        gradient.values_mut().iter_mut().zip(added).for_each(|(g, a)| *g += weight * a);
        loss
    }
}
