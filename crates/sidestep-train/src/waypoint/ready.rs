//! A task made ready for waypoint policies, and the one loop that walks it: see, think, move, until
//! free.

use sidestep::Task;
use sidestep::network::{WaypointNet, WaypointScratch};
use sidestep::objective::Objective;
use sidestep::plane::view::{Iterate, Look, TaskMap, ViewParts, WaypointView};
use sidestep::policy::ActionRule;
use sidestep::profile::Profile;
use sidestep::scene::Query;

/// A task, and the map of it if the policy reads one.
#[derive(Debug, Clone)]
pub(crate) struct Ready {
    pub objective: Objective,
    pub map: Option<TaskMap>,
    /// The gradient of U at what was seen last, if policies see it; else nothing.
    gradient: Vec<f32>,
}

impl Ready {
    /// The map's features are not there until [`Ready::read_map`] or [`Ready::begin_map`]. None
    /// outside of the plane, which is where these policies see.
    pub fn new(view: &ViewParts, objective: Objective) -> Option<Self> {
        let subject = objective.plane()?;
        let map = view.map.as_ref().map(|shape| TaskMap::new(view, shape, subject));
        let gradient = vec![0.0; if view.gradient { objective.dim() } else { 0 }];
        Some(Self { objective, map, gradient })
    }

    /// The task as waypoint policies know it.
    pub fn query(task: &Task) -> Query {
        Query::of(task, &Profile::DEFAULT)
    }

    /// A view of the task for one walk.
    pub fn view(&self, parts: &ViewParts) -> Option<WaypointView> {
        Some(WaypointView::new(parts, self.objective.plane()?, Look::default()))
    }

    /// Reads the map with the network as it is now.
    pub fn read_map(&mut self, net: &WaypointNet) {
        if let Some(map) = &mut self.map {
            net.read_map(map.scratch());
        }
    }

    /// The same for a map that gradients will go back through.
    pub fn begin_map(&mut self, net: &WaypointNet) {
        if let Some(map) = &mut self.map {
            net.begin_map(map.scratch());
            net.read_map(map.scratch());
        }
    }

    /// Adds the gradient of what the map collected to `gradient`.
    pub fn learn_map(&mut self, net: &WaypointNet, gradient: &mut [f32]) {
        if let Some(map) = &mut self.map {
            net.map_backward(map.scratch(), gradient);
        }
    }

    /// Whether the trajectory `x [N x dof]` is free; `free [N + 1]` says it of each segment.
    pub fn is_free(&self, x: &[f32], free: &mut Vec<bool>) -> bool {
        free.resize(self.objective.waypoints() + 1, false);
        self.objective.free_segments(x, free)
    }

    /// Writes to `rows` what `view` sees at `x`, of which [`Ready::is_free`] wrote `free`.
    pub fn see(
        &mut self,
        view: &mut WaypointView,
        x: &[f32],
        free: &[bool],
        rows: &mut [f32],
        stride: usize,
    ) {
        if !self.gradient.is_empty() {
            self.objective.cost_and_gradient(x, &mut self.gradient);
        }
        if let Some(subject) = self.objective.plane() {
            let seen = Iterate { x, free, gradient: &self.gradient };
            view.encode(subject, seen, self.map.as_ref(), rows, stride);
        }
    }

    /// The index of the first iterate from `x` that is free, of `steps` at most; 0 is `x` itself.
    pub fn first_free(
        &mut self,
        mut view: WaypointView,
        mut x: Vec<f32>,
        (net, rule): (&WaypointNet, &ActionRule),
        steps: usize,
        scratch: &mut WaypointScratch,
    ) -> Option<usize> {
        let (waypoints, stride) = (self.objective.waypoints(), net.input_stride());
        let mut free = Vec::new();
        for step in 0..=steps {
            if self.is_free(&x, &mut free) {
                return Some(step);
            }
            if step < steps {
                self.see(&mut view, &x, &free, scratch.input(waypoints, stride), stride);
                net.forward(scratch, waypoints);
                view.apply(rule, |i| scratch.output(i), &mut x);
            }
        }
        None
    }
}
