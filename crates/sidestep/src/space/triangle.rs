//! Distance from a point to a triangle, f64.
//!
//! With unit normal n and unit outward edge normals m_i in the triangle's plane: a point whose
//! projection lies behind all three edges is `|n (p - a)|` away, any other as far as the nearest
//! edge (C. Ericson, "Real-Time Collision Detection", 5.1, in the form of planes, whose errors
//! shift the result by no more than themselves, however thin the triangle is).

use super::vector::{Vector, cross, dot, norm, scale, sub, unit};

/// Triangles lower than this share of their longest side are treated as their sides alone.
const THINNEST: f64 = 1e-9;

/// A triangle with what its distance needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Triangle {
    pub(super) corners: [Vector; 3],
    /// Unit normal, right-handed about the corners; zero if the triangle is too thin to have one.
    pub(super) normal: Vector,
    /// Edge i goes from corner i to corner i + 1.
    pub(super) edges: [Edge; 3],
}

/// A side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    /// From its corner to the next, not normalised.
    pub(super) along: Vector,
    /// `1 / |along|^2`, or zero if the corners are one point.
    pub(super) inverse_square: f64,
    /// Unit vector in the triangle's plane, away from the triangle; zero if there is no plane.
    pub(super) outward: Vector,
}

impl Triangle {
    /// From its corners, in either order round.
    pub(super) fn new(corners: [Vector; 3]) -> Self {
        let along = [0, 1, 2].map(|i| sub(corners[(i + 1) % 3], corners[i]));
        let lengths = along.map(norm);
        let side = (1..3).fold(0, |a, b| if lengths[b] > lengths[a] { b } else { a });
        let longest = lengths[side];
        // Twice the area; its height over the longest side is area / longest.
        let area = cross(along[0], along[1]);
        let thin = norm(area) <= THINNEST * longest * longest;
        // Of a needle the product is off by rounding over its height; along its longest side that would count.
        let upright = |normal: Vector| {
            let axis = scale(along[side], 1.0 / longest);
            unit(sub(normal, scale(axis, dot(axis, normal))))
        };
        let normal = unit(area).filter(|_| !thin).and_then(upright).unwrap_or([0.0; 3]);
        let edges = along.map(|along| {
            let square = dot(along, along);
            Edge {
                along,
                inverse_square: if square >= f64::MIN_POSITIVE { 1.0 / square } else { 0.0 },
                outward: unit(cross(along, normal)).unwrap_or([0.0; 3]),
            }
        });
        Self { corners, normal, edges }
    }

    /// Whether it is so thin that it has no normal.
    pub(super) fn is_thin(&self) -> bool {
        self.normal == [0.0; 3]
    }

    /// Distance and unit direction from the nearest point of the triangle to `p`; on the triangle,
    /// its normal.
    pub(super) fn distance(&self, p: Vector) -> (f64, Vector) {
        let from = self.corners.map(|corner| sub(p, corner));
        if !self.is_thin() && (0..3).all(|i| dot(self.edges[i].outward, from[i]) <= 0.0) {
            let height = dot(self.normal, from[0]);
            return (height.abs(), scale(self.normal, 1.0_f64.copysign(height)));
        }
        let mut nearest = (f64::INFINITY, [0.0; 3], None);
        for (edge, from) in self.edges.iter().zip(from) {
            let t = (dot(edge.along, from) * edge.inverse_square).clamp(0.0, 1.0);
            let across = sub(from, scale(edge.along, t));
            let square = dot(across, across);
            if square < nearest.0 {
                nearest = (square, across, (0.0 < t && t < 1.0).then_some(edge));
            }
        }
        let (square, mut across, beside) = nearest;
        let distance = square.sqrt();
        // Of a point near a side the difference is off along it by rounding of the far longer ones that it is made of.
        if let Some(Edge { along, inverse_square, .. }) = beside {
            across = sub(across, scale(*along, dot(*along, across) * inverse_square));
        }
        match unit(across) {
            Some(direction) => (distance, direction),
            None if self.is_thin() => (distance, [0.0, 0.0, 1.0]),
            None => (distance, self.normal),
        }
    }
}

/// A triangle in f32, in its shape's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Triangle32 {
    pub(super) corners: [[f32; 3]; 3],
    pub(super) normal: [f32; 3],
    pub(super) along: [[f32; 3]; 3],
    pub(super) inverse_square: [f32; 3],
    pub(super) outward: [[f32; 3]; 3],
    /// Infinite for a triangle without a normal, else zero.
    pub(super) never_above: f32,
}

impl Triangle32 {
    pub(super) fn new(triangle: &Triangle) -> Self {
        Self {
            corners: triangle.corners.map(narrow),
            normal: narrow(if triangle.is_thin() { [0.0, 0.0, 1.0] } else { triangle.normal }),
            along: triangle.edges.map(|edge| narrow(edge.along)),
            // Sides shorter than 1e-19 m count as points: their square is no f32.
            inverse_square: triangle.edges.map(|edge| {
                let narrow = edge.inverse_square as f32;
                if narrow.is_finite() { narrow } else { 0.0 }
            }),
            outward: triangle.edges.map(|edge| narrow(edge.outward)),
            never_above: if triangle.is_thin() { f32::INFINITY } else { 0.0 },
        }
    }
}

pub(super) fn narrow(v: Vector) -> [f32; 3] {
    v.map(|v| v as f32)
}
