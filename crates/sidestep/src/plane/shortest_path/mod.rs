//! The exact shortest path of a point or disc among obstacles, or a proof that there is none.
//!
//! A shortest path is straight but for turns at corners of the obstacles grown by the robot (T.
//! Lozano-Perez and M. Wesley, An algorithm for planning collision-free paths among polyhedral
//! obstacles, CACM 1979, doi:10.1145/359156.359164), so a search over corners that see each other
//! is exact. What makes it robust: corners lie two tolerances outside the grown obstacles, and
//! *sees* is the certificate's check, which asks for more than one. Sides on one line, shared
//! edges and touching corners need no special case, a path may run along a side, a gap of no width is
//! closed, and every path is certified.
//!
//! *Solvable* therefore means: there is a path with a clearance of a few tolerances. *Unsolvable* means that there is no path
//! which the certificate would pass: a second search, over corners nearer to the obstacles and with checks that ask for a
//! quarter of what the certificate asks, found none either. Passages between the two, some three tolerances wider than the
//! robot, are left undecided. Arcs, round a disc's corners or circles, are approximated from outside (a path, an
//! upper bound) and from inside (a lower bound, or that proof), finer and finer until both agree on whether there is a path.

mod corners;
mod layer;
mod nodes;
mod raster;
mod route;
mod search;
mod sight;

pub use route::{Doubt, Proof, Route};

use std::sync::{Arc, OnceLock};

use layer::Layer;
use search::{Ending, Limits, Workspace};

use crate::plane::Robot;
use crate::plane::certificate::Certifier;
use crate::plane::geometry::{Point, distance};
use crate::plane::world::World;
use crate::trajectory::Trajectory;

/// Arcs per right angle: a path round a corner is longer than the arc by at most 0.4 %.
const ARCS: u32 = 8;
/// A path at most this many times the lower bound is not approximated more finely.
const CLOSE: f64 = 1.005;
/// The finest approximation tried where the passage is narrow.
const MOST_ARCS: u32 = 64;
/// Most edges that one search checks; what takes longer is undecided.
const MOST_CHECKS: usize = 4_000_000;

/// A world and a robot prepared for shortest-path queries. Clones share what was prepared and have
/// buffers of their own, one for each thread.
#[derive(Debug, Clone)]
pub struct ShortestPath {
    layers: Layers,
    /// Those of the map, where shapes were added to one.
    map: Option<Box<Layers>>,
    is_exact: bool,
    workspace: Workspace,
}

/// What is shared by clones.
#[derive(Debug, Clone)]
struct Layers {
    outside: Arc<Layer>,
    /// The lower bound's corners, from the first query that needs them; none where exact.
    inside: Arc<OnceLock<Layer>>,
}

impl Layers {
    /// The layer of lower bounds, made where there is none yet, on the `map`'s; none once `go_on` is false.
    fn inside(&self, map: Option<&Self>, go_on: &dyn Fn() -> bool) -> Option<&Layer> {
        if self.inside.get().is_none() {
            let known = match map {
                Some(map) => Some(map.inside(None, go_on)?),
                None => None,
            };
            let layer = Layer::inside(&self.outside.certifier, ARCS, known, go_on)?;
            // Whoever was first keeps its own, which is the same.
            let _ = self.inside.set(layer);
        }
        self.inside.get()
    }
}

impl ShortestPath {
    /// Prepares the queries of one robot in one world.
    pub fn new(world: &World, robot: Robot) -> Self {
        Self::of(Certifier::new(world, robot))
    }

    /// Prepares the queries of a certifier's robot in its world.
    pub fn of(certifier: Certifier) -> Self {
        Self::of_while(certifier, &|| true).expect("nobody breaks off")
    }

    /// [`ShortestPath::of`] that is broken off, with nothing, once `go_on` is false.
    pub fn of_while(certifier: Certifier, go_on: &dyn Fn() -> bool) -> Option<Self> {
        let is_exact = Layer::is_exact(&certifier);
        let outside = Arc::new(Layer::outside(certifier, ARCS, None, go_on)?);
        let layers = Layers { outside, inside: Arc::default() };
        Some(Self { layers, map: None, is_exact, workspace: Workspace::default() })
    }

