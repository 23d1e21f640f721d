//! The objective U(ξ) = F_obs(ξ) + λ F_len(ξ) and its gradient (paper, section I.A).
//!
//! - F_obs averages the clearance cost c(D) over N waypoints and S substeps on each of the N + 1
//!   segments; pooled in one mean (the paper's code) or as the sum of two means (its formula).
//! - c(D) = ε/2 - D for D < 0, (D - ε)² / 2ε for 0 ≤ D < ε, 0 beyond: continuously differentiable.
//! - F_len is the plain sum of squared segment lengths.
//!
//! Substep j of a segment lies at t = j / (S + 1), so its gradient goes to the segment's end points
//! with weights 1 - t and t. All lengths are in normalised units ([`crate::profile`]). c itself is in `kernels/clearance.rs`,
//! where scenes find it, and D is the scene's.

mod curvature;
pub mod reference;

use std::sync::Arc;

use crate::arm::view::ArmSubject;
use crate::error::InvalidInput;
use crate::kernels::{Block, Isa, dispatch};
use crate::plane::Subject;
use crate::profile::{Averaging, MAX_WAYPOINTS};
use crate::scene::{Query, Scene};
use crate::trajectory::{Trajectory, waypoints};

/// The parts of U at one trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Cost {
    /// F_obs.
    pub obstacle: f32,
    /// F_len, not yet weighed by λ.
    pub length: f32,
    /// U = F_obs + λ F_len, and what costs of one's own add ([`Query::with_cost`]).
    pub total: f32,
}

/// U and its gradient for one query, with the buffers to compute them in.
#[derive(Debug, Clone)]
pub struct Objective {
    query: Query,
    /// Start and goal `[2 x dof]`, in normalised units.
    ends: Vec<f32>,
    waypoints: usize,
    epsilon: f32,
    lambda: f32,
    fractions: Fractions,
    /// Substeps and waypoints in order: those of segment 0, waypoint 1, ...
    block: Block,
    isa: Isa,
}

/// Substeps that are computed at once.
const AT_ONCE: usize = 8;

/// Fractions of the S substeps on a segment, filled up with zeros.
#[derive(Debug, Clone)]
struct Fractions {
    substeps: usize,
    shares: Vec<Shares>,
}

/// What the ends of a segment have in some of its substeps.
#[derive(Debug, Clone)]
struct Shares {
    /// 1 - t.
    beginning: [f32; AT_ONCE],
    /// t.
    end: [f32; AT_ONCE],
}

impl Fractions {
    fn new(substeps: usize) -> Self {
        let shares = |block: usize| {
            let (mut beginning, mut end) = ([0.0; AT_ONCE], [0.0; AT_ONCE]);
            for j in block * AT_ONCE..substeps.min((block + 1) * AT_ONCE) {
                let t = (j + 1) as f32 / (substeps + 1) as f32;
                (beginning[j % AT_ONCE], end[j % AT_ONCE]) = (1.0 - t, t);
            }
            Shares { beginning, end }
        };
        Self { substeps, shares: (0..substeps.div_ceil(AT_ONCE)).map(shares).collect() }
    }
}

