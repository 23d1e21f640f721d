//! The objective U(ξ) = F_obs(ξ) + λ F_len(ξ) and its gradient (paper, section I.A).
//!
//! - F_obs averages the clearance cost c(D) over N waypoints and S substeps on each of the N + 1
//!   segments; pooled in one mean (the paper's code) or as the sum of two means (its formula).
//! - c(D) = ε/2 - D for D < 0, (D - ε)² / 2ε for 0 ≤ D < ε, 0 beyond: continuously differentiable.
//! - F_len is the plain sum of squared segment lengths.
//!
//! Substep j of a segment lies at t = j / (S + 1), so its gradient goes to the segment's end points
//! with weights 1 - t and t. All lengths are in normalised units ([`crate::profile`]).

pub mod reference;

use std::sync::Arc;

use crate::error::InvalidInput;
use crate::kernels::{Isa, dispatch};
use crate::plane::distance::{LANES, Samples};
use crate::plane::geometry::Point;
use crate::profile::{Averaging, MAX_WAYPOINTS};
use crate::scene::Scene;
use crate::task::Task;
use crate::trajectory::Trajectory;

/// The parts of U at one trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    /// F_obs.
    pub obstacle: f32,
    /// F_len, not yet weighed by λ.
    pub length: f32,
    /// U = F_obs + λ F_len.
    pub total: f32,
}

/// U and its gradient for one task, with the buffers to compute them in.
#[derive(Debug, Clone)]
pub struct Objective {
    scene: Arc<Scene>,
    start: [f32; 2],
    goal: [f32; 2],
    task_start: Point,
    task_goal: Point,
    waypoints: usize,
    epsilon: f32,
    lambda: f32,
    buffers: Buffers,
    isa: Isa,
}

/// Buffers over the points of a trajectory, in order: substeps of segment 0, waypoint 1, ...;
/// lengths are padded to a multiple of [`LANES`] by points of weight 0.
#[derive(Debug, Clone)]
struct Buffers {
    /// Fractions t of the S substeps.
    fractions: Vec<f32>,
    /// Each point's share in F_obs.
    weights: Vec<f32>,
    x: Vec<f32>,
    y: Vec<f32>,
    samples: Samples,
    costs: Vec<f32>,
}

impl Objective {
    /// The objective of `task` for trajectories of `waypoints` free points.
    ///
    /// # Errors
    /// If the number of waypoints is 0 or above [`MAX_WAYPOINTS`].
    pub fn new(task: &Task, scene: Arc<Scene>, waypoints: usize) -> Result<Self, InvalidInput> {
        if waypoints == 0 || waypoints > MAX_WAYPOINTS {
            return Err(InvalidInput::new(
                "waypoints",
                waypoints,
                format!("a number from 1 to {MAX_WAYPOINTS}"),
            ));
        }
        // Prepared here, so that no iteration pays for it.
        scene.field();
        let substeps = scene.profile.substeps;
        let period = substeps + 1;
        let points = (waypoints + 1) * period - 1;
        let padded = points.next_multiple_of(LANES);
        let (waypoint_weight, substep_weight) = match scene.profile.averaging {
            Averaging::Pooled => (1.0 / points as f64, 1.0 / points as f64),
            Averaging::Grouped => {
                (1.0 / waypoints as f64, 1.0 / ((waypoints + 1) * substeps) as f64)
            }
        };
        let mut weights: Vec<f32> = (0..points)
            .map(|k| if k % period == substeps { waypoint_weight } else { substep_weight } as f32)
            .collect();
        weights.resize(padded, 0.0);
        Ok(Self {
            start: scene.frame.to_normalised(task.start),
            goal: scene.frame.to_normalised(task.goal),
            task_start: task.start,
            task_goal: task.goal,
            waypoints,
            epsilon: scene.epsilon() as f32,
            lambda: scene.profile.lambda as f32,
            buffers: Buffers {
                fractions: (1..=substeps).map(|j| j as f32 / period as f32).collect(),
                weights,
                x: vec![0.0; padded],
                y: vec![0.0; padded],
                samples: Samples::with_len(padded),
                costs: vec![0.0; padded],
            },
            isa: Isa::detect(),
            scene,
        })
    }

    /// The same with another clearance ε and weight λ of length, in normalised units.
    pub fn with_weights(self, epsilon: f64, lambda: f64) -> Self {
        Self { epsilon: epsilon as f32, lambda: lambda as f32, ..self }
    }

    /// Number of free waypoints N.
    pub fn waypoints(&self) -> usize {
        self.waypoints
    }

