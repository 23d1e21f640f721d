//! Robots with joints: URDF and SRDF from text.
//!
//! [`read_urdf`] makes a [`Model`](sidestep::arm::Model) of a robot's description, [`read_srdf`] an
//! [`Srdf`] of what people say about it: groups of joints, named configurations, pairs of links that may touch.
//! [`prepare`] makes a robot that can plan of them, and [`RobotFile`] keeps it as our own JSON.
//! Nothing is looked up on the machine: a mesh stays the name that the file gives it.

mod prepare;
mod robot_json;
mod srdf;
mod urdf;
mod xml;

pub use prepare::{DEFAULT_OVERHANG, LoadHull, Moving, Preparation, Prepared, prepare};
pub use robot_json::{ROBOT_FORMAT, RobotFile, is_robot, read_robot};
pub use srdf::{EndEffector, Group, GroupPart, GroupState, Srdf, VirtualJoint, read_srdf};
pub use urdf::read_urdf;
