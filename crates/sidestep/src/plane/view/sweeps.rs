//! How far it is from start and goal to every point of a square of points, round the obstacles: lengths of shortest ways over the
//! eight neighbours of a point.
//!
//! ```text
//! d_q = min over neighbours p of q of d_p + |p - q| w_q,   w = 1 in free space, rising to 400 where q is a step deep in an obstacle
//! ```
//!
//! Obstacles are slow, not closed: a passage that falls between the points is only a little farther, and a waypoint inside an
//! obstacle still has a way out. Sweeps over the rows, down and up, and over the columns, solve it (cf. fast sweeping: H. Zhao, Math.
//! Comp. 74, 2005), each a few additions and minima of whole rows; [`ROUNDS`] of them are enough but for long mazes, where
//! distances come out too large.

use crate::kernels::shift::moved;
use crate::kernels::transpose::{SQUARE, transposed};
use crate::kernels::{Isa, LANES, dispatch};

/// Points per side.
pub(super) const SIDE: usize = 64;
/// Rounds of four sweeps at most.
const ROUNDS: usize = 6;
/// Distances from start and goal are found together: two chains of additions take hardly longer than one.
const ENDS: usize = 2;
/// Farther than anything.
const FAR: f32 = 1e6;
/// What a step deep in an obstacle costs, as a multiple of one in free space.
const SLOWEST: f32 = 400.0;
/// Blocks of a row.
const BLOCKS: usize = SIDE / LANES;

/// Numbers of a row of points, in blocks that fill registers.
type Row = [[f32; LANES]; BLOCKS];
/// Numbers of the points by rows, `N` of them for each.
type Rows<const N: usize> = [[Row; N]; SIDE];
/// w.
type Weights = Rows<1>;
/// d of start and goal.
type Distances = Rows<ENDS>;

/// Distances over a square of points.
#[derive(Debug)]
pub(super) struct Sweeps {
    weights: Box<Weights>,
    distances: Box<Distances>,
}

impl Sweeps {
    /// Distances for these signed distances `[SIDE x SIDE]` at points a `step` apart, from the points that `ends` (column, row) are
    /// nearest to.
    pub fn new(signed_distance: &[f32], step: f32, ends: [[f32; 2]; ENDS]) -> Self {
        let mut weights = Box::new([[[[FAR; LANES]; BLOCKS]; 1]; SIDE]);
        for (line, [row]) in signed_distance.chunks_exact(SIDE).zip(weights.iter_mut()) {
            for (weight, distance) in row.as_flattened_mut().iter_mut().zip(line) {
                let depth = ((0.25 * step - distance) / (1.25 * step)).clamp(0.0, 1.0);
                *weight = 1.0 + (SLOWEST - 1.0) * depth;
            }
        }
        let mut distances = Box::new([[[[FAR; LANES]; BLOCKS]; ENDS]; SIDE]);
        for (end, place) in ends.into_iter().enumerate() {
            let [column, row] = place.map(|v| v.round().clamp(0.0, (SIDE - 1) as f32) as usize);
            distances[row][end].as_flattened_mut()[column] = 0.0;
        }
        sweep(Isa::detect(), &weights, &mut distances);
        Self { weights, distances }
    }

    /// Distances from start and goal at the points of a row.
    pub fn row(&self, row: usize) -> [&[f32]; ENDS] {
        self.distances[row].each_ref().map(|line| line.as_flattened())
    }

    /// Distances from start and goal at a point.
    pub fn get(&self, column: usize, row: usize) -> [f32; ENDS] {
        self.row(row).map(|line| line[column])
    }

    /// The cost w of a step to a point.
    pub fn weight(&self, column: usize, row: usize) -> f32 {
        self.weights[row][0].as_flattened()[column]
    }
}

dispatch! {
    fn sweep(weights: &Weights, distances: &mut Distances) = sweep_body;
}

#[inline(always)]
fn sweep_body<const ISA: u8>(weights: &Weights, distances: &mut Distances) {
    let mut turned_weights = [[[[0.0; LANES]; BLOCKS]; 1]; SIDE];
    let mut turned = [[[[0.0; LANES]; BLOCKS]; ENDS]; SIDE];
    turn::<ISA, 1>(weights, &mut turned_weights);
    let mut before = f32::INFINITY;
    for _ in 0..ROUNDS {
        down_and_up::<ISA>(weights, distances);
        turn::<ISA, ENDS>(distances, &mut turned);
        down_and_up::<ISA>(&turned_weights, &mut turned);
        turn::<ISA, ENDS>(&turned, distances);
        let after = total(distances);
        if after == before {
            break;
        }
        before = after;
    }
}

/// A sum that falls while ways become shorter.
#[inline(always)]
fn total(distances: &Distances) -> f32 {
    let mut sums = [0.0; LANES];
    for block in distances.as_flattened().as_flattened() {
        for lane in 0..LANES {
            sums[lane] += block[lane];
        }
    }
    sums.iter().sum()
}

