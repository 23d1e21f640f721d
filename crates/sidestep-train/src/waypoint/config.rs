//! The configuration of a waypoint policy's training, checked once.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use sidestep::network::WaypointShape;
use sidestep::plane::view::ViewParts;
use sidestep::profile::Profile;
use sidestep::suite::{candidate, varied};
use sidestep::{InvalidInput, Task};

use crate::config::range::{above_zero, refuse, training_seed, validation_seed, within};
use crate::config::toml_file;

/// Everything that decides a training of the waypoint policy; the same configuration gives the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WaypointConfig {
    /// `waypoint`.
    pub architecture: String,
    /// Seed of parameters, noise and the tasks' order.
    pub seed: u64,
    /// The view's parts: `waypoints`, then `probes:KxR1,R2,..`, then perhaps `map:GxCxD1,D2,..`.
    pub observation: Vec<String>,
    /// The network.
    pub network: WaypointNetworkConfig,
    /// The tasks to train on.
    pub tasks: TaskConfig,
    /// The stages, in order.
    pub stages: Vec<StageConfig>,
    /// Settings of imitation.
    pub imitation: ImitationConfig,
    /// Settings of policy gradient.
    pub policy_gradient: PolicyGradientConfig,
    /// The tasks that choose the best policy.
    pub validation: WaypointValidationConfig,
}

/// The network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WaypointNetworkConfig {
    /// Hidden units per waypoint, a multiple of 16.
    pub width: usize,
    /// One residual block each.
    pub dilations: Vec<usize>,
    /// Pixels (0.1 normalised units) per unit of output.
    pub action_pixels: f32,
    /// Largest update along and across the line from start to goal, in pixels.
    pub action_limit_pixels: f32,
}

/// The tasks to train on: fresh ones throughout.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TaskConfig {
    /// Their seed: 0, or 1000 and above.
    pub seed: u64,
    /// Share of tasks of the suite `varied`; the others are the paper's.
    pub varied: f32,
    /// Share that is kept of the tasks whose straight line is free.
    pub direct: f32,
    /// Share of the units of imitation, and of the tasks of policy gradient, with another number of waypoints than 10.
    pub other_waypoints: f32,
    /// Least and most of that number.
    pub waypoints: [usize; 2],
}

/// What a stage does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StageKind {
    /// On-policy imitation of exact paths.
    Imitation,
    /// Policy gradient on success.
    PolicyGradient,
}

/// One stage: Adam from fresh moments, a learning rate with warm-up and cosine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageConfig {
    /// What it does.
    pub kind: StageKind,
    /// Optimizer steps; rounded up to whole units.
    pub updates: u64,
    /// Highest learning rate.
    pub learning_rate: f64,
}

/// Settings of imitation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImitationConfig {
    /// Tasks per update, with 4 trajectories each.
    pub tasks: usize,
    /// Steps of every trajectory per update.
    pub steps: usize,
    /// Weight of the hinge on trajectories from the straight line.
    pub hinge_straight: f32,
    /// The same on the others.
    pub hinge: f32,
    /// Probability of smooth noise after a step.
    pub kick_probability: f32,
    /// Its size, in normalised units.
    pub kick: f32,
    /// Steps that a task lives.
    pub life: u32,
    /// Steps that some live.
    pub long_life: u32,
    /// Share of those.
    pub long_share: f32,
    /// Probability that a task is one that failed before.
    pub retry: f32,
}

/// Settings of policy gradient.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PolicyGradientConfig {
    /// Tasks per update.
    pub tasks: usize,
    /// Noisy walks per task.
    pub walks: usize,
    /// Steps of a walk.
    pub steps: usize,
    /// Standard deviation of the first noise mode, in pixels; mode k has one k-th of it.
    pub noise_pixels: f32,
    /// The return of a walk that is solved after t of T steps is 1 - haste t / T, ..
    pub haste: f32,
    /// .. less this times its length beyond the shortest path's, as a part of that (1 at most).
    pub stretch: f32,
    /// Share of the tasks that are walked from a random bend or via-point, and not from the straight line.
    pub other_starts: f32,
    /// Share that is walked of the tasks that the present policy solves without noise.
    pub solved: f32,
    /// Weight of imitation on walks of tasks that no walk solves; 0 learns nothing from these.
    pub repair: f32,
    /// How often the same walks are learned from; more than once is PPO.
    pub epochs: usize,
    /// From the second epoch on, how far the ratio of densities may leave 1.
    pub clip: f32,
}

