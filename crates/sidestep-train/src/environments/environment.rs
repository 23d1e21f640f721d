//! One environment of the decision process: its task, its episode and its noise.

use rand_chacha::ChaCha8Rng;
use sidestep::objective::Cost;
use sidestep::policy::ActionRule;
use sidestep::rng::{Purpose, stream};

use super::problem::Problem;

/// What the process rewards and allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// From action to update.
    pub action: ActionRule,
    /// Factor mu on the reward of a feasible step.
    pub mu: f32,
    /// Added to the reward of a feasible step.
    pub feasible_bonus: f32,
    /// Steps after which an episode is cut off; `None` for never.
    pub episode_limit: Option<u32>,
}

impl Rules {
    /// The paper's reward of a step, from its parts: -U, or bonus - mu U if the new trajectory is
    /// feasible.
    pub fn reward(&self, cost: Cost, solved: bool) -> f32 {
        if solved { self.feasible_bonus - self.mu * cost.total } else { -cost.total }
    }
}

/// What one step led to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// The reward.
    pub reward: f32,
    /// U of the new trajectory with its parts, of which a reward can be made.
    pub cost: Cost,
    /// Whether the new trajectory is feasible, which ends the episode.
    pub solved: bool,
    /// Whether the time limit ends it instead.
    pub truncated: bool,
    /// Steps of the episode so far.
    pub age: u32,
}

impl Outcome {
    /// Whether the episode has ended.
    pub fn done(&self) -> bool {
        self.solved || self.truncated
    }
}

/// One environment with its episode.
#[derive(Debug, Clone)]
pub struct Environment {
    task: usize,
    problem: Problem,
    x: Vec<f32>,
    gradient: Vec<f32>,
    observation: Vec<f32>,
    age: u32,
    /// Noise of its actions.
    pub rng: ChaCha8Rng,
}

/// An environment's state in a checkpoint.
#[derive(Debug, Clone, PartialEq)]
pub struct Saved {
    /// Index of its task in the training set.
    pub task: usize,
    /// Steps of its episode so far.
    pub age: u32,
    /// Position in its stream, in words.
    pub stream_position: u128,
    /// The waypoints, `[N x dof]`.
    pub x: Vec<f32>,
    /// The observation there.
    pub observation: Vec<f32>,
    /// What the encoder remembers.
    pub memory: Vec<f32>,
}

/// Where an episode got stuck.
#[derive(Debug, Clone, PartialEq)]
pub struct Stuck {
    /// Index of its task in the training set.
    pub task: usize,
    /// The waypoints, `[N x dof]`.
    pub x: Vec<f32>,
    /// What the encoder remembers.
    pub memory: Vec<f32>,
}

impl Environment {
    /// Environment `index`, at the start of its first episode.
    pub fn new(index: usize, problems: &[Problem], seed: u64) -> Self {
        let task = index % problems.len();
        let problem = problems[task].clone();
        let dim = problem.objective.dim();
        let mut environment = Self {
            task,
            x: vec![0.0; dim],
            gradient: vec![0.0; dim],
            observation: vec![0.0; problem.encoder.len(&problem.objective)],
            age: 0,
            rng: stream(seed, Purpose::Environment, index as u64, 0),
            problem,
        };
        environment.begin();
        environment
    }

    /// What the policy sees now.
    pub fn observation(&self) -> &[f32] {
        &self.observation
    }

    /// The waypoints now, `[N x dof]`, normalised units.
    pub fn waypoints(&self) -> &[f32] {
        &self.x
    }

    /// Steps of the episode so far.
    pub fn age(&self) -> u32 {
        self.age
    }

    /// Where the episode is, should it end here.
    pub fn stuck(&self) -> Stuck {
        let memory = self.problem.encoder.memory().to_vec();
        Stuck { task: self.task, x: self.x.clone(), memory }
    }

    /// Applies `action [N x dof]`. After an outcome that is `done`, call [`Environment::reset`].
    pub fn step(&mut self, action: &[f32], rules: &Rules) -> Outcome {
        let limits = self.problem.objective.scene().normalised_limits();
        rules.action.apply(action, limits, &mut self.x);
        self.age += 1;
        let cost = self.problem.observe(&self.x, &mut self.gradient, &mut self.observation);
        let solved = self.problem.objective.is_feasible(&self.x);
        let truncated = !solved && rules.episode_limit.is_some_and(|limit| self.age >= limit);
        Outcome { reward: rules.reward(cost, solved), cost, solved, truncated, age: self.age }
    }

