//! How far it is from start and goal to every point of a square of points, round the obstacles: lengths of shortest ways over the
//! eight neighbours of a point.
//!
//! ```text
//! d_q = min over neighbours p of q of d_p + |p - q| w_q,   w = 1 in free space, rising to 40 where q is a step deep in an obstacle
//! ```
//!
//! Obstacles are slow, not closed: a passage that falls between the points is only a little farther, and a waypoint inside an
//! obstacle still has a way out. Sweeps over the rows, down and up, and over the columns, solve it (cf. fast sweeping: H. Zhao, Math.
//! Comp. 74, 2005), each a few additions and minima of whole rows; [`ROUNDS`] of them are enough but for long mazes, where
//! distances come out too large.

use crate::kernels::{Isa, dispatch};

/// Rounds of four sweeps at most.
const ROUNDS: usize = 6;
/// Rows and columns that are transposed together.
const BLOCK: usize = 8;
/// Farther than anything.
const FAR: f32 = 1e6;
/// What a step deep in an obstacle costs, as a multiple of one in free space.
const SLOWEST: f32 = 40.0;

/// Distances over a square of points.
#[derive(Debug, Clone)]
pub(super) struct Ways {
    side: usize,
    stride: usize,
    /// w by rows and by columns, `[stride x stride]` with a border of [`FAR`].
    weights: [Vec<f32>; 2],
    /// d of start and goal, in the same layout.
    distances: [Vec<f32>; 2],
    turned: Vec<f32>,
}

impl Ways {
    /// Room for `side` x `side` points.
    pub fn new(side: usize) -> Self {
        let stride = (side.next_multiple_of(BLOCK) + 2).next_multiple_of(BLOCK);
        let far = || vec![FAR; stride * stride];
        Self { side, stride, weights: [far(), far()], distances: [far(), far()], turned: far() }
    }

    /// Distances for these signed distances `[side x side]` at points a `step` apart, from the points that `ends` (column, row) are
    /// nearest to.
    pub fn solve(&mut self, signed_distance: &[f32], step: f32, ends: [[f32; 2]; 2]) {
        let side = self.side;
        for (row, line) in signed_distance.chunks_exact(side).take(side).enumerate() {
            for (column, &distance) in line.iter().enumerate() {
                let depth = ((0.25 * step - distance) / (1.25 * step)).clamp(0.0, 1.0);
                let weight = 1.0 + (SLOWEST - 1.0) * depth;
                let (at, turned) = (self.at(column, row), self.at(row, column));
                self.weights[0][at] = weight;
                self.weights[1][turned] = weight;
            }
        }
        for (end, place) in ends.into_iter().enumerate() {
            let last = (side - 1) as f32;
            let [column, row] = place.map(|v| v.round().clamp(0.0, last) as usize);
            let source = self.at(column, row);
            let distances = &mut self.distances[end];
            distances.fill(FAR);
            distances[source] = 0.0;
            let [weights, turned_weights] = &self.weights;
            let turned = &mut self.turned;
            sweep(Isa::detect(), side, self.stride, weights, turned_weights, distances, turned);
        }
    }

    /// Distances from start and goal at a point.
    pub fn get(&self, column: usize, row: usize) -> [f32; 2] {
        let at = self.at(column, row);
        [self.distances[0][at], self.distances[1][at]]
    }

    fn at(&self, column: usize, row: usize) -> usize {
        (row + 1) * self.stride + column + 1
    }
}

dispatch! {
    fn sweep(
        side: usize,
        stride: usize,
        weights: &[f32],
        turned_weights: &[f32],
        distances: &mut [f32],
        turned: &mut [f32],
    ) = sweep_body;
}

#[inline(always)]
fn sweep_body<const ISA: u8>(
    side: usize,
    stride: usize,
    weights: &[f32],
    turned_weights: &[f32],
    distances: &mut [f32],
    turned: &mut [f32],
) {
    for round in 0..ROUNDS {
        let rows = down_and_up(side, stride, weights, distances);
        if round > 0 && !rows {
            break;
        }
        turn(stride, distances, turned);
        let columns = down_and_up(side, stride, turned_weights, turned);
        if !columns {
            break;
        }
        turn(stride, turned, distances);
    }
}

