//! Collecting experience: every environment takes the same number of steps under the current
//! policy.

use rayon::prelude::*;
use sidestep::network::Scratch;

use super::advantage::{Steps, generalised_advantages};
use super::loss::Minibatch;
use super::{PpoConfig, UpdateMetrics};
use crate::environments::{Environments, Stuck};
use crate::paper::agent::Agent;
use crate::paper::gaussian::{self, Density};
use crate::parameters::finite;

/// One environment's steps of one update; each slice has one entry (or row) per step, in order.
#[derive(Debug, Clone, Default)]
pub struct Rollout {
    observations: Vec<f32>,
    actions: Vec<f32>,
    log_probs: Vec<f32>,
    values: Vec<f32>,
    rewards: Vec<f32>,
    dones: Vec<bool>,
    advantages: Vec<f32>,
    returns: Vec<f32>,
    /// Of each episode that ended: its steps, and whether it was solved.
    episodes: Vec<(u32, bool)>,
    /// Where episodes were that the time limit cut off.
    stuck: Vec<Stuck>,
}

/// Runs every environment for `config.steps` steps, and estimates advantages and returns.
pub fn collect(
    agent: &Agent,
    environments: &mut Environments,
    config: &PpoConfig,
    rollouts: &mut Vec<Rollout>,
) {
    let density = Density::new(&agent.log_std);
    rollouts.resize_with(environments.len(), Rollout::default);
    let groups = environments.groups().zip(rollouts.par_chunks_mut(Environments::group_size()));
    groups.for_each(|(mut group, rollouts)| {
        let (mut policy, mut value) = <(Scratch, Scratch)>::default();
        let mut alone = <(Scratch, Scratch)>::default();
        let mut observations = Vec::new();
        let mut action = vec![0.0; agent.actions()];
        rollouts.iter_mut().for_each(Rollout::clear);
        for _ in 0..config.steps {
            observations.clear();
            group.all.iter().for_each(|env| observations.extend_from_slice(env.observation()));
            agent.evaluate(&observations, &mut policy, &mut value);
            for (row, rollout) in rollouts.iter_mut().enumerate() {
                let (mean, env) = (policy.output(row), &mut group.all[row]);
                gaussian::sample(mean, &agent.log_std, &mut env.rng, &mut action);
                rollout.observations.extend_from_slice(env.observation());
                rollout.actions.extend_from_slice(&action);
                rollout.log_probs.push(density.log_prob(&action, mean));
                rollout.values.push(value.output(row)[0]);
                let outcome = group.step(row, &action);
                let (mut reward, env) = (outcome.reward, &group.all[row]);
                if outcome.truncated {
                    rollout.stuck.push(env.stuck());
                    // The rest of an episode that was cut off is worth what the value network says.
                    let rest = agent.value_of(env.observation(), &mut alone.0, &mut alone.1);
                    reward += config.gamma * rest;
                }
                rollout.rewards.push(reward);
                rollout.dones.push(outcome.done());
                if outcome.done() {
                    rollout.episodes.push((outcome.age, outcome.solved));
                    group.reset(row);
                }
            }
        }
        for (env, rollout) in group.all.iter().zip(rollouts) {
            let rest = agent.value_of(env.observation(), &mut alone.0, &mut alone.1);
            rollout.estimate(rest, config);
        }
    });
}

impl Rollout {
    fn clear(&mut self) {
        for buffer in [
            &mut self.observations,
            &mut self.actions,
            &mut self.log_probs,
            &mut self.values,
            &mut self.rewards,
        ] {
            buffer.clear();
        }
        self.dones.clear();
        self.episodes.clear();
        self.stuck.clear();
    }

    /// Where episodes were that the time limit cut off.
    pub fn stuck(&self) -> &[Stuck] {
        &self.stuck
    }

    fn estimate(&mut self, last_value: f32, config: &PpoConfig) {
        self.advantages.resize(self.rewards.len(), 0.0);
        self.returns.resize(self.rewards.len(), 0.0);
        let (rewards, values, dones) = (&self.rewards, &self.values, &self.dones);
        let steps = Steps { rewards, values, dones, last_value };
        let (advantages, returns) = (&mut self.advantages, &mut self.returns);
        generalised_advantages(steps, config.gamma, config.lambda, advantages, returns);
    }
}