    /// Length of the flat `[N x 2]` state.
    pub fn dim(&self) -> usize {
        2 * self.waypoints
    }

    /// Whether the robot may move straight between two points of normalised units, by the exact check.
    pub fn segment_is_free(&self, from: [f32; 2], to: [f32; 2]) -> bool {
        let frame = self.scene.frame;
        self.scene.certifier.segment_is_free(frame.to_task(from), frame.to_task(to))
    }

    /// Start, in normalised units.
    pub fn start(&self) -> [f32; 2] {
        self.start
    }

    /// Goal, in normalised units.
    pub fn goal(&self) -> [f32; 2] {
        self.goal
    }

    /// The shared scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// U at the waypoints `x` (`[N x 2]`).
    pub fn cost(&mut self, x: &[f32]) -> Cost {
        evaluate(self.isa, self, x, None)
    }

    /// U at the waypoints `x` and its gradient, written to `gradient` (both `[N x 2]`).
    ///
    /// With `obstacle_gradient_factor` 1 it is the derivative of U wherever D is differentiable; at
    /// kinks it is one of the one-sided derivatives.
    pub fn cost_and_gradient(&mut self, x: &[f32], gradient: &mut [f32]) -> Cost {
        evaluate(self.isa, self, x, Some(gradient))
    }

    /// The obstacle cost c(D) of each waypoint from the last evaluation, and their mean.
    pub fn waypoint_costs(&self) -> impl Iterator<Item = f32> + '_ {
        let period = self.scene.profile.substeps + 1;
        (0..self.waypoints).map(move |i| self.buffers.costs[i * period + period - 1])
    }

    /// Obstacle cost around each waypoint from the last evaluation, written to `out` (`[N]`): the
    /// mean over the waypoint and the substeps of its two segments.
    pub fn local_costs(&self, out: &mut [f32]) {
        let substeps = self.scene.profile.substeps;
        for (i, out) in out.iter_mut().enumerate() {
            let around = &self.buffers.costs[i * (substeps + 1)..][..2 * substeps + 1];
            *out = around.iter().sum::<f32>() / around.len() as f32;
        }
    }

    /// Whether `x` is feasible by the profile's check.
    pub fn is_feasible(&self, x: &[f32]) -> bool {
        match &self.scene.sampled {
            Some(check) => check.is_feasible(self.start, x, self.goal),
            None => self.is_certified(x),
        }
    }

    /// Whether `x` is certified free of collision by the exact check.
    pub fn is_certified(&self, x: &[f32]) -> bool {
        let certifier = &self.scene.certifier;
        let mut from = self.task_start;
        let free = x.as_chunks::<2>().0.iter().all(|&p| {
            let to = self.scene.frame.to_task(p);
            let free = certifier.segment_is_free(from, to);
            from = to;
            free
        });
        free && certifier.segment_is_free(from, self.task_goal)
    }

    /// Whether the profile's feasibility check is the exact certificate itself.
    pub fn feasible_means_certified(&self) -> bool {
        self.scene.sampled.is_none()
    }

    /// The trajectory from start over `x` to goal, in task units.
    pub fn trajectory(&self, x: &[f32]) -> Trajectory {
        let inner = x.as_chunks::<2>().0.iter().map(|&p| self.scene.frame.to_task(p));
        let points: Vec<Point> =
            std::iter::once(self.task_start).chain(inner).chain([self.task_goal]).collect();
        Trajectory::from_points(&points)
    }

    /// Writes the evenly spaced straight line from start to goal to `x`.
    pub fn straight_line(&self, x: &mut [f32]) {
        let segments = (self.waypoints + 1) as f32;
        for (i, p) in x.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let t = (i + 1) as f32 / segments;
            for axis in 0..2 {
                p[axis] = self.start[axis] + t * (self.goal[axis] - self.start[axis]);
            }
        }
    }
}

dispatch! {
    /// U at `x`, and its gradient where asked for.
    fn evaluate(objective: &mut Objective, x: &[f32], gradient: Option<&mut [f32]>) -> Cost
        = evaluate_body;
}

