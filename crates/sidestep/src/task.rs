//! A motion planning task: a world, a robot, a start and a goal.

use std::sync::Arc;

use crate::error::{InvalidInput, finite_point};
use crate::plane::geometry::Point;
use crate::plane::world::World;
use crate::robot::Robot;

/// One planning question. The world is shared, so that many queries on one map cost one map.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// A name for reports; may be empty.
    pub name: String,
    /// What the robot moves in.
    pub world: Arc<World>,
    /// The body that moves.
    pub robot: Robot,
    /// Start configuration, in task units.
    pub start: Point,
    /// Goal configuration, in task units.
    pub goal: Point,
}

impl Task {
    /// A task from its parts.
    ///
    /// A start or goal in collision is not an error here: planning answers it with a status.
    ///
    /// # Errors
    /// If a coordinate is not finite.
    pub fn new(
        name: impl Into<String>,
        world: Arc<World>,
        robot: Robot,
        start: Point,
        goal: Point,
    ) -> Result<Self, InvalidInput> {
        finite_point("start", start)?;
        finite_point("goal", goal)?;
        Ok(Self { name: name.into(), world, robot, start, goal })
    }
}
