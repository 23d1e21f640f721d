//! DAgger: imitation on the states that the policy itself comes to (S. Ross, G. Gordon and J. A.
//! Bagnell, A reduction of imitation learning and structured prediction to no-regret online
//! learning, AISTATS 2011, algorithm 3.1).
//!
//! ```text
//! round i:  roll in with pi_i = beta_i expert + (1 - beta_i) policy,  beta_i = beta^(i - 1)
//!           ask the expert for its answer at every state;  aggregate;  train on the aggregate
//! ```
//!
//! The paper names it as the cure for its agents with wide observations, whose pretraining on
//! random trajectories says little about the trajectories that they meet (section IV). Each step of
//! a rollout is the expert's with probability beta_i. A rollout begins at the straight line or at a
//! random start, and ends where it is feasible, as planning does. Where this departs from the
//! algorithm: training goes on from the last round's parameters for a fixed number of minibatches
//! instead of beginning anew, and the aggregate forgets its oldest states beyond a capacity.

mod states;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sidestep::network::Scratch;
use sidestep::plan::starts::StartStrategy;
use sidestep::policy::ActionRule;
use sidestep::rng::{Purpose, stream};

use crate::environments::Problem;
use crate::paper::agent::{Agent, Gradient};
use crate::paper::expert::{ExpertKind, Experts};
use crate::paper::stages::cloning::{self, Samples};
use crate::parameters::{Optimizer, Schedule, clip_factor, finite, norm, shuffle_in_place};
use sidestep::rng::standard_normal;

pub use states::States;

/// Settings of DAgger.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DaggerConfig {
    /// Rounds; 0 leaves DAgger out.
    #[schemars(range(min = 0, max = 100_000))]
    pub rounds: usize,
    /// Whom to imitate.
    pub expert: ExpertKind,
    /// Rollouts per round, one task each; the rounds pass through the training tasks in turn.
    #[schemars(range(min = 1, max = 100_000))]
    pub rollouts: usize,
    /// Most steps of a rollout.
    #[schemars(range(min = 1, max = 10_000))]
    pub steps: usize,
    /// The expert's share in round i is `beta^(i - 1)`: the first round is all the expert's.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub beta: f64,
    /// Share of the rollouts that begin at a random start and not at the straight line.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub random_starts: f64,
    /// How random starts are drawn, as `cloning.starts`.
    pub starts: String,
    /// Standard deviation of noise on the policy's actions, in units of the network's output.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub noise: f32,
    /// Most states in the aggregate; the oldest are forgotten.
    #[schemars(range(min = 1, max = 4_000_000))]
    pub capacity: usize,
    /// Minibatches per round.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub minibatches: usize,
    /// States per minibatch.
    #[schemars(range(min = 1, max = 4096))]
    pub minibatch: usize,
    /// Learning rate of Adam at the start.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1000.0))]
    pub learning_rate: f64,
    /// How the learning rate falls over the rounds.
    pub schedule: Schedule,
}

impl Default for DaggerConfig {
    fn default() -> Self {
        Self {
            rounds: 0,
            expert: ExpertKind::default(),
            rollouts: 200,
            steps: 20,
            beta: 0.5,
            random_starts: 0.5,
            starts: "via-point".into(),
            noise: 0.05,
            capacity: 100_000,
            minibatches: 200,
            minibatch: 128,
            learning_rate: 1e-3,
            schedule: Schedule::Cosine,
        }
    }
}

/// What the rollouts of a training are made with.
#[derive(Debug, Clone, Copy)]
pub struct Surroundings<'a> {
    /// The training tasks, made ready.
    pub problems: &'a [Problem],
    /// Their experts.
    pub experts: &'a Experts,
    /// What an action means.
    pub rule: ActionRule,
    /// How random starts are drawn.
    pub starts: StartStrategy,
    /// Seed of all streams.
    pub seed: u64,
}

