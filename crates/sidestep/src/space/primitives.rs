//! Signed distance and unit normal of balls, boxes, cylinders and capsules in their own frames,
//! f64.
//!
//! Outside: the Euclidean distance. Inside a convex solid: minus the distance to the nearest face,
//! which is the largest signed distance to a face's plane, so that the whole is a convex function
//! (and the true signed distance). The formulas are those of I. Quilez's list of distance
//! functions. Normals point out of the shape and are subgradients everywhere: where several faces
//! are nearest, one of them is taken (the lowest axis); at a centre without a direction, an axis.

use super::vector::{Vector, norm, scale, sub};

/// A ball: `|p| - radius`; at the centre the normal is z.
#[inline(always)]
pub(super) fn ball(p: Vector, radius: f64) -> (f64, Vector) {
    let length = norm(p);
    (length - radius, if length > 0.0 { scale(p, 1.0 / length) } else { [0.0, 0.0, 1.0] })
}

/// A box around the origin. With q = |p| - h: outside `|max(q, 0)|`, inside `max(q)`.
#[inline(always)]
pub(super) fn cuboid(p: Vector, half_extents: Vector) -> (f64, Vector) {
    let q = [0, 1, 2].map(|k| p[k].abs() - half_extents[k]);
    let outside = q.map(|v| v.max(0.0));
    let length = norm(outside);
    if length > 0.0 {
        return (length, [0, 1, 2].map(|k| (outside[k] / length).copysign(p[k])));
    }
    let nearest = (1..3).fold(0, |best, k| if q[k] > q[best] { k } else { best });
    let mut normal = [0.0; 3];
    normal[nearest] = 1.0_f64.copysign(p[nearest]);
    (q[nearest], normal)
}

/// A solid cylinder with flat ends, axis z, from -`half_length` to `half_length`: a box in (r, z).
#[inline(always)]
pub(super) fn cylinder(p: Vector, radius: f64, half_length: f64) -> (f64, Vector) {
    let r = (p[0] * p[0] + p[1] * p[1]).sqrt();
    let (side, end) = (r - radius, p[2].abs() - half_length);
    let radial = if r > 0.0 { [p[0] / r, p[1] / r] } else { [1.0, 0.0] };
    let up = 1.0_f64.copysign(p[2]);
    let (a, b) = (side.max(0.0), end.max(0.0));
    let length = (a * a + b * b).sqrt();
    let (distance, a, b) = if length > 0.0 {
        (length, a / length, b / length)
    } else if side >= end {
        (side, 1.0, 0.0)
    } else {
        (end, 0.0, 1.0)
    };
    (distance, [a * radial[0], a * radial[1], b * up])
}

/// A ball swept along z from -`half_length` to `half_length`.
#[inline(always)]
pub(super) fn capsule(p: Vector, radius: f64, half_length: f64) -> (f64, Vector) {
    let on_axis = [0.0, 0.0, p[2].clamp(-half_length, half_length)];
    let (distance, normal) = ball(sub(p, on_axis), radius);
    // On the axis itself every direction across is as near.
    if distance == -radius && half_length > 0.0 {
        (distance, [1.0, 0.0, 0.0])
    } else {
        (distance, normal)
    }
}
