//! The paper's feasibility check: sample points along the trajectory, test each alone.
//!
//! A point is free if it is outside every open obstacle and strictly inside the bounds. The check
//! can miss a corner that is cut between two samples; the exact one is [`crate::certificate`].

use crate::geometry::Point;
use crate::profile::Frame;
use crate::robot::Robot;
use crate::world::{Obstacle, World};

/// How deep a point must lie in an obstacle to collide, in normalised units: points on a side are
/// legal, and f32 rounding must not decide about them.
const DEPTH: f32 = 2e-6;

const LANES: usize = 16;

/// The check for one world and robot, in normalised units.
#[derive(Debug, Clone)]
pub struct SampledCheck {
    /// Fractions of a segment at which points are tested.
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
            fractions: (1..=substeps).map(|j| j as f32 / (substeps + 1) as f32).collect(),
            bounds: [x0, y0, x1, y1],
            rects: rectangles.unwrap_or_default(),
            general,
        }
    }

    /// Whether every sampled point from `start` over the waypoints `x` (`[N x 2]`) to `goal` is free.
    pub fn is_feasible(&self, start: [f32; 2], x: &[f32], goal: [f32; 2]) -> bool {
        let mut block = Block::default();
        let mut free = true;
        let mut push = |p: [f32; 2]| {
            block.x[block.len] = p[0];
            block.y[block.len] = p[1];
            block.len += 1;
            if block.len == LANES {
                free = self.block_is_free(&block);
                block.len = 0;
            }
            free
        };
        let waypoints = x.as_chunks::<2>().0;
        let mut from = start;
        push(from);
        for &to in waypoints.iter().chain([&goal]) {
            for &t in &self.fractions {
                push([from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
            }
            if !push(to) {
                return false;
            }
            from = to;
        }
        block.len == 0 || {
            let last = block.len - 1;
            let (last_x, last_y) = (block.x[last], block.y[last]);
            block.x[last..].fill(last_x);
            block.y[last..].fill(last_y);
            self.block_is_free(&block)
        }
    }

    #[inline(always)]
    fn block_is_free(&self, block: &Block) -> bool {
        let [min_x, min_y, max_x, max_y] = self.bounds;
        let mut hit = [false; LANES];
        for l in 0..LANES {
            let (x, y) = (block.x[l], block.y[l]);
            hit[l] = !((x > min_x) & (x < max_x) & (y > min_y) & (y < max_y));
        }
        for &[x0, y0, x1, y1] in &self.rects {
            for l in 0..LANES {
                let (x, y) = (block.x[l], block.y[l]);
                hit[l] |= (x > x0) & (x < x1) & (y > y0) & (y < y1);
            }
        }
        if hit.contains(&true) {
            return false;
        }
        self.general
            .as_ref()
            .is_none_or(|general| (0..LANES).all(|l| general.is_free([block.x[l], block.y[l]])))
    }
}

#[derive(Default)]
struct Block {
    x: [f32; LANES],
    y: [f32; LANES],
    len: usize,
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
