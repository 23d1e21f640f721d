//! The learned optimizer: a trained policy turned into an ordinary optimizer.
//!
//! ξ ← ξ + clip(π(o)), as the policy was trained: the update clipped per coordinate, positions kept
//! inside the field where the policy's card says so.
//!
//! A waypoint policy that is not through after [`PATIENCE`] steps hardly ever gets through by itself. So after every that many steps a
//! trajectory that is not free is bent at random. A policy with a map knows the way: it is bent a little ([`NUDGE`]), and from then
//! on looks at the task another way, from the other end or in a mirror ([`Look`]). One without is bent much ([`KICK`]).

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use crate::arm::view::{ArmSensor, ArmView, ArmViewShape};
use crate::error::InvalidInput;
use crate::network::{Scratch, WaypointNet, WaypointScratch};
use crate::objective::Objective;
use crate::plane::Subject;
use crate::plane::view::{Iterate, Look, TaskMap, ViewParts, WaypointView};
use crate::policy::observation::Encoder;
use crate::policy::{Policy, PolicyNetwork};
use crate::trajectory::waypoints::bend;

/// Steps before a trajectory is bent.
const PATIENCE: u32 = 10;
/// Sizes of the bend with and without a map, in normalised units; see [`bend`].
const NUDGE: f32 = 0.5;
const KICK: f32 = 2.0;
/// Size of the bend of a robot with joints, rad or m.
const TURN: f32 = 0.3;

#[derive(Debug)]
pub(super) struct Learned {
    policy: Arc<Policy>,
    sight: Sight,
    rng: ChaCha8Rng,
}

/// What the policy sees with, and its buffers.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "one to a trajectory, and in a box already")]
enum Sight {
    Whole {
        encoder: Encoder,
        observation: Vec<f32>,
        action: Vec<f32>,
        scratch: Scratch,
    },
    Waypoints {
        /// The looks that were taken so far, in the order of [`Look::ALL`].
        sights: Vec<Sighted>,
        /// Which of them is taken.
        at: usize,
        /// Steps so far.
        age: u32,
        /// Which segments of a bent trajectory are free, `[N + 1]`.
        free: Vec<bool>,
        scratch: WaypointScratch,
    },
    Joints {
        view: ArmView,
        sensor: ArmSensor,
        /// Steps so far.
        age: u32,
        /// Which segments of a bent trajectory are free, `[N + 1]`.
        free: Vec<bool>,
        scratch: WaypointScratch,
    },
}

/// A look at the task. The map is made by the first step, for many a start needs none.
#[derive(Debug)]
struct Sighted {
    view: WaypointView,
    map: Option<TaskMap>,
}

impl Sighted {
    fn new(parts: &ViewParts, subject: Subject<'_>) -> Self {
        Self { view: WaypointView::new(parts, subject, Look::default()), map: None }
    }

    /// The same task looked at another way.
    fn other(
        &self,
        (parts, network): (&ViewParts, &WaypointNet),
        subject: Subject<'_>,
        look: Look,
    ) -> Self {
        let map = self.map.as_ref().map(|map| {
            let mut map = map.other(subject, look);
            network.read_map(map.scratch());
            map
        });
        Self { view: WaypointView::new(parts, subject, look), map }
    }

    /// Reads the task's map, where the policy has one and that has not been done.
    fn read_map(&mut self, parts: &ViewParts, network: &WaypointNet, subject: Subject<'_>) {
        if let (Some(shape), None) = (&parts.map, &self.map) {
            let mut own = TaskMap::new(parts, shape, subject);
            network.read_map(own.scratch());
            self.map = Some(own);
        }
    }

    /// Writes what the network sees of a trajectory.
    fn encode(
        &mut self,
        (parts, network): (&ViewParts, &WaypointNet),
        subject: Subject<'_>,
        seen: Iterate<'_>,
        scratch: &mut WaypointScratch,
    ) {
        self.read_map(parts, network, subject);
        let stride = network.input_stride();
        let rows = scratch.input(subject.waypoints, stride);
        self.view.encode(subject, seen, self.map.as_ref(), rows, stride);
    }
}

