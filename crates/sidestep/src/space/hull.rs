//! A convex polyhedron by its faces.
//!
//! Inside, the signed distance is the largest of the faces' planes (negative); outside, the
//! distance to the nearest of the faces that the point is in front of. Both together are a convex
//! function.

use std::collections::HashSet;

use super::bounds::Bounds;
use super::pose::finite_vector;
use super::triangle::{Triangle, Triangle32};
use super::vector::{Vector, dot, norm, sub};
use crate::error::InvalidInput;

/// How far a corner may lie in front of a face's plane, as a share of the hull's extent: rounding,
/// no more.
const FLATNESS: f64 = 1e-6;

/// Errors of a height over a face, as a share of the lengths that go into it; some ten roundings.
const ROUNDING: f64 = 1e-14;

/// A convex solid bounded by triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    vertices: Vec<Vector>,
    faces: Vec<[u32; 3]>,
    /// The faces that are not too thin, ready for distances.
    triangles: Vec<Triangle>,
    /// The same in f32.
    narrow: Vec<Triangle32>,
    /// Distance of the farthest corner from the origin.
    radius: f64,
}

impl Hull {
    /// From corners in metres and faces, each a list of three or more corners, counter-clockwise
    /// seen from outside.
    ///
    /// # Errors
    /// If a coordinate is not finite, a face names no corner, the faces do not close, or a corner
    /// lies in front of a face.
    pub fn new(vertices: Vec<Vector>, faces: &[Vec<u32>]) -> Result<Self, InvalidInput> {
        for (i, &vertex) in vertices.iter().enumerate() {
            finite_vector(&format!("vertices[{i}]"), vertex)?;
        }
        let mut triangles = Vec::new();
        for (i, face) in faces.iter().enumerate() {
            if face.len() < 3 {
                let found = format!("{} corners", face.len());
                return Err(InvalidInput::new(format!("faces[{i}]"), found, "at least 3"));
            }
            if let Some(&corner) = face.iter().find(|&&corner| corner as usize >= vertices.len()) {
                let allowed = format!("a corner from 0 to {}", vertices.len() as i64 - 1);
                return Err(InvalidInput::new(format!("faces[{i}]"), corner, allowed));
            }
            triangles.extend(face.windows(2).skip(1).map(|pair| [face[0], pair[0], pair[1]]));
        }
        let hull = Self::from_triangles(vertices, triangles);
        hull.check_closed()?;
        hull.check_convex()?;
        Ok(hull)
    }

    /// From triangles that are known to bound a convex solid, but for rounding.
    pub(super) fn from_triangles(vertices: Vec<Vector>, faces: Vec<[u32; 3]>) -> Self {
        let triangles: Vec<Triangle> = faces
            .iter()
            .map(|face| Triangle::new(face.map(|corner| vertices[corner as usize])))
            .filter(|triangle| !triangle.is_thin())
            .collect();
        let radius = vertices.iter().map(|&vertex| norm(vertex)).fold(0.0, f64::max);
        let narrow = triangles.iter().map(Triangle32::new).collect();
        Self { vertices, faces, triangles, narrow, radius }
    }

    /// Each side of a face is a side of exactly one other, the other way round.
    fn check_closed(&self) -> Result<(), InvalidInput> {
        let sides = || self.faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        let mut directed = HashSet::new();
        let doubled = sides().find(|&side| !directed.insert(side));
        let open = sides().find(|&(a, b)| !directed.contains(&(b, a)));
        match doubled.or(open) {
            None => Ok(()),
            Some((a, b)) => {
                let found = format!("a side from corner {a} to {b} without its partner");
                let allowed = "faces that close, counter-clockwise seen from outside";
                Err(InvalidInput::new("faces", found, allowed))
            }
        }
    }

    fn check_convex(&self) -> Result<(), InvalidInput> {
        let bounds = self.bounds();
        let extent = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f64::max);
        let mut deepest = 0.0_f64;
        for triangle in &self.triangles {
            for (i, &vertex) in self.vertices.iter().enumerate() {
                let height = dot(triangle.normal, sub(vertex, triangle.corners[0]));
                if height > FLATNESS * extent {
                    let found = format!("{height} in front of a face");
                    let allowed = "a corner of a convex solid; ask for the hull of others";
                    return Err(InvalidInput::new(format!("vertices[{i}]"), found, allowed));
                }
                deepest = deepest.max(-height);
            }
        }
        if deepest <= FLATNESS * extent {
            return Err(InvalidInput::new("faces", "a flat solid", "faces around a volume"));
        }
        Ok(())
    }

    /// The corners, in metres.
    pub fn vertices(&self) -> &[Vector] {
        &self.vertices
    }

    /// The faces as triangles of corners, counter-clockwise seen from outside.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    pub(super) fn narrow(&self) -> &[Triangle32] {
        &self.narrow
    }

    pub(super) fn radius(&self) -> f64 {
        self.radius
    }

    pub(super) fn triangles(&self) -> &[Triangle] {
        &self.triangles
    }

    /// The smallest box around it.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(self.vertices.iter().copied())
    }

    /// Signed distance and unit normal at `p`, negative inside.
    pub fn distance(&self, p: Vector) -> (f64, Vector) {
        // A face that p is in front of but for rounding counts: of two faces in a plane, p may seem to
        // be behind the one that it is nearest to.
        let behind = -ROUNDING * (norm(p) + self.radius);
        let mut plane = (f64::NEG_INFINITY, [0.0, 0.0, 1.0]);
        let mut face = (f64::INFINITY, [0.0, 0.0, 1.0]);
        for triangle in &self.triangles {
            let height = dot(triangle.normal, sub(p, triangle.corners[0]));
            if height > plane.0 {
                plane = (height, triangle.normal);
            }
            if height > behind && height < face.0 {
                let there = triangle.distance(p);
                if there.0 < face.0 {
                    face = there;
                }
            }
        }
        if plane.0 > 0.0 { face } else { plane }
    }
}
