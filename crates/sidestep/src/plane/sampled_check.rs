//! The paper's feasibility check: sample points along the trajectory, test each alone.
//!
//! A point is free if it is outside every open obstacle and strictly inside the bounds. The check
//! can miss a corner that is cut between two samples; the exact one is [`crate::plane::certificate`].

use crate::kernels::{Isa, dispatch};
use crate::plane::Robot;
use crate::plane::frame::Frame;
use crate::plane::geometry::Point;
use crate::plane::world::{Obstacle, World};

/// How deep a point must lie in an obstacle to collide, in normalised units: points on a side are
/// legal, and f32 rounding must not decide about them.
const DEPTH: f32 = 2e-6;

const LANES: usize = 16;

/// The check for one world and robot, in normalised units.
#[derive(Debug, Clone)]
pub struct SampledCheck {
    /// Fractions of a segment at which points are tested, both ends included, padded by its end.
    fractions: Vec<f32>,
    /// `[min_x, min_y, max_x, max_y]` of the bounds less the robot's radius.
    bounds: [f32; 4],
    /// Open rectangles, shrunk by [`DEPTH`].
    rects: Vec<[f32; 4]>,
    /// The world itself, where it has more than rectangles or the robot has a radius.
    general: Option<General>,
}

#[derive(Debug, Clone)]
struct General {
    world: World,
    radius: f64,
    frame: Frame,
}

impl SampledCheck {
    /// A check with `substeps` points inside each segment.
    pub fn new(world: &World, robot: Robot, frame: &Frame, substeps: usize) -> Self {
        let rectangles: Option<Vec<[f32; 4]>> = world
            .obstacles()
            .iter()
            .map(|obstacle| match obstacle {
                Obstacle::Rect(rect) => {
                    let [x0, y0] = frame.to_normalised(rect.min);
                    let [x1, y1] = frame.to_normalised(rect.max);
                    Some([x0 + DEPTH, y0 + DEPTH, x1 - DEPTH, y1 - DEPTH])
                }
                _ => None,
            })
            .collect();
        let radius = robot.radius();
        let simple = world.grid().is_none() && radius == 0.0;
        let general = if simple && rectangles.is_some() {
            None
        } else {
            Some(General { world: world.clone(), radius, frame: *frame })
        };
        let inner = world.bounds().inflated(-radius);
        let ([x0, y0], [x1, y1]) = (frame.to_normalised(inner.min), frame.to_normalised(inner.max));
        Self {
            fractions: (0..(substeps + 2).next_multiple_of(LANES))
                .map(|j| (j as f32 / (substeps + 1) as f32).min(1.0))
                .collect(),
            bounds: [x0, y0, x1, y1],
            rects: rectangles.unwrap_or_default(),
            general,
        }
    }

    /// Whether every sampled point from `start` over the waypoints `x` (`[N x 2]`) to `goal` is free.
    pub fn is_feasible(&self, start: [f32; 2], x: &[f32], goal: [f32; 2]) -> bool {
        path_is_free(Isa::detect(), self, start, x.as_chunks::<2>().0, goal)
    }

    /// Whether the sampled points of one segment, its ends included, are free.
    #[inline(always)]
    fn segment_is_free(&self, from: [f32; 2], to: [f32; 2]) -> bool {
        let [min_x, min_y, max_x, max_y] = self.bounds;
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        for fractions in self.fractions.as_chunks::<LANES>().0 {
            let (mut x, mut y) = ([0.0f32; LANES], [0.0f32; LANES]);
            // How far each point is past a wall or inside a rectangle; positive is a collision.
            // Minima and maxima vectorise where comparisons joined by `&` do not.
            let mut depth = [0.0f32; LANES];
            for l in 0..LANES {
                x[l] = from[0] + fractions[l] * dx;
                y[l] = from[1] + fractions[l] * dy;
                let inside_x = (x[l] - min_x).min(max_x - x[l]);
                let inside_y = (y[l] - min_y).min(max_y - y[l]);
                // A point on a wall collides; a NaN must, and `min` would lose it.
                let inside = inside_x.min(inside_y);
                depth[l] = if inside > 0.0 && x[l] + y[l] < f32::INFINITY { -1.0 } else { 1.0 };
            }
            for &[x0, y0, x1, y1] in &self.rects {
                for l in 0..LANES {
                    let inside_x = (x[l] - x0).min(x1 - x[l]);
                    let inside_y = (y[l] - y0).min(y1 - y[l]);
                    depth[l] = depth[l].max(inside_x.min(inside_y));
                }
            }
            if depth.iter().fold(-1.0, |most: f32, &d| most.max(d)) > 0.0 {
                return false;
            }
            if let Some(general) = &self.general
                && !(0..LANES).all(|l| general.is_free([x[l], y[l]]))
            {
                return false;
            }
        }
        true
    }
}

dispatch! {
    /// Whether all segments are free.
    fn path_is_free(check: &SampledCheck, start: [f32; 2], waypoints: &[[f32; 2]], goal: [f32; 2])
        -> bool = path_is_free_body;
}

#[inline(always)]
fn path_is_free_body<const ISA: u8>(
    check: &SampledCheck,
    start: [f32; 2],
    waypoints: &[[f32; 2]],
    goal: [f32; 2],
) -> bool {
    let mut from = start;
    for &to in waypoints.iter().chain([&goal]) {
        if !check.segment_is_free(from, to) {
            return false;
        }
        from = to;
    }
    true
}

impl General {
    fn is_free(&self, p: [f32; 2]) -> bool {
        let p: Point = self.frame.to_task(p);
        let least = self.radius - f64::from(DEPTH) * self.frame.scale;
        if self.world.obstacles().iter().any(|obstacle| obstacle.signed_distance(p) < least) {
            return false;
        }
        let Some(grid) = self.world.grid() else { return true };
        let reach = (self.radius / grid.resolution()).ceil() as i64;
        let (column, row) = grid.cell_of(p);
        !(row - reach..=row + reach).any(|j| {
            (column - reach..=column + reach)
                .any(|i| grid.is_occupied(i, j) && grid.cell_rect(i, j).signed_distance(p) < least)
        })
    }
}
