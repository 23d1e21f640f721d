//! Forward kinematics of a block of configurations: lanes are configurations, f32.
//!
//! ```text
//! frame_k = frame_parent(k) * C_k * Rz(q_k)      (or C_k * translation (0, 0, q_k))
//! ```
//!
//! 36 products with constants and 12 for the turn a joint, 9 a ball. `Chain::frames` is the slow twin in f64.
//!
//! **Rounding.** With u = 2^-24, sines and cosines within 1.2e-7 and angles rounded to f32, a slot turns its
//! frame by at most 24 u more than it should, in any direction; that error and those of all slots before it carry along everything behind.
//! A ball is thus within `(24 u (k + 1) + 8 u) reach` of its place, k slots from the base, which
//! [`rounding`] states with the largest k. Measured errors are a tenth of it.

use super::Arm;
use super::chain::Slot;
use super::lanes::{Lane, Points};
use super::sincos::sin_cos;
use crate::kernels::{LANES, madd};
use crate::space::Pose;

/// A frame for each: the rows of `[R | t]`, one after the other.
pub(super) type Frame = [Lane; 12];

/// The f32 program of an arm.
#[derive(Debug, Clone)]
pub(super) struct Program {
    slots: Vec<Step>,
    /// How far a computed place can be from the true one, in metres.
    pub(super) rounding: f64,
}

/// A slot in f32.
#[derive(Debug, Clone)]
struct Step {
    parent: usize,
    constant: [f32; 12],
    prismatic: bool,
    coordinate: usize,
    multiplier: f32,
    offset: f32,
}

impl Step {
    fn new(slot: &Slot) -> Self {
        Self {
            parent: slot.parent,
            constant: rows(&slot.constant),
            prismatic: slot.prismatic,
            coordinate: slot.coordinate,
            multiplier: slot.multiplier as f32,
            offset: slot.offset as f32,
        }
    }
}

/// The rows of `[R | t]`.
fn rows(pose: &Pose) -> [f32; 12] {
    let (r, t) = (pose.rotation(), pose.translation());
    std::array::from_fn(|at| match at % 4 {
        3 => t[at / 4] as f32,
        column => r[at / 4][column] as f32,
    })
}

impl Program {
    pub(super) fn new(arm: &Arm) -> Self {
        let slots: Vec<Step> = arm.chain.slots.iter().map(Step::new).collect();
        Self { rounding: rounding(arm), slots }
    }

    /// Number of frames: one for each slot and the base's.
    pub(super) fn frames(&self) -> usize {
        self.slots.len() + 1
    }

    /// Pulls forces and moments (about the origin) on the frames of slots back to the coordinates, adding to `slopes [dof]`: one sweep
    /// from the last slot to the first, in which every slot hands on to its parent what it carries.
    ///
    /// With z and o a slot's axis and origin: dU/dq = z . (moment - o x force) if it turns, z . force if it slides.
    #[inline(always)]
    pub(super) fn pull_back<const ISA: u8>(
        &self,
        frames: &[Frame],
        forces: &mut [Points],
        moments: &mut [Points],
        slopes: &mut [Lane],
    ) {
        for (index, step) in self.slots.iter().enumerate().rev() {
            let slot = index + 1;
            let frame = &frames[slot];
            let slope = &mut slopes[step.coordinate];
            for lane in 0..LANES {
                let z = [frame[2][lane], frame[6][lane], frame[10][lane]];
                let o = [frame[3][lane], frame[7][lane], frame[11][lane]];
                let (f, m) = (&forces[slot], &moments[slot]);
                let force = [f[0][lane], f[1][lane], f[2][lane]];
                let moment = [m[0][lane], m[1][lane], m[2][lane]];
                let turn = [
                    moment[0] - (o[1] * force[2] - o[2] * force[1]),
                    moment[1] - (o[2] * force[0] - o[0] * force[2]),
                    moment[2] - (o[0] * force[1] - o[1] * force[0]),
                ];
                let v = if step.prismatic { force } else { turn };
                let along = madd::<ISA>(z[0], v[0], madd::<ISA>(z[1], v[1], z[2] * v[2]));
                slope[lane] = madd::<ISA>(step.multiplier, along, slope[lane]);
            }
            for carried in [&mut *forces, &mut *moments] {
                let (before, after) = carried.split_at_mut(slot);
                let (parent, own) = (&mut before[step.parent], &after[0]);
                for axis in 0..3 {
                    for lane in 0..LANES {
                        parent[axis][lane] += own[axis][lane];
                    }
                }
            }
        }
    }