    /// Prepares the queries in this one's world with more obstacles; `certifier` is this one's [`over`](Certifier::over) that
    /// world. What was prepared of the map is shared. None once `go_on` is false.
    pub(crate) fn over_while(
        &self,
        certifier: Certifier,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let is_exact = Layer::is_exact(&certifier);
        let map = self.map.as_deref().unwrap_or(&self.layers);
        let outside = Arc::new(Layer::outside(certifier, ARCS, Some(&map.outside), go_on)?);
        let layers = Layers { outside, inside: Arc::default() };
        let map = Some(Box::new(map.clone()));
        Some(Self { layers, map, is_exact, workspace: Workspace::default() })
    }

    /// Prepares what bounds paths from below and proves that there is none, which the first query that needs it would
    /// prepare; whether it did before `go_on` was false.
    pub fn prepare_bounds(&self, go_on: &dyn Fn() -> bool) -> bool {
        self.layers.inside(self.map.as_deref(), go_on).is_some()
    }

    /// The certifier of the same world and robot.
    pub fn certifier(&self) -> &Certifier {
        &self.layers.outside.certifier
    }

    /// A shortest path between two positions of the robot, certified.
    ///
    /// Repeated calls reuse their buffers; only the answer is allocated.
    pub fn find(&mut self, start: Point, goal: Point) -> Route {
        self.find_while(start, goal, &|| true)
    }

    /// [`ShortestPath::find`] that is broken off ([`Doubt::BrokenOff`]) once `go_on` is false. It is asked every few microseconds.
    pub fn find_while(&mut self, start: Point, goal: Point, go_on: &dyn Fn() -> bool) -> Route {
        let limits = Limits { checks: MOST_CHECKS, go_on };
        let certifier = &self.layers.outside.certifier;
        if !(certifier.point_is_free(start) && certifier.point_is_free(goal)) {
            let ends = Trajectory::from_points(&[start, goal]);
            if let Err(violation) = certifier.check(&ends) {
                return Route::Unsolvable(Proof::End(violation));
            }
        }
        if certifier.segment_is_free(start, goal) {
            let length = distance(start, goal);
            let trajectory = Trajectory::from_points(&[start, goal]);
            return Route::Found { trajectory, length, lower_bound: length };
        }
        if let Some(sight) = &self.layers.outside.sight
            && let (Some(a), Some(b)) = (sight.part(start), sight.part(goal))
            && a != b
        {
            return Route::Unsolvable(Proof::Disconnected);
        }
        let workspace = &mut self.workspace;
        let outer = workspace.search(&self.layers.outside, start, goal, true, limits);
        let trajectory =
            || Trajectory::from_points(&workspace.path(&self.layers.outside, start, goal));
        match outer {
            Ending::OutOfWork => Route::Undecided(Doubt::OutOfWork { checks: MOST_CHECKS }),
            Ending::BrokenOff => Route::Undecided(Doubt::BrokenOff),
            Ending::Found(length) if self.is_exact => {
                Route::Found { trajectory: trajectory(), length, lower_bound: length }
            }
            Ending::Found(length) => {
                let found = (trajectory(), length);
                self.bound([start, goal], Some(found), limits)
            }
            // Shapes that close the way are often wide enough for a proof that takes no second search.
            Ending::Exhausted if self.is_cut(start, goal) => Route::Unsolvable(Proof::Disconnected),
            Ending::Exhausted => self.bound([start, goal], None, limits),
        }
    }

    /// Whether what was added to the map cuts it between two points, as far as cells can tell.
    fn is_cut(&self, start: Point, goal: Point) -> bool {
        let (Some(map), Some(sight)) = (&self.map, &self.layers.outside.sight) else {
            return false;
        };
        let known = map.outside.certifier.obstacles().len();
        sight.is_cut(&self.layers.outside.certifier, known, [start, goal])
    }

