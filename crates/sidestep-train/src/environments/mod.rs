//! Trajectory optimisation as a partially observable decision process (paper, section I.B).
//!
//! - state: the waypoints of a trajectory of one task; it begins as the straight line;
//! - observation: what the core's `Encoder` writes, in the paper the gradient of U;
//! - action: an update of the waypoints, clipped and applied by the core's `ActionRule`;
//! - reward: -U of the new trajectory, or bonus - mu U if that is feasible (the paper: no bonus);
//! - end: at the first feasible step. There is no time limit unless one is set: what is not solved
//!   goes on over the next update. A time limit *truncates*: the value of the last observation
//!   stands in for the rest.
//!
//! An environment takes the tasks of the set in turn: number e of E has tasks e, e + E, .. modulo
//! their number, so with as many environments as tasks (the paper: 100 each) it keeps one. The
//! noise of its actions comes from its own stream.
//!
//! All that a training sees of the world is [`Environments`]: reset, step and two sizes.

mod environment;
mod problem;

use std::fmt;
use std::sync::Arc;

use rayon::prelude::*;
use sidestep::policy::observation::ObservationPart;
use sidestep::profile::Profile;
use sidestep::{InvalidInput, Task};

pub use environment::{Environment, Outcome, Rules, Saved, Stuck};
pub use problem::{Place, Problem};

/// A reward of one's own, from what a step led to; `reward` in there is the paper's.
pub type Reward = Arc<dyn Fn(&Outcome) -> f32 + Send + Sync>;

/// Environments that one thread runs together; the results do not depend on it.
const TOGETHER: usize = 25;

/// Environments side by side, with their tasks and their rules.
///
/// Arrays are row-major f32, one row for each environment: observations `[environments x
/// observation]`, actions `[environments x N x dof]` in units of a network's output. An episode
/// that is done stays so until [`Environments::reset`].
///
/// ```
/// use sidestep::policy::{ActionRule, observation::ObservationPart};
/// use sidestep::{profile::Profile, suite::Suite};
/// use sidestep_train::environments::{Environments, Rules};
///
/// let tasks = Suite::Easy.generate(3, 1000, &Profile::PAPER);
/// let parts = [ObservationPart::Gradient];
/// let rules = Rules { action: ActionRule::PAPER, mu: 0.1, feasible_bonus: 0.0, episode_limit: Some(40) };
/// let mut environments = Environments::new(&tasks, &Profile::PAPER, &parts, rules, 2, 7)?;
/// let mut seen = vec![0.0; 2 * environments.observation_size()];
/// environments.observe(&mut seen);
/// // The agent that is gradient descent.
/// let actions: Vec<f32> = seen.iter().map(|gradient| -0.1 * gradient).collect();
/// let outcomes = environments.step(&actions);
/// for (index, outcome) in outcomes.iter().enumerate() {
///     if outcome.done() {
///         environments.reset(index);
///     }
/// }
/// # Ok::<(), sidestep::InvalidInput>(())
/// ```
#[derive(Clone)]
pub struct Environments {
    problems: Vec<Problem>,
    rules: Rules,
    reward: Option<Reward>,
    all: Vec<Environment>,
}

impl fmt::Debug for Environments {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { problems, rules, reward, all } = self;
        let mut shown = f.debug_struct("Environments");
        shown.field("tasks", &problems.len()).field("rules", rules);
        shown.field("own_reward", &reward.is_some()).field("environments", &all.len()).finish()
    }
}

impl Environments {
    /// `count` environments on `tasks`, each at the start of its first episode; `seed` decides the
    /// noise of their streams.
    ///
    /// # Errors
    /// If there are no tasks, or the observation does not fit one.
    pub fn new(
        tasks: &[Task],
        profile: &Profile,
        parts: &[ObservationPart],
        rules: Rules,
        count: usize,
        seed: u64,
    ) -> Result<Self, InvalidInput> {
        if tasks.is_empty() {
            return Err(InvalidInput::new("tasks", "none", "at least one"));
        }
        let ready = |task| Problem::new(task, profile, profile.waypoints, parts);
        let problems: Vec<Problem> = tasks.iter().map(ready).collect::<Result<_, _>>()?;
        let all = (0..count).map(|index| Environment::new(index, &problems, seed)).collect();
        Ok(Self { problems, rules, reward: None, all })
    }

