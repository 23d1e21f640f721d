//! Robots with joints: kinematics of blocks of configurations, and proofs that motions are free.
//!
//! A [`Model`] is a robot as its file describes it (links, joints, shapes). An [`Arm`] is the same
//! robot compiled: some joints move, all others are held; what moves is a flat program of slots
//! (`chain.rs`) that the kernels evaluate for many configurations at once (`kinematics.rs`), and the body
//! is balls (`spheres.rs`). A configuration is a slice with a number for each moving joint, in rad
//! or m, in the order of [`Arm::joints`].

mod cells;
pub mod certificate;
mod chain;
mod contacts;
mod corners;
mod costs;
mod covered;
mod explain;
mod inverse_kinematics;
mod kinematics;
mod lanes;
mod model;
mod reach;
mod robot;
mod scene;
mod sincos;
mod spheres;
mod surroundings;
pub mod view;

pub(crate) use cells::MOST_JOINTS;
pub use covered::MeshHull;
pub use explain::{explain, explain_ends};
pub use inverse_kinematics::Tool;
pub use model::{Body, BodyShape, Joint, JointKind, Limits, Link, MAX_LINKS, Mimic, Model};
pub use robot::{Arm, ArmJoint, LIMIT_TOLERANCE, MAX_DOF};
pub use scene::ArmScene;
pub use spheres::Ball;

#[cfg(test)]
mod scene_tests;
#[cfg(test)]
mod tests;