    /// Bounds a path from below, or decides whether there is one, by the approximation from inside; both
    /// become finer until they agree.
    fn bound(
        &mut self,
        [start, goal]: [Point; 2],
        found: Option<(Trajectory, f64)>,
        limits: Limits<'_>,
    ) -> Route {
        let workspace = &mut self.workspace;
        let (mut arcs, mut found) = (ARCS, found);
        let mut lower_bound = distance(start, goal);
        loop {
            let fresh;
            let inside = if arcs == ARCS {
                self.layers.inside(self.map.as_deref(), limits.go_on)
            } else {
                fresh = Layer::inside(&self.layers.outside.certifier, arcs, None, limits.go_on);
                fresh.as_ref()
            };
            let Some(inside) = inside else { return broken_off(found, lower_bound) };
            let inner = search(workspace, inside, start, goal, limits);
            if let Ending::Found(bound) = inner {
                lower_bound = lower_bound.max(bound);
            }
            match (found.take(), inner) {
                (Some((trajectory, length)), inner) => {
                    let close = length <= CLOSE * lower_bound || !matches!(inner, Ending::Found(_));
                    if close || arcs == MOST_ARCS {
                        let lower_bound = lower_bound.min(length);
                        return Route::Found { trajectory, length, lower_bound };
                    }
                    found = Some((trajectory, length));
                }
                (None, Ending::Exhausted) => return Route::Unsolvable(Proof::Disconnected),
                (None, Ending::OutOfWork) => {
                    return Route::Undecided(Doubt::OutOfWork { checks: MOST_CHECKS });
                }
                (None, Ending::BrokenOff) => return Route::Undecided(Doubt::BrokenOff),
                (None, Ending::Found(_)) if arcs == MOST_ARCS => {
                    return Route::Undecided(Doubt::NarrowPassage { lower_bound });
                }
                (None, Ending::Found(_)) => {}
            }
            // Perhaps the rules about turning were too strict.
            if found.is_none()
                && arcs == ARCS
                && let Ending::Found(length) =
                    workspace.search(&self.layers.outside, start, goal, false, limits)
            {
                let points = workspace.path(&self.layers.outside, start, goal);
                let trajectory = Trajectory::from_points(&points);
                if self.is_exact {
                    return Route::Found { trajectory, length, lower_bound: length };
                }
                found = Some((trajectory, length));
                continue;
            }
            if self.is_exact {
                return Route::Undecided(Doubt::NarrowPassage { lower_bound });
            }
            arcs *= 2;
            let certifier = self.layers.outside.certifier.clone();
            let Some(outside) = Layer::outside(certifier, arcs, None, limits.go_on) else {
                return broken_off(found, lower_bound);
            };
            let outer = workspace.search(&outside, start, goal, true, limits);
            if let Ending::Found(length) = outer
                && found.as_ref().is_none_or(|known| length < known.1)
            {
                let points = workspace.path(&outside, start, goal);
                found = Some((Trajectory::from_points(&points), length));
            }
        }
    }
}

/// The path found so far, or that time did not allow to find one.
fn broken_off(found: Option<(Trajectory, f64)>, lower_bound: f64) -> Route {
    match found {
        Some((trajectory, length)) => {
            Route::Found { trajectory, length, lower_bound: lower_bound.min(length) }
        }
        None => Route::Undecided(Doubt::BrokenOff),
    }
}

/// A search whose failure is a proof: with the rules about turning, and where that fails once more
/// without them.
fn search(
    workspace: &mut Workspace,
    layer: &Layer,
    start: Point,
    goal: Point,
    limits: Limits<'_>,
) -> Ending {
    match workspace.search(layer, start, goal, true, limits) {
        Ending::Exhausted => workspace.search(layer, start, goal, false, limits),
        ending => ending,
    }
}

#[cfg(test)]
mod grid_tests;
#[cfg(test)]
mod tests;
