//! What a policy sees of a trajectory and what it answers, as arrays: for programs that run its network elsewhere.
//!
//! The inputs are those that planning computes for the first step from a trajectory, the answer is planning's before positions are
//! kept inside the field. A network elsewhere is right if it answers alike.

use super::observation::Encoder;
use super::{Policy, PolicyNetwork};
use crate::arm::view::{ArmSensor, ArmView, ArmViewShape};
use crate::error::InvalidInput;
use crate::network::{Scratch, WaypointNet, WaypointScratch};
use crate::objective::Objective;
use crate::plane::view::{Iterate, Look, TaskMap, ViewParts, WaypointView};

/// What a network reads, and the update that the policy makes of it. Arrays are flat and row-major.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Seen {
    /// The observation, or a waypoint's row for each of them `[N x row]`.
    pub rows: Vec<f32>,
    /// Where a task has a map.
    pub map: Option<SeenMap>,
    /// Of a robot with joints, what is added to the network's scaled answer, `[N x dof]`.
    pub base: Option<Vec<f32>>,
    /// The update: of coordinates, or along and across the line from start to goal, `[N x dof]`, clipped.
    pub update: Vec<f32>,
}

/// The map of a task as a network reads it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SeenMap {
    /// Numbers of each cell, `[cells x cells x 15]`.
    pub cells: Vec<f32>,
    /// Where each waypoint reads features, `[N x 5 x 2]`: column and row, in cells.
    pub places: Vec<f32>,
}

impl Policy {
    /// What the policy sees of the waypoints `x [N x dof]`, in normalised units, as a first trajectory, and its answer.
    ///
    /// # Errors
    /// If the policy does not fit the task or the number of its waypoints.
    ///
    /// # Panics
    /// If `x` is shorter than the objective's trajectories.
    pub fn look(&self, objective: &mut Objective, x: &[f32]) -> Result<Seen, InvalidInput> {
        self.check_use(objective.waypoints(), objective.scene().profile().name)?;
        let refuse = |allowed: String| {
            let found = format!("{}, of {} coordinates", self.card.architecture, self.card.dof);
            InvalidInput::new("policy", found, allowed)
        };
        if self.card.dof != objective.dof() {
            return Err(refuse(format!("one of {}, as the task's robot has", objective.dof())));
        }
        let mut gradient = vec![0.0; objective.dim()];
        objective.cost_and_gradient(x, &mut gradient);
        let mut free = vec![false; objective.waypoints() + 1];
        objective.free_segments(x, &mut free);
        let mut seen = Seen::default();
        match &self.network {
            PolicyNetwork::Whole { parts, network } => {
                let mut encoder = Encoder::new(parts, objective)?;
                seen.rows = vec![0.0; encoder.len(objective)];
                encoder.encode(objective, x, &gradient, &mut seen.rows);
                seen.update = vec![0.0; objective.dim()];
                network.forward(&seen.rows, &mut Scratch::default(), &mut seen.update);
            }
            PolicyNetwork::Waypoint { view, network } => {
                let subject = objective.plane();
                let subject = subject.ok_or_else(|| refuse("a task in the plane for it".into()))?;
                let mut map = view.map.as_ref().map(|shape| TaskMap::new(view, shape, subject));
                if let Some(map) = &mut map {
                    network.read_map(map.scratch());
                    seen.map = Some(SeenMap { cells: map.cells(), places: map.places(x) });
                }
                let mut own = WaypointView::new(view, subject, Look::default());
                let mut scratch = network.scratch(objective.waypoints());
                let rows = scratch.input(objective.waypoints(), network.input_stride());
                let iterate = Iterate { x, free: &free, gradient: &gradient };
                own.encode(subject, iterate, map.as_ref(), rows, network.input_stride());
                seen.take_rows(network, &mut scratch, objective.waypoints());
                blank(view, network, &mut seen.rows);
            }
            PolicyNetwork::Joints { view, network } => {
                let subject = objective.arm();
                let subject = subject.ok_or_else(|| refuse("a robot with joints for it".into()))?;
                let fits = ArmViewShape::of(subject.scene.arm());
                if *view != fits {
                    return Err(refuse(format!("one that sees {}, its robot", fits.names()[0])));
                }
                let (mut own, mut sensor) = (ArmView::new(subject), ArmSensor::new(subject));
                let mut scratch = network.scratch(subject.waypoints);
                let rows = scratch.input(subject.waypoints, network.input_stride());
                own.encode(subject, &mut sensor, (x, &free), rows, network.input_stride());
                seen.take_rows(network, &mut scratch, subject.waypoints);
                seen.base = Some(own.base().to_vec());
            }
        }
        let (rule, base) = (self.card.action, seen.base.as_deref());
        for (i, update) in seen.update.iter_mut().enumerate() {
            let sum = base.map_or(0.0, |base| base[i]) + rule.scale * *update;
            let clipped = sum.clamp(-rule.limit, rule.limit);
            *update = if clipped.is_nan() { 0.0 } else { clipped };
        }
        Ok(seen)
    }
}

impl Seen {
    /// Runs the network on the scratch's rows and keeps both.
    fn take_rows(&mut self, net: &WaypointNet, scratch: &mut WaypointScratch, waypoints: usize) {
        let (stride, row) = (net.input_stride(), net.shape().inputs);
        let rows = scratch.input(waypoints, stride).chunks_exact(stride);
        self.rows = rows.flat_map(|padded| &padded[..row]).copied().collect();
        net.forward(scratch, waypoints);
        scratch.outputs(0..waypoints, &mut self.update);
    }
}

/// Zeros in place of the map's features, which the network elsewhere makes itself.
fn blank(view: &ViewParts, network: &WaypointNet, rows: &mut [f32]) {
    if let Some(features) = view.features_at() {
        for row in rows.chunks_exact_mut(network.shape().inputs) {
            row[features.clone()].fill(0.0);
        }
    }
}