/// The tasks that choose the best policy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WaypointValidationConfig {
    /// Tasks of each of the suites easy and hard.
    pub count: usize,
    /// Their seed: 7 or 17.
    pub seed: u64,
    /// Units from one validation to the next.
    pub every: u64,
    /// Iterations per task.
    pub steps: usize,
}

impl TaskConfig {
    /// A number of waypoints: mostly the default profile's.
    pub(super) fn draw_waypoints(&self, rng: &mut ChaCha8Rng) -> usize {
        if rng.random::<f32>() < self.other_waypoints {
            rng.random_range(self.waypoints[0]..=self.waypoints[1])
        } else {
            Profile::DEFAULT.waypoints
        }
    }

    /// The training task of that number; `rng` decides its kind.
    pub(super) fn draw(&self, number: u64, rng: &mut ChaCha8Rng) -> Task {
        if rng.random::<f32>() < self.varied {
            varied(self.seed, number)
        } else {
            candidate(self.seed, number)
        }
    }
}

impl Default for WaypointConfig {
    fn default() -> Self {
        let stage = |kind, updates, learning_rate| StageConfig { kind, updates, learning_rate };
        Self {
            architecture: ARCHITECTURE.into(),
            seed: 0,
            observation: vec![WAYPOINTS_PART.into(), "probes:12x0.25,0.6,1.1,1.8,2.8,4.2".into()],
            network: WaypointNetworkConfig::default(),
            tasks: TaskConfig::default(),
            stages: vec![
                stage(StageKind::Imitation, 200_000, 1.2e-3),
                stage(StageKind::PolicyGradient, 2_000, 1e-4),
            ],
            imitation: ImitationConfig::default(),
            policy_gradient: PolicyGradientConfig::default(),
            validation: WaypointValidationConfig::default(),
        }
    }
}

impl Default for WaypointNetworkConfig {
    fn default() -> Self {
        let dilations = vec![1, 2, 4];
        Self { width: 80, dilations, action_pixels: 4.0, action_limit_pixels: 16.0 }
    }
}

impl Default for TaskConfig {
    fn default() -> Self {
        let waypoints = [5, 24];
        Self { seed: 1000, varied: 0.25, direct: 0.05, other_waypoints: 0.2, waypoints }
    }
}

impl Default for ImitationConfig {
    fn default() -> Self {
        Self {
            tasks: 16,
            steps: 3,
            hinge_straight: 0.2,
            hinge: 0.6,
            kick_probability: 0.1,
            kick: 0.2,
            life: 20,
            long_life: 50,
            long_share: 0.3,
            retry: 0.2,
        }
    }
}

impl Default for PolicyGradientConfig {
    fn default() -> Self {
        Self {
            tasks: 16,
            walks: 8,
            steps: 24,
            noise_pixels: 0.7,
            haste: 0.3,
            stretch: 0.5,
            other_starts: 0.25,
            solved: 0.5,
            repair: 0.0,
            epochs: 1,
            clip: 0.2,
        }
    }
}

impl Default for WaypointValidationConfig {
    fn default() -> Self {
        Self { count: 500, seed: 7, every: 4, steps: 40 }
    }
}

/// The name of this architecture in configurations and policy files.
pub const ARCHITECTURE: &str = "waypoint";
/// The name of the part of the observation that every waypoint policy has.
pub const WAYPOINTS_PART: &str = sidestep::plane::view::PART;

impl WaypointConfig {
    /// Reads a TOML file's text and checks it.
    ///
    /// # Errors
    /// If it is no TOML, has an unknown key or a value of the wrong kind or out of range.
    pub fn from_toml(text: &str) -> Result<Self, InvalidInput> {
        let config: Self = toml_file::parse(text)?;
        config.check()?;
        Ok(config)
    }

