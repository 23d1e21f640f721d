//! The certificate: does the swept robot stay strictly clear of every obstacle, exactly, in f64?
//!
//! A segment is certified when its distance to every obstacle is more than
//! `r + tolerance`, with `r` the robot's radius, and both its ends lie in the bounds shrunk by `r`
//! (bounds are closed: the body may touch a wall). Touching an obstacle is not certified. The tolerance
//! ([`World::tolerance`], at least twice what rounding can do, see `near.rs`) is what closes gaps of
//! no width: between boxes that share an edge or a corner, or between a box and the wall that it
//! is flush with. Any single robot position is the segment from it to itself.
//!
//! Nothing is sampled: segments meet shapes by separating axes and exact distances (`distance.rs`,
//! `boxes.rs`), grid cells by an exact walk (`cells.rs`), and above a few dozen shapes buckets
//! (`buckets.rs`) choose which to test. For a point robot, boxes and cells grow by the tolerance
//! with mitred corners, which refuses at most 0.42 tolerances more than the definition.

mod boxes;
mod buckets;
mod cells;
mod distance;
mod near;

use boxes::Boxes;
use std::sync::Arc;

use buckets::Buckets;
pub(crate) use cells::{Cells, Growth};
pub(crate) use distance::segment_obstacle_distance;
use near::Near;

use crate::plane::Robot;
use crate::plane::geometry::{Point, Rect};
use crate::plane::points;
use crate::plane::world::{Obstacle, World};
use crate::trajectory::{ObstacleId, Trajectory, Violation};

/// Above this many shapes, buckets are built.
const MOST_WITHOUT_BUCKETS: usize = 32;

/// A world and a robot prepared for many exact collision checks.
#[derive(Debug, Clone)]
pub struct Certifier {
    /// Where the robot's reference point may be, rounded inwards.
    inside: Rect,
    /// The same, rounded to the nearest numbers.
    bounds: Rect,
    radius: f64,
    tolerance: f64,
    /// Radius and tolerance: what the path must stay away from every obstacle, and more.
    margin: f64,
    obstacles: Vec<Obstacle>,
    boxes: Boxes,
    /// Indices of the shapes that are neither in `boxes` nor in buckets.
    others: Vec<usize>,
    /// Those of a map, and those of shapes that were added to it, where these are many.
    buckets: Vec<Arc<Buckets>>,
    /// How many shapes, the first ones, are in buckets.
    sorted: usize,
    cells: Option<Cells>,
}

impl Certifier {
    /// Prepares the checks of one robot in one world.
    pub fn new(world: &World, robot: Robot) -> Self {
        let radius = robot.radius();
        let Near { obstacles, tolerance } = Near::new(world, robot);
        let margin = radius + tolerance;
        let growth = if radius > 0.0 { Growth::Round(margin) } else { Growth::Square(margin) };
        let cells = world.grid().map(|grid| Cells::new(grid, growth));
        let bounds = world.bounds().inflated(-radius);
        let inside = rounded_inwards(world.bounds(), radius, bounds);
        Self { inside, ..Self::from_parts(bounds, radius, tolerance, obstacles, cells) }
    }

    /// The same from its parts; `bounds` are those of the robot's reference point, and the cells are
    /// already grown.
    pub(crate) fn from_parts(
        bounds: Rect,
        radius: f64,
        tolerance: f64,
        obstacles: Vec<Obstacle>,
        cells: Option<Cells>,
    ) -> Self {
        let margin = radius + tolerance;
        let nothing = Self {
            inside: bounds,
            bounds,
            radius,
            tolerance,
            margin,
            obstacles: Vec::new(),
            boxes: Boxes::new(Vec::new(), margin, radius > 0.0),
            others: Vec::new(),
            buckets: Vec::new(),
            sorted: 0,
            cells,
        };
        nothing.with(&obstacles)
    }

    /// The certifier of the same robot in `world`, which is the certifier's with more obstacles behind its own: what it adds
    /// costs what these cost. None where their coordinates ask for another tolerance.
    pub(crate) fn over(&self, world: &World, robot: Robot) -> Option<Self> {
        let Near { obstacles, tolerance } = Near::new(world, robot);
        (tolerance == self.tolerance).then(|| self.with(&obstacles[self.obstacles.len()..]))
    }

