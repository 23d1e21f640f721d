//! RRT-Connect for robots with joints: two trees of certified motions, grown towards random
//! configurations and each other.
//!
//! J. Kuffner and S. LaValle, RRT-Connect: an efficient approach to single-query path planning, ICRA
//! 2000, doi:10.1109/ROBOT.2000.844730. The smaller tree is extended by one step towards a sample; the other then grows
//! towards the new node, step by step, until it arrives or is blocked. A motion is certified as a whole.

mod shortcut;
mod tree;

pub use shortcut::shortcut;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::certificate::{Certifier, Work};
use crate::error::InvalidInput;
use tree::Tree;

/// Parameters of the planner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RrtConnect {
    /// Samples drawn before giving up; at least 1.
    pub max_samples: usize,
    /// Longest motion towards a sample, by Euclidean distance of all joints (rad, m); above 0.
    pub step: f64,
    /// Random short cuts tried on the path; 0 leaves it as it was found.
    pub shortcut_rounds: usize,
}

impl Default for RrtConnect {
    fn default() -> Self {
        Self { max_samples: 100_000, step: 1.0, shortcut_rounds: 32 }
    }
}

/// What a run of the planner did.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RrtRun {
    /// A certified path `[waypoints x dof]`; none where the samples did not suffice or an end is not free.
    pub path: Option<Vec<f64>>,
    /// Samples drawn.
    pub samples: usize,
    /// Nodes of both trees.
    pub nodes: usize,
    /// Motions judged.
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
        if !(self.step > 0.0 && self.step.is_finite()) {
            return Err(InvalidInput::new("step", self.step, "a finite number above 0"));
        }
        Ok(())
    }

    /// Plans from one configuration to another, both within the limits. Not finding a path proves nothing.
    pub fn plan(
        &self,
        start: &[f64],
        goal: &[f64],
        certifier: &Certifier,
        work: &mut Work,
        rng: &mut ChaCha8Rng,
    ) -> RrtRun {
        let mut run = RrtRun::default();
        if let Some(mut path) = self.search(start, goal, certifier, work, rng, &mut run) {
            if self.shortcut_rounds > 0 {
                run.checks += shortcut(&mut path, certifier, work, self.shortcut_rounds, rng);
            }
            run.path = Some(path);
        }
        run
    }

    /// Grows the trees; the path once they meet.
    fn search(
        &self,
        start: &[f64],
        goal: &[f64],
        certifier: &Certifier,
        work: &mut Work,
        rng: &mut ChaCha8Rng,
        run: &mut RrtRun,
    ) -> Option<Vec<f64>> {
        run.checks = 1;
        if certifier.motion_is_free(start, goal, work) {
            return Some([start, goal].concat());
        }
        run.checks += 2;
        if !certifier.motion_is_free(start, start, work)
            || !certifier.motion_is_free(goal, goal, work)
        {
            return None;
        }
        let joints = certifier.arm().joints();
        let mut sample = vec![0.0; joints.len()];
        let mut grow = Grow { certifier, work, step: self.step, to: vec![0.0; joints.len()] };
        let mut trees = [Tree::new(start), Tree::new(goal)];
        while run.samples < self.max_samples {
            run.samples += 1;
            for (value, joint) in sample.iter_mut().zip(joints) {
                *value = joint.lower + rng.random::<f64>() * (joint.upper - joint.lower);
            }
            let small = usize::from(trees[1].len() < trees[0].len());
            let [first, second] = &mut trees;
            let (one, other) = if small == 0 { (first, second) } else { (second, first) };
            let met = grow
                .extend(one, &sample, run)
                .and_then(|new| grow.connect(other, one.node(new), run).map(|other| (new, other)));
            run.nodes = trees[0].len() + trees[1].len();
            if let Some((new, other)) = met {
                let (from_start, from_goal) = if small == 0 { (new, other) } else { (other, new) };
                return Some(join(&trees, from_start, from_goal));
            }
        }
        None
    }
}

/// The path from the start's root through both nodes to the goal's root.
fn join(trees: &[Tree; 2], from_start: usize, from_goal: usize) -> Vec<f64> {
    let dof = trees[0].node(0).len();
    let mut backwards = Vec::new();
    trees[0].branch(from_start, &mut backwards);
    let mut path = Vec::with_capacity(backwards.len());
    for node in backwards.chunks_exact(dof).rev() {
        path.extend_from_slice(node);
    }
    trees[1].branch(from_goal, &mut path);
    path
}

/// What grows a tree.
struct Grow<'a> {
    certifier: &'a Certifier,
    work: &'a mut Work,
    step: f64,
    to: Vec<f64>,
}

impl Grow<'_> {
    /// One step from the nearest node towards `target`; the new node if the motion is free.
    fn extend(&mut self, tree: &mut Tree, target: &[f64], run: &mut RrtRun) -> Option<usize> {
        let near = tree.nearest(target);
        let from = tree.node(near);
        let length = distance(from, target);
        along(
            from,
            target,
            if length > self.step { self.step / length } else { 1.0 },
            &mut self.to,
        );
        run.checks += 1;
        let free = self.certifier.motion_is_free(from, &self.to, self.work);
        free.then(|| tree.push(&self.to, near))
    }

    /// Steps from the nearest node towards `target`; the node that reaches it, if the way is free.
    fn connect(&mut self, tree: &mut Tree, target: &[f64], run: &mut RrtRun) -> Option<usize> {
        let mut node = tree.nearest(target);
        loop {
            let from = tree.node(node);
            let length = distance(from, target);
            run.checks += 1;
            if length <= self.step {
                return self.certifier.motion_is_free(from, target, self.work).then_some(node);
            }
            along(from, target, self.step / length, &mut self.to);
            if !self.certifier.motion_is_free(from, &self.to, self.work) {
                return None;
            }
            node = tree.push(&self.to, node);
        }
    }
}

/// Euclidean distance of two configurations.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// The configuration at part `t` of the way; exactly `b` at 1.
fn along(a: &[f64], b: &[f64], t: f64, out: &mut [f64]) {
    for ((out, &a), &b) in out.iter_mut().zip(a).zip(b) {
        *out = if t == 1.0 { b } else { a + t * (b - a) };
    }
}
