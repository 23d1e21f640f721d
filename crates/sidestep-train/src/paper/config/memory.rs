//! The memory that a training of the paper's system takes.

use sidestep::InvalidInput;
use sidestep::policy::observation::ObservationPart;

use super::TrainConfig;
use crate::config::memory::{NUMBER, Part, TASK, check as check_parts};
use crate::paper::agent::{CHUNK, WAVE};

/// Checks counts times sizes, for `observation` numbers of so many waypoints.
pub(super) fn check(
    config: &TrainConfig,
    observation: usize,
    seen_parts: &[ObservationPart],
    waypoints: usize,
) -> Result<(), InvalidInput> {
    let TrainConfig { training, network, cloning, dagger, ppo, repair, validation, .. } = config;
    let [seen, acts, hidden] = [observation, 2 * waypoints, network.hidden].map(|n| n as f64);
    let [tasks, environments, steps] =
        [training.count, ppo.environments, ppo.steps].map(|n| n as f64);
    // What an encoder draws and remembers is at most a few times as large as what it writes.
    let task = TASK + 4.0 * NUMBER * seen;
    let pair = NUMBER * (seen + acts);
    let state = NUMBER * (1.0 + 2.0 * acts + remembered(seen_parts, waypoints) as f64);
    let parameters = 2.0 * (seen * hidden + hidden * hidden) + hidden * acts;
    let largest = ppo.minibatch.max(cloning.minibatch).max(dagger.minibatch);
    let workers = largest.div_ceil(CHUNK).min(WAVE) as f64;
    // Parameters and two moments, again as they were before a unit, the best, and their bytes in a
    // checkpoint.
    let copies = 12.0 + workers;
    let failed = environments
        * config.environment.episode_limit.map_or(1.0, |limit| steps / f64::from(limit) + 1.0);
    let part = |key, value, bytes| Part { key, value, bytes };
    let mut parts = vec![
        part("training.count", training.count, tasks * task),
        part("validation.count", validation.count, validation.count as f64 * task),
        part("network.hidden", network.hidden, copies * NUMBER * parameters),
        part("ppo.environments", ppo.environments, environments * 2.0 * task),
        part("ppo.steps", ppo.steps, environments * steps * (pair + NUMBER * (acts + 6.0))),
    ];
    if cloning.epochs > 0 {
        let samples = tasks * cloning.samples_per_task as f64;
        let value = cloning.samples_per_task;
        parts.push(part("cloning.samples_per_task", value, 2.0 * samples * pair));
    }
    if dagger.rounds > 0 {
        let met = (dagger.rollouts * dagger.steps) as f64;
        parts.push(part("dagger.capacity", dagger.capacity, 2.0 * dagger.capacity as f64 * state));
        parts.push(part("dagger.rollouts", dagger.rollouts, 2.0 * met * state));
    }
    if repair.expert.expert().is_some() {
        let walked = 2.0 * failed * repair.steps as f64;
        parts.push(part("repair.steps", repair.steps, 2.0 * walked * pair));
    }
    check_parts(&parts)
}

/// Numbers that an encoder of these parts remembers.
fn remembered(parts: &[ObservationPart], waypoints: usize) -> usize {
    let gradients = |part: &ObservationPart| match part {
        ObservationPart::PreviousGradients { count } => *count,
        _ => 0,
    };
    2 * waypoints * parts.iter().map(gradients).sum::<usize>()
}