/// Rolls in for round `round` (from 0) and returns the states met, with the expert's answers.
pub fn collect(agent: &Agent, around: Surroundings, config: &DaggerConfig, round: u64) -> States {
    let one = |scratch: &mut Scratch, rollout: usize| {
        let task = (round as usize * config.rollouts + rollout) % around.problems.len();
        let rng = stream(around.seed, Purpose::Dagger, round, rollout as u64);
        roll_in(agent, around, config, round, task, rng, scratch)
    };
    let met: Vec<States> =
        (0..config.rollouts).into_par_iter().map_init(Scratch::default, one).collect();
    let mut all = States::default();
    for states in met {
        all.append(states, usize::MAX);
    }
    all
}

fn roll_in(
    agent: &Agent,
    around: Surroundings,
    config: &DaggerConfig,
    round: u64,
    task: usize,
    mut rng: ChaCha8Rng,
    scratch: &mut Scratch,
) -> States {
    let mut problem = around.problems[task].clone();
    let mut x = vec![0.0; problem.objective.dim()];
    let beta = config.beta.powi(i32::try_from(round).unwrap_or(i32::MAX));
    let mut states = States::default();
    if rng.random::<f64>() < config.random_starts {
        around.starts.draw(&problem.objective, &mut rng, &mut x);
    } else {
        problem.objective.straight_line(&mut x);
    }
    problem.encoder.reset();
    let (experts, kind) = (around.experts, config.expert);
    problem.walk(&mut x, config.steps, around.rule, |place, action| {
        if !experts.answer(kind, task, place.problem, place.x, place.gradient, action) {
            return false;
        }
        states.push(task, place.x, place.memory, action);
        if rng.random::<f64>() >= beta {
            agent.policy.forward(place.observation, scratch, action);
            for pair in action.chunks_mut(2) {
                let noise = standard_normal(&mut rng);
                pair.iter_mut().zip(noise).for_each(|(a, z)| *a += config.noise * z);
            }
        }
        true
    });
    states
}

/// How far one optimizer step goes.
#[derive(Debug, Clone, Copy)]
pub struct Rate {
    /// Learning rate.
    pub learning_rate: f64,
    /// Largest norm of the gradient.
    pub max_gradient_norm: f32,
}

/// States observed at once: bounds the memory that images take (64 MB).
const BLOCK: usize = 4096;

/// Trains on `config.minibatches` minibatches of the aggregate, in a new order each time it is
/// through; returns their losses.
pub fn train(
    agent: &mut Agent,
    optimizer: &mut Optimizer,
    (states, problems): (&States, &[Problem]),
    config: &DaggerConfig,
    rate: Rate,
    shuffle: &mut ChaCha8Rng,
) -> Vec<f64> {
    let mut losses = Vec::with_capacity(config.minibatches);
    let mut order: Vec<u32> = (0..states.len() as u32).collect();
    let (mut batch, mut gradient) = (Samples::default(), Gradient::default());
    let (wide, acts) = (agent.observations(), agent.actions());
    let per_block = (BLOCK / config.minibatch).max(1) * config.minibatch;
    while !order.is_empty() && losses.len() < config.minibatches {
        shuffle_in_place(&mut order, shuffle);
        for block in order.chunks(per_block) {
            let left = config.minibatches - losses.len();
            let block = &block[..block.len().min(left * config.minibatch)];
            let samples = states.observe(block, problems);
            for first in (0..block.len()).step_by(config.minibatch) {
                let rows = first..block.len().min(first + config.minibatch);
                batch.observations.clear();
                batch.targets.clear();
                let seen = &samples.observations[rows.start * wide..rows.end * wide];
                batch.observations.extend_from_slice(seen);
                let targets = &samples.targets[rows.start * acts..rows.end * acts];
                batch.targets.extend_from_slice(targets);
                let loss = cloning::loss_and_gradient(agent, &batch, &[], &mut gradient);
                let norm = norm(gradient.values());
                let scale = clip_factor(norm, rate.max_gradient_norm);
                agent.step(optimizer, rate.learning_rate, scale, gradient.values());
                losses.push(finite(loss));
            }
        }
    }
    losses
}
