//! The shapes that a world is made of, each in its own frame.

use std::sync::Arc;

use super::bounds::Bounds;
use super::height_map::HeightMap;
use super::hull::Hull;
use super::pose::finite_vector;
use super::primitives;
use super::triangle::Triangle;
use super::vector::{Vector, sub};
use crate::error::{InvalidInput, MAX_COORDINATE, finite};

/// A shape around its own origin, in metres. Its constructors check; [`super::World::new`] checks
/// again.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A ball.
    Sphere {
        /// Radius, above 0.
        radius: f64,
    },
    /// A box with the axes of its frame.
    Box {
        /// Half its size on each axis, above 0.
        half_extents: Vector,
    },
    /// A solid cylinder about z with flat ends.
    Cylinder {
        /// Radius, above 0.
        radius: f64,
        /// Half its length, above 0.
        half_length: f64,
    },
    /// A ball swept along z.
    Capsule {
        /// Radius, above 0.
        radius: f64,
        /// Half the length of the way that the ball's centre takes, at least 0.
        half_length: f64,
    },
    /// A convex polyhedron.
    Hull(Arc<Hull>),
    /// A surface of triangles. It has no inside: what it encloses is free.
    Mesh(Arc<Mesh>),
    /// Columns on a grid.
    HeightMap(Arc<HeightMap>),
    /// Points with a radius.
    Points(Arc<PointCloud>),
}

/// Triangles between corners, in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    vertices: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
}

/// Points, each the centre of a ball of one radius, in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct PointCloud {
    points: Vec<Vector>,
    radius: f64,
}

impl Mesh {
    /// From corners in metres and triangles of them.
    ///
    /// # Errors
    /// If a coordinate is not finite, there is no triangle, or one names a corner that there is
    /// not.
    pub fn new(vertices: Vec<Vector>, triangles: Vec<[u32; 3]>) -> Result<Self, InvalidInput> {
        for (i, &vertex) in vertices.iter().enumerate() {
            finite_vector(&format!("vertices[{i}]"), vertex)?;
        }
        if triangles.is_empty() {
            return Err(InvalidInput::new("triangles", "none", "at least one"));
        }
        for (i, triangle) in triangles.iter().enumerate() {
            if let Some(&corner) = triangle.iter().find(|&&c| c as usize >= vertices.len()) {
                let allowed = format!("a corner below {}", vertices.len());
                return Err(InvalidInput::new(format!("triangles[{i}]"), corner, allowed));
            }
        }
        Ok(Self { vertices, triangles })
    }

    /// The corners.
    pub fn vertices(&self) -> &[Vector] {
        &self.vertices
    }

    /// The triangles, each three corners.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The corners of triangle `i`.
    pub fn corners(&self, i: usize) -> [Vector; 3] {
        self.triangles[i].map(|corner| self.vertices[corner as usize])
    }
}

impl PointCloud {
    /// From points and the radius of the ball around each, both in metres.
    ///
    /// # Errors
    /// If a number is not finite, the radius is negative, or there is no point.
    pub fn new(points: Vec<Vector>, radius: f64) -> Result<Self, InvalidInput> {
        for (i, &point) in points.iter().enumerate() {
            finite_vector(&format!("points[{i}]"), point)?;
        }
        if points.is_empty() {
            return Err(InvalidInput::new("points", "none", "at least one"));
        }
        at_least_zero("radius", radius)?;
        Ok(Self { points, radius })
    }

    /// The points.
    pub fn points(&self) -> &[Vector] {
        &self.points
    }

    /// The radius of the ball around each.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl Shape {
    /// A ball of this radius.
    ///
    /// # Errors
    /// If the radius is not a number above 0.
    pub fn sphere(radius: f64) -> Result<Self, InvalidInput> {
        Self::Sphere { radius }.checked()
    }

    /// A box of twice these extents.
    ///
    /// # Errors
    /// If an extent is not a number above 0.
    pub fn cuboid(half_extents: Vector) -> Result<Self, InvalidInput> {
        Self::Box { half_extents }.checked()
    }

    /// A flat-ended cylinder about z from -`length` / 2 to `length` / 2.
    ///
    /// # Errors
    /// If a number is not above 0.
    pub fn cylinder(radius: f64, length: f64) -> Result<Self, InvalidInput> {
        Self::Cylinder { radius, half_length: 0.5 * length }.checked()
    }