    /// The same with more obstacles, as they are.
    pub(crate) fn with(&self, more: &[Obstacle]) -> Self {
        let obstacles = [&self.obstacles[..], more].concat();
        let mut buckets = self.buckets.clone();
        // What is sorted stays so; a few more are faster met one by one.
        let mut sorted = self.sorted;
        let few = obstacles.len() - sorted <= MOST_WITHOUT_BUCKETS;
        let (mut rects, mut others) = (Vec::new(), Vec::new());
        if few {
            for (index, obstacle) in obstacles.iter().enumerate().skip(sorted) {
                match obstacle {
                    Obstacle::Rect(rect) => rects.push(*rect),
                    _ => others.push(index),
                }
            }
        } else {
            let grown = |shape: &Obstacle| shape.bounding_box().inflated(self.margin);
            let grown: Vec<_> = obstacles[sorted..].iter().map(grown).collect();
            buckets.push(Arc::new(Buckets::new(self.bounds, &grown, sorted)));
            sorted = obstacles.len();
        }
        let boxes = Boxes::new(rects, self.margin, self.radius > 0.0);
        Self { obstacles, boxes, others, buckets, sorted, cells: self.cells.clone(), ..*self }
    }

    /// The robot's radius.
    pub(crate) fn radius(&self) -> f64 {
        self.radius
    }

    /// Distances up to this count as touching.
    pub(crate) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The obstacle shapes.
    pub(crate) fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// The occupied cells.
    pub(crate) fn cells(&self) -> Option<&Cells> {
        self.cells.as_ref()
    }

    /// The distance that a certified path keeps, and more, from every obstacle: the robot's radius
    /// and the tolerance.
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// The rectangle in which the robot's reference point may be: the world's bounds shrunk by the
    /// robot's radius.
    pub fn bounds(&self) -> Rect {
        self.bounds
    }

    /// Whether the robot may stand at `p`.
    #[inline]
    pub fn point_is_free(&self, p: Point) -> bool {
        self.segment_is_free(p, p)
    }

    /// Whether the robot may move straight from `a` to `b`.
    #[inline]
    pub fn segment_is_free(&self, a: Point, b: Point) -> bool {
        self.inside.contains(a) && self.inside.contains(b) && self.segment_avoids_obstacles(a, b)
    }

    /// Whether the robot may move along the points in order. No points are not certified.
    pub fn is_certified(&self, points: &[Point]) -> bool {
        let (Some(&first), true) = (points.first(), self.all_in_bounds(points)) else {
            return false;
        };
        match points.len() {
            1 => self.segment_avoids_obstacles(first, first),
            _ => points.windows(2).all(|pair| self.segment_avoids_obstacles(pair[0], pair[1])),
        }
    }

    /// Certifies a trajectory, or names the first violation: of its ends, then along it.
    ///
    /// # Errors
    /// If the trajectory is not certified.
    pub fn check(&self, trajectory: &Trajectory) -> Result<(), Violation> {
        let points = points(trajectory);
        let (Some(&start), Some(&goal)) = (points.first(), points.last()) else {
            return Err(Violation::EmptyTrajectory);
        };
        let finite = |p: &Point| p[0].is_finite() && p[1].is_finite();
        if let Some(point) = points.iter().position(|p| !finite(p)) {
            return Err(Violation::NotFinite { point });
        }
        if !self.inside.contains(start) {
            return Err(Violation::StartOutOfBounds);
        }
        if let Some(obstacle) = self.first_obstacle_hit(start, start) {
            return Err(Violation::StartInCollision { obstacle });
        }
        if !self.inside.contains(goal) {
            return Err(Violation::GoalOutOfBounds);
        }
        if let Some(obstacle) = self.first_obstacle_hit(goal, goal) {
            return Err(Violation::GoalInCollision { obstacle });
        }
        for (segment, pair) in points.windows(2).enumerate() {
            let (a, b) = (pair[0], pair[1]);
            if !self.inside.contains(b) {
                return Err(Violation::OutOfBounds { segment, point: segment + 1 });
            }
            if let Some(obstacle) = self.first_obstacle_hit(a, b) {
                return Err(Violation::Collision { segment, obstacle });
            }
        }
        Ok(())
    }

    /// The smallest distance from the swept body to any obstacle, occupied cell or wall, exact up to
    /// rounding. Where the path enters an obstacle this is minus the robot's radius, and outside
    /// the bounds it is below that. Infinite for an empty trajectory.
    pub fn clearance(&self, trajectory: &Trajectory) -> f64 {
        self.clearance_of(points(trajectory))
    }

