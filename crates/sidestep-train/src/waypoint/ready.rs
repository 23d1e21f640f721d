//! A task made ready for waypoint policies, and the one loop that walks it: see, think, move, until
//! free.

use rand_chacha::ChaCha8Rng;
use sidestep::network::{WaypointNet, WaypointScratch};
use sidestep::objective::Objective;
use sidestep::plane::view::TaskMap;
use sidestep::policy::ActionRule;
use sidestep::profile::Profile;
use sidestep::scene::Query;
use sidestep::{Route, Task};

use super::sight::{Eyes, Sight, View};
use crate::routes::{Target, jointed, sparingly_grown};

/// A task, and what it is looked at with.
#[derive(Debug, Clone)]
pub(crate) struct Ready {
    pub objective: Objective,
    eyes: Eyes,
}

impl Ready {
    /// A map's features are not there until [`Ready::read_map`] or [`Ready::begin_map`]. None if the
    /// sight is for another kind of robot.
    pub fn new(sight: &Sight, objective: Objective) -> Option<Self> {
        let eyes = Eyes::new(sight, &objective)?;
        Some(Self { objective, eyes })
    }

    /// The task as waypoint policies know it.
    pub fn query(task: &Task) -> Query {
        Query::of(task, &Profile::DEFAULT)
    }

    /// A view of the task for one walk.
    pub fn view(&self, sight: &Sight) -> Option<View> {
        View::new(sight, &self.objective)
    }

    /// The task's map, where the policy reads one.
    pub fn map(&mut self) -> Option<&mut TaskMap> {
        self.eyes.map()
    }

    /// Reads the map with the network as it is now.
    pub fn read_map(&mut self, net: &WaypointNet) {
        self.eyes.read_map(net);
    }

    /// The same for a map that gradients will go back through.
    pub fn begin_map(&mut self, net: &WaypointNet) {
        if let Some(map) = self.map() {
            net.begin_map(map.scratch());
            net.read_map(map.scratch());
        }
    }

    /// Adds the gradient of what the map collected to `gradient`.
    pub fn learn_map(&mut self, net: &WaypointNet, gradient: &mut [f32]) {
        if let Some(map) = self.map() {
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
        view: &mut View,
        x: &[f32],
        free: &[bool],
        rows: &mut [f32],
        stride: usize,
    ) {
        self.eyes.see(&mut self.objective, view, (x, free), rows, stride);
    }

    /// The index of the first iterate from `x` that is free, of `steps` at most; 0 is `x` itself.
    pub fn first_free(
        &mut self,
        mut view: View,
        mut x: Vec<f32>,
        (net, rule): (&WaypointNet, &ActionRule),
        steps: usize,
        scratch: &mut WaypointScratch,
    ) -> Option<usize> {
        let (waypoints, stride) = (self.objective.waypoints(), net.input_stride());
        let (mut free, mut outputs) = (Vec::new(), Vec::new());
        for step in 0..=steps {
            if self.is_free(&x, &mut free) {
                return Some(step);
            }
            if step < steps {
                self.see(&mut view, &x, &free, scratch.input(waypoints, stride), stride);
                net.forward(scratch, waypoints);
                scratch.outputs(0..waypoints, &mut outputs);
                view.apply(&self.objective, rule, &outputs, &mut x);
            }
        }
        None
    }

    /// The routes that an expert would take; none if there is no way.
    pub fn targets(&self, task: &Task, rng: &mut ChaCha8Rng) -> Vec<Target> {
        match task.plane() {
            Ok(plane) => sparingly_grown::targets(plane, &self.objective, rng),
            Err(_) => jointed::targets(&self.objective, rng),
        }
    }
}

/// What lengths are compared with: the shortest path's length in the plane, that of a few searches
/// of a robot with joints. None if there is no path, or none was found.
pub(crate) fn reference_length(query: &Query, rng: &mut ChaCha8Rng) -> Option<f64> {
    match query.scene().exact(query.start(), query.goal(), &|| true) {
        Some(route) => route.length(),
        None => jointed::reference(query, rng).map(|path| path.length()),
    }
}

/// Whether there is a path, as far as searches tell.
pub(crate) fn is_solvable(query: &Query, rng: &mut ChaCha8Rng) -> bool {
    match query.scene().exact(query.start(), query.goal(), &|| true) {
        Some(route) => matches!(route, Route::Found { .. }),
        None => jointed::reference(query, rng).is_some(),
    }
}
