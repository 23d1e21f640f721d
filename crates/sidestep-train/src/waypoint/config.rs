//! The configuration of a waypoint policy's training, checked once.

use std::sync::Arc;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sidestep::arm::Arm;
use sidestep::network::WaypointShape;
use sidestep::profile::Profile;
use sidestep::scene::Setting;
use sidestep::suite::arms::{ArmSuite, planar_arm_alone};
use sidestep::suite::{candidate, varied};
use sidestep::{InvalidInput, Task};

use super::memory;
use super::sight::Sight;
use crate::config::check_ranges;
use crate::config::range::{refuse, training_seed, validation_seed};
use crate::config::toml_file;

/// Everything that decides a training of the waypoint policy; the same configuration gives the same
/// bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct WaypointConfig {
    /// `waypoint`.
    pub architecture: String,
    /// Seed of parameters, noise and the tasks' order.
    pub seed: u64,
    /// The view's parts. Of a robot with joints `joints:B`, with B the balls of its body that are looked at (4 a link). In
    /// the plane `waypoints` or `picture:P` (pixels along a side), then `probes:KxR1,R2,..`, then perhaps
    /// `map:GxCxD1,D2,..`, then perhaps `gradient`.
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct WaypointNetworkConfig {
    /// Hidden units per waypoint, a multiple of 16.
    pub width: usize,
    /// One residual block each.
    pub dilations: Vec<usize>,
    /// Pixels (0.1 normalised units) per unit of output.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1000.0))]
    pub action_pixels: f32,
    /// Largest update along and across the line from start to goal, in pixels.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1000.0))]
    pub action_limit_pixels: f32,
}

/// The tasks to train on: fresh ones throughout.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TaskConfig {
    /// Joints of the planar arm that the tasks are of, those of the suite `planar-arm`; 0 for a robot in the
    /// plane.
    #[schemars(range(min = 0, max = 16))]
    pub joints: usize,
    /// Seed of the training tasks: 0, or 1000 and above.
    pub seed: u64,
    /// In the plane, share of tasks of the suite `varied`; the others are the paper's.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub varied: f32,
    /// Share that is kept of the tasks whose straight line is free.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub direct: f32,
    /// Share of the units of imitation, and of the tasks of policy gradient, with another number of
    /// waypoints than 10.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub other_waypoints: f32,
    /// Least and most number of waypoints, where it is another than 10.
    pub waypoints: [usize; 2],
}

/// What a stage does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StageKind {
    /// On-policy imitation of exact paths.
    Imitation,
    /// Policy gradient on success.
    PolicyGradient,
}

/// One stage: Adam from fresh moments, a learning rate with warm-up and cosine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StageConfig {
    /// What it does.
    pub kind: StageKind,
    /// Optimizer steps; rounded up to whole units.
    #[schemars(range(min = 1, max = 1_000_000_000))]
    pub updates: u64,
    /// Highest learning rate.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1000.0))]
    pub learning_rate: f64,
}

/// Settings of imitation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ImitationConfig {
    /// Tasks per update, with 4 trajectories each.
    #[schemars(range(min = 1, max = 1024))]
    pub tasks: usize,
    /// Steps of every trajectory per update.
    #[schemars(range(min = 1, max = 1000))]
    pub steps: usize,
    /// Weight of the hinge on trajectories from the straight line.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub hinge_straight: f32,
    /// Weight of the hinge on the other trajectories.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub hinge: f32,
    /// Probability of smooth noise after a step.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub kick_probability: f32,
    /// Size of the noise after a step, in normalised units.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub kick: f32,
    /// Steps that a task lives.
    #[schemars(range(min = 1, max = 100_000))]
    pub life: u32,
    /// Steps that long-lived tasks live.
    #[schemars(range(min = 1, max = 100_000))]
    pub long_life: u32,
    /// Share of long-lived tasks.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub long_share: f32,
    /// Probability that a task is one that failed before.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub retry: f32,
}

