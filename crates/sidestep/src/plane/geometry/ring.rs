//! Whether corners in a row are a convex polygon, decided exactly.
//!
//! The sign of every turn comes from Shewchuk's adaptive predicate (doi:10.1007/PL00009321), so small
//! polygons far from the origin are judged like any others. What people write is often convex only but
//! for rounding: points along an edge that bend inwards by a last digit. Those are straightened by the
//! convex hull, which holds all of the polygon, so nothing that was forbidden becomes free.

use super::point::Point;
use super::segment::point_segment_distance;
use crate::error::InvalidInput;

/// Corners this far inside the hull are rounding, in parts of the polygon's extent: that of f32.
const RELATIVE_SLACK: f64 = f32::EPSILON as f64;

/// The same in units of the last place of the largest coordinate.
const SLACK_IN_ULPS: f64 = 8.0;

/// The corners of a closed ring, none equal to the next.
pub(super) struct Ring {
    corners: Vec<Point>,
    /// Where each corner stands in the input.
    indices: Vec<usize>,
}

impl Ring {
    /// The ring of `vertices`, of which the last may repeat the first.
    pub(super) fn new(vertices: &[Point]) -> Result<Self, InvalidInput> {
        let mut ring = Self { corners: Vec::new(), indices: Vec::new() };
        for (i, &vertex) in vertices.iter().enumerate() {
            if ring.corners.last() != Some(&vertex) {
                ring.corners.push(vertex);
                ring.indices.push(i);
            }
        }
        while ring.corners.len() > 1 && ring.corners.first() == ring.corners.last() {
            ring.corners.pop();
        }
        if ring.corners.len() < 3 {
            let found = format!("{} different vertices", ring.corners.len());
            return Err(InvalidInput::new("polygon", found, "at least 3"));
        }
        Ok(ring)
    }

    /// The corners counter-clockwise if they are a convex polygon, else those of its hull if it differs by
    /// rounding only.
    pub(super) fn convex(mut self) -> Result<Vec<Point>, InvalidInput> {
        let n = self.corners.len();
        let corner = |i: usize| self.corners[i % n];
        let turn = |i: usize| orientation(corner(i), corner(i + 1), corner(i + 2));
        let Some(sense) = (0..n).map(turn).find(|&turn| turn != 0.0) else {
            let found = format!("{n} vertices on one line");
            return Err(InvalidInput::new("polygon", found, "a polygon of positive area"));
        };
        // One sense everywhere, and once round: the edge directions cross the x axis twice.
        let upward = |i: usize| {
            let ([x0, y0], [x1, y1]) = (corner(i), corner(i + 1));
            y1 > y0 || (y1 == y0 && x1 > x0)
        };
        let one_sense = (0..n).all(|i| turn(i) * sense.signum() >= 0.0);
        if !one_sense || (0..n).filter(|&i| upward(i) != upward(i + 1)).count() != 2 {
            return self.straightened();
        }
        if sense < 0.0 {
            self.corners.reverse();
        }
        Ok(self.corners)
    }