#[inline(always)]
fn down_and_up<const ISA: u8>(weights: &Weights, distances: &mut Distances) {
    let mut beside = distances[0];
    for (weights, row) in weights.iter().zip(distances.iter_mut()).skip(1) {
        relax::<ISA>(&weights[0], &mut beside, row);
    }
    for (weights, row) in weights.iter().zip(distances.iter_mut()).rev().skip(1) {
        relax::<ISA>(&weights[0], &mut beside, row);
    }
}

/// Takes the ways from the row `beside` to `row`, which then is the row beside the next: from one row to the next the numbers stay
/// in registers, as a shifted row that has just been stored would take long to load.
#[inline(always)]
fn relax<const ISA: u8>(weights: &Row, beside: &mut [Row; ENDS], row: &mut [Row; ENDS]) {
    const EDGE: [f32; LANES] = [FAR; LANES];
    for (from, to) in beside.iter_mut().zip(row) {
        let mut own = *to;
        for block in 0..BLOCKS {
            let middle = &from[block];
            let before = if block > 0 { &from[block - 1] } else { &EDGE };
            let after = if block + 1 < BLOCKS { &from[block + 1] } else { &EDGE };
            let [left, right] = moved::<ISA>(before, middle, after);
            let (weights, known) = (&weights[block], own[block]);
            for lane in 0..LANES {
                let near = if left[lane] < right[lane] { left[lane] } else { right[lane] };
                let aslant = near + std::f32::consts::SQRT_2 * weights[lane];
                let straight = middle[lane] + weights[lane];
                let way = if aslant < straight { aslant } else { straight };
                own[block][lane] = if way < known[lane] { way } else { known[lane] };
            }
        }
        *from = own;
        *to = own;
    }
}

/// Exchanges rows and columns.
#[inline(always)]
fn turn<const ISA: u8, const N: usize>(from: &Rows<N>, to: &mut Rows<N>) {
    for i in (0..SIDE).step_by(SQUARE) {
        for j in (0..SIDE).step_by(SQUARE) {
            for layer in 0..N {
                let mut square = [[0.0; SQUARE]; SQUARE];
                for (k, row) in square.iter_mut().enumerate() {
                    row.copy_from_slice(&from[i + k][layer].as_flattened()[j..j + SQUARE]);
                }
                for (k, row) in transposed::<ISA>(&square).iter().enumerate() {
                    to[j + k][layer].as_flattened_mut()[i..i + SQUARE].copy_from_slice(row);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::cmp::Reverse;
    use std::collections::BinaryHeap;

    /// Dijkstra's answer; costs in millionths, so that they have an order.
    fn reference(weights: &[f32], source: usize) -> Vec<u64> {
        let mut distances = vec![u64::MAX; SIDE * SIDE];
        let mut open = BinaryHeap::from([(Reverse(0), source)]);
        while let Some((Reverse(distance), from)) = open.pop() {
            if distance >= distances[from] {
                continue;
            }
            distances[from] = distance;
            let (x, y) = (from % SIDE, from / SIDE);
            for row in y.saturating_sub(1)..=(y + 1).min(SIDE - 1) {
                for column in x.saturating_sub(1)..=(x + 1).min(SIDE - 1) {
                    let to = row * SIDE + column;
                    let (dx, dy) = (column.abs_diff(x) as f64, row.abs_diff(y) as f64);
                    let cost = dx.hypot(dy) * f64::from(weights[to]) * 1e6;
                    open.push((Reverse(distance + cost as u64), to));
                }
            }
        }
        distances
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]
        #[test]
        fn sweeps_match_reference(
            boxes in prop::collection::vec(prop::array::uniform4(0.0_f32..20.0), 1..12),
            ends in prop::array::uniform4(0.0_f32..63.0),
        ) {
            // Rectangles at three times the first two numbers, as large as the others.
            let field: Vec<f32> = (0..SIDE * SIDE).map(|at| {
                let (x, y) = ((at % SIDE) as f32, (at / SIDE) as f32);
                let beyond = |[u, v, w, h]: [f32; 4]| {
                    (3.0 * u - x).max(x - 3.0 * u - w).max(3.0 * v - y).max(y - 3.0 * v - h)
                };
                boxes.iter().map(|b| beyond(*b)).fold(f32::INFINITY, f32::min)
            }).collect();
            let ends = [[ends[0], ends[1]], [ends[2], ends[3]]];
            let sweeps = Sweeps::new(&field, 1.0, ends);
            let weights: Vec<f32> =
                field.iter().map(|d| 1.0 + (SLOWEST - 1.0) * ((0.25 - d) / 1.25).clamp(0.0, 1.0)).collect();
            for (end, place) in ends.into_iter().enumerate() {
                let [column, row] = place.map(|v| v.round() as usize);
                for (at, want) in reference(&weights, row * SIDE + column).iter().enumerate() {
                    let got = f64::from(sweeps.get(at % SIDE, at / SIDE)[end]);
                    let want = *want as f64 * 1e-6;
                    prop_assert!((got - want).abs() <= 1e-3 * (1.0 + want), "{at}: {got} {want}");
                }
            }
        }
    }
}
