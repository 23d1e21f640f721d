//! What training changes: a policy network, a value network and the log-std of the actions; and
//! the gradient of a loss with respect to all of them, as one flat vector.
//!
//! The order in the flat vector is policy, value, log-std. No layer is shared (paper, section II.B).

use std::ops::Range;

use rayon::prelude::*;
use sidestep::InvalidInput;
use sidestep::network::{Mlp, Scratch};
use sidestep::rng::{Purpose, stream};

use crate::initialization::{Initialization, Role};
use crate::optimizer::Optimizer;

/// Policy, value and log-std.
#[derive(Debug, Clone, PartialEq)]
pub struct Agent {
    /// From observation to the mean of the action.
    pub policy: Mlp,
    /// From observation to the expected return.
    pub value: Mlp,
    /// Log-std of each action coordinate, `[actions]`.
    pub log_std: Vec<f32>,
}

impl Agent {
    /// A new agent with networks `[observation, hidden, hidden, actions]` and `[observation, hidden, hidden, 1]`.
    ///
    /// # Errors
    /// If a size is 0 or too large.
    pub fn new(
        observation: usize,
        hidden: usize,
        actions: usize,
        initialization: Initialization,
        initial_log_std: f32,
        seed: u64,
    ) -> Result<Self, InvalidInput> {
        let network = |outputs: usize, role: Role, index: u64| {
            let mut rng = stream(seed, Purpose::Parameters, index, 0);
            initialization.network(&[observation, hidden, hidden, outputs], role, &mut rng)
        };
        Ok(Self {
            policy: network(actions, Role::Policy, 0)?,
            value: network(1, Role::Value, 1)?,
            log_std: vec![initial_log_std; actions],
        })
    }

    /// Length of the observation.
    pub fn observations(&self) -> usize {
        self.policy.inputs()
    }

    /// Number of action coordinates.
    pub fn actions(&self) -> usize {
        self.log_std.len()
    }

    /// Length of the flat parameter vector.
    pub fn parameter_count(&self) -> usize {
        self.policy.parameters().len() + self.value.parameters().len() + self.log_std.len()
    }

    /// One optimizer step along the flat `gradient`, scaled by `scale`.
    pub fn step(
        &mut self,
        optimizer: &mut Optimizer,
        learning_rate: f64,
        scale: f32,
        gradient: &[f32],
    ) {
        let Self { policy, value, log_std } = self;
        policy.update(|policy| {
            value.update(|value| {
                optimizer.step(learning_rate, scale, gradient, &mut [policy, value, log_std]);
            });
        });
    }

    fn split<'a>(&self, flat: &'a mut [f32]) -> [&'a mut [f32]; 3] {
        let (policy, rest) = flat.split_at_mut(self.policy.parameters().len());
        let (value, log_std) = rest.split_at_mut(self.value.parameters().len());
        [policy, value, log_std]
    }
}

/// Rows per chunk. A minibatch of up to so many stays on one thread; larger ones are spread over the
/// threads chunk by chunk and added up in order, so the bits do not depend on the threads.
pub const CHUNK: usize = 64;

/// Chunks in flight at once; bounds the memory of their gradients.
const WAVE: usize = 16;

/// Sums over the rows of a minibatch, for losses and diagnostics.
pub type Sums = [f64; 4];

/// Buffers for one chunk's forward and backward passes.
#[derive(Debug, Default)]
pub struct Worker {
    /// Activations of the policy.
    pub policy: Scratch,
    /// Activations of the value network.
    pub value: Scratch,
    /// Gradient of the loss with respect to the policy's outputs, `[rows x actions]`.
    pub mean_gradient: Vec<f32>,
    /// The same for the value network, `[rows]`.
    pub value_gradient: Vec<f32>,
    gradient: Vec<f32>,
    sums: Sums,
}

impl Worker {
    /// Adds the chunk's gradients to its share of the flat gradient, given the filled output gradients; a network that
    /// was not run (`rows` 0 in its scratch) adds nothing.
    pub fn backward(&mut self, agent: &Agent) {
        let [policy, value, _] = agent.split(&mut self.gradient);
        if self.policy.rows() > 0 {
            agent.policy.backward(&self.mean_gradient, &mut self.policy, policy);
        }
        if self.value.rows() > 0 {
            agent.value.backward(&self.value_gradient, &mut self.value, value);
        }
    }

    /// The log-std's part of the flat gradient, `[actions]`.
    pub fn log_std_gradient(&mut self, agent: &Agent) -> &mut [f32] {
        let [.., log_std] = agent.split(&mut self.gradient);
        log_std
    }
}

/// The gradient of a minibatch's loss, and the buffers it is computed with.
#[derive(Debug, Default)]
pub struct Gradient {
    workers: Vec<Worker>,
    total: Vec<f32>,
}

impl Gradient {
    /// The flat gradient `[parameters]` of the last accumulation.
    pub fn values(&self) -> &[f32] {
        &self.total
    }

    /// The same, to be changed.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.total
    }

    /// Runs `chunk(rows, worker)` for chunks of `0..rows`, `rows > 0`, and adds up their gradients and sums in order.
    pub fn accumulate(
        &mut self,
        agent: &Agent,
        rows: usize,
        chunk: impl Fn(Range<usize>, &mut Worker) -> Sums + Sync,
    ) -> Sums {
        let parameters = agent.parameter_count();
        let chunks = rows.div_ceil(CHUNK);
        self.workers.resize_with(WAVE.min(chunks).max(self.workers.len()), Worker::default);
        let mut sums = Sums::default();
        let run = |index: usize, worker: &mut Worker| {
            worker.gradient.clear();
            worker.gradient.resize(parameters, 0.0);
            worker.sums = chunk(index * CHUNK..rows.min((index + 1) * CHUNK), worker);
        };
        let mut first = 0;
        while first < chunks {
            let count = WAVE.min(chunks - first);
            let wave = &mut self.workers[..count];
            if count == 1 {
                run(first, &mut wave[0]);
            } else {
                wave.par_iter_mut().enumerate().for_each(|(i, worker)| run(first + i, worker));
            }
            for (index, worker) in wave.iter_mut().enumerate() {
                sums.iter_mut().zip(worker.sums).for_each(|(t, s)| *t += s);
                if first + index == 0 {
                    std::mem::swap(&mut self.total, &mut worker.gradient);
                    continue;
                }
                self.total.iter_mut().zip(&worker.gradient).for_each(|(t, g)| *t += g);
            }
            first += count;
        }
        sums
    }
}
