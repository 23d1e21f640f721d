//! The learned optimizer: a trained policy turned into an ordinary optimizer.
//!
//! ξ ← ξ + clip(π(o)), as the policy was trained: the update clipped per coordinate, positions kept
//! inside the field where the policy's card says so.
//!
//! A waypoint policy that is not through after [`PATIENCE`] steps hardly ever gets through by itself. So every that many steps a
//! trajectory that is not free is bent at random first (`KICK`), which is what the optimizer does about local optima.

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;

use crate::error::InvalidInput;
use crate::network::{Scratch, WaypointNet, WaypointScratch};
use crate::objective::Objective;
use crate::observation::Encoder;
use crate::policy::{Policy, PolicyNetwork};
use crate::starts::bend;
use crate::task::Task;
use crate::waypoint_view::{TaskMap, ViewParts, WaypointView};

/// Steps between two kicks.
const PATIENCE: u32 = 10;
/// Size of a kick, in normalised units; see [`bend`].
const KICK: f32 = 2.0;

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
    /// The map is made by the first step, for many a start needs none.
    Waypoints {
        view: WaypointView,
        map: Option<TaskMap>,
        scratch: WaypointScratch,
    },
}

impl Learned {
    pub fn new(
        policy: Arc<Policy>,
        task: &Task,
        objective: &Objective,
        rng: ChaCha8Rng,
    ) -> Result<Self, InvalidInput> {
        policy.check_use(objective.waypoints(), objective.scene().profile().name)?;
        let sight = match policy.network() {
            PolicyNetwork::Whole { parts, .. } => {
                let encoder = Encoder::new(parts, objective, &task.world)?;
                Sight::Whole {
                    observation: vec![0.0; encoder.len(objective)],
                    action: vec![0.0; objective.dim()],
                    scratch: Scratch::default(),
                    encoder,
                }
            }
            PolicyNetwork::Waypoint { view, .. } => Sight::Waypoints {
                view: WaypointView::new(&view.probes, objective),
                map: None,
                scratch: WaypointScratch::default(),
            },
        };
        Ok(Self { policy, sight, rng })
    }

    pub fn step(&mut self, x: &mut [f32], gradient: &[f32], objective: &Objective) {
        let rule = &self.policy.card().action;
        match (self.policy.network(), &mut self.sight) {
            (
                PolicyNetwork::Whole { network, .. },
                Sight::Whole { encoder, observation, action, scratch },
            ) => {
                encoder.encode(objective, x, gradient, observation);
                network.forward(observation, scratch, action);
                rule.apply(action, objective.scene().field_size(), x);
            }
            (
                PolicyNetwork::Waypoint { view: parts, network },
                Sight::Waypoints { view, map, scratch },
            ) => {
                let (waypoints, stride) = (objective.waypoints(), network.input_stride());
                read_map(parts, network, objective, map);
                let rows = scratch.input(waypoints, stride);
                view.encode(objective, x, map.as_ref(), rows, stride);
                let age = view.age();
                if age > 0 && age.is_multiple_of(PATIENCE) && !view.is_free() {
                    bend(x, KICK, &mut self.rng);
                    view.encode(objective, x, map.as_ref(), rows, stride);
                }
                network.forward(scratch, waypoints);
                view.apply(rule, |i| scratch.output(i), x);
            }
            // `new` made the sight that belongs to the network.
            _ => {}
        }
    }

    /// Reads the task's map, where the policy has one and that has not been done; else the first step does it.
    pub fn prepare(&mut self, objective: &Objective) {
        if let (PolicyNetwork::Waypoint { view: parts, network }, Sight::Waypoints { map, .. }) =
            (self.policy.network(), &mut self.sight)
        {
            read_map(parts, network, objective, map);
        }
    }

    /// Whether the policy sees the gradient of U.
    pub fn uses_gradient(&self) -> bool {
        matches!(self.sight, Sight::Whole { .. })
    }
}

fn read_map(
    parts: &ViewParts,
    network: &WaypointNet,
    objective: &Objective,
    map: &mut Option<TaskMap>,
) {
    if let (Some(shape), None) = (&parts.map, &map) {
        let mut own = TaskMap::new(shape, objective);
        network.read_map(own.scratch());
        *map = Some(own);
    }
}
