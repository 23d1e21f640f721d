//! The plane: worlds of shapes and grids, what is exact about them, and what a policy sees of them.

mod bit_grid;
pub mod certificate;
pub mod distance;
pub mod geometry;
pub(crate) mod sampled_check;
pub mod shortest_path;
pub mod view;
pub mod world;
