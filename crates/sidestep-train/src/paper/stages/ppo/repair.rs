//! Repair of failed episodes by an expert (T. Jurgenson and A. Tamar, Harnessing reinforcement
//! learning for neural motion planning, RSS 2019, section IV): what the policy could not solve, an
//! expert planner completes, and the policy learns from that.
//!
//! An episode has failed where the time limit cut it off, or where it is unsolved after `after`
//! steps at an update's end. The expert walks its task once from the straight line and once from
//! where the episode got stuck; each walk that becomes feasible is a demonstration. Demonstrations
//! are no experience of the policy, so they have no place in PPO's surrogate. They join each of its
//! minibatches with a loss of their own:
//!
//! ```text
//! loss = loss of PPO + weight mean(|mean of the policy - expert's answer|^2)
//! ```
//!
//! The environment then goes on to its next task.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sidestep::policy::ActionRule;

use super::Rollout;
use crate::environments::{Environments, Problem, Stuck};
use crate::paper::expert::{ExpertKind, Experts};
use crate::paper::stages::cloning::Samples;

/// Who repairs failed episodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RepairBy {
    /// Nobody.
    #[default]
    None,
    /// [`ExpertKind::GradientDescent`].
    GradientDescent,
    /// [`ExpertKind::TunedGradientDescent`].
    TunedGradientDescent,
    /// [`ExpertKind::ShortestPath`].
    ShortestPath,
}

impl RepairBy {
    /// The expert, if there is one.
    pub fn expert(self) -> Option<ExpertKind> {
        match self {
            Self::None => None,
            Self::GradientDescent => Some(ExpertKind::GradientDescent),
            Self::TunedGradientDescent => Some(ExpertKind::TunedGradientDescent),
            Self::ShortestPath => Some(ExpertKind::ShortestPath),
        }
    }
}

/// Settings of the repair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RepairConfig {
    /// Who repairs; `none` leaves it out.
    pub expert: RepairBy,
    /// Age from which an unsolved episode counts as failed at the end of an update.
    #[schemars(range(min = 1, max = 4_294_967_295_u32))]
    pub after: u32,
    /// Most steps of the expert.
    #[schemars(range(min = 1, max = 10_000))]
    pub steps: usize,
    /// Weight of the demonstrations' loss.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1_000_000.0))]
    pub weight: f32,
}

impl Default for RepairConfig {
    fn default() -> Self {
        Self { expert: RepairBy::None, after: 40, steps: 30, weight: 1.0 }
    }
}

/// The demonstrations of one update.
#[derive(Debug, Clone, Default)]
pub struct Repaired {
    /// What the expert saw and answered.
    pub samples: Samples,
    /// Failed episodes.
    pub failed: usize,
    /// Those of which the expert solved the task at least once.
    pub repaired: usize,
}

/// Repairs the failed episodes of what was just collected, and sends their environments on.
pub fn repair(
    environments: &mut Environments,
    rollouts: &[Rollout],
    experts: &Experts,
    config: &RepairConfig,
) -> Repaired {
    let Some(kind) = config.expert.expert() else { return Repaired::default() };
    let mut failed: Vec<Stuck> = rollouts.iter().flat_map(|r| r.stuck().iter().cloned()).collect();
    for index in 0..environments.len() {
        if environments.all()[index].age() >= config.after {
            failed.push(environments.all()[index].stuck());
            environments.reset(index);
        }
    }
    let (problems, rule) = (environments.problems(), environments.rules().action);
    let walks: Vec<[Option<Samples>; 2]> = failed
        .par_iter()
        .map(|stuck| {
            let walk = |from: Option<&Stuck>| {
                let problem = problems[stuck.task].clone();
                walk(kind, stuck.task, problem, from, experts, rule, config.steps)
            };
            [walk(None), walk(Some(stuck))]
        })
        .collect();
    let repaired = walks.iter().filter(|pair| pair.iter().any(Option::is_some)).count();
    let mut samples = Samples::default();
    for walk in walks.into_iter().flatten().flatten() {
        samples.observations.extend(walk.observations);
        samples.targets.extend(walk.targets);
    }
    Repaired { samples, failed: failed.len(), repaired }
}

