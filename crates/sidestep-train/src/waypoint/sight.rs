//! What a policy sees with, in the plane or with joints: the one place where the two part.

use std::sync::Arc;

use sidestep::InvalidInput;
use sidestep::arm::Arm;
use sidestep::arm::view::{ArmSensor, ArmView, ArmViewShape};
use sidestep::network::{MapShape, WaypointNet};
use sidestep::objective::Objective;
use sidestep::plane::view::{Iterate, Look, TaskMap, ViewParts, WaypointView};
use sidestep::policy::ActionRule;

/// What a view is made of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Sight {
    /// Of a robot in the plane.
    Plane(ViewParts),
    /// Of a robot with joints.
    Joints(ArmViewShape, Arc<Arm>),
}

impl Sight {
    /// The sight that names in a configuration stand for; of `arm`, where the tasks are of one.
    ///
    /// # Errors
    /// If a name is unknown, or they are not those of the tasks' robot.
    pub fn from_names(names: &[String], arm: Option<Arc<Arm>>) -> Result<Self, InvalidInput> {
        let Some(arm) = arm else {
            if ArmViewShape::is_named(names) {
                let allowed = "the view of a robot in the plane, where tasks.joints is 0";
                return Err(InvalidInput::new("observation", names.join(", "), allowed));
            }
            return Ok(Self::Plane(ViewParts::from_names(names)?));
        };
        let shape = ArmViewShape::of(&arm);
        if names != shape.names() {
            let allowed = format!("{:?}, where tasks.joints is {}", shape.names(), arm.dof());
            return Err(InvalidInput::new("observation", format!("{names:?}"), allowed));
        }
        Ok(Self::Joints(shape, arm))
    }

    /// Coordinates of a configuration.
    pub fn dof(&self) -> usize {
        match self {
            Self::Plane(_) => 2,
            Self::Joints(shape, _) => shape.dof,
        }
    }

    /// Numbers of a row.
    pub fn row_len(&self) -> usize {
        match self {
            Self::Plane(parts) => parts.row_len(),
            Self::Joints(shape, _) => shape.row_len(),
        }
    }

    /// The map that the policy reads, if any.
    pub fn map(&self) -> Option<&MapShape> {
        match self {
            Self::Plane(parts) => parts.map.as_ref(),
            Self::Joints(..) => None,
        }
    }
}

/// What a trajectory carries from step to step.
#[derive(Debug, Clone)]
pub(crate) enum View {
    Plane(Box<WaypointView>),
    Joints(ArmView),
}

impl View {
    /// At the beginning of a walk; none if the question is to another kind of robot.
    pub fn new(sight: &Sight, objective: &Objective) -> Option<Self> {
        Some(match sight {
            Sight::Plane(parts) => {
                let subject = objective.plane()?;
                Self::Plane(Box::new(WaypointView::new(parts, subject, Look::default())))
            }
            Sight::Joints(..) => Self::Joints(ArmView::new(objective.arm()?)),
        })
    }

    /// Back to the beginning of a walk.
    pub fn reset(&mut self) {
        match self {
            Self::Plane(view) => view.reset(),
            Self::Joints(view) => view.reset(),
        }
    }

    /// The direction from start to goal, in the plane.
    pub fn along(&self) -> Option<[f32; 2]> {
        match self {
            Self::Plane(view) => Some(view.along()),
            Self::Joints(_) => None,
        }
    }

    /// What is added to the network's answer, of a robot with joints.
    pub fn base(&self) -> &[f32] {
        match self {
            Self::Plane(_) => &[],
            Self::Joints(view) => view.base(),
        }
    }

    /// Moves the waypoints `x [N x dof]` by the network's `outputs [N x dof]`.
    pub fn apply(
        &mut self,
        objective: &Objective,
        rule: &ActionRule,
        outputs: &[f32],
        x: &mut [f32],
    ) {
        match (self, objective.arm()) {
            (Self::Plane(view), _) => {
                view.apply(rule, |i| [outputs[2 * i], outputs[2 * i + 1]], x);
            }
            (Self::Joints(view), Some(subject)) => {
                let dof = objective.dof();
                view.apply(subject, rule, |i| &outputs[i * dof..][..dof], x);
            }
            // Views are made for their task.
            (Self::Joints(_), None) => {}
        }
    }
}

/// What is made once a task to look with.
#[derive(Debug, Clone)]
pub(crate) enum Eyes {
    Plane {
        map: Option<Box<TaskMap>>,
        /// The gradient of U at what was seen last, if policies see it; else nothing.
        gradient: Vec<f32>,
    },
    Joints(Box<ArmSensor>),
}

impl Eyes {
    /// For the trajectories of a question; none if it is to another kind of robot.
    pub fn new(sight: &Sight, objective: &Objective) -> Option<Self> {
        Some(match sight {
            Sight::Plane(parts) => {
                let subject = objective.plane()?;
                let map = parts.map.as_ref();
                let map = map.map(|shape| Box::new(TaskMap::new(parts, shape, subject)));
                let gradient = vec![0.0; if parts.gradient { objective.dim() } else { 0 }];
                Self::Plane { map, gradient }
            }
            Sight::Joints(..) => Self::Joints(Box::new(ArmSensor::new(objective.arm()?))),
        })
    }

    /// The map of the task, where the policy reads one.
    pub fn map(&mut self) -> Option<&mut TaskMap> {
        match self {
            Self::Plane { map, .. } => map.as_deref_mut(),
            Self::Joints(_) => None,
        }
    }

    /// Writes to `rows` what `view` sees at `x`, whose segments are `free`.
    pub fn see(
        &mut self,
        objective: &mut Objective,
        view: &mut View,
        (x, free): (&[f32], &[bool]),
        rows: &mut [f32],
        stride: usize,
    ) {
        match (self, view) {
            (Self::Plane { map, gradient }, View::Plane(view)) => {
                if !gradient.is_empty() {
                    objective.cost_and_gradient(x, gradient);
                }
                if let Some(subject) = objective.plane() {
                    let seen = Iterate { x, free, gradient };
                    view.encode(subject, seen, map.as_deref(), rows, stride);
                }
            }
            (Self::Joints(sensor), View::Joints(view)) => {
                if let Some(subject) = objective.arm() {
                    view.encode(subject, sensor, (x, free), rows, stride);
                }
            }
            // Both are made for the task.
            _ => {}
        }
    }

    /// Reads the map with the network as it is now.
    pub fn read_map(&mut self, net: &WaypointNet) {
        if let Some(map) = self.map() {
            net.read_map(map.scratch());
        }
    }
}
