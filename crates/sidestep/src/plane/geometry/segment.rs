//! Distances from and between closed segments.

use super::point::{Point, add, cross, distance, dot, scale, sub};

/// The point of segment `a b` nearest to `p`.
#[inline]
pub fn closest_on_segment(p: Point, a: Point, b: Point) -> Point {
    let direction = sub(b, a);
    let length_squared = dot(direction, direction);
    if length_squared == 0.0 {
        return a;
    }
    let t = (dot(sub(p, a), direction) / length_squared).clamp(0.0, 1.0);
    add(a, scale(direction, t))
}

/// The distance from `p` to segment `a b`.
#[inline]
pub fn point_segment_distance(p: Point, a: Point, b: Point) -> f64 {
    distance(p, closest_on_segment(p, a, b))
}

/// The distance between segments `a b` and `c d`; 0 where they touch or cross.
///
/// Two segments that do not cross are nearest at an end point of one of them.
pub fn segments_distance(a: Point, b: Point, c: Point, d: Point) -> f64 {
    if properly_cross(a, b, c, d) {
        return 0.0;
    }
    point_segment_distance(a, c, d)
        .min(point_segment_distance(b, c, d))
        .min(point_segment_distance(c, a, b))
        .min(point_segment_distance(d, a, b))
}

/// Whether the segments cross in a point inside both.
fn properly_cross(a: Point, b: Point, c: Point, d: Point) -> bool {
    let (ab, cd) = (sub(b, a), sub(d, c));
    let (side_c, side_d) = (cross(ab, sub(c, a)), cross(ab, sub(d, a)));
    let (side_a, side_b) = (cross(cd, sub(a, c)), cross(cd, sub(b, c)));
    side_c * side_d < 0.0 && side_a * side_b < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances() {
        let check = |a, b, c, d, expected: f64| {
            let got = segments_distance(a, b, c, d);
            assert!((got - expected).abs() < 1e-12, "{a:?} {b:?} {c:?} {d:?}: {got}");
        };
        check([0.0, 0.0], [2.0, 2.0], [0.0, 2.0], [2.0, 0.0], 0.0);
        check([0.0, 0.0], [1.0, 0.0], [0.0, 2.0], [1.0, 2.0], 2.0);
        check([0.0, 0.0], [1.0, 0.0], [4.0, 4.0], [8.0, 4.0], 5.0);
        check([0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 5.0], 0.0);
        check([3.0, 0.0], [3.0, 0.0], [0.0, 0.0], [0.0, 9.0], 3.0);
    }
}