impl Objective {
    /// The objective of a query for trajectories of `waypoints` free configurations.
    ///
    /// # Errors
    /// If the number of waypoints is 0 or above [`MAX_WAYPOINTS`].
    pub fn new(query: &Query, waypoints: usize) -> Result<Self, InvalidInput> {
        if waypoints == 0 || waypoints > MAX_WAYPOINTS {
            return Err(InvalidInput::new(
                "waypoints",
                waypoints,
                format!("a number from 1 to {MAX_WAYPOINTS}"),
            ));
        }
        let scene = query.scene();
        scene.prepare_costs(&|| true);
        let (profile, dof) = (scene.profile(), scene.dof());
        let substeps = profile.substeps;
        let period = substeps + 1;
        let points = (waypoints + 1) * period - 1;
        let (waypoint_weight, substep_weight) = match profile.averaging {
            Averaging::Pooled => (1.0 / points as f64, 1.0 / points as f64),
            Averaging::Grouped => {
                (1.0 / waypoints as f64, 1.0 / ((waypoints + 1) * substeps) as f64)
            }
        };
        let weights: Vec<f32> = (0..points)
            .map(|k| if k % period == substeps { waypoint_weight } else { substep_weight } as f32)
            .collect();
        let mut ends = vec![0.0; 2 * dof];
        let (start, goal) = ends.split_at_mut(dof);
        scene.to_normalised(query.start(), start);
        scene.to_normalised(query.goal(), goal);
        Ok(Self {
            ends,
            waypoints,
            epsilon: scene.epsilon() as f32,
            lambda: profile.lambda as f32,
            fractions: Fractions::new(substeps),
            block: Block::new(dof, weights),
            isa: Isa::detect(),
            query: query.clone(),
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

    /// Coordinates of a configuration.
    pub fn dof(&self) -> usize {
        self.ends.len() / 2
    }

    /// Length of the flat `[N x dof]` state.
    pub fn dim(&self) -> usize {
        self.dof() * self.waypoints
    }

    /// Start `[dof]`, in normalised units.
    pub fn start(&self) -> &[f32] {
        &self.ends[..self.dof()]
    }

    /// Goal `[dof]`, in normalised units.
    pub fn goal(&self) -> &[f32] {
        &self.ends[self.dof()..]
    }

    /// What is asked.
    pub fn query(&self) -> &Query {
        &self.query
    }

    /// The shared scene.
    pub fn scene(&self) -> &Arc<Scene> {
        self.query.scene()
    }

    /// The question as a policy of the plane sees it, where the robot is one of the plane.
    pub fn plane(&self) -> Option<Subject<'_>> {
        let scene = self.scene().plane()?;
        let &[a, b, c, d] = &self.ends[..] else { return None };
        let (start, goal) = ([a, b], [c, d]);
        Some(Subject { scene, start, goal, waypoints: self.waypoints })
    }

    /// The question as a policy of robots with joints sees it, where the robot is one.
    pub fn arm(&self) -> Option<ArmSubject<'_>> {
        let scene = self.scene().arm()?;
        Some(ArmSubject {
            scene,
            start: self.start(),
            goal: self.goal(),
            waypoints: self.waypoints,
        })
    }

    /// U at the waypoints `x` (`[N x dof]`).
    pub fn cost(&mut self, x: &[f32]) -> Cost {
        evaluate(self.isa, self, x, None)
    }

    /// U at the waypoints `x` and its gradient, written to `gradient` (both `[N x dof]`).
    ///
    /// With `obstacle_gradient_factor` 1 it is the derivative of U wherever D is differentiable; at
    /// kinks it is one of the one-sided derivatives.
    pub fn cost_and_gradient(&mut self, x: &[f32], gradient: &mut [f32]) -> Cost {
        evaluate(self.isa, self, x, Some(gradient))
    }

    /// The obstacle cost c(D) of each waypoint from the last evaluation, and their mean.
    pub fn waypoint_costs(&self) -> impl Iterator<Item = f32> + '_ {
        let period = self.fractions.substeps + 1;
        (0..self.waypoints).map(move |i| self.block.costs[i * period + period - 1])
    }

    /// Obstacle cost around each waypoint from the last evaluation, written to `out` (`[N]`): the
    /// mean over the waypoint and the substeps of its two segments.
    pub fn local_costs(&self, out: &mut [f32]) {
        let substeps = self.fractions.substeps;
        for (i, out) in out.iter_mut().enumerate() {
            let around = &self.block.costs[i * (substeps + 1)..][..2 * substeps + 1];
            *out = around.iter().sum::<f32>() / around.len() as f32;
        }
    }

    /// Whether `x` is feasible by the profile's check.
    pub fn is_feasible(&self, x: &[f32]) -> bool {
        let sampled = self.scene().is_feasible(self.start(), x, self.goal());
        sampled.unwrap_or_else(|| self.is_certified(x))
    }

    /// Whether `x` is certified free of collision by the exact check, from the query's exact start to its exact goal.
    pub fn is_certified(&self, x: &[f32]) -> bool {
        self.scene().path_is_free(self.query.start(), x, self.query.goal(), None)
    }

    /// [`Objective::is_certified`] that writes to `free [N + 1]` which segments are, and does not end at the first that is not.
    pub fn free_segments(&self, x: &[f32], free: &mut [bool]) -> bool {
        self.scene().path_is_free(self.query.start(), x, self.query.goal(), Some(free))
    }

    /// Whether the profile's feasibility check is the exact certificate itself.
    pub fn feasible_means_certified(&self) -> bool {
        self.scene().feasible_means_certified()
    }

    /// The trajectory from start over `x` to goal, in task units.
    pub fn trajectory(&self, x: &[f32]) -> Trajectory {
        let (start, goal) = (self.query.start(), self.query.goal());
        let mut values = vec![0.0; x.len() + 2 * start.len()];
        let (first, rest) = values.split_at_mut(start.len());
        let (inner, last) = rest.split_at_mut(x.len());
        first.copy_from_slice(start);
        self.scene().to_task(x, inner);
        last.copy_from_slice(goal);
        Trajectory::new(start.len(), values)
    }

    /// Writes the evenly spaced straight line from start to goal to `x`.
    pub fn straight_line(&self, x: &mut [f32]) {
        waypoints::straight_line(self.start(), self.goal(), x);
    }
}

