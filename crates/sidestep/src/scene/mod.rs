//! The seam between robots and everything above them: what a robot and its surroundings answer about configurations.
//!
//! A [`Scene`] is prepared once for a robot, its surroundings and a profile. It is a closed set, and one `match` serves a whole
//! block of configurations, so that a robot in the plane pays nothing for those with joints. Everything above it (objective,
//! optimizers, starts, planners, policies that see a whole trajectory) sees flat buffers `[N x dof]`, with `dof` known at
//! run time. Another kind of robot answers what the methods here ask:
//!
//! | asked | for |
//! | --- | --- |
//! | `dof`, `limits`, `normalised_limits` | starts, sampling, clipping |
//! | `to_normalised`, `to_task`, `normalised_length` | optimizers work in normalised units, certificates in task units |
//! | `epsilon`, `typical_clearance`, `cost_and_slope` | U and ∂U |
//! | `motion_is_free`, `path_is_free`, `is_free`, `check`, `clearance` | certificates, never by samples |
//! | `exact`, `disproof` | the shortest path or a proof that there is none, where there is such a search |

mod query;
mod task;

pub use crate::plane::PlaneTask;
pub use query::{Query, Refused};
pub use task::{Setting, Task};

use crate::arm::ArmScene;
use crate::kernels::Block;
use crate::plane::shortest_path::{Doubt, Proof, Route};
use crate::plane::world::Obstacle;
use crate::plane::{PlaneScene, points};
use crate::profile::Profile;
use crate::trajectory::{Trajectory, Violation};

/// A robot, its surroundings and a profile, prepared for every query there.
#[derive(Debug)]
#[non_exhaustive]
#[allow(
    clippy::large_enum_variant,
    reason = "made once and shared; the plane's is read without a detour"
)]
pub enum Scene {
    /// A point or disc in the plane.
    Plane(PlaneScene),
    /// A robot with joints in space.
    Arm(ArmScene),
}

/// A trajectory that is certified free of collision from its task's start to its goal. Only [`Query::certify`] makes one.
#[derive(Debug, Clone, PartialEq)]
pub struct Certified(Trajectory);

impl Certified {
    /// The trajectory.
    pub fn trajectory(&self) -> &Trajectory {
        &self.0
    }

    /// The trajectory, out of its seal.
    pub fn into_trajectory(self) -> Trajectory {
        self.0
    }
}

impl Scene {
    /// Prepares a setting.
    pub fn new(setting: &Setting, profile: &Profile) -> Self {
        match setting {
            Setting::Plane { world, robot } => Self::Plane(PlaneScene::new(world, *robot, profile)),
            Setting::Arm { arm, world } => Self::Arm(ArmScene::new(arm, world, profile)),
        }
    }

    /// The scene of a task.
    pub fn of(task: &Task, profile: &Profile) -> Self {
        Self::new(&task.setting, profile)
    }

    /// The scene of a robot in the plane with more obstacles; what this one prepares of its world is shared, so that they cost
    /// what they cost. The world with them is the new scene's. None for robots with joints.
    pub fn with_obstacles(&self, more: &[Obstacle]) -> Option<Self> {
        Some(Self::Plane(self.plane()?.with_obstacles(more)))
    }

    /// The scene in the plane, where it is one.
    pub fn plane(&self) -> Option<&PlaneScene> {
        match self {
            Self::Plane(plane) => Some(plane),
            Self::Arm(_) => None,
        }
    }

    /// The scene of a robot with joints, where it is one.
    pub fn arm(&self) -> Option<&ArmScene> {
        match self {
            Self::Plane(_) => None,
            Self::Arm(arm) => Some(arm),
        }
    }

    /// Whether the scene was prepared for the setting.
    pub fn serves(&self, setting: &Setting) -> bool {
        match (self, setting) {
            (Self::Plane(plane), Setting::Plane { world, robot }) => {
                std::sync::Arc::ptr_eq(plane.world(), world) && plane.robot() == *robot
            }
            (Self::Arm(scene), Setting::Arm { arm, world }) => {
                std::sync::Arc::ptr_eq(scene.world(), world)
                    && std::sync::Arc::ptr_eq(scene.arm(), arm)
            }
            _ => false,
        }
    }

