//! What a policy's view measures: gaps of some balls of the body and the slopes of the cost that they make, for sixteen
//! configurations at once.
//!
//! Each part of the body that moves is looked at through at most [`BALLS_A_PART`] of its balls, evenly along it, each of which stands for as
//! many as it was taken from. So the slopes are nearly those of the objective's obstacle cost (`costs.rs`), at a fraction of their price.

use super::super::certificate::Certifier;
use super::super::costs::{Buffers, OF_LINKS, UNITS, begin, from_itself, press, push};
use super::super::kinematics::point;
use super::super::lanes::{Lane, span};
use super::super::robot::Arm;
use crate::kernels::lanes::all_above;
use crate::kernels::{Isa, LANES, dispatch};

/// Balls of a part that are looked at.
const BALLS_A_PART: usize = 4;
/// How far the view sees, in metres.
pub(super) const HORIZON: f32 = 0.25;

/// A ball that is looked at.
#[derive(Debug, Clone, Copy)]
struct Seen {
    part: usize,
    ball: usize,
    /// How many balls it stands for.
    weight: f32,
}

/// The balls that are looked at of an arm, part by part.
fn seen(arm: &Arm) -> Vec<Seen> {
    let mut all = Vec::new();
    for (part, described) in arm.parts.iter().enumerate().filter(|(_, part)| part.slot > 0) {
        let count = described.balls.len();
        let taken = count.min(BALLS_A_PART);
        for k in 0..taken {
            // The middle of each of as many equal stretches.
            let ball = described.balls.start + (2 * k + 1) * count / (2 * taken);
            all.push(Seen { part, ball, weight: count as f32 / taken as f32 });
        }
    }
    all
}

/// How many balls of an arm are looked at.
pub(super) fn seen_count(arm: &Arm) -> usize {
    seen(arm).len()
}

/// Measures blocks of sixteen configurations of an arm in a world.
#[derive(Debug, Clone)]
pub(super) struct Measure {
    buffers: Buffers,
    seen: Vec<Seen>,
    /// The gap of each ball, in metres, at most [`HORIZON`].
    pub gaps: Vec<Lane>,
    /// What links cost that are too near to each other.
    pub own: Lane,
    /// The whole cost, whose slopes are [`Self::slopes`].
    pub costs: Lane,
}

impl Measure {
    pub(super) fn new(certifier: &Certifier) -> Self {
        let seen = seen(&certifier.arm);
        Self {
            buffers: Buffers::new(certifier),
            gaps: vec![[HORIZON; LANES]; seen.len()],
            seen,
            own: [0.0; LANES],
            costs: [0.0; LANES],
        }
    }

    /// The configurations `[dof]` to measure, in rad and m.
    pub(super) fn q(&mut self) -> &mut [Lane] {
        &mut self.buffers.q
    }

    /// The slopes `[dof]` of the obstacle cost at what was measured last.
    pub(super) fn slopes(&self) -> &[Lane] {
        &self.buffers.slopes
    }

    /// Measures what stands in [`Self::q`]; `epsilon` is the clearance under which a gap costs, in normalised units.
    pub(super) fn measure(&mut self, certifier: &Certifier, epsilon: f32) {
        measure(Isa::detect(), self, certifier, epsilon);
    }
}

dispatch! {
    /// See [`Measure::measure`].
    fn measure(own: &mut Measure, certifier: &Certifier, epsilon: f32) = measure_body;
}

#[inline(always)]
fn measure_body<const ISA: u8>(own: &mut Measure, certifier: &Certifier, epsilon: f32) {
    let Measure { buffers, seen, gaps, costs, own } = own;
    begin::<ISA>(certifier, buffers);
    gaps.fill([HORIZON; LANES]);
    costs.fill(0.0);
    own.fill(0.0);
    let mut first = 0;
    while first < seen.len() {
        let part = seen[first].part;
        let count = seen[first..].iter().take_while(|ball| ball.part == part).count();
        let balls = first..first + count;
        of_part::<ISA>(
            certifier,
            buffers,
            &seen[balls.clone()],
            epsilon,
            (&mut gaps[balls], costs),
        );
        first += count;
    }
    for &[a, b] in &certifier.arm.pairs {
        from_itself::<ISA>(certifier, buffers, a, b, OF_LINKS * epsilon, own);
    }
    costs.iter_mut().zip(&*own).for_each(|(cost, own)| *cost += own);
    let Buffers { frames, forces, moments, slopes, .. } = buffers;
    certifier.program.pull_back::<ISA>(frames, forces, moments, slopes);
}

/// Gaps and forces of the balls of one part among the pieces near to it.
#[inline(always)]
fn of_part<const ISA: u8>(
    certifier: &Certifier,
    buffers: &mut Buffers,
    seen: &[Seen],
    epsilon: f32,
    (gaps, costs): (&mut [Lane], &mut Lane),
) {
    let (arm, part) = (&certifier.arm, seen[0].part);
    let (count, margin) = (arm.parts.len(), arm.margin() as f32);
    let Buffers { near, places, forces, moments, frames, .. } = &mut *buffers;
    let surroundings = &certifier.surroundings;
    let reach = certifier.around[part].1 + margin + HORIZON;
    surroundings.near::<ISA>(&span::<ISA>(&places[part]), reach, near);
    let slot = arm.parts[part].slot;
    for (k, ball) in seen.iter().enumerate() {
        let (center, radius) = certifier.balls[ball.ball];
        point::<ISA>(&frames[slot], center, &mut places[count + ball.ball]);
        let place = &places[count + ball.ball];
        let radius = radius + margin;
        for &piece in near.iter() {
            let distances = surroundings.distances::<ISA>(piece, place);
            for lane in 0..LANES {
                let gap = distances[lane] - radius;
                gaps[k][lane] = if gap < gaps[k][lane] { gap } else { gaps[k][lane] };
            }
            if all_above::<ISA>(&distances, radius + epsilon / UNITS) {
                continue;
            }
            let (distances, normals) = surroundings.answer::<ISA>(piece, place);
            let mut of_ball = [0.0; LANES];
            let force = press(&mut of_ball, epsilon, &distances, &normals, radius);
            costs.iter_mut().zip(of_ball).for_each(|(cost, own)| *cost += ball.weight * own);
            push(&force, place, ball.weight, &mut forces[slot], &mut moments[slot]);
        }
    }
}
