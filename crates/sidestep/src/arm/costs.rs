//! The obstacle cost of a block of configurations, and its slope in the joints.
//!
//! ```text
//! cost(q) = sum over balls and pieces near them of c(D) + sum over pairs of balls of links that must not touch of c(D')
//! ```
//!
//! D is the gap between ball and piece in normalised units ([`UNITS`] a metre), c the objective's clearance cost
//! (`kernels/clearance.rs`): N. Ratliff et al., CHOMP: gradient optimization techniques for efficient motion planning, ICRA 2009,
//! doi:10.1109/ROBOT.2009.5152817, with exact distances and a sum instead of the worst. Slopes are forces on
//! the balls along the distances' normals, pulled back in one sweep (`Program::pull_back`).

use super::certificate::Certifier;
use super::kinematics::{Frame, point};
use super::lanes::{Lane, Points, span, squares};
use crate::kernels::lanes::all_above;
use crate::kernels::{Block, Isa, LANES, clearance, dispatch};
use crate::space::PieceId;

/// Normalised units of clearance in a metre: the profile's clearance of 1 is 0.1 m.
pub(super) const UNITS: f32 = 10.0;

/// The clearance that balls of two links should keep, as a part of that from obstacles: links are built close to each other.
pub(super) const OF_LINKS: f32 = 0.2;

/// Buffers for costs of blocks.
#[derive(Debug, Clone)]
pub(super) struct Buffers {
    pub(super) q: Vec<Lane>,
    pub(super) frames: Vec<Frame>,
    /// Centres of the balls around the parts, then of the balls.
    pub(super) places: Vec<Points>,
    placed: Vec<bool>,
    /// On each slot's frame, in the root's axes.
    pub(super) forces: Vec<Points>,
    /// About the root's origin.
    pub(super) moments: Vec<Points>,
    pub(super) slopes: Vec<Lane>,
    pub(super) near: Vec<PieceId>,
}

impl Buffers {
    pub(super) fn new(certifier: &Certifier) -> Self {
        let arm = &certifier.arm;
        let (zero, frames) = ([[0.0; LANES]; 3], certifier.program.frames());
        Self {
            q: vec![[0.0; LANES]; arm.dof()],
            frames: vec![[[0.0; LANES]; 12]; frames],
            places: vec![zero; arm.parts.len() + arm.balls.len()],
            placed: vec![false; arm.parts.len()],
            forces: vec![zero; frames],
            moments: vec![zero; frames],
            slopes: vec![[0.0; LANES]; arm.dof()],
            near: Vec::new(),
        }
    }
}

/// Costs of a block of configurations in rad and m, and where asked for their slopes times weight and `factor`.
pub(super) fn cost_and_slope(
    certifier: &Certifier,
    buffers: &mut Buffers,
    block: &mut Block,
    epsilon: f32,
    factor: f32,
    slopes: bool,
) {
    let isa = Isa::detect();
    let padded = block.padded;
    for first in (0..block.count).step_by(LANES) {
        for (k, q) in buffers.q.iter_mut().enumerate() {
            q.copy_from_slice(&block.points[k * padded + first..][..LANES]);
            // Padding stands where the first configuration stands, so that it makes nothing near.
            let first_value = q[0];
            q[(block.count - first).min(LANES)..].fill(first_value);
        }
        let costs = chunk(isa, certifier, buffers, epsilon, slopes);
        block.costs[first..first + LANES].copy_from_slice(&costs);
        if slopes {
            let weights = &block.weights[first..first + LANES];
            for (k, slope) in buffers.slopes.iter().enumerate() {
                let out = &mut block.slopes[k * padded + first..][..LANES];
                for lane in 0..LANES {
                    out[lane] = factor * weights[lane] * slope[lane];
                }
            }
        }
    }
    // What lies behind the last chunk is padding of weight 0.
    let rest = block.count.next_multiple_of(LANES);
    block.costs[rest..].fill(0.0);
    if slopes {
        block.slopes.chunks_exact_mut(padded).for_each(|row| row[rest..].fill(0.0));
    }
}

dispatch! {
    /// Costs of sixteen configurations `buffers.q`; their slopes, where asked for, in `buffers.slopes`.
    fn chunk(certifier: &Certifier, buffers: &mut Buffers, epsilon: f32, slopes: bool) -> Lane
        = chunk_body;
}

#[inline(always)]
fn chunk_body<const ISA: u8>(
    certifier: &Certifier,
    buffers: &mut Buffers,
    epsilon: f32,
    slopes: bool,
) -> Lane {
    let arm = &certifier.arm;
    begin::<ISA>(certifier, buffers);
    let mut costs = [0.0; LANES];
    for index in certifier.first_moving..arm.parts.len() {
        from_world::<ISA>(certifier, buffers, index, epsilon, &mut costs);
    }
    for &[a, b] in &arm.pairs {
        from_itself::<ISA>(certifier, buffers, a, b, OF_LINKS * epsilon, &mut costs);
    }
    if slopes {
        let Buffers { frames, forces, moments, slopes, .. } = buffers;
        certifier.program.pull_back::<ISA>(frames, forces, moments, slopes);
    }
    costs
}

/// Places the parts of sixteen configurations, with no forces yet.
#[inline(always)]
pub(super) fn begin<const ISA: u8>(certifier: &Certifier, buffers: &mut Buffers) {
    let zero = [[0.0; LANES]; 3];
    buffers.forces.fill(zero);
    buffers.moments.fill(zero);
    buffers.slopes.fill([0.0; LANES]);
    certifier.program.place::<ISA>(&buffers.q, &mut buffers.frames);
    for (index, part) in certifier.arm.parts.iter().enumerate() {
        let center = certifier.around[index].0;
        point::<ISA>(&buffers.frames[part.slot], center, &mut buffers.places[index]);
        buffers.placed[index] = false;
    }
}