    /// Checks every value, and returns what the names stand for.
    ///
    /// # Errors
    /// If a value is out of range; the message names the field, the value and the range.
    pub fn check(&self) -> Result<(ViewParts, WaypointShape), InvalidInput> {
        if self.architecture != ARCHITECTURE {
            return refuse("architecture", &self.architecture, ARCHITECTURE);
        }
        let view = ViewParts::from_names(&self.observation)?;
        let network = &self.network;
        let shape = WaypointShape {
            inputs: view.row_len(),
            width: network.width,
            dilations: network.dilations.clone(),
            map: view.map.clone(),
        };
        shape.parameter_count()?;
        self.check_numbers()?;
        Ok((view, shape))
    }

    fn check_numbers(&self) -> Result<(), InvalidInput> {
        let Self { network, tasks, stages, imitation, policy_gradient, validation, .. } = self;
        above_zero("network.action_pixels", network.action_pixels, 1000.0)?;
        above_zero("network.action_limit_pixels", network.action_limit_pixels, 1000.0)?;
        training_seed("tasks.seed", tasks.seed)?;
        within("tasks.varied", tasks.varied, 0.0..=1.0)?;
        within("tasks.direct", tasks.direct, 0.0..=1.0)?;
        within("tasks.other_waypoints", tasks.other_waypoints, 0.0..=1.0)?;
        let [least, most] = tasks.waypoints;
        if !(1..=most).contains(&least) || most > 200 {
            let found = format!("[{least}, {most}]");
            return refuse("tasks.waypoints", found, "[least, most] within 1 to 200");
        }
        if stages.is_empty() {
            return refuse("stages", "none", "at least one stage");
        }
        for stage in stages {
            within("stages.updates", stage.updates, 1..=1_000_000_000)?;
            above_zero("stages.learning_rate", stage.learning_rate, 1000.0)?;
        }
        within("imitation.tasks", imitation.tasks, 1..=1024)?;
        within("imitation.steps", imitation.steps, 1..=1000)?;
        within("imitation.hinge_straight", imitation.hinge_straight, 0.0..=100.0)?;
        within("imitation.hinge", imitation.hinge, 0.0..=100.0)?;
        within("imitation.kick_probability", imitation.kick_probability, 0.0..=1.0)?;
        within("imitation.kick", imitation.kick, 0.0..=100.0)?;
        within("imitation.life", imitation.life, 1..=100_000)?;
        within("imitation.long_life", imitation.long_life, 1..=100_000)?;
        within("imitation.long_share", imitation.long_share, 0.0..=1.0)?;
        within("imitation.retry", imitation.retry, 0.0..=0.9)?;
        within("policy_gradient.tasks", policy_gradient.tasks, 1..=256)?;
        within("policy_gradient.walks", policy_gradient.walks, 1..=256)?;
        within("policy_gradient.steps", policy_gradient.steps, 1..=1000)?;
        above_zero("policy_gradient.noise_pixels", policy_gradient.noise_pixels, 1000.0)?;
        within("policy_gradient.haste", policy_gradient.haste, 0.0..=1.0)?;
        within("policy_gradient.stretch", policy_gradient.stretch, 0.0..=1.0)?;
        within("policy_gradient.other_starts", policy_gradient.other_starts, 0.0..=1.0)?;
        within("policy_gradient.solved", policy_gradient.solved, 0.0..=1.0)?;
        within("policy_gradient.repair", policy_gradient.repair, 0.0..=1.0)?;
        within("policy_gradient.epochs", policy_gradient.epochs, 1..=100)?;
        within("policy_gradient.clip", policy_gradient.clip, 0.0..=1.0)?;
        within("validation.count", validation.count, 1..=100_000)?;
        validation_seed("validation.seed", validation.seed)?;
        within("validation.every", validation.every, 1..=1_000_000)?;
        within("validation.steps", validation.steps, 1..=100_000)
    }
}