// The same plain arithmetic on every instruction set, so the same bits.
#[inline(always)]
fn evaluate_body<const ISA: u8>(
    objective: &mut Objective,
    x: &[f32],
    gradient: Option<&mut [f32]>,
) -> Cost {
    let Objective { scene, start, goal, epsilon, lambda, buffers, .. } = objective;
    let profile = &scene.profile;
    let (waypoints, lambda) = (x.as_chunks::<2>().0, *lambda);
    buffers.place_points(*start, waypoints, *goal);
    let points = (waypoints.len() + 1) * (profile.substeps + 1) - 1;
    scene.field().sample(&buffers.x, &buffers.y, points, &mut buffers.samples);
    let obstacle = buffers.costs_and_slopes(
        *epsilon,
        profile.obstacle_gradient_factor as f32,
        gradient.is_some(),
    );
    let mut length = 0.0;
    let mut from = *start;
    for &to in waypoints.iter().chain([&*goal]) {
        length += (to[0] - from[0]).powi(2) + (to[1] - from[1]).powi(2);
        from = to;
    }
    if let Some(gradient) = gradient {
        let gradient = gradient.as_chunks_mut::<2>().0;
        // dF_len/dx_i = 2 (x_i - x_{i-1}) - 2 (x_{i+1} - x_i)
        for i in 0..waypoints.len() {
            let before = if i > 0 { waypoints[i - 1] } else { *start };
            let after = waypoints.get(i + 1).unwrap_or(goal);
            for axis in 0..2 {
                let second = 2.0 * waypoints[i][axis] - before[axis] - after[axis];
                gradient[i][axis] = 2.0 * lambda * second;
            }
        }
        buffers.scatter(gradient);
    }
    Cost { obstacle, length, total: obstacle + lambda * length }
}

impl Buffers {
    /// Fills `x`, `y` with the substeps and waypoints in order.
    #[inline(always)]
    fn place_points(&mut self, start: [f32; 2], waypoints: &[[f32; 2]], goal: [f32; 2]) {
        let period = self.fractions.len() + 1;
        let mut from = start;
        for (segment, &to) in waypoints.iter().chain([&goal]).enumerate() {
            let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
            let base = segment * period;
            for (j, &t) in self.fractions.iter().enumerate() {
                self.x[base + j] = from[0] + t * dx;
                self.y[base + j] = from[1] + t * dy;
            }
            if segment < waypoints.len() {
                self.x[base + period - 1] = to[0];
                self.y[base + period - 1] = to[1];
            }
            from = to;
        }
        // Padding must be a valid place; its weight is 0.
        let points = (waypoints.len() + 1) * period - 1;
        self.x[points..].fill(start[0]);
        self.y[points..].fill(start[1]);
    }

    /// Turns sampled distances into costs, and sampled gradients into weighted cost gradients;
    /// returns F_obs. With t = clamp(ε - D, 0, ε): c = t² / 2ε + max(-D, 0) and c' = -t / ε.
    #[inline(always)]
    fn costs_and_slopes(&mut self, epsilon: f32, factor: f32, slopes: bool) -> f32 {
        let inverse = 1.0 / epsilon;
        let mut sums = [0.0f32; LANES];
        let Samples { distance, gradient_x, gradient_y } = &mut self.samples;
        for block in 0..self.weights.len() / LANES {
            let range = block * LANES..(block + 1) * LANES;
            let weights = &self.weights[range.clone()];
            let distance = &distance[range.clone()];
            let costs = &mut self.costs[range.clone()];
            for l in 0..LANES {
                let t = (epsilon - distance[l]).max(0.0).min(epsilon);
                costs[l] = 0.5 * inverse * t * t + (-distance[l]).max(0.0);
                sums[l] += weights[l] * costs[l];
            }
            if slopes {
                let gradient_x = &mut gradient_x[range.clone()];
                let gradient_y = &mut gradient_y[range];
                for l in 0..LANES {
                    let t = (epsilon - distance[l]).max(0.0).min(epsilon);
                    let slope = -t * inverse * factor * weights[l];
                    gradient_x[l] *= slope;
                    gradient_y[l] *= slope;
                }
            }
        }
        sums.iter().sum()
    }

    /// Adds each point's cost gradient to the waypoints that carry it.
    #[inline(always)]
    fn scatter(&self, gradient: &mut [[f32; 2]]) {
        let period = self.fractions.len() + 1;
        let n = gradient.len();
        for segment in 0..=n {
            let base = segment * period;
            let (mut before, mut after) = ([0.0f32; 2], [0.0f32; 2]);
            for (j, &t) in self.fractions.iter().enumerate() {
                let g = [self.samples.gradient_x[base + j], self.samples.gradient_y[base + j]];
                for axis in 0..2 {
                    before[axis] += (1.0 - t) * g[axis];
                    after[axis] += t * g[axis];
                }
            }
            for axis in 0..2 {
                if segment > 0 {
                    gradient[segment - 1][axis] += before[axis];
                }
                if segment < n {
                    let own = [&self.samples.gradient_x, &self.samples.gradient_y][axis];
                    gradient[segment][axis] += after[axis] + own[base + period - 1];
                }
            }
        }
    }
}