impl Learned {
    pub fn new(
        policy: Arc<Policy>,
        objective: &Objective,
        rng: ChaCha8Rng,
    ) -> Result<Self, InvalidInput> {
        policy.check_use(objective.waypoints(), objective.scene().profile().name)?;
        if policy.card().dof != objective.dof() {
            let allowed = format!("{}, as the task's robot has", objective.dof());
            return Err(InvalidInput::new("policy.dof", policy.card().dof, allowed));
        }
        let sight = match policy.network() {
            PolicyNetwork::Whole { parts, .. } => {
                let encoder = Encoder::new(parts, objective)?;
                Sight::Whole {
                    observation: vec![0.0; encoder.len(objective)],
                    action: vec![0.0; objective.dim()],
                    scratch: Scratch::default(),
                    encoder,
                }
            }
            PolicyNetwork::Waypoint { view, network } => {
                let refuse = || {
                    InvalidInput::new("planner", "a waypoint policy", "a robot in the plane for it")
                };
                Sight::Waypoints {
                    sights: vec![Sighted::new(view, objective.plane().ok_or_else(refuse)?)],
                    at: 0,
                    age: 0,
                    free: vec![false; objective.waypoints() + 1],
                    scratch: network.scratch(objective.waypoints()),
                }
            }
            PolicyNetwork::Joints { view, network } => {
                let subject = objective.arm().filter(|s| *view == ArmViewShape::of(s.scene.arm()));
                let refuse = || {
                    let allowed = format!(
                        "a robot of {} joints and {} balls that are looked at for it",
                        view.dof, view.balls
                    );
                    InvalidInput::new("planner", "a policy of a robot with joints", allowed)
                };
                let subject = subject.ok_or_else(refuse)?;
                Sight::Joints {
                    view: ArmView::new(subject),
                    sensor: ArmSensor::new(subject),
                    age: 0,
                    free: vec![false; objective.waypoints() + 1],
                    scratch: network.scratch(objective.waypoints()),
                }
            }
        };
        Ok(Self { policy, sight, rng })
    }

    /// One update of `x`, whose `gradient` or `free` segments are known.
    pub fn step(&mut self, x: &mut [f32], gradient: &[f32], free: &[bool], objective: &Objective) {
        let rule = &self.policy.card().action;
        match (self.policy.network(), &mut self.sight, objective.plane()) {
            (
                PolicyNetwork::Whole { network, .. },
                Sight::Whole { encoder, observation, action, scratch },
                _,
            ) => {
                encoder.encode(objective, x, gradient, observation);
                network.forward(observation, scratch, action);
                rule.apply(action, objective.scene().normalised_limits(), x);
            }
            (
                PolicyNetwork::Waypoint { view: parts, network },
                Sight::Waypoints { sights, at, age, free: own, scratch },
                Some(subject),
            ) => {
                let policy = (parts, network);
                if *age > 0 && age.is_multiple_of(PATIENCE) && free.contains(&false) {
                    if parts.map.is_some() {
                        bend(2, x, NUDGE, &mut self.rng);
                        *at = (*at + 1) % Look::ALL.len();
                        if *at == sights.len() {
                            sights.push(sights[0].other(policy, subject, Look::ALL[*at]));
                        }
                    } else {
                        bend(2, x, KICK, &mut self.rng);
                    }
                    *age += 1;
                    if parts.gradient {
                        // Of where it was, and not of where it is now: that is for the next step.
                        return;
                    }
                    objective.free_segments(x, own);
                    let seen = Iterate { x, free: own, gradient };
                    sights[*at].encode(policy, subject, seen, scratch);
                } else {
                    *age += 1;
                    sights[*at].encode(policy, subject, Iterate { x, free, gradient }, scratch);
                }
                network.forward(scratch, objective.waypoints());
                sights[*at].view.apply(rule, |i| scratch.pair(i), x);
            }
            (
                PolicyNetwork::Joints { network, .. },
                Sight::Joints { view, sensor, age, free: own, scratch },
                _,
            ) => {
                let Some(subject) = objective.arm() else { return };
                let stuck = *age > 0 && age.is_multiple_of(PATIENCE) && free.contains(&false);
                if stuck {
                    bend(objective.dof(), x, TURN, &mut self.rng);
                    objective.free_segments(x, own);
                }
                *age += 1;
                let stride = network.input_stride();
                let rows = scratch.input(subject.waypoints, stride);
                let free = if stuck { own } else { free };
                view.encode(subject, sensor, (x, free), rows, stride);
                network.forward(scratch, subject.waypoints);
                view.apply(subject, rule, |i| scratch.output(i), x);
            }
            // `new` made the sight that belongs to the network, in the plane where it needs one.
            _ => {}
        }
    }

    /// Reads the task's map, where the policy has one and that has not been done; else the first step does it.
    pub fn prepare(&mut self, objective: &Objective) {
        if let (
            PolicyNetwork::Waypoint { view: parts, network },
            Sight::Waypoints { sights, .. },
            Some(subject),
        ) = (self.policy.network(), &mut self.sight, objective.plane())
        {
            sights[0].read_map(parts, network, subject);
        }
    }

    /// Whether the policy sees the gradient of U.
    pub fn uses_gradient(&self) -> bool {
        match self.policy.network() {
            PolicyNetwork::Whole { .. } => true,
            PolicyNetwork::Waypoint { view, .. } => view.gradient,
            PolicyNetwork::Joints { .. } => false,
        }
    }

    /// Whether the policy sees which segments are free.
    pub fn uses_free_segments(&self) -> bool {
        matches!(self.sight, Sight::Waypoints { .. } | Sight::Joints { .. })
    }
}
