//! A convex polygon.

use super::point::Point;
use super::ring::{Ring, orientation};
use super::segment::point_segment_distance;
use crate::error::{InvalidInput, finite_point};

/// A convex polygon, its vertices counter-clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct ConvexPolygon {
    vertices: Vec<Point>,
}

impl ConvexPolygon {
    /// A polygon from its corners in either order round. A ring may be closed (its first corner repeated
    /// at its end), corners may be repeated and points may lie along an edge. What is not convex by less
    /// than rounding leaves behind (`Ring::slack`) becomes its convex hull.
    ///
    /// # Errors
    /// If a coordinate is not finite, there are fewer than three different vertices, they lie on one
    /// line, or they are not the corners of a convex polygon visited once round; the field names the
    /// corner.
    pub fn new(vertices: Vec<Point>) -> Result<Self, InvalidInput> {
        for (i, &vertex) in vertices.iter().enumerate() {
            finite_point(&format!("polygon[{i}]"), vertex)?;
        }
        Ring::new(&vertices)?.convex().map(|vertices| Self { vertices })
    }

    /// A polygon from vertices that are known to be counter-clockwise and convex but for rounding.
    pub(crate) fn from_convex(vertices: Vec<Point>) -> Self {
        Self { vertices }
    }

    /// The vertices, counter-clockwise.
    pub fn vertices(&self) -> &[Point] {
        &self.vertices
    }