/// The expert's walk on a task from where it got stuck, or from the straight line; none if it does
/// not become feasible.
fn walk(
    kind: ExpertKind,
    task: usize,
    mut problem: Problem,
    from: Option<&Stuck>,
    experts: &Experts,
    rule: ActionRule,
    steps: usize,
) -> Option<Samples> {
    let mut x = vec![0.0; problem.objective.dim()];
    problem.encoder.reset();
    match from {
        Some(stuck) => {
            x.copy_from_slice(&stuck.x);
            problem.encoder.restore(&stuck.memory);
        }
        None => problem.objective.straight_line(&mut x),
    }
    let mut samples = Samples::default();
    let solved = problem.walk(&mut x, steps, rule, |place, answer| {
        if !experts.answer(kind, task, place.problem, place.x, place.gradient, answer) {
            return false;
        }
        samples.observations.extend_from_slice(place.observation);
        samples.targets.extend_from_slice(answer);
        true
    });
    solved.map(|_| samples)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::environments::Rules;
    use crate::paper::agent::Agent;
    use crate::paper::expert::ExpertConfig;
    use crate::paper::stages::ppo::{PpoConfig, collect};
    use crate::parameters::Initialization;
    use sidestep::policy::observation::ObservationPart;
    use sidestep::profile::Profile;
    use sidestep::suite::Suite;

    #[test]
    fn failed_episodes_become_demonstrations_and_their_environments_go_on() {
        let parts = [ObservationPart::Gradient, ObservationPart::PreviousGradients { count: 1 }];
        let tasks = Suite::Hard.generate(6, 1000, &Profile::PAPER);
        let rule = ActionRule::PAPER;
        let experts = Experts::new(tasks.clone(), ExpertConfig::default(), rule, 3);
        let agent = Agent::new(40, 8, 20, Initialization::Orthogonal, -4.0, 1).unwrap();
        let check = |episode_limit: Option<u32>, steps: usize, expert: RepairBy| {
            let rules = Rules { action: rule, mu: 0.1, feasible_bonus: 0.0, episode_limit };
            let environments = Environments::new(&tasks, &Profile::PAPER, &parts, rules, 3, 3);
            let mut environments = environments.unwrap();
            let ppo = PpoConfig { steps, ..PpoConfig::default() };
            let mut rollouts = Vec::new();
            collect(&agent, &mut environments, &ppo, &mut rollouts);
            let config = RepairConfig { expert, after: 10, ..RepairConfig::default() };
            let found = repair(&mut environments, &rollouts, &experts, &config);
            let tasks: Vec<usize> = environments.all().iter().map(|env| env.save().task).collect();
            (found, tasks)
        };
        let (none, tasks) = check(None, 10, RepairBy::None);
        assert_eq!((none.failed, none.samples.targets.len(), tasks), (0, 0, vec![0, 1, 2]));
        let (old, tasks) = check(None, 10, RepairBy::ShortestPath);
        assert_eq!((old.failed, tasks), (3, vec![3, 4, 5]));
        assert!(old.repaired >= 2, "{}", old.repaired);
        assert_eq!(old.samples.observations.len(), 2 * old.samples.targets.len());
        let (young, tasks) = check(None, 9, RepairBy::ShortestPath);
        assert_eq!((young.failed, tasks), (0, vec![0, 1, 2]));
        // Cut off twice in 8 steps, then 0 steps old at the end.
        let (cut, _) = check(Some(4), 8, RepairBy::ShortestPath);
        assert_eq!(cut.failed, 6);
        // Gradient descent does not solve what is hard, so it demonstrates nothing from the
        // straight line.
        let (descent, _) = check(None, 10, RepairBy::GradientDescent);
        assert_eq!(descent.failed, 3);
        assert!(descent.repaired < old.repaired);
    }
}
