//! Experts: what a policy that is being trained should have answered.
//!
//! - gradient descent, -γ ∂U with the profile's step (what the paper cloned) or with a tuned one;
//! - the exact shortest path: an update towards the nearest of several routes ([`crate::routes`]).
//!
//! The expert answers at any trajectory, not only along its own: that is what DAgger
//! ([`crate::paper::stages::dagger`]) and the repair of failed episodes
//! ([`crate::paper::stages::ppo::repair`]) ask of it.

use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sidestep::Task;
use sidestep::policy::ActionRule;

use crate::environments::Problem;
use crate::routes::{Target, evenly_grown, nearest};

/// Who shows what to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExpertKind {
    /// Gradient descent with the profile's step, as the paper cloned.
    #[default]
    GradientDescent,
    /// Gradient descent with the step that `expert.step` names.
    TunedGradientDescent,
    /// The exact shortest path and its alternatives.
    ShortestPath,
}

/// Settings of the experts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ExpertConfig {
    /// Step γ of the tuned gradient descent; 0.5 is the best on validation tasks in the paper's
    /// profile.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1000.0))]
    pub step: f32,
    /// Share of the way to its route that the shortest-path expert goes in one update, before the
    /// action's limit.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1.0))]
    pub rate: f32,
    /// Alternative routes that the shortest-path expert looks for.
    #[schemars(range(min = 0, max = 64))]
    pub alternatives: usize,
}

impl Default for ExpertConfig {
    fn default() -> Self {
        Self { step: 0.5, rate: 0.5, alternatives: 4 }
    }
}

/// The experts of one training's tasks. Routes are found when first asked for; they depend on the
/// task and the seed only.
#[derive(Debug)]
pub struct Experts {
    tasks: Vec<Task>,
    routes: Vec<OnceLock<Vec<Target>>>,
    config: ExpertConfig,
    rule: ActionRule,
    seed: u64,
}

impl Experts {
    /// Experts for `tasks`, whose answers are outputs of a network under `rule`.
    pub fn new(tasks: Vec<Task>, config: ExpertConfig, rule: ActionRule, seed: u64) -> Self {
        let routes = tasks.iter().map(|_| OnceLock::new()).collect();
        Self { tasks, routes, config, rule, seed }
    }

    /// Writes to `answer [N x 2]` the output that brings the policy where the expert would go from
    /// the waypoints `x [N x 2]` of task `index`, made ready as `problem`, with the gradient of U
    /// there. Returns whether the expert has an answer: there are no routes where there is no path.
    pub fn answer(
        &self,
        kind: ExpertKind,
        index: usize,
        problem: &Problem,
        x: &[f32],
        gradient: &[f32],
        answer: &mut [f32],
    ) -> bool {
        let step = match kind {
            ExpertKind::GradientDescent => problem.objective.scene().profile().gradient_step as f32,
            ExpertKind::TunedGradientDescent => self.config.step,
            ExpertKind::ShortestPath => {
                let Some(target) = nearest(2, self.routes(index, problem), x) else {
                    return false;
                };
                for ((answer, x), target) in answer.iter_mut().zip(x).zip(target) {
                    *answer = self.output(self.config.rate * (target - x));
                }
                return true;
            }
        };
        for (answer, gradient) in answer.iter_mut().zip(gradient) {
            *answer = self.output(-step * gradient);
        }
        true
    }

    /// The network's output that makes an update, as near as the limit allows.
    fn output(&self, update: f32) -> f32 {
        update.clamp(-self.rule.limit, self.rule.limit) / self.rule.scale
    }

    /// The routes of task `index`.
    pub fn routes(&self, index: usize, problem: &Problem) -> &[Target] {
        self.routes[index].get_or_init(|| {
            let Ok(task) = self.tasks[index].plane() else { return Vec::new() };
            let streams = (self.seed, index as u64);
            evenly_grown::find(task, &problem.objective, self.config.alternatives, streams)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sidestep::policy::observation::ObservationPart;
    use sidestep::profile::Profile;
    use sidestep::suite::Suite;

    /// Tasks of `suite` that the expert solves from the straight line in 30 updates, and those that
    /// have an answer at all.
    fn solved(kind: ExpertKind, suite: Suite, profile: &Profile) -> (usize, usize) {
        let tasks = suite.generate(60, 1000, &Profile::PAPER);
        let rule = ActionRule::PAPER;
        let experts = Experts::new(tasks.clone(), ExpertConfig::default(), rule, 3);
        let (mut solved, mut answered) = (0, 0);
        for (index, task) in tasks.iter().enumerate() {
            let parts = [ObservationPart::Gradient];
            let mut problem = Problem::new(task, profile, 10, &parts).unwrap();
            let (mut x, mut gradient) = (vec![0.0; 20], vec![0.0; 20]);
            let (mut seen, mut action) = (vec![0.0; 20], vec![0.0; 20]);
            problem.objective.straight_line(&mut x);
            for step in 0..30 {
                if problem.objective.is_feasible(&x) {
                    solved += 1;
                    answered += usize::from(step == 0);
                    break;
                }
                problem.observe(&x, &mut gradient, &mut seen);
                let has = experts.answer(kind, index, &problem, &x, &gradient, &mut action);
                answered += usize::from(has && step == 0);
                if !has {
                    break;
                }
                rule.apply(&action, problem.objective.scene().normalised_limits(), &mut x);
            }
        }
        (solved, answered)
    }

    #[test]
    fn the_shortest_path_expert_solves_what_has_a_path_and_gradient_descent_does_not() {
        for profile in [Profile::PAPER, Profile::DEFAULT] {
            let (solved, answered) = self::solved(ExpertKind::ShortestPath, Suite::Hard, &profile);
            assert!(answered >= 54, "{answered} of 60 hard tasks have a path");
            assert!(solved + 1 >= answered, "{solved} of {answered}");
        }
        let (hard, _) = solved(ExpertKind::GradientDescent, Suite::Hard, &Profile::PAPER);
        assert_eq!(hard, 0);
        let (easy, answered) =
            solved(ExpertKind::TunedGradientDescent, Suite::Easy, &Profile::PAPER);
        assert!(easy > 40 && answered == 60, "{easy} {answered}");
    }
}
