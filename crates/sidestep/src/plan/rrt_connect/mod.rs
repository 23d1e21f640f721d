//! RRT-Connect: two trees of certified motions, grown towards random positions and each other.
//!
//! J. Kuffner and S. LaValle, RRT-Connect: an efficient approach to single-query path planning, ICRA
//! 2000, doi:10.1109/ROBOT.2000.844730. The smaller tree is extended by one step towards a uniform
//! sample; the other is then extended towards the new node until it arrives or is blocked. Where
//! this departs: a motion is certified exactly and as a whole, so the last stretch to the other tree
//! is first tried in one piece, however long; and the smaller tree goes first, instead of the two
//! in turns, so that neither starves in a narrow pocket.

mod lanes;
pub mod shortcut;
mod tree;

pub use shortcut::shortcut;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::error::InvalidInput;
use crate::plan::answer::{Origin, Plan, Reason, Status};
use crate::plan::options::{Options, Watch};
use crate::rng::{Purpose, stream};
use crate::scene::{Query, Scene};
use crate::trajectory::{Trajectory, distance};
use tree::Tree;

/// With more than two coordinates, a node whose extension was blocked is extended only towards samples nearer than this part of the
/// distance that two random configurations have (A. Yershova, L. Jaillet, T. Siméon and S. LaValle, Dynamic-domain RRTs,
/// ICRA 2005, doi:10.1109/ROBOT.2005.1570709): others would mostly meet the same obstacle.
const DOMAIN: f64 = 0.7;
/// One in so many of those others is looked at all the same, so that no tree stands still for ever.
const REFUSED: usize = 16;

/// Samples from one question whether to go on to the next.
const SAMPLES_A_QUESTION: usize = 16;

/// Parameters of the planner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RrtConnect {
    /// Samples drawn before giving up; at least 1.
    pub max_samples: usize,
    /// Nodes of both trees before giving up.
    pub max_nodes: usize,
    /// Longest motion towards a sample, as a part of the largest range of a coordinate; in (0, 1].
    pub step: f64,
    /// Random short cuts tried on the path; 0 leaves it as it was found.
    pub shortcut_rounds: usize,
}