    /// The corners of the hull, if the ring runs once round it and strays from it by rounding only.
    fn straightened(&self) -> Result<Vec<Point>, InvalidInput> {
        let (hull, places) = self.hull();
        let n = self.corners.len();
        let on_hull: Vec<usize> = (0..n).filter(|&i| places[i].is_some()).collect();
        let step = |k: usize| {
            let place = |k: usize| places[on_hull[k % on_hull.len()]].unwrap_or(0);
            (place(k + 1) + hull.len() - place(k)) % hull.len()
        };
        let sense = step(0);
        for k in 0..on_hull.len() {
            if ![1, hull.len() - 1].contains(&sense) || step(k) != sense || k >= hull.len() {
                return Err(self.refused(
                    on_hull[(k + 1) % on_hull.len()],
                    "out of order round the polygon",
                    "each corner once, in order round; split other shapes into convex ones",
                ));
            }
        }
        let slack = self.slack();
        let mut deepest = (slack, None);
        for k in 0..on_hull.len() {
            let (from, to) = (on_hull[k], on_hull[(k + 1) % on_hull.len()]);
            let [a, b] = [from, to].map(|i| self.corners[i]);
            for i in (from + 1..from + (to + n - from) % n).map(|i| i % n) {
                let depth = point_segment_distance(self.corners[i], a, b);
                if depth > deepest.0 {
                    deepest = (depth, Some(i));
                }
            }
        }
        match deepest {
            (_, None) => Ok(hull.iter().map(|&i| self.corners[i]).collect()),
            (depth, Some(i)) => Err(self.refused(
                i,
                format!("{depth:.3e} inside the polygon's convex hull"),
                format!(
                    "a convex polygon (up to {slack:.0e} counts as rounding); split other shapes \
                     into convex ones"
                ),
            )),
        }
    }

    /// The corners of the convex hull counter-clockwise, and the place on it of every corner that is one
    /// of its (A. Andrew's monotone chain, doi:10.1016/0020-0190(79)90072-3).
    fn hull(&self) -> (Vec<usize>, Vec<Option<usize>>) {
        let mut order: Vec<usize> = (0..self.corners.len()).collect();
        order.sort_by(|&a, &b| {
            let ([ax, ay], [bx, by]) = (self.corners[a], self.corners[b]);
            ax.total_cmp(&bx).then(ay.total_cmp(&by))
        });
        order.dedup_by_key(|&mut i| self.corners[i]);
        let mut hull: Vec<usize> = Vec::new();
        let mut chain = |order: &mut dyn Iterator<Item = &usize>| {
            let first = hull.len();
            for &i in order {
                while let [.., a, b] = hull[first..]
                    && orientation(self.corners[a], self.corners[b], self.corners[i]) <= 0.0
                {
                    hull.pop();
                }
                hull.push(i);
            }
            // The other half begins with it.
            hull.pop();
        };
        chain(&mut order.iter());
        chain(&mut order.iter().rev());
        let mut places = vec![None; self.corners.len()];
        let by_corner: std::collections::HashMap<[u64; 2], usize> =
            hull.iter().enumerate().map(|(place, &i)| (bits(self.corners[i]), place)).collect();
        for (place, &corner) in places.iter_mut().zip(&self.corners) {
            *place = by_corner.get(&bits(corner)).copied();
        }
        (hull, places)
    }

    /// How far inside the hull a corner may lie.
    fn slack(&self) -> f64 {
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in &self.corners {
            for axis in 0..2 {
                min[axis] = min[axis].min(corner[axis]);
                max[axis] = max[axis].max(corner[axis]);
            }
        }
        let extent = (max[0] - min[0]).max(max[1] - min[1]);
        let largest = min.into_iter().chain(max).fold(0.0, |largest: f64, v| largest.max(v.abs()));
        RELATIVE_SLACK * extent + SLACK_IN_ULPS * f64::EPSILON * largest
    }

    fn refused(
        &self,
        corner: usize,
        fault: impl std::fmt::Display,
        allowed: impl Into<String>,
    ) -> InvalidInput {
        let [x, y] = self.corners[corner];
        let field = format!("polygon[{}]", self.indices[corner]);
        InvalidInput::new(field, format!("the corner [{x}, {y}], {fault},"), allowed)
    }
}

/// Positive if `c` lies to the left of the line from `a` to `b`, negative to its right, 0 on it: the
/// sign is exact.
pub(super) fn orientation(a: Point, b: Point, c: Point) -> f64 {
    let coord = |[x, y]: Point| robust::Coord { x, y };
    robust::orient2d(coord(a), coord(b), coord(c))
}

/// A point as a key; -0 is 0.
fn bits(p: Point) -> [u64; 2] {
    p.map(|v| (v + 0.0).to_bits())
}