dispatch! {
    /// U at `x`, and its gradient where asked for.
    fn evaluate(objective: &mut Objective, x: &[f32], gradient: Option<&mut [f32]>) -> Cost
        = evaluate_body;
}

// The same plain arithmetic on every instruction set, so the same bits. Two coordinates have loops of their own, which the
// compiler unrolls.
#[inline(always)]
fn evaluate_body<const ISA: u8>(
    objective: &mut Objective,
    x: &[f32],
    gradient: Option<&mut [f32]>,
) -> Cost {
    match objective.dof() {
        2 => evaluate_in(2, objective, x, gradient),
        dof => evaluate_in(dof, objective, x, gradient),
    }
}

#[inline(always)]
fn evaluate_in(
    dof: usize,
    objective: &mut Objective,
    x: &[f32],
    mut gradient: Option<&mut [f32]>,
) -> Cost {
    let Objective { query, ends, epsilon, lambda, fractions, block, .. } = objective;
    let (start, goal) = ends.split_at(dof);
    let (scene, lambda) = (query.scene(), *lambda);
    let factor = scene.profile().obstacle_gradient_factor as f32;
    place_points(dof, fractions, [start, x, goal], block);
    scene.cost_and_slope(block, *epsilon, factor, gradient.is_some());
    let obstacle = block.total();
    let square = |from: &[f32], to: &[f32]| {
        (0..dof).fold(0.0, |sum, k| sum + (to[k] - from[k]) * (to[k] - from[k]))
    };
    let last = x.len() - dof;
    let mut length = square(start, x);
    for i in (0..last).step_by(dof) {
        length += square(&x[i..], &x[i + dof..]);
    }
    length += square(&x[last..], goal);
    if let Some(gradient) = gradient.as_deref_mut() {
        // dF_len/dx_i = 2 (x_i - x_{i-1}) - 2 (x_{i+1} - x_i)
        let slope = |before: f32, at: f32, after: f32| 2.0 * lambda * (2.0 * at - before - after);
        for i in dof..last {
            gradient[i] = slope(x[i - dof], x[i], x[i + dof]);
        }
        for k in 0..dof {
            gradient[k] = slope(start[k], x[k], if last > 0 { x[dof + k] } else { goal[k] });
            if last > 0 {
                gradient[last + k] = slope(x[last - dof + k], x[last + k], goal[k]);
            }
        }
        scatter(dof, fractions, block, gradient);
    }
    let mut total = obstacle + lambda * length;
    for term in query.terms() {
        total += term.add([start, x, goal], gradient.as_deref_mut());
    }
    Cost { obstacle, length, total }
}

/// Fills the block's lanes with substeps and waypoints in order. Substeps are written [`AT_ONCE`]; what is too many, the next
/// segment or the padding writes over.
#[inline(always)]
fn place_points(
    dof: usize,
    fractions: &Fractions,
    [start, x, goal]: [&[f32]; 3],
    block: &mut Block,
) {
    let (substeps, waypoints) = (fractions.substeps, x.len() / dof);
    for (k, lane) in block.points.chunks_exact_mut(block.padded).enumerate() {
        let mut from = start[k];
        for segment in 0..=waypoints {
            let to = if segment < waypoints { x[segment * dof + k] } else { goal[k] };
            let way = to - from;
            let points = &mut lane[segment * (substeps + 1)..];
            for (points, shares) in points.as_chunks_mut().0.iter_mut().zip(&fractions.shares) {
                *points = shares.end.map(|t| from + t * way);
            }
            if segment < waypoints {
                points[substeps] = to;
            }
            from = to;
        }
        // Padding must be a valid place; its weight is 0.
        lane[block.count..].fill(start[k]);
    }
}

/// Adds the slope of each point to the waypoints that carry it.
#[inline(always)]
fn scatter(dof: usize, fractions: &Fractions, block: &Block, gradient: &mut [f32]) {
    let (substeps, waypoints) = (fractions.substeps, gradient.len() / dof);
    for (k, lane) in block.slopes.chunks_exact(block.padded).enumerate() {
        for segment in 0..=waypoints {
            let slopes = &lane[segment * (substeps + 1)..];
            let (mut before, mut after) = (0.0f32, 0.0f32);
            let blocks = slopes.as_chunks::<AT_ONCE>().0.iter();
            for (slopes, shares) in blocks.zip(&fractions.shares) {
                for l in 0..AT_ONCE {
                    before += shares.beginning[l] * slopes[l];
                    after += shares.end[l] * slopes[l];
                }
            }
            if segment > 0 {
                gradient[(segment - 1) * dof + k] += before;
            }
            if segment < waypoints {
                gradient[segment * dof + k] += after + slopes[substeps];
            }
        }
    }
}