    /// The frames of all slots, the base's first, at the configurations `q[coordinate][lane]`.
    #[inline(always)]
    pub(super) fn place<const ISA: u8>(&self, q: &[Lane], frames: &mut [Frame]) {
        frames[0] = std::array::from_fn(|at| [if at % 5 == 0 { 1.0 } else { 0.0 }; LANES]);
        for (index, step) in self.slots.iter().enumerate() {
            let (before, after) = frames.split_at_mut(index + 1);
            let (parent, frame) = (&before[step.parent], &mut after[0]);
            let q = &q[step.coordinate];
            if step.prismatic {
                slide::<ISA>(step, parent, q, frame);
            } else if step.parent == 0 {
                turn_base::<ISA>(step, q, frame);
            } else {
                turn::<ISA>(step, parent, q, frame);
            }
        }
    }
}

/// A row of a frame in one lane.
#[inline(always)]
fn row_of(frame: &Frame, row: usize, lane: usize) -> [f32; 4] {
    let at = 4 * row;
    [frame[at][lane], frame[at + 1][lane], frame[at + 2][lane], frame[at + 3][lane]]
}

/// A row times a column of a constant, and `start`.
#[inline(always)]
fn along<const ISA: u8>(p: &[f32; 4], c: &[f32; 12], column: usize, start: f32) -> f32 {
    let a = madd::<ISA>(p[2], c[8 + column], start);
    madd::<ISA>(p[0], c[column], madd::<ISA>(p[1], c[4 + column], a))
}

/// A turning slot.
#[inline(always)]
fn turn<const ISA: u8>(step: &Step, parent: &Frame, q: &Lane, frame: &mut Frame) {
    let c = &step.constant;
    for lane in 0..LANES {
        let [sin, cos] = sin_cos::<ISA>(madd::<ISA>(step.multiplier, q[lane], step.offset));
        for row in 0..3 {
            let p = row_of(parent, row, lane);
            let x = along::<ISA>(&p, c, 0, 0.0);
            let y = along::<ISA>(&p, c, 1, 0.0);
            let z = along::<ISA>(&p, c, 2, 0.0);
            frame[4 * row][lane] = madd::<ISA>(cos, x, sin * y);
            frame[4 * row + 1][lane] = madd::<ISA>(cos, y, -(sin * x));
            frame[4 * row + 2][lane] = z;
            frame[4 * row + 3][lane] = along::<ISA>(&p, c, 3, p[3]);
        }
    }
}

/// A turning slot on the base.
#[inline(always)]
fn turn_base<const ISA: u8>(step: &Step, q: &Lane, frame: &mut Frame) {
    let c = &step.constant;
    for lane in 0..LANES {
        let [sin, cos] = sin_cos::<ISA>(madd::<ISA>(step.multiplier, q[lane], step.offset));
        for row in 0..3 {
            let [x, y] = [c[4 * row], c[4 * row + 1]];
            frame[4 * row][lane] = madd::<ISA>(cos, x, sin * y);
            frame[4 * row + 1][lane] = madd::<ISA>(cos, y, -(sin * x));
            frame[4 * row + 2][lane] = c[4 * row + 2];
            frame[4 * row + 3][lane] = c[4 * row + 3];
        }
    }
}

/// A sliding slot.
#[inline(always)]
fn slide<const ISA: u8>(step: &Step, parent: &Frame, q: &Lane, frame: &mut Frame) {
    let c = &step.constant;
    for lane in 0..LANES {
        let q = madd::<ISA>(step.multiplier, q[lane], step.offset);
        for row in 0..3 {
            let p = row_of(parent, row, lane);
            let z = along::<ISA>(&p, c, 2, 0.0);
            frame[4 * row][lane] = along::<ISA>(&p, c, 0, 0.0);
            frame[4 * row + 1][lane] = along::<ISA>(&p, c, 1, 0.0);
            frame[4 * row + 2][lane] = z;
            frame[4 * row + 3][lane] = madd::<ISA>(q, z, along::<ISA>(&p, c, 3, p[3]));
        }
    }
}

/// A point of a frame, placed.
#[inline(always)]
pub(super) fn point<const ISA: u8>(frame: &Frame, p: [f32; 3], out: &mut Points) {
    for lane in 0..LANES {
        for row in 0..3 {
            let [a, b, c, t] = row_of(frame, row, lane);
            let sum = madd::<ISA>(c, p[2], t);
            out[row][lane] = madd::<ISA>(a, p[0], madd::<ISA>(b, p[1], sum));
        }
    }
}

/// See the module's text.
fn rounding(arm: &Arm) -> f64 {
    const U: f64 = 5.97e-8;
    let mut depth = vec![0_usize; arm.chain.slots.len() + 1];
    for (index, slot) in arm.chain.slots.iter().enumerate() {
        depth[index + 1] = depth[slot.parent] + 1;
    }
    let deepest = depth.into_iter().max().unwrap_or(0);
    (24.0 * (deepest + 1) as f64 + 8.0) * U * arm.reach()
}
