//! The fastest way along a path: TOPP-RA (H. Pham, Q.-C. Pham, "A New Approach to Time-Optimal Path
//! Parameterization Based on Reachability Analysis", IEEE T-RO 34(3), 2018, DOI
//! 10.1109/TRO.2018.2819195).
//!
//! With `x = ṡ²` and `u = s̈`, joint j has velocity `q'_j √x` and acceleration `q'_j u + q''_j x`,
//! and over an interval of length Δ with constant u, `x` goes to `x + 2 Δ u`. Backwards: the
//! largest x from which the end can be reached within the limits. Forwards: the largest u that
//! stays below. Both are linear programs of two variables; as standing still (x = u = 0) is always
//! allowed, the first is the least crossing of a lower with an upper bound on u.
//!
//! Within an interval of a piece with constant q'', q' and x are linear in s, so the acceleration
//! is too, and the limits at the interval's two ends hold on all of it. (The original asks for one
//! end, or for two on any path; there the limits are passed a little between grid points.) For
//! velocities the larger |q'_j| of both ends counts.

use super::limits::Limits;
use super::path::Piece;

/// Limits are made smaller by this share, so that rounding does not pass them.
const ROUNDING: f64 = 1e-9;

/// A bound `u <= at_rest + slope x` (an upper one) or `u >= ...` (a lower one).
#[derive(Clone, Copy)]
struct Bound {
    at_rest: f64,
    slope: f64,
}

/// What an interval of the grid allows.
struct Interval {
    length: f64,
    /// Largest x at both ends, by the velocities and where u has no say.
    fastest: f64,
    lower: Vec<Bound>,
    upper: Vec<Bound>,
}

impl Interval {
    /// From `from` to `to` behind the beginning of a piece.
    fn new(piece: &Piece, from: f64, to: f64, limits: &Limits) -> Self {
        let length = to - from;
        let mut fastest = f64::INFINITY;
        let (mut lower, mut upper) = (Vec::new(), Vec::new());
        for j in 0..limits.dof() {
            let velocity = limits.velocity()[j] * (1.0 - ROUNDING);
            let acceleration = limits.acceleration()[j] * (1.0 - ROUNDING);
            let bend = piece.bend[j];
            let slopes = [piece.slope_at(j, from), piece.slope_at(j, to)];
            let steepest = slopes[0].abs().max(slopes[1].abs());
            if steepest > 0.0 {
                fastest = fastest.min((velocity / steepest).powi(2));
            }
            // -a <= weight u + bend x <= a, at the left end and, with x + 2 Δ u, at the right one.
            for weight in [slopes[0], slopes[1] + 2.0 * length * bend] {
                if weight.abs() < 1e-12 {
                    if bend != 0.0 {
                        fastest = fastest.min(acceleration / bend.abs());
                    }
                    continue;
                }
                let (reach, slope) = (acceleration / weight.abs(), -bend / weight);
                lower.push(Bound { at_rest: -reach, slope });
                upper.push(Bound { at_rest: reach, slope });
            }
        }
        Self { length, fastest, lower, upper }
    }

    /// The bounds that follow from `0 <= x + 2 Δ u <= next` at the right end.
    fn arriving(&self, next: f64) -> (Bound, Bound) {
        let slope = -0.5 / self.length;
        (Bound { at_rest: 0.0, slope }, Bound { at_rest: next * -slope, slope })
    }

    /// The largest x at the left end from which the right end can be reached with at most `next`.
    fn controllable(&self, next: f64) -> f64 {
        let (last_lower, last_upper) = self.arriving(next);
        let mut fastest = self.fastest;
        for lower in self.lower.iter().chain([&last_lower]) {
            for upper in self.upper.iter().chain([&last_upper]) {
                let closing = lower.slope - upper.slope;
                if closing > 0.0 {
                    fastest = fastest.min((upper.at_rest - lower.at_rest) / closing);
                }
            }
        }
        fastest.max(0.0)
    }

    /// x at the right end after the largest u from `x` at the left end.
    fn forward(&self, x: f64, next: f64) -> f64 {
        let (_, last_upper) = self.arriving(next);
        let bounds = self.upper.iter().chain([&last_upper]);
        let u = bounds.map(|bound| bound.at_rest + bound.slope * x).fold(f64::INFINITY, f64::min);
        (x + 2.0 * self.length * u).clamp(0.0, next)
    }
}

/// `ṡ²` at each of `grid`'s points for pieces that the robot goes through without a stop, from rest
/// to rest. `grid[k]` is a point's piece and how far behind its beginning the interval from there
/// on begins and ends.
pub(super) fn fastest(pieces: &[Piece], grid: &[(usize, f64, f64)], limits: &Limits) -> Vec<f64> {
    let intervals: Vec<Interval> = grid
        .iter()
        .map(|&(piece, from, to)| Interval::new(&pieces[piece], from, to, limits))
        .collect();
    let n = intervals.len();
    let mut x = vec![0.0; n + 1];
    for i in (0..n).rev() {
        let before = if i > 0 { intervals[i - 1].fastest } else { 0.0 };
        x[i] = intervals[i].controllable(x[i + 1]).min(before);
    }
    for i in 0..n {
        x[i + 1] = intervals[i].forward(x[i], x[i + 1]);
    }
    x
}