/// Whether a way became shorter.
#[inline(always)]
fn down_and_up(side: usize, stride: usize, weights: &[f32], distances: &mut [f32]) -> bool {
    let mut changed = false;
    for row in 2..=side {
        let (before, rest) = distances.split_at_mut(row * stride);
        changed |= relax(&weights[row * stride..], &before[(row - 1) * stride..], rest, side);
    }
    for row in (1..side).rev() {
        let (rest, after) = distances.split_at_mut((row + 1) * stride);
        changed |= relax(&weights[row * stride..], after, &mut rest[row * stride..], side);
    }
    changed
}

/// Takes the ways from a row to the one beside it; whether one is shorter than before.
#[inline(always)]
fn relax(weights: &[f32], from: &[f32], to: &mut [f32], side: usize) -> bool {
    let mut changed = [0; BLOCK];
    // Whole blocks: what lies beyond the last column costs too much to go through.
    for first in (1..=side).step_by(BLOCK) {
        let block = |values: &[f32], at: usize| -> [f32; BLOCK] {
            std::array::from_fn(|lane| values[at..at + BLOCK][lane])
        };
        let (left, middle, right) =
            (block(from, first - 1), block(from, first), block(from, first + 1));
        let weight = block(weights, first);
        let to = &mut to[first..first + BLOCK];
        for lane in 0..BLOCK {
            let beside = if left[lane] < right[lane] { left[lane] } else { right[lane] };
            let aslant = beside + std::f32::consts::SQRT_2 * weight[lane];
            let straight = middle[lane] + weight[lane];
            let way = if aslant < straight { aslant } else { straight };
            changed[lane] |= u32::from(way < to[lane]);
            to[lane] = if way < to[lane] { way } else { to[lane] };
        }
    }
    changed != [0; BLOCK]
}

/// Transposes `[stride x stride]`, border and all.
#[inline(always)]
fn turn(stride: usize, from: &[f32], to: &mut [f32]) {
    for first_row in (0..stride).step_by(BLOCK) {
        for first_column in (0..stride).step_by(BLOCK) {
            let mut block = [[0.0_f32; BLOCK]; BLOCK];
            for (row, values) in block.iter_mut().enumerate() {
                let at = (first_row + row) * stride + first_column;
                values.copy_from_slice(&from[at..at + BLOCK]);
            }
            for column in 0..BLOCK {
                let at = (first_column + column) * stride + first_row;
                let to = &mut to[at..at + BLOCK];
                for row in 0..BLOCK {
                    to[row] = block[row][column];
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Dijkstra's answer by relaxing until nothing changes.
    fn reference(weights: &[f32], side: usize, source: usize) -> Vec<f64> {
        let mut distances = vec![f64::INFINITY; side * side];
        distances[source] = 0.0;
        loop {
            let mut changed = false;
            for to in 0..side * side {
                for from in 0..side * side {
                    let (dx, dy) =
                        ((to % side).abs_diff(from % side), (to / side).abs_diff(from / side));
                    if dx.max(dy) != 1 {
                        continue;
                    }
                    let length = ((dx * dx + dy * dy) as f64).sqrt();
                    let way = distances[from] + length * f64::from(weights[to]);
                    if way < distances[to] - 1e-12 {
                        distances[to] = way;
                        changed = true;
                    }
                }
            }
            if !changed {
                return distances;
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]
        #[test]
        fn sweeps_match_reference(
            side in 4_usize..10,
            field in prop::collection::vec(-1.5_f32..3.0, 81),
            ends in prop::array::uniform4(0.0_f32..9.0),
        ) {
            let field = &field[..side * side];
            let mut ways = Ways::new(side);
            let ends = [[ends[0], ends[1]], [ends[2], ends[3]]];
            ways.solve(field, 1.0, ends);
            let weights: Vec<f32> =
                field.iter().map(|d| 1.0 + 39.0 * ((0.25 - d) / 1.25).clamp(0.0, 1.0)).collect();
            for (end, place) in ends.into_iter().enumerate() {
                let [column, row] = place.map(|v| (v.round() as usize).min(side - 1));
                let exact = reference(&weights, side, row * side + column);
                for (at, want) in exact.iter().enumerate() {
                    let got = f64::from(ways.get(at % side, at / side)[end]);
                    prop_assert!((got - want).abs() <= 1e-4 * (1.0 + want), "{at}: {got} {want}");
                }
            }
        }
    }
}
