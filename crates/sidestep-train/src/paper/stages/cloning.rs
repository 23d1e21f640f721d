//! Behaviour cloning: the policy learns to answer like gradient descent before PPO begins (paper,
//! section II.B).
//!
//! ```text
//! loss = mean over samples and coordinates of (prediction - target)^2,   target = -gamma dU/dxi
//! ```
//!
//! The paper draws 100 random trajectories for each of 100 tasks and makes one epoch in minibatches
//! of 64 with Adadelta. Its text clones the policy's output; its code cloned a *sample* of the
//! policy, mean + exp(log-std) noise, which adds noise to every gradient and moves log-std as well.
//! Both are here ([`Prediction`]).

use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sidestep::plan::starts::StartStrategy;
use sidestep::rng::{Purpose, stream};

use crate::environments::Problem;
use crate::paper::agent::{Agent, Gradient, Sums, Worker};
use crate::parameters::{Optimizer, OptimizerKind, finite, shuffle_in_place};
use sidestep::rng::standard_normal;

/// What is compared with the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Prediction {
    /// The policy's mean.
    #[default]
    Mean,
    /// A sample of the policy, as the paper's code did.
    Sampled,
}

/// Settings of cloning. The defaults are the paper's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct CloningConfig {
    /// Passes over the samples; 0 leaves cloning out.
    #[schemars(range(min = 0, max = 1_000_000))]
    pub epochs: usize,
    /// Random trajectories per task.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub samples_per_task: usize,
    /// Step gamma of the gradient descent that is cloned.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1000.0))]
    pub step: f32,
    /// How trajectories are drawn: `line`, `via-point`, `sorted`, `random` or `paper`.
    pub starts: String,
    /// Samples per optimizer step.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub minibatch: usize,
    /// Which optimizer.
    pub optimizer: OptimizerKind,
    /// Learning rate of the optimizer.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1000.0))]
    pub learning_rate: f64,
    /// What is compared with the target.
    pub prediction: Prediction,
}

impl Default for CloningConfig {
    fn default() -> Self {
        Self {
            epochs: 1,
            samples_per_task: 100,
            step: 0.1,
            starts: "random".into(),
            minibatch: 64,
            optimizer: OptimizerKind::Adadelta,
            learning_rate: 1.0,
            prediction: Prediction::Mean,
        }
    }
}

/// Pairs of observation and target.
#[derive(Debug, Clone, Default)]
pub struct Samples {
    /// `[samples x observations]`.
    pub observations: Vec<f32>,
    /// `[samples x actions]`.
    pub targets: Vec<f32>,
}

impl Samples {
    /// Copies the samples `rows`, in that order, to `batch`.
    pub fn gather(&self, rows: &[u32], agent: &Agent, batch: &mut Self) {
        let (wide, acts) = (agent.observations(), agent.actions());
        batch.observations.clear();
        batch.targets.clear();
        for &row in rows {
            let row = row as usize;
            batch.observations.extend_from_slice(&self.observations[row * wide..][..wide]);
            batch.targets.extend_from_slice(&self.targets[row * acts..][..acts]);
        }
    }
}

/// Draws `config.samples_per_task` trajectories for each problem, and what gradient descent would
/// do there.
///
/// Trajectory i of task k has the stream (seed, imitation, k, i).
pub fn draw_samples(
    problems: &[Problem],
    strategy: StartStrategy,
    config: &CloningConfig,
    seed: u64,
) -> Samples {
    let per_task: Vec<Samples> = problems
        .par_iter()
        .enumerate()
        .map(|(task, problem)| {
            let mut problem = problem.clone();
            let (dim, wide) = (problem.objective.dim(), problem.encoder.len(&problem.objective));
            let mut samples = Samples::default();
            let (mut x, mut gradient, mut seen) = (vec![0.0; dim], vec![0.0; dim], vec![0.0; wide]);
            for sample in 0..config.samples_per_task {
                let mut rng = stream(seed, Purpose::Imitation, task as u64, sample as u64);
                strategy.draw(&problem.objective, &mut rng, &mut x);
                problem.encoder.reset();
                problem.observe(&x, &mut gradient, &mut seen);
                samples.observations.extend_from_slice(&seen);
                samples.targets.extend(gradient.iter().map(|g| -config.step * g));
            }
            samples
        })
        .collect();
    let mut all = Samples::default();
    for samples in per_task {
        all.observations.extend(samples.observations);
        all.targets.extend(samples.targets);
    }
    all
}

/// One epoch over the samples in a new order; returns the loss of each minibatch, the learning
/// curve.
pub fn epoch(
    agent: &mut Agent,
    optimizer: &mut Optimizer,
    samples: &Samples,
    config: &CloningConfig,
    shuffle: &mut ChaCha8Rng,
) -> Vec<f64> {
    let acts = agent.actions();
    let mut order: Vec<u32> = (0..(samples.targets.len() / acts) as u32).collect();
    shuffle_in_place(&mut order, shuffle);
    let (mut batch, mut noise, mut gradient) =
        (Samples::default(), Vec::new(), Gradient::default());
    let mut curve = Vec::with_capacity(order.len().div_ceil(config.minibatch));
    for rows in order.chunks(config.minibatch) {
        samples.gather(rows, agent, &mut batch);
        noise.clear();
        if config.prediction == Prediction::Sampled {
            let pairs = (rows.len() * acts).div_ceil(2);
            noise.extend((0..pairs).flat_map(|_| standard_normal(shuffle)));
        }
        let loss = loss_and_gradient(agent, &batch, &noise, &mut gradient);
        agent.step(optimizer, config.learning_rate, 1.0, gradient.values());
        curve.push(finite(loss));
    }
    curve
}

/// The loss of a batch; its gradient is left in `gradient`. `noise [rows x actions]` is standard
/// normal for [`Prediction::Sampled`], and empty for [`Prediction::Mean`].
///
/// ```text
/// prediction = mean + exp(s) noise;   d loss / d mean = 2 error / count;   d loss / d s = sum of that * exp(s) noise
/// ```
pub fn loss_and_gradient(
    agent: &Agent,
    batch: &Samples,
    noise: &[f32],
    gradient: &mut Gradient,
) -> f64 {
    let (wide, acts, count) = (agent.observations(), agent.actions(), batch.targets.len());
    let share = 2.0 / count as f32;
    let sums = gradient.accumulate(agent, count / acts, |range, worker: &mut Worker| {
        let observations = &batch.observations[range.start * wide..range.end * wide];
        agent.policy.forward_batch(observations, &mut worker.policy);
        worker.mean_gradient.resize(range.len() * acts, 0.0);
        let mut log_std_gradient = vec![0.0; acts];
        let mut sum = 0.0;
        for (local, row) in range.enumerate() {
            let mean = worker.policy.output(local);
            for j in 0..acts {
                let drawn = noise.get(row * acts + j).map_or(0.0, |z| agent.log_std[j].exp() * z);
                let error = mean[j] + drawn - batch.targets[row * acts + j];
                worker.mean_gradient[local * acts + j] = share * error;
                log_std_gradient[j] += share * error * drawn;
                sum += f64::from(error) * f64::from(error);
            }
        }
        worker.log_std_gradient(agent).copy_from_slice(&log_std_gradient);
        worker.backward(agent);
        [sum, 0.0, 0.0, 0.0] as Sums
    });
    sums[0] / count as f64
}