    /// The same with a reward of one's own.
    pub fn with_reward(mut self, reward: Reward) -> Self {
        self.reward = Some(reward);
        self
    }

    /// How many environments.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Numbers of an observation.
    pub fn observation_size(&self) -> usize {
        let problem = &self.problems[0];
        problem.encoder.len(&problem.objective)
    }

    /// Numbers of an action.
    pub fn action_size(&self) -> usize {
        self.problems[0].objective.dim()
    }

    /// The tasks made ready.
    pub fn problems(&self) -> &[Problem] {
        &self.problems
    }

    /// What the process rewards and allows.
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// The environments.
    pub fn all(&self) -> &[Environment] {
        &self.all
    }

    /// Writes what every environment shows now, `[environments x observation]`.
    ///
    /// # Panics
    /// If `out` has another length.
    pub fn observe(&self, out: &mut [f32]) {
        let size = self.observation_size();
        assert_eq!(out.len(), self.len() * size, "environments x observation");
        let rows = out.chunks_exact_mut(size).zip(&self.all);
        rows.for_each(|(row, environment)| row.copy_from_slice(environment.observation()));
    }

    /// Applies `actions [environments x N x dof]`, on all cores.
    ///
    /// # Panics
    /// If `actions` has another length.
    pub fn step(&mut self, actions: &[f32]) -> Vec<Outcome> {
        let size = self.action_size();
        assert_eq!(actions.len(), self.len() * size, "environments x N x dof");
        let groups = self.groups().zip(actions.par_chunks(TOGETHER * size));
        let outcomes: Vec<Vec<Outcome>> = groups
            .map(|(mut group, actions)| {
                let rows = actions.chunks_exact(size).enumerate();
                rows.map(|(index, action)| group.step(index, action)).collect()
            })
            .collect();
        outcomes.concat()
    }

    /// Begins the next episode of one environment, on the next of its tasks.
    ///
    /// # Panics
    /// If there is no environment of that index.
    pub fn reset(&mut self, index: usize) {
        let count = self.all.len();
        self.all[index].reset(&self.problems, count);
    }

    /// Groups of environments that one thread each runs.
    pub(crate) fn groups(&mut self) -> impl IndexedParallelIterator<Item = Group<'_>> {
        let Self { problems, rules, reward, all } = self;
        let (problems, rules, count) = (&problems[..], &*rules, all.len());
        let reward = reward.as_ref();
        let chunks = all.par_chunks_mut(TOGETHER);
        chunks.map(move |all| Group { all, problems, rules, reward, count })
    }

    /// As many environments as are in a group, but for the last one.
    pub(crate) const fn group_size() -> usize {
        TOGETHER
    }

    /// Goes back to environments that [`Environments::all`] gave, or on from saved ones.
    pub(crate) fn set_all(&mut self, all: Vec<Environment>) {
        self.all = all;
    }

    /// Puts a saved state back; none if its task is not one of these.
    pub(crate) fn restore(&mut self, index: usize, saved: Saved) -> Option<()> {
        let problem = self.problems.get(saved.task)?;
        self.all[index].restore(saved, problem);
        Some(())
    }
}

/// Some of the environments, with what they share.
pub(crate) struct Group<'a> {
    pub all: &'a mut [Environment],
    problems: &'a [Problem],
    rules: &'a Rules,
    reward: Option<&'a Reward>,
    /// Environments in all groups.
    count: usize,
}

impl Group<'_> {
    /// Steps one environment of the group.
    pub fn step(&mut self, index: usize, action: &[f32]) -> Outcome {
        let mut outcome = self.all[index].step(action, self.rules);
        if let Some(reward) = self.reward {
            outcome.reward = reward(&outcome);
        }
        outcome
    }

    /// Begins the next episode of one environment of the group.
    pub fn reset(&mut self, index: usize) {
        self.all[index].reset(self.problems, self.count);
    }
}