    /// A ball swept along z from -`length` / 2 to `length` / 2, so that it is `length + 2 radius`
    /// long.
    ///
    /// # Errors
    /// If the radius is not above 0 or the length below 0.
    pub fn capsule(radius: f64, length: f64) -> Result<Self, InvalidInput> {
        Self::Capsule { radius, half_length: 0.5 * length }.checked()
    }

    /// The shape, if its numbers are allowed.
    pub(super) fn checked(self) -> Result<Self, InvalidInput> {
        match self {
            Self::Sphere { radius } => above_zero("radius", radius)?,
            Self::Box { half_extents } => {
                for k in 0..3 {
                    above_zero(&format!("half_extents[{k}]"), half_extents[k])?;
                }
            }
            Self::Cylinder { radius, half_length } => {
                above_zero("radius", radius)?;
                above_zero("length", 2.0 * half_length)?;
            }
            Self::Capsule { radius, half_length } => {
                above_zero("radius", radius)?;
                at_least_zero("length", 2.0 * half_length)?;
            }
            Self::Hull(_) | Self::Mesh(_) | Self::HeightMap(_) | Self::Points(_) => {}
        }
        Ok(self)
    }

    /// What kind of shape it is, in a word.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Box { .. } => "box",
            Self::Cylinder { .. } => "cylinder",
            Self::Capsule { .. } => "capsule",
            Self::Hull(_) => "hull",
            Self::Mesh(_) => "mesh",
            Self::HeightMap(_) => "height_map",
            Self::Points(_) => "points",
        }
    }

    /// Number of convex pieces.
    pub fn pieces(&self) -> usize {
        match self {
            Self::Mesh(mesh) => mesh.triangles.len(),
            Self::HeightMap(map) => map.cells(),
            Self::Points(cloud) => cloud.points.len(),
            _ => 1,
        }
    }

    /// Signed distance and unit normal of piece `i` (below [`Self::pieces`]) at `p`, both in the
    /// shape's frame.
    ///
    /// Exact but for rounding; negative inside; 1-Lipschitz and convex in `p`. The normal is the
    /// gradient where there is one, else a subgradient. A height map's empty cells are infinitely
    /// far.
    #[inline]
    pub fn distance(&self, i: usize, p: Vector) -> (f64, Vector) {
        match self {
            Self::Sphere { radius } => primitives::ball(p, *radius),
            Self::Box { half_extents } => primitives::cuboid(p, *half_extents),
            Self::Cylinder { radius, half_length } => {
                primitives::cylinder(p, *radius, *half_length)
            }
            Self::Capsule { radius, half_length } => primitives::capsule(p, *radius, *half_length),
            Self::Hull(hull) => hull.distance(p),
            Self::Mesh(mesh) => Triangle::new(mesh.corners(i)).distance(p),
            Self::HeightMap(map) => map.distance(i, p),
            Self::Points(cloud) => primitives::ball(sub(p, cloud.points[i]), cloud.radius),
        }
    }

    /// The box around piece `i` in the shape's frame; nothing for an empty cell of a height map.
    pub fn piece_bounds(&self, i: usize) -> Option<Bounds> {
        let symmetric = |half: Vector| Some(Bounds { min: half.map(|v| -v), max: half });
        match self {
            Self::Sphere { radius } => symmetric([*radius; 3]),
            Self::Box { half_extents } => symmetric(*half_extents),
            Self::Cylinder { radius, half_length } => symmetric([*radius, *radius, *half_length]),
            Self::Capsule { radius, half_length } => {
                symmetric([*radius, *radius, half_length + radius])
            }
            Self::Hull(hull) => Some(hull.bounds()),
            Self::Mesh(mesh) => Some(Bounds::around(mesh.corners(i))),
            Self::HeightMap(map) => map.cell(i),
            Self::Points(cloud) => Some(Bounds::around([cloud.points[i]]).grown(cloud.radius)),
        }
    }
}

fn above_zero(field: &str, value: f64) -> Result<(), InvalidInput> {
    if value > 0.0 && value <= MAX_COORDINATE {
        Ok(())
    } else {
        Err(InvalidInput::new(field, value, "a number above 0, at most 1e9"))
    }
}

fn at_least_zero(field: &str, value: f64) -> Result<(), InvalidInput> {
    finite(field, value)?;
    if value < 0.0 {
        return Err(InvalidInput::new(field, value, "a number of at least 0"));
    }
    Ok(())
}