    /// Begins the next episode, on the next of its tasks out of `problems`, with `count`
    /// environments in all.
    pub fn reset(&mut self, problems: &[Problem], count: usize) {
        let next = (self.task + count) % problems.len();
        if next != self.task {
            self.task = next;
            self.problem.clone_from(&problems[next]);
        }
        self.begin();
    }

    fn begin(&mut self) {
        self.age = 0;
        self.problem.objective.straight_line(&mut self.x);
        self.problem.encoder.reset();
        self.problem.observe(&self.x, &mut self.gradient, &mut self.observation);
    }

    /// The state for a checkpoint.
    pub fn save(&self) -> Saved {
        Saved {
            task: self.task,
            age: self.age,
            stream_position: self.rng.get_word_pos(),
            x: self.x.clone(),
            observation: self.observation.clone(),
            memory: self.problem.encoder.memory().to_vec(),
        }
    }

    /// Puts a saved state back into an environment of the same index and seed; `problem` is its
    /// task made ready, and the slices have the lengths that belong to it.
    pub(crate) fn restore(&mut self, saved: Saved, problem: &Problem) {
        self.problem.clone_from(problem);
        self.problem.encoder.restore(&saved.memory);
        self.rng.set_word_pos(saved.stream_position);
        self.task = saved.task;
        self.age = saved.age;
        self.x = saved.x;
        self.observation = saved.observation;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sidestep::policy::observation::ObservationPart;
    use sidestep::profile::Profile;
    use sidestep::suite::Suite;

    const RULES: Rules =
        Rules { action: ActionRule::PAPER, mu: 0.1, feasible_bonus: 0.0, episode_limit: None };

    fn problems(suite: Suite, count: usize) -> Vec<Problem> {
        let tasks = suite.generate(count, 1000, &Profile::PAPER);
        let parts = [ObservationPart::Gradient];
        tasks.iter().map(|task| Problem::new(task, &Profile::PAPER, 10, &parts).unwrap()).collect()
    }

    #[test]
    fn gradient_descent_as_the_agent_walks_as_gradient_descent() {
        let problems = problems(Suite::Easy, 8);
        for (index, problem) in problems.iter().enumerate() {
            let mut environment = Environment::new(index, &problems, 3);
            let mut problem = problem.clone();
            let (mut x, mut gradient) = (vec![0.0; 20], vec![0.0; 20]);
            problem.objective.straight_line(&mut x);
            for age in 1..=20 {
                problem.objective.cost_and_gradient(&x, &mut gradient);
                assert_eq!(environment.observation(), gradient);
                let action: Vec<f32> = gradient.iter().map(|g| -0.1 * g).collect();
                // Inside the field and below 1 in size, so that no clipping decides.
                x.iter_mut().zip(&action).for_each(|(x, a)| *x += a);
                let outcome = environment.step(&action, &RULES);
                assert_eq!(environment.waypoints(), x);
                let solved = problem.objective.is_feasible(&x);
                let cost = problem.objective.cost(&x);
                let reward = if solved { -0.1 * cost.total } else { -cost.total };
                let expected = Outcome { reward, cost, solved, truncated: false, age };
                assert_eq!(outcome, expected);
                if solved {
                    break;
                }
            }
        }
    }

    #[test]
    fn episodes_end_by_limit_and_tasks_take_turns() {
        let problems = problems(Suite::HardTraining, 5);
        let rules = Rules { episode_limit: Some(3), ..RULES };
        let mut environment = Environment::new(1, &problems, 3);
        let mut tasks = Vec::new();
        for _ in 0..5 {
            tasks.push(environment.save().task);
            let outcomes: Vec<Outcome> =
                (0..3).map(|_| environment.step(&[0.0; 20], &rules)).collect();
            assert!(outcomes.iter().all(|outcome| !outcome.solved));
            assert_eq!(
                outcomes.iter().map(Outcome::done).collect::<Vec<_>>(),
                [false, false, true]
            );
            environment.reset(&problems, 2);
        }
        assert_eq!(tasks, [1, 3, 0, 2, 4]);
    }
}
