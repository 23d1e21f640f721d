//! How a trajectory bends: the turn at each of its points, and the radius that it leaves for driving round.

use super::{Trajectory, distance};

impl Trajectory {
    /// The turn at each inner point, in radians from 0 (straight on) to π (back), with the shorter
    /// half of its two segments. Points that repeat their neighbour, as far as rounding can tell, are passed over.
    pub fn turns(&self) -> Vec<(f64, f64)> {
        let mut distinct: Vec<&[f64]> = Vec::with_capacity(self.len());
        let largest = self.values.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        for point in self.configurations() {
            if distinct.last().is_none_or(|last| distance(last, point) > 1e-12 * largest) {
                distinct.push(point);
            }
        }
        distinct.windows(3).map(|p| bend(p[0], p[1], p[2])).collect()
    }

    /// The sharpest turn between two segments, in radians: 0 for a straight line.
    pub fn sharpest_turn(&self) -> f64 {
        self.turns().iter().fold(0.0, |sharpest, (turn, _)| turn.max(sharpest))
    }

    /// The least radius of the arcs that round the corners and touch both segments no further away
    /// than half the shorter one; infinite for a straight line.
    pub fn turning_radius(&self) -> f64 {
        let radius = |&(turn, half): &(f64, f64)| half / (0.5 * turn).tan();
        self.turns().iter().map(radius).fold(f64::INFINITY, f64::min)
    }
}

/// Turn at `b` in radians, and half the shorter of the segments `a b` and `b c`.
fn bend(a: &[f64], b: &[f64], c: &[f64]) -> (f64, f64) {
    let (first, second) = (distance(a, b), distance(b, c));
    let dot: f64 = (0..b.len()).map(|k| (b[k] - a[k]) * (c[k] - b[k])).sum();
    // Half the angle between unit vectors, by sides of their rhomb: exact near 0 and near π.
    let cosine = dot / (first * second);
    let across = (0..b.len())
        .map(|k| ((b[k] - a[k]) / first - (c[k] - b[k]) / second).powi(2))
        .sum::<f64>()
        .sqrt();
    let turn = if cosine > 0.0 {
        2.0 * (0.5 * across).min(1.0).asin()
    } else {
        cosine.clamp(-1.0, 1.0).acos()
    };
    (turn, 0.5 * first.min(second))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    #[test]
    fn turns_and_radii_of_known_paths() {
        let check = |points: &[[f64; 2]], turn: f64, radius: f64| {
            let path = Trajectory::from_points(points);
            assert!((path.sharpest_turn() - turn).abs() < 1e-9, "{points:?}");
            let found = path.turning_radius();
            assert!(found == radius || (found - radius).abs() < 1e-9, "{points:?} {found}");
        };
        check(&[[0.0, 0.0], [1.0, 1.0]], 0.0, f64::INFINITY);
        check(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 4.0]], FRAC_PI_2, 1.0);
        check(&[[0.0, 0.0], [2.0, 0.0], [0.0, 0.0]], PI, 0.0);
        // Corners of a regular polygon: the arc is its inscribed circle.
        let corner = |i: usize| {
            let angle = PI * i as f64 / 8.0;
            [3.0 * angle.cos(), 3.0 * angle.sin()]
        };
        let circle: Vec<[f64; 2]> = (0..10).map(corner).collect();
        check(&circle, PI / 8.0, 3.0 * (PI / 16.0).cos());
    }
}
