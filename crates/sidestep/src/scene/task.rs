//! A motion planning task: a robot in its surroundings, a start and a goal.

use std::sync::Arc;

use crate::arm::Arm;
use crate::error::{InvalidInput, finite, finite_point};
use crate::plane::ends::{EndChange, snapped};
use crate::plane::geometry::Point;
use crate::plane::world::World;
use crate::plane::{PlaneTask, Robot};
use crate::space;

/// Which robot moves, and among what. Shared, so that many queries on one map cost one map.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Setting {
    /// A point or disc that translates in the plane; its configuration is `[x, y]`.
    Plane {
        /// What the robot moves in.
        world: Arc<World>,
        /// The body that moves.
        robot: Robot,
    },
    /// A robot with joints; its configuration has a number for each joint that moves, in rad or m.
    Arm {
        /// The robot.
        arm: Arc<Arm>,
        /// What it moves in, in the frame of its root link.
        world: Arc<space::World>,
    },
}

impl Setting {
    /// Coordinates of a configuration.
    pub fn dof(&self) -> usize {
        match self {
            Self::Plane { .. } => 2,
            Self::Arm { arm, .. } => arm.dof(),
        }
    }

    /// Whether both share their surroundings and have equal robots, and so can share a [`Scene`](super::Scene).
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Plane { world: a, robot: p }, Self::Plane { world: b, robot: q }) => {
                Arc::ptr_eq(a, b) && p == q
            }
            (Self::Arm { world: a, arm: p }, Self::Arm { world: b, arm: q }) => {
                Arc::ptr_eq(a, b) && Arc::ptr_eq(p, q)
            }
            _ => false,
        }
    }
}

/// One planning question.
#[derive(Debug, Clone, PartialEq)]
pub struct Task {
    /// A name for reports; may be empty.
    pub name: String,
    /// The robot and its surroundings.
    pub setting: Setting,
    /// Start configuration `[dof]`, in task units.
    pub start: Vec<f64>,
    /// Goal configuration `[dof]`, in task units.
    pub goal: Vec<f64>,
}

impl Task {
    /// A task of any kind of robot.
    ///
    /// A start or goal in collision is not an error here: planning answers it with a status.
    ///
    /// # Errors
    /// If a configuration has another number of coordinates than the robot, or one is not finite.
    pub fn new(
        name: impl Into<String>,
        setting: Setting,
        start: Vec<f64>,
        goal: Vec<f64>,
    ) -> Result<Self, InvalidInput> {
        for (field, end) in [("start", &start), ("goal", &goal)] {
            if end.len() != setting.dof() {
                let allowed = format!("{}, one for each coordinate of the robot", setting.dof());
                let found = format!("{} numbers", end.len());
                return Err(InvalidInput::new(field, found, allowed));
            }
            for (k, &value) in end.iter().enumerate() {
                finite(&format!("{field}[{k}]"), value)?;
            }
        }
        Ok(Self { name: name.into(), setting, start, goal })
    }

    /// A task of a robot in the plane.
    ///
    /// # Errors
    /// If a coordinate is not finite.
    pub fn in_plane(
        name: impl Into<String>,
        world: Arc<World>,
        robot: Robot,
        start: Point,
        goal: Point,
    ) -> Result<Self, InvalidInput> {
        finite_point("start", start)?;
        finite_point("goal", goal)?;
        let setting = Setting::Plane { world, robot };
        Ok(Self { name: name.into(), setting, start: start.into(), goal: goal.into() })
    }

    /// The same question for a robot that is larger by `margin`, in task units: a plan for it keeps that far from everything.
    ///
    /// # Errors
    /// If the margin is negative or larger than the field.
    pub fn with_margin(&self, margin: f64) -> Result<Self, InvalidInput> {
        match &self.setting {
            Setting::Plane { world, robot } => {
                let most = world.bounds().extent();
                if !(0.0..=most).contains(&margin) {
                    let allowed = format!("a number from 0 to {most}, the field's extent");
                    return Err(InvalidInput::new("margin", margin, allowed));
                }
                let robot = Robot::disc(robot.radius() + margin)?;
                let setting = Setting::Plane { world: world.clone(), robot };
                Ok(Self { setting, ..self.clone() })
            }
            Setting::Arm { arm, world } => {
                let arm = Arc::new(Arm::clone(arm).with_margin(margin)?);
                let setting = Setting::Arm { arm, world: world.clone() };
                Ok(Self { setting, ..self.clone() })
            }
        }
    }

    /// The same question between ends where the robot can stand: one that is not free is moved by at most `most`, in task units, to
    /// where the robot has the margin if there is such a place, else to where it is free; and what was changed.
    ///
    /// # Errors
    /// If the robot has joints, or a number is not allowed.
    pub fn snapped(&self, margin: f64, most: f64) -> Result<(Self, Vec<EndChange>), InvalidInput> {
        let ([start, goal], changes) = snapped(&self.plane()?, margin, most)?;
        Ok((Self { start: start.to_vec(), goal: goal.to_vec(), ..self.clone() }, changes))
    }

    /// The parts of a task in the plane.
    ///
    /// # Errors
    /// If the robot is of another kind.
    pub fn plane(&self) -> Result<PlaneTask<'_>, InvalidInput> {
        let point = |end: &[f64]| Point::try_from(end).ok();
        match (&self.setting, point(&self.start), point(&self.goal)) {
            (Setting::Plane { world, robot }, Some(start), Some(goal)) => {
                Ok(PlaneTask { name: &self.name, world, robot: *robot, start, goal })
            }
            _ => Err(InvalidInput::new("task", &self.name, "a robot in the plane")),
        }
    }
}