    /// Coordinates of a configuration.
    pub fn dof(&self) -> usize {
        self.limits().len()
    }

    /// The profile that the scene was prepared for.
    pub fn profile(&self) -> &Profile {
        match self {
            Self::Plane(plane) => plane.profile(),
            Self::Arm(arm) => arm.profile(),
        }
    }

    /// Least and greatest value of each coordinate `[dof]`, in task units.
    pub fn limits(&self) -> &[[f64; 2]] {
        match self {
            Self::Plane(plane) => plane.limits(),
            Self::Arm(arm) => arm.limits(),
        }
    }

    /// Least and greatest value of each coordinate `[dof]`, in normalised units; in the plane those of the bounds.
    pub fn normalised_limits(&self) -> &[[f32; 2]] {
        match self {
            Self::Plane(plane) => plane.normalised_limits(),
            Self::Arm(arm) => arm.normalised_limits(),
        }
    }

    /// Configurations `[N x dof]` from task units to normalised units.
    pub fn to_normalised(&self, from: &[f64], to: &mut [f32]) {
        match self {
            Self::Plane(plane) => plane.frame().block_to_normalised(from, to),
            Self::Arm(arm) => arm.to_normalised(from, to),
        }
    }

    /// Configurations `[N x dof]` from normalised units to task units.
    pub fn to_task(&self, from: &[f32], to: &mut [f64]) {
        match self {
            Self::Plane(plane) => plane.frame().block_to_task(from, to),
            Self::Arm(arm) => arm.to_task(from, to),
        }
    }

    /// Length of a trajectory in normalised units.
    pub fn normalised_length(&self, trajectory: &Trajectory) -> f64 {
        match self {
            Self::Plane(plane) => trajectory.length() / plane.frame().scale,
            Self::Arm(_) => trajectory.length(),
        }
    }

    /// The clearance ε under which a configuration costs, in normalised units.
    pub fn epsilon(&self) -> f64 {
        match self {
            Self::Plane(plane) => plane.epsilon(),
            Self::Arm(arm) => arm.epsilon(),
        }
    }

    /// Half the width of a typical passage, in normalised units.
    pub fn typical_clearance(&self) -> f64 {
        match self {
            Self::Plane(plane) => plane.typical_clearance(),
            Self::Arm(arm) => arm.typical_clearance(),
        }
    }

    /// Prepares what costs ask for, so that no iteration pays for it, unless `go_on` becomes false meanwhile; whether it is
    /// prepared.
    pub fn prepare_costs(&self, go_on: &(dyn Fn() -> bool + Sync)) -> bool {
        match self {
            Self::Plane(plane) => plane.prepare_field(go_on),
            Self::Arm(_) => true,
        }
    }

    /// Obstacle costs of a block of configurations, and where asked for their slopes times weight and `factor`.
    #[inline(always)]
    pub(crate) fn cost_and_slope(
        &self,
        block: &mut Block,
        epsilon: f32,
        factor: f32,
        slopes: bool,
    ) {
        match self {
            Self::Plane(plane) => plane.cost_and_slope(block, epsilon, factor, slopes),
            Self::Arm(arm) => arm.cost_and_slope(block, epsilon, factor, slopes),
        }
    }

    /// Whether the profile's feasibility check passes the waypoints `x [N x dof]` between two configurations, all in normalised
    /// units; none where feasible means certified.
    pub fn is_feasible(&self, start: &[f32], x: &[f32], goal: &[f32]) -> Option<bool> {
        match self {
            Self::Plane(plane) => {
                let check = plane.sampled_check()?;
                Some(check.is_feasible([start[0], start[1]], x, [goal[0], goal[1]]))
            }
            Self::Arm(_) => None,
        }
    }

