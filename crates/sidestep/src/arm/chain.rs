//! From a tree of links and joints to a flat program: one slot for each joint that moves.
//!
//! A slot's frame has its joint's axis as z, so that a slot is evaluated as
//! `frame = parent frame * constant * Rz(q)` (or `* translation (0, 0, q)`) whatever the axis was;
//! fixed joints, and joints that are held, disappear into the constants. Slot 0 is the base: the
//! root link's frame, which does not move. A joint that mimics another is a slot of its own that
//! reads the same coordinate: `q = multiplier * coordinate + offset`.

use super::model::{Joint, JointKind, Model};
use crate::error::InvalidInput;
use crate::space::Pose;
use crate::space::vector::Vector;

/// A moving joint, compiled.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Slot {
    /// The slot below; less than this slot's own number.
    pub(super) parent: usize,
    /// The frame at 0 in the parent's.
    pub(super) constant: Pose,
    /// Moves along z instead of about it.
    pub(super) prismatic: bool,
    /// Which number of a configuration it reads.
    pub(super) coordinate: usize,
    /// Factor of that number.
    pub(super) multiplier: f64,
    /// Summand, rad or m.
    pub(super) offset: f64,
}

impl Slot {
    /// The frame in the parent's for a coordinate.
    pub(super) fn place(&self, coordinate: f64) -> Pose {
        let q = self.multiplier * coordinate + self.offset;
        self.constant.compose(&motion(self.prismatic, q))
    }
}

/// The chain of a robot: its slots, and where each link of the model stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Chain {
    /// Slots 1, 2, ..: `slots[k]` is slot `k + 1`. Parents come first.
    pub(super) slots: Vec<Slot>,
    /// For each link of the model its slot and its frame in that slot's.
    pub(super) links: Vec<(usize, Pose)>,
}

/// What drives a joint.
#[derive(Debug, Clone, Copy)]
enum Drive {
    /// `multiplier * coordinate + offset`.
    Coordinate { coordinate: usize, multiplier: f64, offset: f64 },
    /// Held at a value.
    Held(f64),
}

impl Chain {
    /// Compiles a model whose joints `moving` (indices, in the order of a configuration's numbers) move;
    /// all others are held at `held[joint]`, or follow the joint that they mimic.
    ///
    /// # Errors
    /// If a moving joint is fixed or mimics another.
    pub(super) fn new(model: &Model, moving: &[usize], held: &[f64]) -> Result<Self, InvalidInput> {
        let drives = drives(model.joints(), moving, held)?;
        let mut children = vec![Vec::new(); model.links().len()];
        for (index, joint) in model.joints().iter().enumerate() {
            children[joint.parent].push(index);
        }
        let mut slots = Vec::new();
        let mut links = vec![(0, Pose::IDENTITY); model.links().len()];
        let mut open = vec![model.root()];
        while let Some(link) = open.pop() {
            let (slot, place) = links[link];
            for &index in &children[link] {
                let joint = &model.joints()[index];
                let origin = place.compose(&joint.origin);
                links[joint.child] = match (joint.kind, drives[index]) {
                    (JointKind::Fixed, _) => (slot, origin),
                    (kind, drive) => {
                        let turned = z_to(joint.axis)?;
                        let constant = origin.compose(&turned);
                        let prismatic = kind == JointKind::Prismatic;
                        match drive {
                            Drive::Held(value) => {
                                let moved = constant.compose(&motion(prismatic, value));
                                (slot, moved.compose(&turned.inverse()))
                            }
                            Drive::Coordinate { coordinate, multiplier, offset } => {
                                slots.push(Slot {
                                    parent: slot,
                                    constant,
                                    prismatic,
                                    coordinate,
                                    multiplier,
                                    offset,
                                });
                                (slots.len(), turned.inverse())
                            }
                        }
                    }
                };
                open.push(joint.child);
            }
        }
        Ok(Self { slots, links })
    }

    /// The frames of all slots at a configuration, the base's first; the slow twin of the kernel.
    pub(super) fn frames(&self, configuration: &[f64]) -> Vec<Pose> {
        let mut frames = Vec::with_capacity(self.slots.len() + 1);
        frames.push(Pose::IDENTITY);
        for slot in &self.slots {
            let frame = frames[slot.parent].compose(&slot.place(configuration[slot.coordinate]));
            frames.push(frame);
        }
        frames
    }
}

/// The motion of a joint along or about z.
fn motion(prismatic: bool, q: f64) -> Pose {
    let placed =
        if prismatic { Pose::at([0.0, 0.0, q]) } else { Pose::from_rpy([0.0, 0.0, q], [0.0; 3]) };
    // Configurations are checked before they come here; one that is not finite stays where it was.
    placed.unwrap_or(Pose::IDENTITY)
}

/// The shortest rotation that takes z to a unit axis: `I + [v] + [v]^2 / (1 + c)` with v = z x axis, c = z . axis;
/// for the opposite of z, half a turn about x.
fn z_to(axis: Vector) -> Result<Pose, InvalidInput> {
    let [x, y, z] = axis;
    if z < -0.999_999 {
        return Pose::from_rotation(
            [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            [0.0; 3],
        )
        .map(|half_turn| half_turn.compose(&nudge([x, -y, -z])));
    }
    Ok(nudge([x, y, z]))
}

/// [`z_to`] for an axis that is not opposite to z.
fn nudge([x, y, z]: Vector) -> Pose {
    let k = 1.0 / (1.0 + z);
    let rotation =
        [[1.0 - k * x * x, -k * x * y, x], [-k * x * y, 1.0 - k * y * y, y], [-x, -y, z]];
    Pose::from_rotation(rotation, [0.0; 3]).unwrap_or(Pose::IDENTITY)
}

/// What drives each joint; mimics are followed to the joint that moves by itself.
fn drives(joints: &[Joint], moving: &[usize], held: &[f64]) -> Result<Vec<Drive>, InvalidInput> {
    let mut drives: Vec<Drive> = held.iter().map(|&value| Drive::Held(value)).collect();
    for (coordinate, &index) in moving.iter().enumerate() {
        let joint = &joints[index];
        let refuse = |found: &str| {
            Err(InvalidInput::new(
                format!("joints[{coordinate}]"),
                format!("{:?}, which {found}", joint.name),
                "a joint that moves by itself",
            ))
        };
        if joint.kind == JointKind::Fixed {
            return refuse("is fixed");
        }
        if let Some(mimic) = joint.mimic {
            return refuse(&format!("mimics {:?}", joints[mimic.joint].name));
        }
        if matches!(drives[index], Drive::Coordinate { .. }) {
            return refuse("is named twice");
        }
        drives[index] = Drive::Coordinate { coordinate, multiplier: 1.0, offset: 0.0 };
    }
    for index in 0..joints.len() {
        let (mut at, mut factor, mut summand) = (index, 1.0, 0.0);
        while let Some(mimic) = joints[at].mimic {
            summand += factor * mimic.offset;
            factor *= mimic.multiplier;
            at = mimic.joint;
        }
        if at != index {
            drives[index] = match drives[at] {
                Drive::Held(value) => Drive::Held(factor * value + summand),
                Drive::Coordinate { coordinate, multiplier, offset } => Drive::Coordinate {
                    coordinate,
                    multiplier: factor * multiplier,
                    offset: factor * offset + summand,
                },
            };
        }
    }
    Ok(drives)
}
