//! [`ArmScene`]: what a robot with joints answers about configurations, for the seam in [`crate::scene`].
//!
//! Normalised units of a configuration are its own: rad and m, from 0. A turn by 1 rad and a slide by 1 m move an arm
//! about as far. Clearances are normalised in `costs.rs`.

use std::sync::{Arc, Mutex, PoisonError};

use super::cells::are_separated;
use super::certificate::{Certifier, Hit, Met, Verdict, Work};
use super::costs::{Buffers, cost_and_slope};
use super::robot::Arm;
use crate::kernels::Block;
use crate::profile::Profile;
use crate::space::World;
use crate::trajectory::{ObstacleId, Trajectory, Violation};

/// A robot with joints in a world, and a profile, prepared for every query there.
#[derive(Debug)]
pub struct ArmScene {
    certifier: Certifier,
    profile: Profile,
    limits: Vec<[f64; 2]>,
    normalised_limits: Vec<[f32; 2]>,
    /// Buffers of those who asked before; as many as ever asked at once.
    #[allow(clippy::vec_box, reason = "each question moves one out and in")]
    idle: Mutex<Vec<Box<Room>>>,
}

/// Buffers for one who asks.
#[derive(Debug)]
struct Room {
    work: Work,
    costs: Buffers,
    /// Two configurations, `[dof]` each.
    from: Vec<f64>,
    to: Vec<f64>,
}

impl ArmScene {
    /// Prepares the checks. The world's frame is that of the arm's root link.
    pub fn new(arm: &Arc<Arm>, world: &Arc<World>, profile: &Profile) -> Self {
        let limits: Vec<[f64; 2]> = arm.joints().iter().map(|j| [j.lower, j.upper]).collect();
        let narrow = |limits: &[f64; 2]| limits.map(|limit| limit as f32);
        Self {
            certifier: Certifier::new(Arc::clone(arm), Arc::clone(world)),
            profile: profile.clone(),
            normalised_limits: limits.iter().map(narrow).collect(),
            limits,
            idle: Mutex::default(),
        }
    }

    /// The robot.
    pub fn arm(&self) -> &Arc<Arm> {
        self.certifier.arm()
    }

    /// The world.
    pub fn world(&self) -> &Arc<World> {
        self.certifier.world()
    }

    /// The profile that the scene was built for.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }

    /// The certificate.
    pub fn certifier(&self) -> &Certifier {
        &self.certifier
    }

    /// The joints' limits `[dof]`, rad or m.
    pub fn limits(&self) -> &[[f64; 2]] {
        &self.limits
    }

    /// The same in f32.
    pub fn normalised_limits(&self) -> &[[f32; 2]] {
        &self.normalised_limits
    }

    /// Configurations `[N x dof]` in f32.
    pub fn to_normalised(&self, from: &[f64], to: &mut [f32]) {
        to.iter_mut().zip(from).for_each(|(to, &from)| *to = from as f32);
    }

    /// Configurations `[N x dof]` in f64. Where rounding to f32 left the limits, they are taken back to them.
    pub fn to_task(&self, from: &[f32], to: &mut [f64]) {
        let dof = self.limits.len();
        for (from, to) in from.chunks_exact(dof).zip(to.chunks_exact_mut(dof)) {
            for (k, (&from, to)) in from.iter().zip(to).enumerate() {
                let ([lower, upper], [least, most]) = (self.limits[k], self.normalised_limits[k]);
                let value = f64::from(from);
                let within = least <= from && from <= most;
                *to = if within { value.clamp(lower, upper) } else { value };
            }
        }
    }

    /// The profile's clearance, in normalised units.
    pub fn epsilon(&self) -> f64 {
        self.profile.epsilon
    }

    /// Half the profile's clearance: no passage is known to be typical.
    pub fn typical_clearance(&self) -> f64 {
        0.5 * self.profile.epsilon
    }

    /// Obstacle costs of a block of configurations, and where asked for their slopes times weight and `factor`.
    pub(crate) fn cost_and_slope(
        &self,
        block: &mut Block,
        epsilon: f32,
        factor: f32,
        slopes: bool,
    ) {
        self.in_room(|room| {
            cost_and_slope(&self.certifier, &mut room.costs, block, epsilon, factor, slopes);
        });
    }

    /// Whether a motion is proved free and within the limits.
    pub fn motion_is_free(&self, from: &[f64], to: &[f64]) -> bool {
        self.in_room(|room| {
            self.is_within(from)
                && self.is_within(to)
                && self.certifier.motion_is_free(from, to, &mut room.work)
        })
    }

    /// Whether the robot may move from `start` over the waypoints `x [N x dof]`, in normalised units, to `goal`. Writes to
    /// `free [N + 1]` which segments it may move along; without it the first one that it may not ends the check.
    pub fn path_is_free(
        &self,
        start: &[f64],
        x: &[f32],
        goal: &[f64],
        mut free: Option<&mut [bool]>,
    ) -> bool {
        let dof = self.limits.len();
        self.in_room(|room| {
            let Room { work, from, to, .. } = room;
            from.copy_from_slice(start);
            let mut all = self.is_within(from);
            for segment in 0..=x.len() / dof {
                match x.get(segment * dof..(segment + 1) * dof) {
                    Some(point) => self.to_task(point, to),
                    None => to.copy_from_slice(goal),
                }
                let is_free = self.is_within(from)
                    && self.is_within(to)
                    && self.certifier.motion_is_free(from, to, work);
                all &= is_free;
                match &mut free {
                    Some(free) => free[segment] = is_free,
                    None if !all => return false,
                    None => {}
                }
                std::mem::swap(from, to);
            }
            all
        })
    }

