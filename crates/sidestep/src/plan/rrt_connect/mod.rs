//! RRT-Connect: two trees of certified motions, grown towards random positions and each other.
//!
//! J. Kuffner and S. LaValle, RRT-Connect: an efficient approach to single-query path planning, ICRA
//! 2000, doi:10.1109/ROBOT.2000.844730. The smaller tree is extended by one step towards a uniform
//! sample; the other is then extended towards the new node until it arrives or is blocked. Where
//! this departs: a motion is certified exactly and as a whole, so the last stretch to the other tree
//! is first tried in one piece, however long; and the smaller tree goes first, instead of the two
//! in turns, so that neither starves in a narrow pocket.

mod shortcut;
mod tree;

pub use shortcut::shortcut;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::error::InvalidInput;
use crate::plane::certificate::Certifier;
use crate::plane::geometry::{Point, distance, lerp};
use crate::task::Task;
use crate::trajectory::Trajectory;
use tree::Tree;

/// Parameters of the planner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RrtConnect {
    /// Samples drawn before giving up; at least 1.
    pub max_samples: usize,
    /// Longest motion towards a sample, as a part of the larger side of the bounds; in (0, 1].
    pub step: f64,
    /// Random short cuts tried on the path; 0 leaves it as it was found.
    pub shortcut_rounds: usize,
}

/// Measured on 4,947 solvable tasks of the paper's kind (`examples/exact_timing.rs`): steps of 0.1,
/// 0.2, 0.4 and 1 solve all but at most one. The shorter the step, the shorter the paths (1.06,
/// 1.08, 1.10 and 1.11 of the shortest on average) and the longer the 95th percentile of the time
/// (34, 25, 24 and 20 us).
impl Default for RrtConnect {
    fn default() -> Self {
        Self { max_samples: 20_000, step: 0.1, shortcut_rounds: 32 }
    }
}

/// What a run of the planner did.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RrtRun {
    /// A certified path; none where the samples did not suffice or an end is not free.
    pub trajectory: Option<Trajectory>,
    /// Samples drawn.
    pub samples: usize,
    /// Nodes of both trees.
    pub nodes: usize,
    /// Segments checked.
    pub checks: usize,
}

impl RrtConnect {
    /// Checks the parameters.
    ///
    /// # Errors
    /// If a number is outside its range.
    pub fn validate(&self) -> Result<(), InvalidInput> {
        if self.max_samples == 0 {
            return Err(InvalidInput::new("max_samples", 0, "at least 1"));
        }
        if !(self.step > 0.0 && self.step <= 1.0) {
            return Err(InvalidInput::new("step", self.step, "a number above 0 and at most 1"));
        }
        Ok(())
    }

    /// Plans a task whose world and robot the certifier was prepared for. Not finding a path proves
    /// nothing.
    pub fn plan(&self, task: &Task, certifier: &Certifier, rng: &mut ChaCha8Rng) -> RrtRun {
        let mut run = RrtRun::default();
        let Some(mut points) = self.search(task.start, task.goal, certifier, rng, &mut run) else {
            return run;
        };
        if self.shortcut_rounds > 0 {
            run.checks += shortcut(&mut points, certifier, self.shortcut_rounds, rng);
        }
        run.trajectory = Some(Trajectory::from_points(&points));
        run
    }

    /// Grows the trees; the points from start to goal once they meet.
    fn search(
        &self,
        start: Point,
        goal: Point,
        certifier: &Certifier,
        rng: &mut ChaCha8Rng,
        run: &mut RrtRun,
    ) -> Option<Vec<Point>> {
        run.checks = 3;
        if certifier.segment_is_free(start, goal) {
            return Some(vec![start, goal]);
        }
        if !certifier.point_is_free(start) || !certifier.point_is_free(goal) {
            return None;
        }
        let bounds = certifier.bounds();
        let step = self.step * bounds.extent();
        let mut trees = [Tree::new(start, bounds), Tree::new(goal, bounds)];
        while run.samples < self.max_samples {
            run.samples += 1;
            let sample = [0, 1].map(|axis| {
                let t: f64 = rng.random();
                bounds.min[axis] + t * (bounds.max[axis] - bounds.min[axis])
            });
            let small = usize::from(trees[1].len() < trees[0].len());
            let met = extend(&mut trees[small], sample, step, certifier, run).and_then(|new| {
                let target = trees[small].point(new);
                connect(&mut trees[1 - small], target, step, certifier, run)
                    .map(|other| (new, other))
            });
            run.nodes = trees[0].len() + trees[1].len();
            if let Some((new, other)) = met {
                let (from_start, from_goal) = if small == 0 { (new, other) } else { (other, new) };
                let mut points = trees[0].branch(from_start);
                points.reverse();
                points.extend(trees[1].branch(from_goal));
                return Some(points);
            }
        }
        None
    }
}

/// One step from the nearest node towards `target`; the new node if the motion is free.
fn extend(
    tree: &mut Tree,
    target: Point,
    step: f64,
    certifier: &Certifier,
    run: &mut RrtRun,
) -> Option<usize> {
    let near = tree.nearest(target);
    let from = tree.point(near);
    let length = distance(from, target);
    let to = if length > step { lerp(from, target, step / length) } else { target };
    run.checks += 1;
    certifier.segment_is_free(from, to).then(|| tree.push(to, near))
}

/// Steps from the nearest node towards `target` until it is seen or the way is blocked; the node
/// that sees it, if any.
fn connect(
    tree: &mut Tree,
    target: Point,
    step: f64,
    certifier: &Certifier,
    run: &mut RrtRun,
) -> Option<usize> {
    let mut node = tree.nearest(target);
    loop {
        let from = tree.point(node);
        run.checks += 1;
        if certifier.segment_is_free(from, target) {
            return Some(node);
        }
        let length = distance(from, target);
        if length <= step {
            return None;
        }
        let to = lerp(from, target, step / length);
        run.checks += 1;
        if !certifier.segment_is_free(from, to) {
            return None;
        }
        node = tree.push(to, node);
    }
}

#[cfg(test)]
mod tests;