    /// Whether feasible means certified by this profile.
    pub fn feasible_means_certified(&self) -> bool {
        match self {
            Self::Plane(plane) => plane.sampled_check().is_none(),
            Self::Arm(_) => true,
        }
    }

    /// Whether the robot may move straight between two configurations `[dof]`, in task units; from one to itself, whether it
    /// may be there.
    #[inline]
    pub fn motion_is_free(&self, from: &[f64], to: &[f64]) -> bool {
        match self {
            Self::Plane(plane) => {
                plane.certifier().segment_is_free([from[0], from[1]], [to[0], to[1]])
            }
            Self::Arm(arm) => arm.motion_is_free(from, to),
        }
    }

    /// Whether the robot may move from `start` over the waypoints `x [N x dof]`, in normalised units, to `goal`, both `[dof]` and
    /// in task units. Writes to `free [N + 1]` which segments it may move along; without it the first one that it may not ends
    /// the check.
    pub fn path_is_free(
        &self,
        start: &[f64],
        x: &[f32],
        goal: &[f64],
        free: Option<&mut [bool]>,
    ) -> bool {
        match self {
            Self::Plane(plane) => {
                plane.path_is_free([start[0], start[1]], x, [goal[0], goal[1]], free)
            }
            Self::Arm(arm) => arm.path_is_free(start, x, goal, free),
        }
    }

    /// Whether the robot may move along a trajectory: [`Scene::check`] without a reason.
    pub fn is_free(&self, trajectory: &Trajectory) -> bool {
        match self {
            Self::Plane(plane) => plane.certifier().is_certified(points(trajectory)),
            Self::Arm(arm) => arm.is_free(trajectory),
        }
    }

    /// Checks a trajectory, its ends first.
    ///
    /// # Errors
    /// The first violation found.
    pub fn check(&self, trajectory: &Trajectory) -> Result<(), Violation> {
        match self {
            Self::Plane(plane) => plane.certifier().check(trajectory),
            Self::Arm(arm) => arm.check(trajectory),
        }
    }

    /// The smallest distance between the swept robot and anything else, in task units; of a robot with joints that at its
    /// waypoints, in metres.
    pub fn clearance(&self, trajectory: &Trajectory) -> f64 {
        match self {
            Self::Plane(plane) => plane.certifier().clearance(trajectory),
            Self::Arm(arm) => arm.clearance(trajectory),
        }
    }

    /// The exact answer, where there is a search for it: the shortest path, a proof that there is none, or doubt. Broken off once
    /// `go_on` is false.
    pub fn exact(&self, start: &[f64], goal: &[f64], go_on: &dyn Fn() -> bool) -> Option<Route> {
        match self {
            Self::Plane(plane) => {
                let ends = ([start[0], start[1]], [goal[0], goal[1]]);
                Some(match plane.shortest_path_while(go_on) {
                    Some(mut exact) => exact.find_while(ends.0, ends.1, go_on),
                    None => Route::Undecided(Doubt::BrokenOff),
                })
            }
            Self::Arm(_) => None,
        }
    }

    /// A proof that no path leads from start to goal, where one can be had: in the plane, and mostly for robots with up to
    /// three joints, never beyond. None where there is a path, where nothing is known, and once `go_on` is false.
    pub fn disproof(&self, start: &[f64], goal: &[f64], go_on: &dyn Fn() -> bool) -> Option<Proof> {
        match self {
            Self::Plane(_) => match self.exact(start, goal, go_on) {
                Some(Route::Unsolvable(proof)) => Some(proof),
                _ => None,
            },
            Self::Arm(arm) => arm.are_separated(start, goal, go_on).then_some(Proof::Disconnected),
        }
    }
}

/// Certifies a trajectory as an answer to a task. To check many, keep a [`Query`].
///
/// # Errors
/// If the trajectory is not certified.
pub fn certify(task: &Task, trajectory: &Trajectory) -> Result<Certified, Violation> {
    let scene = std::sync::Arc::new(Scene::of(task, &Profile::DEFAULT));
    Query::unchecked(scene, task).certify(trajectory.clone()).map_err(|refused| refused.violation)
}