    /// Whether the robot may move along a trajectory: [`Self::check`] without a reason.
    pub fn is_free(&self, trajectory: &Trajectory) -> bool {
        let Some(first) = trajectory.configurations().next() else { return false };
        let free = |(from, to): (&[f64], &[f64])| self.motion_is_free(from, to);
        self.motion_is_free(first, first) && trajectory.segments().all(free)
    }

    /// Checks a trajectory, its ends first.
    ///
    /// # Errors
    /// The first violation found.
    pub fn check(&self, trajectory: &Trajectory) -> Result<(), Violation> {
        let points: Vec<&[f64]> = trajectory.configurations().collect();
        let (Some(first), Some(last)) = (points.first(), points.last()) else {
            return Err(Violation::EmptyTrajectory);
        };
        let is_finite = |point: &&[f64]| point.iter().all(|value| value.is_finite());
        if let Some(point) = points.iter().position(|point| !is_finite(point)) {
            return Err(Violation::NotFinite { point });
        }
        for (point, values) in points.iter().enumerate() {
            if let Some(coordinate) = self.outside(values) {
                return Err(Violation::OutOfLimits { point, coordinate });
            }
        }
        self.in_room(|room| {
            match self.certifier.judge(first, first, &mut room.work) {
                Verdict::Free => {}
                Verdict::Blocked(hit) => {
                    return Err(Violation::StartInCollision { obstacle: self.met(&hit) });
                }
                Verdict::Undecided(_) => return Err(Violation::Undecided { segment: 0 }),
            }
            match self.certifier.judge(last, last, &mut room.work) {
                Verdict::Free => {}
                Verdict::Blocked(hit) => {
                    return Err(Violation::GoalInCollision { obstacle: self.met(&hit) });
                }
                Verdict::Undecided(_) => {
                    return Err(Violation::Undecided { segment: points.len().saturating_sub(2) });
                }
            }
            for (segment, pair) in points.windows(2).enumerate() {
                match self.certifier.judge(pair[0], pair[1], &mut room.work) {
                    Verdict::Free => {}
                    Verdict::Blocked(hit) => {
                        return Err(Violation::Collision { segment, obstacle: self.met(&hit) });
                    }
                    Verdict::Undecided(_) => return Err(Violation::Undecided { segment }),
                }
            }
            Ok(())
        })
    }

    /// Whether it is proved that no motion leads from one configuration to another; of robots with up to three joints.
    pub fn are_separated(&self, start: &[f64], goal: &[f64], go_on: &dyn Fn() -> bool) -> bool {
        are_separated(&self.certifier, start, goal, go_on)
    }

    /// What is wrong with a trajectory, in full: which link meets what, where, and how deep. None if nothing collides.
    pub fn hit(&self, trajectory: &Trajectory) -> Option<Hit> {
        self.in_room(|room| {
            let judge =
                |(from, to): (&[f64], &[f64])| match self.certifier.judge(from, to, &mut room.work)
                {
                    Verdict::Blocked(hit) => Some(hit),
                    _ => None,
                };
            trajectory.segments().find_map(judge)
        })
    }

    /// The least gap between a ball of the body and a piece of the world at the trajectory's configurations, in metres,
    /// f64: an upper bound of the clearance of the motion. Infinite in an empty world.
    pub fn clearance(&self, trajectory: &Trajectory) -> f64 {
        let (arm, world) = (self.arm(), self.world());
        let mut least = f64::INFINITY;
        let mut near = Vec::new();
        let everything = world.bounds().map_or(0.0, |bounds| {
            let ends = [bounds.min, bounds.max].concat();
            ends.iter().fold(0.0, |far: f64, v| far.max(v.abs())) * 2.0 + arm.reach()
        });
        for configuration in trajectory.configurations() {
            for ball in arm.balls_at(configuration) {
                let reach = if least.is_finite() { least.max(0.0) } else { everything };
                world.near(ball.center, ball.radius + reach, &mut near);
                for &piece in &near {
                    least = least.min(world.distance(piece, ball.center).0 - ball.radius);
                }
            }
        }
        least
    }

    /// The first coordinate that is outside its limits, if any.
    fn outside(&self, configuration: &[f64]) -> Option<usize> {
        let mut pairs = configuration.iter().zip(self.arm().joints());
        pairs.position(|(&value, joint)| !joint.allows(value))
    }

    fn is_within(&self, configuration: &[f64]) -> bool {
        self.outside(configuration).is_none()
    }

    /// What was hit, by number.
    fn met(&self, hit: &Hit) -> ObstacleId {
        let link = self.arm().link_index(&hit.link);
        match &hit.with {
            Met::Object(name) => {
                let objects = self.world().objects();
                let object = objects.iter().position(|object| object.name() == name);
                ObstacleId::Object { link, object: object.unwrap_or(0) }
            }
            Met::Link(name) => ObstacleId::Link { link, other: self.arm().link_index(name) },
        }
    }

    /// Runs a question with buffers of its own.
    fn in_room<T>(&self, ask: impl FnOnce(&mut Room) -> T) -> T {
        // Buffers hold nothing between questions, so those of one who panicked are as good.
        let idle = || self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        let room = idle().pop();
        let mut room = room.unwrap_or_else(|| {
            let zeros = || vec![0.0; self.limits.len()];
            Box::new(Room {
                work: self.certifier.work(),
                costs: Buffers::new(&self.certifier),
                from: zeros(),
                to: zeros(),
            })
        });
        let answer = ask(&mut room);
        idle().push(room);
        answer
    }
}
