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
/// Points of a row with a border of [`FAR`].
const STRIDE: usize = (SIDE + 2).next_multiple_of(SQUARE);

/// Numbers of the points by rows, `N` of them for each.
type Rows<const N: usize> = [[[f32; STRIDE]; N]; STRIDE];
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
        let mut weights = Box::new([[[FAR; STRIDE]]; STRIDE]);
        for (line, [row]) in signed_distance.chunks_exact(SIDE).take(SIDE).zip(&mut weights[1..]) {
            for (weight, distance) in row[1..].iter_mut().zip(line) {
                let depth = ((0.25 * step - distance) / (1.25 * step)).clamp(0.0, 1.0);
                *weight = 1.0 + (SLOWEST - 1.0) * depth;
            }
        }
        let mut distances = Box::new([[[FAR; STRIDE]; ENDS]; STRIDE]);
        for (end, place) in ends.into_iter().enumerate() {
            let [column, row] = place.map(|v| v.round().clamp(0.0, (SIDE - 1) as f32) as usize);
            distances[row + 1][end][column + 1] = 0.0;
        }
        sweep(Isa::detect(), &weights, &mut distances);
        Self { weights, distances }
    }

    /// Distances from start and goal at the points of a row.
    pub fn row(&self, row: usize) -> [&[f32]; ENDS] {
        self.distances[row + 1].each_ref().map(|line| &line[1..][..SIDE])
    }

    /// Distances from start and goal at a point.
    pub fn get(&self, column: usize, row: usize) -> [f32; ENDS] {
        self.row(row).map(|line| line[column])
    }

    /// The cost w of a step to a point.
    pub fn weight(&self, column: usize, row: usize) -> f32 {
        self.weights[row + 1][0][column + 1]
    }
}

dispatch! {
    fn sweep(weights: &Weights, distances: &mut Distances) = sweep_body;
}

#[inline(always)]
fn sweep_body<const ISA: u8>(weights: &Weights, distances: &mut Distances) {
    let mut turned_weights = [[[0.0; STRIDE]; 1]; STRIDE];
    let mut turned = [[[0.0; STRIDE]; ENDS]; STRIDE];
    turn::<ISA, 1>(weights, &mut turned_weights);
    let mut before = f32::INFINITY;
    for _ in 0..ROUNDS {
        down_and_up(weights, distances);
        turn::<ISA, ENDS>(distances, &mut turned);
        down_and_up(&turned_weights, &mut turned);
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
    for row in &distances[1..=SIDE] {
        for line in row {
            for block in line[1..=SIDE].chunks_exact(LANES) {
                for lane in 0..LANES {
                    sums[lane] += block[lane];
                }
            }
        }
    }
    sums.iter().sum()
}

#[inline(always)]
fn down_and_up(weights: &Weights, distances: &mut Distances) {
    for row in 2..=SIDE {
        let (before, rest) = distances.split_at_mut(row);
        relax(&weights[row][0], &before[row - 1], &mut rest[0]);
    }
    for row in (1..SIDE).rev() {
        let (rest, after) = distances.split_at_mut(row + 1);
        relax(&weights[row][0], &after[0], &mut rest[row]);
    }
}

/// Takes the ways from a row to the one beside it.
#[inline(always)]
fn relax(weights: &[f32; STRIDE], from: &[[f32; STRIDE]; ENDS], to: &mut [[f32; STRIDE]; ENDS]) {
    for end in 0..ENDS {
        for first in (1..=SIDE).step_by(LANES) {
            let [mut left, mut middle, mut right, mut weight, mut own] = [[0.0; LANES]; 5];
            left.copy_from_slice(&from[end][first - 1..first - 1 + LANES]);
            middle.copy_from_slice(&from[end][first..first + LANES]);
            right.copy_from_slice(&from[end][first + 1..first + 1 + LANES]);
            weight.copy_from_slice(&weights[first..first + LANES]);
            let to = &mut to[end][first..first + LANES];
            own.copy_from_slice(to);
            for lane in 0..LANES {
                let near = if left[lane] < right[lane] { left[lane] } else { right[lane] };
                let aslant = near + std::f32::consts::SQRT_2 * weight[lane];
                let straight = middle[lane] + weight[lane];
                let way = if aslant < straight { aslant } else { straight };
                own[lane] = if way < own[lane] { way } else { own[lane] };
            }
            // All of it: masked stores cannot be read back at once.
            to.copy_from_slice(&own);
        }
    }
}

/// Exchanges rows and columns, border and all.
#[inline(always)]
fn turn<const ISA: u8, const N: usize>(from: &Rows<N>, to: &mut Rows<N>) {
    for i in (0..STRIDE).step_by(SQUARE) {
        for j in (0..STRIDE).step_by(SQUARE) {
            for layer in 0..N {
                let mut square = [[0.0; SQUARE]; SQUARE];
                for (k, row) in square.iter_mut().enumerate() {
                    row.copy_from_slice(&from[i + k][layer][j..j + SQUARE]);
                }
                for (k, row) in transposed::<ISA>(&square).iter().enumerate() {
                    to[j + k][layer][i..i + SQUARE].copy_from_slice(row);
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