/// Costs and forces of one part among the pieces near to it.
#[inline(always)]
fn from_world<const ISA: u8>(
    certifier: &Certifier,
    buffers: &mut Buffers,
    index: usize,
    epsilon: f32,
    costs: &mut Lane,
) {
    let arm = &certifier.arm;
    let (count, margin) = (arm.parts.len(), arm.margin() as f32);
    let reach = certifier.around[index].1 + margin + epsilon / UNITS;
    let Buffers { near, places, .. } = &mut *buffers;
    let surroundings = &certifier.surroundings;
    surroundings.near::<ISA>(&span::<ISA>(&places[index]), reach, near);
    let mut kept = 0;
    for at in 0..near.len() {
        let piece = near[at];
        if !all_above::<ISA>(&surroundings.distances::<ISA>(piece, &places[index]), reach) {
            near[kept] = piece;
            kept += 1;
        }
    }
    if kept == 0 {
        return;
    }
    place_balls::<ISA>(certifier, buffers, index);
    let part = &arm.parts[index];
    let Buffers { near, places, forces, moments, .. } = &mut *buffers;
    for &piece in &near[..kept] {
        for ball in part.balls.clone() {
            let place = &places[count + ball];
            let radius = certifier.balls[ball].1 + margin;
            let (distances, normals) = surroundings.answer::<ISA>(piece, place);
            if all_above::<ISA>(&distances, radius + epsilon / UNITS) {
                continue;
            }
            let force = press(costs, epsilon, &distances, &normals, radius);
            push(&force, place, 1.0, &mut forces[part.slot], &mut moments[part.slot]);
        }
    }
}

/// Costs and forces of two parts on each other.
#[inline(always)]
pub(super) fn from_itself<const ISA: u8>(
    certifier: &Certifier,
    buffers: &mut Buffers,
    a: usize,
    b: usize,
    epsilon: f32,
    costs: &mut Lane,
) {
    let arm = &certifier.arm;
    let count = arm.parts.len();
    let own = epsilon / UNITS;
    let around = [certifier.around[a].1, certifier.around[b].1];
    if far::<ISA>(&buffers.places[a], &buffers.places[b], around[0] + around[1] + own) {
        return;
    }
    place_balls::<ISA>(certifier, buffers, a);
    place_balls::<ISA>(certifier, buffers, b);
    let Buffers { places, forces, moments, .. } = &mut *buffers;
    let slots = [arm.parts[a].slot, arm.parts[b].slot];
    for i in arm.parts[a].balls.clone() {
        let first = &places[count + i];
        if far::<ISA>(first, &places[b], certifier.balls[i].1 + around[1] + own) {
            continue;
        }
        for j in arm.parts[b].balls.clone() {
            let second = &places[count + j];
            let radius = certifier.balls[i].1 + certifier.balls[j].1;
            if far::<ISA>(first, second, radius + own) {
                continue;
            }
            let (mut distance, mut normal) = ([0.0; LANES], [[0.0; LANES]; 3]);
            for lane in 0..LANES {
                let x = second[0][lane] - first[0][lane];
                let d = [x, second[1][lane] - first[1][lane], second[2][lane] - first[2][lane]];
                let length = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
                distance[lane] = length;
                for axis in 0..3 {
                    normal[axis][lane] = d[axis] * inverse;
                }
            }
            let force = press(costs, epsilon, &distance, &normal, radius);
            push(&force, second, 1.0, &mut forces[slots[1]], &mut moments[slots[1]]);
            push(&force, first, -1.0, &mut forces[slots[0]], &mut moments[slots[0]]);
        }
    }
}

/// Whether two points are `reach` apart in every lane.
#[inline(always)]
fn far<const ISA: u8>(a: &Points, b: &Points, reach: f32) -> bool {
    all_above::<ISA>(&squares::<ISA>(a, b), reach * reach)
}

/// Adds c of the gap `distance - radius` to the costs; the slope of c by the place, along the normal.
#[inline(always)]
pub(super) fn press(
    costs: &mut Lane,
    epsilon: f32,
    distance: &Lane,
    normal: &Points,
    radius: f32,
) -> Points {
    let mut force = [[0.0; LANES]; 3];
    for lane in 0..LANES {
        let gap = UNITS * (distance[lane] - radius);
        costs[lane] += clearance::cost(epsilon, gap);
        let slope = UNITS * clearance::slope(epsilon, gap);
        for axis in 0..3 {
            force[axis][lane] = slope * normal[axis][lane];
        }
    }
    force
}

/// Adds a force at a place, times `factor`, to a slot's force and moment.
#[inline(always)]
pub(super) fn push(
    force: &Points,
    place: &Points,
    factor: f32,
    total: &mut Points,
    moment: &mut Points,
) {
    for lane in 0..LANES {
        let f = [0, 1, 2].map(|axis: usize| factor * force[axis][lane]);
        let p = [0, 1, 2].map(|axis: usize| place[axis][lane]);
        for axis in 0..3 {
            let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
            total[axis][lane] += f[axis];
            moment[axis][lane] += p[y] * f[z] - p[z] * f[y];
        }
    }
}

/// Places the balls of a part, unless this block has done so.
#[inline(always)]
fn place_balls<const ISA: u8>(certifier: &Certifier, buffers: &mut Buffers, index: usize) {
    if buffers.placed[index] {
        return;
    }
    buffers.placed[index] = true;
    let (part, count) = (&certifier.arm.parts[index], certifier.arm.parts.len());
    for ball in part.balls.clone() {
        let center = certifier.balls[ball].0;
        point::<ISA>(&buffers.frames[part.slot], center, &mut buffers.places[count + ball]);
    }
}