    /// The clearance of a path through these points.
    pub(crate) fn clearance_of(&self, points: &[Point]) -> f64 {
        // To the walls, from the reference point; the extremes are at points.
        let body = self.bounds.inflated(self.radius);
        let mut best =
            points.iter().map(|&p| -body.signed_distance(p)).fold(f64::INFINITY, f64::min);
        let lone = points.iter().take(if points.len() == 1 { 1 } else { 0 }).map(|&p| (p, p));
        let segments = points.windows(2).map(|pair| (pair[0], pair[1]));
        for (a, b) in segments.chain(lone) {
            for obstacle in &self.obstacles {
                if boxes_distance(a, b, &obstacle.bounding_box()) < best {
                    best = best.min(segment_obstacle_distance(a, b, obstacle));
                }
            }
            if let Some(cells) = self.cells.as_ref().filter(|_| best > 0.0) {
                best = cells.distance(a, b, best);
            }
        }
        best - self.radius
    }

    fn all_in_bounds(&self, points: &[Point]) -> bool {
        points.iter().all(|&p| self.inside.contains(p))
    }

    #[inline]
    fn segment_avoids_obstacles(&self, a: Point, b: Point) -> bool {
        self.boxes.segment_is_free(a, b)
            && (self.others.is_empty() || !self.others.iter().any(|&index| self.hits(index, a, b)))
            && !self.buckets.iter().any(|near| near.any_near(a, b, |i| self.hits(i, a, b)))
            && self.cells.as_ref().is_none_or(|cells| cells.segment_is_free(a, b))
    }

    /// Whether the segment comes within the margin of a shape.
    fn hits(&self, index: usize, a: Point, b: Point) -> bool {
        let obstacle = &self.obstacles[index];
        let far = boxes_distance(a, b, &obstacle.bounding_box()) > self.margin;
        !far && segment_obstacle_distance(a, b, obstacle) <= self.margin
    }

    /// What a segment that is not free touches: the shape of least index, else a cell.
    fn first_obstacle_hit(&self, a: Point, b: Point) -> Option<ObstacleId> {
        if self.segment_avoids_obstacles(a, b) {
            return None;
        }
        // Growing the reach covers the mitred corners, and ends: there is something to be found.
        let mut reach = self.margin;
        loop {
            let shape = self
                .obstacles
                .iter()
                .position(|obstacle| segment_obstacle_distance(a, b, obstacle) <= reach)
                .map(ObstacleId::Shape);
            let cell = || self.cells.as_ref().and_then(|cells| cells.hit(a, b, reach));
            if let Some(found) =
                shape.or_else(|| cell().map(|(column, row)| ObstacleId::Cell { column, row }))
            {
                return Some(found);
            }
            reach *= 2.0;
        }
    }
}

/// `shrunk`, the bounds less the radius in rounded arithmetic, without what rounding may have added.
fn rounded_inwards(bounds: Rect, radius: f64, shrunk: Rect) -> Rect {
    let mut inside = shrunk;
    for axis in 0..2 {
        if two_sum_error(bounds.min[axis], radius, shrunk.min[axis]) > 0.0 {
            inside.min[axis] = shrunk.min[axis].next_up();
        }
        if two_sum_error(bounds.max[axis], -radius, shrunk.max[axis]) < 0.0 {
            inside.max[axis] = shrunk.max[axis].next_down();
        }
    }
    inside
}

/// `a + b - sum` without error, for the rounded `sum` of both (D. Knuth, The Art of Computer Programming, vol.
/// 2, 4.2.2, theorem B).
fn two_sum_error(a: f64, b: f64, sum: f64) -> f64 {
    let b_part = sum - a;
    (a - (sum - b_part)) + (b - b_part)
}

/// A lower bound of the distance from segment `a b` to what `rect` bounds: the larger of the gaps
/// along the axes.
fn boxes_distance(a: Point, b: Point, rect: &Rect) -> f64 {
    let gap = |axis: usize| {
        let (low, high) = (a[axis].min(b[axis]), a[axis].max(b[axis]));
        (rect.min[axis] - high).max(low - rect.max[axis])
    };
    gap(0).max(gap(1)).max(0.0)
}

#[cfg(test)]
mod tests;
