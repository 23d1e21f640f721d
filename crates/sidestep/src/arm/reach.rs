//! How far each ball can be from each joint's axis: what its speed and its acceleration are bounded by.
//!
//! For q(t) = a + t D, a ball's centre c(t) and a joint m between it and the base:
//!
//! ```text
//! |dc/dq_m| <= R_m                    largest distance of c from m's axis; 1 if m slides
//! |c''| <= M = sum_m |D_m| R_m (|D_m| [m turns] + 2 sum_{j before m, j turns} |D_j|)
//! |c(t) - chord(t)| <= h^2 M / 8      on an interval of width h
//! ```
//!
//! The second line is the manipulator's Hessian: d²c/dq_j dq_m = z_j x dc/dq_m for j at or before m if j turns, 0 if
//! j slides (a slide turns nothing). The third is the error of linear interpolation.
//!
//! R_m is the supremum over all configurations, from balls that hold every place of c in the frame of m and of the joints
//! behind it: a ball of radius s at p, turned about z all the way round, lies in the ball at (0, 0, p_z) of radius |p_xy| + s;
//! its distance from the axis is at most that too.

use super::Arm;
use super::chain::Slot;
use super::robot::LIMIT_TOLERANCE;
use crate::kernels::{Isa, LANES, dispatch};
use crate::space::vector::Vector;

/// Bounds of the balls of an arm; those around the links come first.
#[derive(Debug, Clone)]
pub(super) struct Reach {
    /// `[slot - 1][ball]`, metres (1 for a slide); 0 where the slot does not move the ball. Padded to `stride`.
    farthest: Vec<f32>,
    /// For each slot what drives it.
    slots: Vec<Driven>,
    /// The largest of each row of `farthest`.
    longest: Vec<f64>,
    stride: usize,
}

/// What a slot takes from a configuration.
#[derive(Debug, Clone, Copy)]
struct Driven {
    parent: usize,
    coordinate: usize,
    factor: f64,
    turns: bool,
}

/// Rounded up by more than what sums in f32 lose.
const UP: f64 = 1.0 + 1e-5;

impl Reach {
    pub(super) fn new(arm: &Arm) -> Self {
        let around = arm.parts.iter().map(|part| (part.slot, part.around.center));
        let balls = arm.parts.iter().flat_map(|part| {
            arm.balls[part.balls.clone()].iter().map(|ball| (part.slot, ball.center))
        });
        let points: Vec<(usize, Vector)> = around.chain(balls).collect();
        let stride = points.len().next_multiple_of(LANES);
        let mut farthest = vec![0.0; arm.chain.slots.len() * stride];
        for (index, &(slot, center)) in points.iter().enumerate() {
            for (slot, reach) in reaches(arm, slot, center) {
                farthest[(slot - 1) * stride + index] = (reach * UP) as f32;
            }
        }
        let driven = |slot: &Slot| Driven {
            parent: slot.parent,
            coordinate: slot.coordinate,
            factor: slot.multiplier.abs(),
            turns: !slot.prismatic,
        };
        let longest = |row: &[f32]| f64::from(row.iter().copied().fold(0.0, f32::max));
        // A robot without balls has no rows.
        let row = |slot: usize| &farthest[slot * stride..][..stride];
        let longest = (0..arm.chain.slots.len()).map(|slot| longest(row(slot))).collect();
        Self { farthest, slots: arm.chain.slots.iter().map(driven).collect(), longest, stride }
    }

    /// Numbers of a block of bounds: one for each ball, padded.
    pub(super) fn stride(&self) -> usize {
        self.stride
    }

    /// How far a ball's centre moves at most for each rad or m of each joint, `[dof]`.
    pub(super) fn of_ball(&self, ball: usize, arm: &Arm) -> Vec<f64> {
        let mut reach = vec![0.0; arm.dof()];
        for (index, slot) in self.slots.iter().enumerate() {
            let farthest = self.farthest[index * self.stride + arm.parts.len() + ball];
            reach[slot.coordinate] += slot.factor * f64::from(farthest);
        }
        reach
    }

    /// M / 8 of each ball for a motion by `delta`, and the largest speed sum_m |D_m| R_m of any.
    ///
    /// `bulge` has [`Self::stride`] numbers; `turned` one for each slot and one more: how far the slots up to each turn together.
    pub(super) fn bulges(
        &self,
        isa: Isa,
        delta: &[f64],
        turned: &mut [f64],
        weights: &mut [f32],
        bulge: &mut [f32],
    ) -> f64 {
        turned[0] = 0.0;
        let mut speed = 0.0;
        for (index, slot) in self.slots.iter().enumerate() {
            let by = (delta[slot.coordinate] * slot.factor).abs();
            let before = turned[slot.parent];
            let turns = if slot.turns { by } else { 0.0 };
            turned[index + 1] = before + turns;
            weights[index] = (by * (turns + 2.0 * before) * (UP / 8.0)) as f32;
            speed += by * self.longest[index];
        }
        weighted(isa, &self.farthest, weights, bulge);
        speed
    }
}

dispatch! {
    /// The sum of the rows `[weights x sums]`, each times its weight.
    fn weighted(rows: &[f32], weights: &[f32], sums: &mut [f32]) = weighted_body;
}

#[inline(always)]
fn weighted_body<const ISA: u8>(rows: &[f32], weights: &[f32], sums: &mut [f32]) {
    let stride = sums.len();
    for (block, sums) in sums.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        *sums = [0.0; LANES];
        for (slot, &weight) in weights.iter().enumerate() {
            let row = &rows[slot * stride + block * LANES..][..LANES];
            for lane in 0..LANES {
                sums[lane] += weight * row[lane];
            }
        }
    }
}

/// The slots that move a point of a slot's frame, each with the largest distance of the point from its axis.
fn reaches(arm: &Arm, mut slot: usize, mut center: Vector) -> Vec<(usize, f64)> {
    let mut found = Vec::new();
    let mut radius = 0.0;
    while slot > 0 {
        let step = &arm.chain.slots[slot - 1];
        if step.prismatic {
            found.push((slot, 1.0));
            // Anywhere on a piece of a line: the ball around it.
            let joint = &arm.joints()[step.coordinate];
            let ends = [joint.lower, joint.upper].map(|end| step.multiplier * end + step.offset);
            center[2] += 0.5 * (ends[0] + ends[1]);
            radius += 0.5 * (ends[0] - ends[1]).abs() + step.multiplier.abs() * LIMIT_TOLERANCE;
        } else {
            radius += center[0].hypot(center[1]);
            found.push((slot, radius));
            center = [0.0, 0.0, center[2]];
        }
        center = step.constant.apply(center);
        slot = step.parent;
    }
    found
}