/// Measured on 4,947 solvable tasks of the paper's kind (`benches/exact_timing.rs`): steps of 0.1,
/// 0.2, 0.4 and 1 solve all but at most one. The shorter the step, the shorter the paths (1.06,
/// 1.08, 1.10 and 1.11 of the shortest on average) and the longer the 95th percentile of the time
/// (34, 25, 24 and 20 us).
impl Default for RrtConnect {
    fn default() -> Self {
        Self { max_samples: 20_000, max_nodes: usize::MAX, step: 0.1, shortcut_rounds: 32 }
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
    /// Whether `go_on` ended it.
    pub broken_off: bool,
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

    /// Answers a query. Not finding a path proves nothing.
    pub fn plan(&self, query: &Query, rng: &mut ChaCha8Rng) -> RrtRun {
        self.plan_while(query, rng, &|| true)
    }

    /// [`RrtConnect::plan`] that is broken off once `go_on` is false.
    pub fn plan_while(
        &self,
        query: &Query,
        rng: &mut ChaCha8Rng,
        go_on: &dyn Fn() -> bool,
    ) -> RrtRun {
        let mut run = RrtRun::default();
        let Some(points) = self.search(query, rng, &mut run, go_on) else {
            return run;
        };
        let mut path = Trajectory::new(query.scene().dof(), points);
        if self.shortcut_rounds > 0 {
            let is_free = |from: &[f64], to: &[f64]| query.scene().motion_is_free(from, to);
            run.checks += shortcut(&mut path, is_free, self.shortcut_rounds, rng);
        }
        run.trajectory = Some(path);
        run
    }

    /// Grows the trees; the configurations `[.. x dof]` from start to goal once they meet.
    fn search(
        &self,
        query: &Query,
        rng: &mut ChaCha8Rng,
        run: &mut RrtRun,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Vec<f64>> {
        let (scene, start, goal) = (&**query.scene(), query.start(), query.goal());
        run.checks = 3;
        if scene.motion_is_free(start, goal) {
            return Some([start, goal].concat());
        }
        if !scene.motion_is_free(start, start) || !scene.motion_is_free(goal, goal) {
            return None;
        }
        let limits = scene.limits();
        let extent = limits.iter().map(|[least, most]| most - least).fold(0.0, f64::max);
        let square: f64 = limits.iter().map(|[least, most]| (most - least) * (most - least)).sum();
        let domain = DOMAIN * (square / 6.0).sqrt();
        let mut growth = Growth {
            scene,
            step: self.step * extent,
            domain,
            refused: 0,
            to: vec![0.0; limits.len()],
        };
        let mut trees = [Tree::new(start, limits), Tree::new(goal, limits)];
        let mut sample = vec![0.0; limits.len()];
        while run.samples < self.max_samples && run.nodes < self.max_nodes {
            if run.samples.is_multiple_of(SAMPLES_A_QUESTION) && !go_on() {
                run.broken_off = true;
                return None;
            }
            run.samples += 1;
            for (value, [least, most]) in sample.iter_mut().zip(limits) {
                let t: f64 = rng.random();
                *value = least + t * (most - least);
            }
            let small = usize::from(trees[1].len() < trees[0].len());
            let [a, b] = &mut trees;
            let (small_tree, large_tree) = if small == 0 { (a, b) } else { (b, a) };
            let met = growth.extend(small_tree, &sample, run).and_then(|new| {
                growth.connect(large_tree, small_tree.point(new), run).map(|other| (new, other))
            });
            run.nodes = trees[0].len() + trees[1].len();
            if let Some((new, other)) = met {
                let (from_start, from_goal) = if small == 0 { (new, other) } else { (other, new) };
                let mut path: Vec<&[f64]> = trees[0].branch(from_start).collect();
                path.reverse();
                path.extend(trees[1].branch(from_goal));
                return Some(path.concat());
            }
        }
        None
    }
}

/// How trees grow: by certified motions of at most a step.
struct Growth<'a> {
    scene: &'a Scene,
    step: f64,
    /// Of nodes at an obstacle.
    domain: f64,
    /// Samples outside of a node's domain so far.
    refused: usize,
    /// Where the next motion ends, `[dof]`.
    to: Vec<f64>,
}

impl Growth<'_> {
    /// One step from the nearest node towards `target`; the new node if the motion is free.
    fn extend(&mut self, tree: &mut Tree, target: &[f64], run: &mut RrtRun) -> Option<usize> {
        let near = tree.nearest(target);
        let from = tree.point(near);
        let length = distance(from, target);
        if length > tree.domain(near) {
            self.refused += 1;
            if !self.refused.is_multiple_of(REFUSED) {
                return None;
            }
        }
        if length > self.step {
            lerp(from, target, self.step / length, &mut self.to);
        } else {
            self.to.copy_from_slice(target);
        }
        run.checks += 1;
        if !self.scene.motion_is_free(from, &self.to) {
            tree.restrict(near, self.domain);
            return None;
        }
        Some(tree.push(&self.to, near))
    }

    /// Steps from the nearest node towards `target` until it is seen or the way is blocked; the node
    /// that sees it, if any.
    fn connect(&mut self, tree: &mut Tree, target: &[f64], run: &mut RrtRun) -> Option<usize> {
        let mut node = tree.nearest(target);
        loop {
            let from = tree.point(node);
            run.checks += 1;
            if self.scene.motion_is_free(from, target) {
                return Some(node);
            }
            let length = distance(from, target);
            if length <= self.step {
                return None;
            }
            lerp(from, target, self.step / length, &mut self.to);
            run.checks += 1;
            if !self.scene.motion_is_free(from, &self.to) {
                return None;
            }
            node = tree.push(&self.to, node);
        }
    }
}

/// The configuration at fraction `t` of the way from one to another, `[dof]`.
fn lerp(from: &[f64], to: &[f64], t: f64, out: &mut [f64]) {
    for ((out, from), to) in out.iter_mut().zip(from).zip(to) {
        *out = from + t * (to - from);
    }
}

/// Answers a query by trees.
pub(super) fn tree(query: &Query, rrt: &RrtConnect, options: &Options, watch: Watch<'_>) -> Plan {
    let mut rng = stream(options.seed, Purpose::Planner, options.index, 0);
    let most = options.max_samples.unwrap_or(usize::MAX);
    let rrt = RrtConnect { max_samples: rrt.max_samples.min(most), ..*rrt };
    let RrtRun { trajectory, samples, broken_off, .. } =
        rrt.plan_while(query, &mut rng, watch.go_on);
    let reason = match trajectory {
        Some(trajectory) => return Plan::of(query, trajectory, 0, Origin::Tree),
        None if broken_off => Reason::SamplingBrokenOff { samples },
        None => Reason::SamplesSpent { samples },
    };
    Plan::none(Status::Unsolved(reason), Origin::Tree)
}

#[cfg(test)]
mod tests;
