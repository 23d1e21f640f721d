//! A convex polygon.

use super::point::{Point, cross, sub};
use super::segment::point_segment_distance;
use crate::error::{InvalidInput, finite_point};

/// A convex polygon, its vertices counter-clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct ConvexPolygon {
    vertices: Vec<Point>,
}

impl ConvexPolygon {
    /// A polygon from its vertices in either order round.
    ///
    /// # Errors
    /// If a coordinate is not finite, there are fewer than three vertices, or they are not the
    /// corners of a convex polygon of positive area visited once round.
    pub fn new(mut vertices: Vec<Point>) -> Result<Self, InvalidInput> {
        for (i, &vertex) in vertices.iter().enumerate() {
            finite_point(&format!("polygon[{i}]"), vertex)?;
        }
        let n = vertices.len();
        if n < 3 {
            return Err(InvalidInput::new("polygon", format!("{n} vertices"), "at least 3"));
        }
        let twice_area: f64 = (0..n).map(|i| cross(vertices[i], vertices[(i + 1) % n])).sum();
        if twice_area < 0.0 {
            vertices.reverse();
        }
        let edge = |i: usize| sub(vertices[(i + 1) % n], vertices[i % n]);
        // Left turns everywhere, and once round: the edge directions cross the x axis twice.
        let convex = (0..n).all(|i| cross(edge(i), edge(i + 1)) >= 0.0);
        let upward = |i: usize| edge(i)[1] > 0.0 || (edge(i)[1] == 0.0 && edge(i)[0] > 0.0);
        let sign_changes = (0..n).filter(|&i| upward(i) != upward(i + 1)).count();
        if !convex || sign_changes != 2 || twice_area == 0.0 {
            return Err(InvalidInput::new(
                "polygon",
                format!("{n} vertices that are not convex"),
                "the corners of a convex polygon of positive area, in order; split others",
            ));
        }
        Ok(Self { vertices })
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

    /// Signed distance from `p` to the border, negative inside.
    pub fn signed_distance(&self, p: Point) -> f64 {
        let inside = self.edges().all(|(a, b)| cross(sub(b, a), sub(p, a)) >= 0.0);
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

    #[test]
    fn accepts_convex_in_either_order_and_refuses_the_rest() {
        let square = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let clockwise: Vec<Point> = square.iter().rev().copied().collect();
        assert!(ConvexPolygon::new(square).is_ok());
        let polygon = ConvexPolygon::new(clockwise).unwrap();
        assert!((polygon.signed_distance([1.0, 1.0]) + 1.0).abs() < 1e-12);
        assert!((polygon.signed_distance([5.0, 6.0]) - 5.0).abs() < 1e-12);
        for bad in [
            vec![[0.0, 0.0], [1.0, 1.0]],
            vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]],
            vec![[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]],
            // A pentagram turns left everywhere but goes round twice.
            vec![[0.0, 1.0], [-0.6, -0.8], [0.95, 0.3], [-0.95, 0.3], [0.6, -0.8]],
        ] {
            assert!(ConvexPolygon::new(bad.clone()).is_err(), "{bad:?}");
        }
    }
}