    /// The edges `(from, to)`, counter-clockwise.
    pub fn edges(&self) -> impl Iterator<Item = (Point, Point)> + '_ {
        let n = self.vertices.len();
        (0..n).map(move |i| (self.vertices[i], self.vertices[(i + 1) % n]))
    }

    /// Signed distance from `p` to the border, negative inside; the sign is exact.
    pub fn signed_distance(&self, p: Point) -> f64 {
        let inside = self.edges().all(|(a, b)| orientation(a, b, p) >= 0.0);
        let border = self
            .edges()
            .map(|(a, b)| point_segment_distance(p, a, b))
            .fold(f64::INFINITY, f64::min);
        if inside { -border } else { border }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Corners on an ellipse, at increasing angles.
    fn ellipse(corners: usize, centre: Point, radii: [f64; 2]) -> Vec<Point> {
        (0..corners)
            .map(|i| (i as f64 + 0.3) / corners as f64 * std::f64::consts::TAU)
            .map(|t| [centre[0] + radii[0] * t.cos(), centre[1] + radii[1] * t.sin()])
            .collect()
    }

    #[test]
    fn distances_are_those_of_either_order() {
        let square = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let clockwise: Vec<Point> = square.iter().rev().copied().collect();
        assert!(ConvexPolygon::new(square).is_ok());
        let polygon = ConvexPolygon::new(clockwise).unwrap();
        assert!((polygon.signed_distance([1.0, 1.0]) + 1.0).abs() < 1e-12);
        assert!((polygon.signed_distance([5.0, 6.0]) - 5.0).abs() < 1e-12);
    }

    /// Beyond the tip of a needle the sides' cross products are less than their rounding.
    #[test]
    fn a_place_beyond_a_needle_is_outside() {
        let tip = [-0.300_000_017_500_000_05, -0.200_000_022_750_000_03];
        let blunt = [0.399_999_998_750_000_1; 2];
        let needle = ConvexPolygon::new(vec![blunt, [blunt[0], 0.400_000_000_250_000_04], tip]);
        let beyond = [-0.300_000_019_018_513_25, -0.200_000_024_051_582_3];
        assert!(needle.unwrap().signed_distance(beyond) > 1.9e-9);
    }

    #[test]
    fn refusals_name_the_corner() {
        for (corners, expected) in [
            (vec![[0.0, 0.0], [1.0, 1.0]], "polygon: 2 different vertices"),
            (vec![[0.0, 0.0], [1.0, 1.0], [1.0, 1.0], [0.0, 0.0]], "polygon: 2 different vertices"),
            (vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], "polygon: 3 vertices on one line"),
            (
                vec![[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]],
                "polygon[2]: the corner [1, 1], 1.414e0 inside the polygon's convex hull",
            ),
            // Repeated corners count where the corner is named.
            (
                vec![[0.0, 0.0], [0.0, 0.0], [4.0, 0.0], [2.0, 0.01], [4.0, 4.0], [0.0, 4.0]],
                "polygon[3]: the corner [2, 0.01], ",
            ),
            // A bow tie.
            (
                vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]],
                "polygon[1]: the corner [1, 1], out of order round the polygon",
            ),
            // A pentagram turns left everywhere but goes round twice.
            (
                vec![[0.0, 1.0], [-0.6, -0.8], [0.95, 0.3], [-0.95, 0.3], [0.6, -0.8]],
                "out of order round the polygon",
            ),
            // A square twice round.
            (
                [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]; 2].concat(),
                "out of order round the polygon",
            ),
            (vec![[0.0, f64::NAN], [1.0, 0.0], [1.0, 1.0]], "polygon[0][1]: NaN"),
        ] {
            let error = ConvexPolygon::new(corners).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    proptest! {
        /// Whatever people do to a convex polygon without changing it: where the ring begins, which way it
        /// runs, whether it is closed, repeated corners, points along its edges, its place and size.
        #[test]
        fn one_polygon_however_it_is_written(
            corners in 3usize..40,
            aspect in 0.01..1.0f64,
            place in prop_oneof![
                Just([0.0f64; 2]), Just([500_000.0, 5_500_000.0]), Just([15_550_000.0, 4_256_000.0]),
                Just([1e8, -1e8]), Just([-9e8, 9e8])
            ],
            size in -6.0..4.0f64,
            first in any::<prop::sample::Index>(),
            clockwise in any::<bool>(),
            closed in any::<bool>(),
            repeats in prop::collection::vec(1usize..3, 40),
            between in prop::collection::vec(0usize..4, 40),
        ) {
            // Not so small that the corners of so flat and round an ellipse fall together by rounding.
            let least = place[1].abs() * 1e-10 * (corners * corners) as f64 / aspect;
            let size = 10f64.powf(size).max(least);
            let mut ring = ellipse(corners, place, [size, size * aspect]);
            let plain = ConvexPolygon::new(ring.clone());
            prop_assert!(plain.is_ok(), "{:?}", plain);
            ring.rotate_left(first.index(corners));
            if clockwise {
                ring.reverse();
            }
            let mut written = Vec::new();
            for (i, &a) in ring.iter().enumerate() {
                let b = ring[(i + 1) % corners];
                written.extend(std::iter::repeat_n(a, repeats[i]));
                for k in 1..=between[i] {
                    let t = k as f64 / (between[i] + 1) as f64;
                    written.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
                }
            }
            if closed {
                written.push(ring[0]);
            }
            let polygon = ConvexPolygon::new(written);
            prop_assert!(polygon.is_ok(), "{:?}", polygon);
            let (plain, polygon) = (plain.unwrap(), polygon.unwrap());
            for t in 0..32 {
                let angle = f64::from(t) * 0.2;
                let reach = 0.5 + f64::from(t % 7) * 0.25;
                let p = [place[0] + reach * size * angle.cos(), place[1] + reach * size * angle.sin()];
                let slack = 1e-15 * (place[0].abs() + place[1].abs() + size) * 8.0 + 2.4e-7 * size;
                let (a, b) = (plain.signed_distance(p), polygon.signed_distance(p));
                prop_assert!((a - b).abs() <= slack, "{a} {b} at {p:?}");
            }
        }

        /// A corner pushed in by more than rounding is refused by its name.
        #[test]
        fn a_dent_is_named(corners in 4usize..30, at in any::<prop::sample::Index>(), depth in 1e-5..0.5f64) {
            let mut ring = ellipse(corners, [3.0, 4.0], [1.0, 1.0]);
            let at = at.index(corners);
            let (a, b) = (ring[at], ring[(at + 1) % corners]);
            let mid = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
            ring.insert(at + 1, [mid[0] + depth * (3.0 - mid[0]), mid[1] + depth * (4.0 - mid[1])]);
            let error = ConvexPolygon::new(ring).unwrap_err().to_string();
            let expected = format!("polygon[{}]: the corner", at + 1);
            prop_assert!(error.starts_with(&expected), "{}", error);
        }
    }
}
