//! Why a trajectory is not certified.

/// An obstacle of a world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum ObstacleId {
    /// The shape at this index of the world's obstacles.
    Shape(usize),
    /// An occupied cell of the world's grid.
    Cell {
        /// Column, from the left.
        column: usize,
        /// Row, from the bottom.
        row: usize,
    },
    /// An object of a world in space, met by a link of a robot with joints.
    Object {
        /// The link's number in the robot's model.
        link: usize,
        /// The object's index in the world.
        object: usize,
    },
    /// Another link of the same robot.
    Link {
        /// The link's number in the robot's model.
        link: usize,
        /// The other's.
        other: usize,
    },
}

impl std::fmt::Display for ObstacleId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Shape(index) => write!(f, "obstacle {index}"),
            Self::Cell { column, row } => write!(f, "the grid cell in column {column}, row {row}"),
            Self::Object { link, object } => write!(f, "object {object} (link {link})"),
            Self::Link { link, other } => write!(f, "itself (links {link} and {other})"),
        }
    }
}

/// The first reason found why a trajectory is not certified.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Violation {
    /// There is no point at all.
    #[error("the trajectory is empty")]
    EmptyTrajectory,
    /// A coordinate is infinite or not a number.
    #[error("point {point} of the trajectory is not finite")]
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// The first point is not the task's start.
    #[error("the trajectory does not begin at the task's start")]
    WrongStart,
    /// The last point is not the task's goal.
    #[error("the trajectory does not end at the task's goal")]
    WrongGoal,
    /// The robot's body leaves the bounds at the start.
    #[error("the start is out of bounds")]
    StartOutOfBounds,
    /// The robot's body leaves the bounds at the goal.
    #[error("the goal is out of bounds")]
    GoalOutOfBounds,
    /// The robot's body touches an obstacle at the start.
    #[error("the start is in collision with {obstacle}")]
    StartInCollision {
        /// What is touched.
        obstacle: ObstacleId,
    },
    /// The robot's body touches an obstacle at the goal.
    #[error("the goal is in collision with {obstacle}")]
    GoalInCollision {
        /// What is touched.
        obstacle: ObstacleId,
    },
    /// The robot's body leaves the bounds in between.
    #[error("the trajectory leaves the bounds at point {point}, on segment {segment}")]
    OutOfBounds {
        /// Index of the segment that ends in the point.
        segment: usize,
        /// Index of the point.
        point: usize,
    },
    /// The swept body touches an obstacle.
    #[error("segment {segment} of the trajectory collides with {obstacle}")]
    Collision {
        /// Index of the segment.
        segment: usize,
        /// What is touched.
        obstacle: ObstacleId,
    },
    /// A joint leaves its limits.
    #[error("coordinate {coordinate} of point {point} of the trajectory is outside its limits")]
    OutOfLimits {
        /// Index of the point.
        point: usize,
        /// Index of the coordinate.
        coordinate: usize,
    },
    /// Neither free nor in collision as far as the certificate can tell: all but touching.
    #[error("segment {segment} of the trajectory all but touches something")]
    Undecided {
        /// Index of the segment.
        segment: usize,
    },
}
