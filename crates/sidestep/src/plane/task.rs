//! A task in the plane, part by part.

use std::sync::Arc;

use crate::plane::Robot;
use crate::plane::geometry::Point;
use crate::plane::world::World;

/// A task in the plane, part by part.
#[derive(Debug, Clone, Copy)]
pub struct PlaneTask<'a> {
    /// A name for reports; may be empty.
    pub name: &'a str,
    /// What the robot moves in.
    pub world: &'a Arc<World>,
    /// The body that moves.
    pub robot: Robot,
    /// Where it begins, in task units.
    pub start: Point,
    /// Where it ends.
    pub goal: Point,
}
