//! What training changes: a policy network, a value network and the log-std of the actions; and
//! the gradient of a loss with respect to all of them, as one flat vector.
//!
//! The order in the flat vector is policy, value, log-std. No dense layer is shared (paper, section
//! II.B); an image's convolutions are: they belong to the policy, and the value network reads what
//! they make of it (section III.E).

use std::ops::Range;

use rayon::prelude::*;
use sidestep::InvalidInput;
use sidestep::network::{Cnn, FEATURES, Mlp, Network, Scratch};
use sidestep::policy::observation::ObservationPart;
use sidestep::rng::{Purpose, stream};

use crate::parameters::{Initialization, Optimizer, Role};

/// Policy, value and log-std.
#[derive(Debug, Clone, PartialEq)]
pub struct Agent {
    /// From observation to the mean of the action.
    pub policy: Network,
    /// From observation, or from the features of its image, to the expected return.
    pub value: Mlp,
    /// Log-std of each action coordinate, `[actions]`.
    pub log_std: Vec<f32>,
}

impl Agent {
    /// A new agent with networks `[observation, hidden, hidden, actions]` and `[observation,
    /// hidden, hidden, 1]`.
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
        let mut rng = stream(seed, Purpose::Parameters, 0, 0);
        let sizes = [observation, hidden, hidden, actions];
        let policy = initialization.network(&sizes, Role::Policy, &mut rng)?;
        Self::with_policy(policy.into(), hidden, initialization, initial_log_std, seed)
    }

    /// A new agent whose policy sees `parts` of so many waypoints; its value network has hidden
    /// layers of the same size.
    ///
    /// # Errors
    /// If a size is 0 or too large.
    pub fn seeing(
        parts: &[ObservationPart],
        waypoints: usize,
        hidden: usize,
        initialization: Initialization,
        initial_log_std: f32,
        seed: u64,
    ) -> Result<Self, InvalidInput> {
        let mut rng = stream(seed, Purpose::Parameters, 0, 0);
        let policy = initialization.policy(parts, waypoints, hidden, &mut rng)?;
        Self::with_policy(policy, hidden, initialization, initial_log_std, seed)
    }

    fn with_policy(
        policy: Network,
        hidden: usize,
        initialization: Initialization,
        initial_log_std: f32,
        seed: u64,
    ) -> Result<Self, InvalidInput> {
        let mut rng = stream(seed, Purpose::Parameters, 1, 0);
        let sizes = [value_inputs(&policy), hidden, hidden, 1];
        let value = initialization.network(&sizes, Role::Value, &mut rng)?;
        Ok(Self { log_std: vec![initial_log_std; policy.outputs()], policy, value })
    }

    /// The policy's means for `observations [rows x observations]`, left in `policy`, and the
    /// values, left in `value`.
    pub fn evaluate(&self, observations: &[f32], policy: &mut Scratch, value: &mut Scratch) {
        self.policy.forward_batch(observations, policy);
        match &self.policy {
            Network::Mlp(_) => self.value.forward_batch(observations, value),
            Network::Cnn(_) => self.value.forward_batch(Cnn::features(policy), value),
        }
    }

    /// The value of one observation.
    pub fn value_of(&self, observation: &[f32], policy: &mut Scratch, value: &mut Scratch) -> f32 {
        match &self.policy {
            Network::Mlp(_) => self.value.forward_batch(observation, value),
            Network::Cnn(_) => self.evaluate(observation, policy, value),
        }
        value.output(0)[0]
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

/// Numbers that the value network beside this policy reads.
fn value_inputs(policy: &Network) -> usize {
    match policy {
        Network::Mlp(mlp) => mlp.inputs(),
        Network::Cnn(_) => FEATURES,
    }
}

/// Rows per chunk. A minibatch of up to so many stays on one thread; larger ones are spread over
/// the threads chunk by chunk and added up in order, so the bits do not depend on the threads.
pub const CHUNK: usize = 64;

/// Chunks in flight at once; bounds the memory of their gradients.
pub const WAVE: usize = 16;

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
    /// Adds the chunk's gradients to its share of the flat gradient, given the filled output
    /// gradients; a network that was not run (`rows` 0 in its scratch) adds nothing.
    pub fn backward(&mut self, agent: &Agent) {
        let [policy, value, _] = agent.split(&mut self.gradient);
        let valued = self.value.rows() > 0;
        if valued {
            agent.value.backward(&self.value_gradient, &mut self.value, value);
        }
        if self.policy.rows() > 0 {
            let (means, scratch) = (&self.mean_gradient, &mut self.policy);
            match &agent.policy {
                Network::Mlp(mlp) => mlp.backward(means, scratch, policy),
                Network::Cnn(cnn) => {
                    if valued {
                        agent.value.input_gradient(&mut self.value);
                    }
                    let features = valued.then(|| self.value.input_gradient());
                    cnn.backward(means, features, scratch, policy);
                }
            }
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

    /// Runs `chunk(rows, worker)` for chunks of `0..rows`, `rows > 0`, and adds up their gradients
    /// and sums in order.
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