/// Settings of policy gradient.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PolicyGradientConfig {
    /// Tasks per update.
    #[schemars(range(min = 1, max = 256))]
    pub tasks: usize,
    /// Noisy walks per task.
    #[schemars(range(min = 1, max = 256))]
    pub walks: usize,
    /// Steps of a walk.
    #[schemars(range(min = 1, max = 1000))]
    pub steps: usize,
    /// Standard deviation of the first noise mode, in pixels; mode k has one k-th of it.
    #[schemars(extend("exclusiveMinimum" = 0), range(max = 1000.0))]
    pub noise_pixels: f32,
    /// What a walk that is solved after t of T steps loses of its return of 1: this times t / T.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub haste: f32,
    /// What it loses for its length beyond the shortest path's, as a part of that (1 at most): this
    /// times that.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub stretch: f32,
    /// Random short cuts on a solved walk before its length counts.
    #[schemars(range(min = 0, max = 1000))]
    pub short_cuts: usize,
    /// Share of the tasks that are walked from a random bend or via-point, and not from the
    /// straight line.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub other_starts: f32,
    /// Share that is walked of the tasks that the present policy solves without noise.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub solved: f32,
    /// Weight of imitation on walks of tasks that no walk solves; 0, as for robots with joints, learns nothing
    /// from these.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub repair: f32,
    /// How often the same walks are learned from; more than once is PPO.
    #[schemars(range(min = 1, max = 100))]
    pub epochs: usize,
    /// From the second epoch on, how far the ratio of densities may leave 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub clip: f32,
}

/// The tasks that choose the best policy.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct WaypointValidationConfig {
    /// Tasks of each of the suites easy and hard.
    #[schemars(range(min = 1, max = 100_000))]
    pub count: usize,
    /// Seed of the validation tasks: 7 or 17.
    pub seed: u64,
    /// Units from one validation to the next.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub every: u64,
    /// Iterations per task.
    #[schemars(range(min = 1, max = 100_000))]
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

    /// The robot with joints that the tasks are of, if they are of one.
    pub(super) fn arm(&self) -> Result<Option<Arc<Arm>>, InvalidInput> {
        if self.joints == 0 {
            return Ok(None);
        }
        let arm = planar_arm_alone(self.joints);
        Ok(Some(Arc::new(
            arm.map_err(|error| InvalidInput { field: "tasks.joints".into(), ..error })?,
        )))
    }

    /// The training task of that number, of the sight's robot; `rng` decides its kind. None where there is no such task.
    pub(super) fn draw(&self, sight: &Sight, number: u64, rng: &mut ChaCha8Rng) -> Option<Task> {
        match sight {
            Sight::Joints(_, arm) => jointed_task(arm, self.seed, number),
            Sight::Plane(_) => Some(self.draw_plane(number, rng)),
        }
    }

    fn draw_plane(&self, number: u64, rng: &mut ChaCha8Rng) -> Task {
        if rng.random::<f32>() < self.varied {
            varied(self.seed, number)
        } else {
            candidate(self.seed, number)
        }
    }
}

/// Task `number` of a seed, of a planar arm.
pub(super) fn jointed_task(arm: &Arc<Arm>, seed: u64, number: u64) -> Option<Task> {
    let problem = ArmSuite::PlanarArm.problem(arm, None, None, seed, number).ok()?;
    let setting = Setting::Arm { arm: arm.clone(), world: problem.world };
    Task::new(problem.name, setting, problem.start, problem.goal).ok()
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
        Self { joints: 0, seed: 1000, varied: 0.25, direct: 0.05, other_waypoints: 0.2, waypoints }
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
            short_cuts: 0,
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
        let config: Self = toml_file::parse(&toml_file::table(text)?, text)?;
        config.check()?;
        Ok(config)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// If a value is out of range; the message names the field, the value and the range.
    pub fn check(&self) -> Result<(), InvalidInput> {
        self.checked().map(|_| ())
    }

    /// [`Self::check`], and what the names stand for.
    pub(super) fn checked(&self) -> Result<(Sight, WaypointShape), InvalidInput> {
        if self.architecture != ARCHITECTURE {
            return refuse("architecture", &self.architecture, ARCHITECTURE);
        }
        let sight = Sight::from_names(&self.observation, self.tasks.arm()?)?;
        let network = &self.network;
        let shape = WaypointShape {
            inputs: sight.row_len(),
            width: network.width,
            dilations: network.dilations.clone(),
            outputs: sight.dof(),
            map: sight.map().cloned(),
        };
        shape.parameter_count()?;
        self.check_numbers()?;
        memory::check(self, &shape)?;
        Ok((sight, shape))
    }

    fn check_numbers(&self) -> Result<(), InvalidInput> {
        let Self { tasks, stages, validation, .. } = self;
        check_ranges(self)?;
        training_seed("tasks.seed", tasks.seed)?;
        validation_seed("validation.seed", validation.seed)?;
        let [least, most] = tasks.waypoints;
        if !(1..=most).contains(&least) || most > 200 {
            let found = format!("[{least}, {most}]");
            return refuse("tasks.waypoints", found, "[least, most] within 1 to 200");
        }
        let repair = self.policy_gradient.repair;
        if tasks.joints > 0 && repair > 0.0 {
            return refuse("policy_gradient.repair", repair, "0, where tasks.joints is not 0");
        }
        if stages.is_empty() {
            return refuse("stages", "none", "at least one stage");
        }
        Ok(())
    }
}