/// Fills `batch` with the given steps: number r is step r mod `steps` of environment r / `steps`.
pub(super) fn gather(
    batch: &mut Minibatch,
    rollouts: &[Rollout],
    steps: usize,
    rows: &[u32],
    agent: &Agent,
) {
    let (wide, acts) = (agent.observations(), agent.actions());
    let Minibatch { observations, actions, old_log_probs, advantages, returns } = batch;
    for buffer in
        [&mut *observations, &mut *actions, &mut *old_log_probs, &mut *advantages, &mut *returns]
    {
        buffer.clear();
    }
    for &row in rows {
        let (rollout, t) = (&rollouts[row as usize / steps], row as usize % steps);
        observations.extend_from_slice(&rollout.observations[t * wide..][..wide]);
        actions.extend_from_slice(&rollout.actions[t * acts..][..acts]);
        old_log_probs.push(rollout.log_probs[t]);
        advantages.push(rollout.advantages[t]);
        returns.push(rollout.returns[t]);
    }
}

/// The part of the metrics that the experience alone decides.
pub(super) fn summary(rollouts: &[Rollout]) -> UpdateMetrics {
    let all = |pick: fn(&Rollout) -> &Vec<f32>| {
        rollouts.iter().flat_map(pick).map(|&value| f64::from(value)).collect::<Vec<f64>>()
    };
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let variance = |values: &[f64]| {
        let centre = mean(values);
        mean(&values.iter().map(|value| (value - centre).powi(2)).collect::<Vec<f64>>())
    };
    let returns = all(|rollout| &rollout.returns);
    let errors = all(|rollout| &rollout.advantages);
    let episodes: Vec<(u32, bool)> = rollouts.iter().flat_map(|r| r.episodes.clone()).collect();
    let lengths: Vec<f64> = episodes.iter().map(|&(length, _)| f64::from(length)).collect();
    UpdateMetrics {
        mean_reward: finite(mean(&all(|rollout| &rollout.rewards))),
        episodes: episodes.len(),
        solved: episodes.iter().filter(|(_, solved)| *solved).count(),
        episode_length: mean(&lengths),
        // Of returns that are all the same nothing can be explained; the quotient may overflow
        // then.
        explained_variance: finite(
            1.0 - variance(&errors) / variance(&returns).max(f64::MIN_POSITIVE),
        ),
        ..UpdateMetrics::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environments::Rules;
    use crate::parameters::Initialization;
    use sidestep::policy::ActionRule;
    use sidestep::policy::observation::ObservationPart;
    use sidestep::profile::Profile;
    use sidestep::suite::Suite;

    #[test]
    fn an_episode_that_is_cut_off_is_worth_what_the_value_network_says() {
        let parts = [ObservationPart::Gradient];
        let tasks = Suite::HardTraining.generate(1, 1000, &Profile::PAPER);
        let agent = Agent::new(20, 8, 20, Initialization::Orthogonal, -4.0, 1).unwrap();
        let config = PpoConfig { steps: 1, gamma: 0.9, ..PpoConfig::default() };
        let rules = Rules {
            action: ActionRule::PAPER,
            mu: 0.1,
            feasible_bonus: 0.0,
            episode_limit: Some(1),
        };
        let environments = Environments::new(&tasks, &Profile::PAPER, &parts, rules, 1, 3);
        let mut environments = environments.unwrap();
        let mut by_hand = environments.all()[0].clone();
        let mut rollouts = Vec::new();
        collect(&agent, &mut environments, &config, &mut rollouts);

        let (mut scratch, mut mean, mut value) = (Scratch::default(), [0.0; 20], [0.0]);
        agent.policy.forward(by_hand.observation(), &mut scratch, &mut mean);
        let mut action = [0.0; 20];
        gaussian::sample(&mean, &agent.log_std, &mut by_hand.rng, &mut action);
        let outcome = by_hand.step(&action, &rules);
        assert!(outcome.truncated);
        agent.value.forward(by_hand.observation(), &mut scratch, &mut value);
        let rollout = &rollouts[0];
        assert_eq!(rollout.actions, action);
        assert_eq!(rollout.rewards, [outcome.reward + 0.9 * value[0]]);
        assert_eq!(rollout.advantages, [rollout.rewards[0] - rollout.values[0]]);
        assert_eq!((&rollout.dones, &rollout.episodes), (&vec![true], &vec![(1, false)]));
    }
}
