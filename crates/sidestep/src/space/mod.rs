//! Worlds in space: shapes, signed distances with normals, and an index so that cost grows little
//! with what is far.
//!
//! A [`World`] is a set of named [`Object`]s, each a list of [`Shape`]s at [`Pose`]s. A shape is
//! made of convex *pieces* (a box is one, a mesh one per triangle, a height map one per cell),
//! because the signed distance to a convex piece is a convex function, which is what proofs about
//! motions rest on. Lengths are metres, angles radians.
//!
//! ```
//! use sidestep::space::{Object, Pose, Shape, World};
//!
//! let pose = Pose::at([0.5, 0.0, 0.3]).unwrap();
//! let shelf = Object::new("shelf", vec![(pose, Shape::cuboid([0.2, 0.4, 0.01]).unwrap())]);
//! let world = World::new(vec![shelf]).unwrap();
//! let mut near = Vec::new();
//! world.near([0.5, 0.0, 0.5], 0.3, &mut near);
//! let (distance, normal) = world.distance(near[0], [0.5, 0.0, 0.5]);
//! assert!((distance - 0.19).abs() < 1e-12 && normal == [0.0, 0.0, 1.0]);
//! assert_eq!(world.name_of(near[0]), "shelf");
//! ```

mod blocks;
mod bounds;
mod cover;
pub mod generate;
mod height_map;
mod hull;
mod index;
mod pose;
mod primitives;
mod quickhull;
mod shape;
#[cfg(test)]
mod tests;
mod triangle;
pub mod vector;
mod world;

pub use blocks::PointBlock;
pub(crate) use blocks::Primitive;
pub use bounds::Bounds;
pub use cover::Cover;
pub use height_map::HeightMap;
pub use hull::Hull;
pub use pose::Pose;
pub use shape::{Mesh, PointCloud, Shape};
pub use vector::Vector;
pub use world::{Distance, Object, PieceId, World};

pub use crate::kernels::LANES;
