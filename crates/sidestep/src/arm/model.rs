//! A robot as its file describes it: links joined by joints into one tree.
//!
//! A link is a rigid body with a frame and shapes around which it must not collide. A joint places
//! the frame of its child in that of its parent: `parent_from_child = origin * motion(q)`, where the
//! motion is a rotation about the axis by q rad or a translation along it by q m, as in URDF
//! (<https://wiki.ros.org/urdf/XML/joint>). Nothing here is fast: [`Arm`](super::Arm) is.

use std::collections::HashMap;

use crate::error::{InvalidInput, finite};
use crate::space::Pose;
use crate::space::vector::{Vector, dot, unit};

/// A tree of links. Made by [`Model::new`], which checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    name: String,
    links: Vec<Link>,
    joints: Vec<Joint>,
    root: usize,
    /// For each link the joint above it; none for the root.
    above: Vec<Option<usize>>,
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Link {
    /// Its name, unlike any other link's.
    pub name: String,
    /// The shapes that stand for it in collision checks; none if it has no extent.
    pub bodies: Vec<Body>,
}

/// A shape at a place in its link's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Where the shape's own frame stands in the link's.
    pub origin: Pose,
    /// The shape.
    pub shape: BodyShape,
}

/// What a body looks like, in metres, in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub enum BodyShape {
    /// A ball around the origin.
    Sphere {
        /// Above 0.
        radius: f64,
    },
    /// A box around the origin.
    Box {
        /// Half of each side, above 0.
        half_extents: Vector,
    },
    /// A solid cylinder with flat ends around z.
    Cylinder {
        /// Above 0.
        radius: f64,
        /// From end to end, above 0.
        length: f64,
    },
    /// A cylinder around z with a half ball on each end.
    Capsule {
        /// Above 0.
        radius: f64,
        /// Of the cylinder, without the half balls; at least 0.
        length: f64,
    },
    /// Triangles in another file.
    Mesh {
        /// The file as it is named, such as `package://panda/meshes/hand.stl`.
        file: String,
        /// Factors of the coordinates.
        scale: Vector,
    },
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Not at all.
    Fixed,
    /// About its axis, between limits; rad.
    Revolute,
    /// About its axis, round and round; rad.
    Continuous,
    /// Along its axis, between limits; m.
    Prismatic,
}

/// A joint between two links.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Its name, unlike any other joint's.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Index of the link that carries it.
    pub parent: usize,
    /// Index of the link that it carries.
    pub child: usize,
    /// Where the child's frame stands in the parent's while the joint is at 0.
    pub origin: Pose,
    /// The axis in the joint's frame; any length but 0, normalised by [`Model::new`].
    pub axis: Vector,
    /// Limits; must be there for revolute and prismatic joints.
    pub limits: Option<Limits>,
    /// The joint that this one follows, if any.
    pub mimic: Option<Mimic>,
}

/// What a joint can do; rad or m, seconds, N or N m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Least position, and [`Self::upper`] the largest; ignored for continuous joints.
    pub lower: f64,
    /// At least [`Self::lower`].
    pub upper: f64,
    /// Largest speed, if one is given.
    pub velocity: Option<f64>,
    /// Largest force or torque, if one is given.
    pub effort: Option<f64>,
}

/// `q = multiplier * q[joint] + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mimic {
    /// Index of the joint that is followed.
    pub joint: usize,
    /// Factor.
    pub multiplier: f64,
    /// Summand, in this joint's unit.
    pub offset: f64,
}

/// Most links of a robot: a humanoid with hands has 100.
pub const MAX_LINKS: usize = 10_000;

impl Model {
    /// Checks that the links form one tree, that names are unique and that every number is usable.
    ///
    /// # Errors
    /// If there is no link or more than [`MAX_LINKS`], a name appears twice, an index is out of range, a
    /// link has two parents, there is a cycle or more than one root, an axis is zero, limits are
    /// missing or empty, a joint mimics itself (perhaps through others), or a number is not finite.
    pub fn new(
        name: impl Into<String>,
        links: Vec<Link>,
        mut joints: Vec<Joint>,
    ) -> Result<Self, InvalidInput> {
        if links.is_empty() || links.len() > MAX_LINKS {
            return Err(InvalidInput::new("links", links.len(), format!("1 to {MAX_LINKS} links")));
        }
        unique("links", links.iter().map(|link| &link.name))?;
        unique("joints", joints.iter().map(|joint| &joint.name))?;
        for link in &links {
            for (index, body) in link.bodies.iter().enumerate() {
                check_shape(&body.shape)
                    .map_err(|e| e.inside(&format!("link {}.collision[{index}]", link.name)))?;
            }
        }
        let count = joints.len();
        for joint in &mut joints {
            check_joint(joint, links.len(), count)
                .map_err(|e| e.inside(&format!("joint {}", joint.name)))?;
        }
        check_mimics(&joints)?;
        let (root, above) = tree(&links, &joints)?;
        Ok(Self { name: name.into(), links, joints, root, above })
    }

    /// The robot's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All links, in the file's order.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// All joints, in the file's order.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Index of the link that no joint carries.
    pub fn root(&self) -> usize {
        self.root
    }

    /// Index of the joint that carries a link; none for the root.
    pub fn joint_above(&self, link: usize) -> Option<usize> {
        self.above[link]
    }

    /// Index of the link of this name.
    pub fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// Index of the joint of this name.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Replaces the shapes of the links, one list for each link: spheres for meshes, say.
    ///
    /// # Errors
    /// If there are not as many lists as links, or a shape has a number that is not usable.
    pub fn with_bodies(mut self, bodies: Vec<Vec<Body>>) -> Result<Self, InvalidInput> {
        if bodies.len() != self.links.len() {
            let allowed = format!("{} lists, one for each link", self.links.len());
            return Err(InvalidInput::new("bodies", bodies.len(), allowed));
        }
        for (link, bodies) in self.links.iter_mut().zip(bodies) {
            link.bodies = bodies;
        }
        Self::new(self.name, self.links, self.joints)
    }
}

fn unique<'a>(field: &str, names: impl Iterator<Item = &'a String>) -> Result<(), InvalidInput> {
    let mut seen = std::collections::HashSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err(InvalidInput::new(field, format!("{name:?} twice"), "a name only once"));
        }
    }
    Ok(())
}

fn check_shape(shape: &BodyShape) -> Result<(), InvalidInput> {
    let above_zero = |field: &str, value: f64| {
        if finite(field, value)? > 0.0 {
            Ok(())
        } else {
            Err(InvalidInput::new(field, value, "a number above 0, in metres"))
        }
    };
    match shape {
        BodyShape::Sphere { radius } => above_zero("radius", *radius),
        BodyShape::Box { half_extents } => {
            half_extents.iter().try_for_each(|&half| above_zero("half extent", half))
        }
        BodyShape::Cylinder { radius, length } => {
            above_zero("radius", *radius)?;
            above_zero("length", *length)
        }
        BodyShape::Capsule { radius, length } => {
            above_zero("radius", *radius)?;
            if finite("length", *length)? >= 0.0 {
                return Ok(());
            }
            Err(InvalidInput::new("length", length, "a number of at least 0, in metres"))
        }
        BodyShape::Mesh { scale, .. } => {
            scale.iter().try_for_each(|&factor| finite("scale", factor).map(|_| ()))
        }
    }
}

fn check_joint(joint: &mut Joint, links: usize, joints: usize) -> Result<(), InvalidInput> {
    for (field, index) in [("parent", joint.parent), ("child", joint.child)] {
        if index >= links {
            return Err(InvalidInput::new(field, index, format!("a link below {links}")));
        }
    }
    for value in joint.axis {
        finite("axis", value)?;
    }
    if joint.kind != JointKind::Fixed {
        let axis = format!("{:?}", joint.axis);
        // One that has been normalised before stays what it is, to the bit.
        if (dot(joint.axis, joint.axis) - 1.0).abs() > 1e-14 {
            joint.axis = unit(joint.axis)
                .ok_or_else(|| InvalidInput::new("axis", axis, "a vector that is not zero"))?;
        }
    }
    match (&joint.limits, joint.kind) {
        (None, JointKind::Revolute | JointKind::Prismatic) => {
            return Err(InvalidInput::new("limit", "nothing", "a lower and an upper limit"));
        }
        (Some(limits), JointKind::Revolute | JointKind::Prismatic) => {
            finite("limit.lower", limits.lower)?;
            if finite("limit.upper", limits.upper)? < limits.lower {
                let allowed = format!("at least the lower limit {}", limits.lower);
                return Err(InvalidInput::new("limit.upper", limits.upper, allowed));
            }
        }
        _ => {}
    }
    if let Some(limits) = &joint.limits {
        for (field, value) in [("limit.velocity", limits.velocity), ("limit.effort", limits.effort)]
        {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value >= 0.0)) {
                return Err(InvalidInput::new(field, value, "a finite number of at least 0"));
            }
        }
    }
    if let Some(mimic) = &joint.mimic {
        finite("mimic.multiplier", mimic.multiplier)?;
        finite("mimic.offset", mimic.offset)?;
        if mimic.joint >= joints {
            let allowed = format!("a joint below {joints}");
            return Err(InvalidInput::new("mimic.joint", mimic.joint, allowed));
        }
    }
    Ok(())
}

/// No joint follows itself: from each, the chain of followed joints ends within as many steps as
/// there are joints. Each joint is walked over once.
fn check_mimics(joints: &[Joint]) -> Result<(), InvalidInput> {
    let mut ends = vec![false; joints.len()];
    for first in 0..joints.len() {
        let mut walked = Vec::new();
        let mut at = first;
        while !ends[at] {
            walked.push(at);
            match joints[at].mimic {
                Some(mimic) if walked.len() <= joints.len() => at = mimic.joint,
                Some(_) => {
                    let field = format!("joint {}.mimic", joints[first].name);
                    return Err(InvalidInput::new(
                        field,
                        "a circle",
                        "a joint that moves by itself",
                    ));
                }
                None => break,
            }
        }
        walked.into_iter().for_each(|joint| ends[joint] = true);
    }
    Ok(())
}

/// The root, and for each link the joint above it.
fn tree(links: &[Link], joints: &[Joint]) -> Result<(usize, Vec<Option<usize>>), InvalidInput> {
    let mut above = vec![None; links.len()];
    for (index, joint) in joints.iter().enumerate() {
        if let Some(other) = above[joint.child].replace(index) {
            let other: &Joint = &joints[other];
            return Err(InvalidInput::new(
                format!("joint {}.child", joint.name),
                format!("{:?}, which joint {} carries", links[joint.child].name, other.name),
                "a link that no other joint carries",
            ));
        }
    }
    let roots: Vec<usize> = (0..links.len()).filter(|&link| above[link].is_none()).collect();
    let &[root] = roots.as_slice() else {
        let name = |&link: &usize| format!("{:?}", links[link].name);
        let found = match roots.len() {
            0 => "a circle of links".to_string(),
            count => {
                let some: Vec<String> = roots.iter().take(4).map(name).collect();
                format!("{count} roots: {}{}", some.join(", "), if count > 4 { ", .." } else { "" })
            }
        };
        return Err(InvalidInput::new("links", found, "one tree: one link that no joint carries"));
    };
    // With one root and one joint above every other link, whatever the root does not reach is a circle.
    let mut children: HashMap<usize, Vec<usize>> = HashMap::new();
    for joint in joints {
        children.entry(joint.parent).or_default().push(joint.child);
    }
    let (mut reached, mut open) = (vec![false; links.len()], vec![root]);
    while let Some(link) = open.pop() {
        reached[link] = true;
        open.extend(children.get(&link).into_iter().flatten());
    }
    match reached.iter().position(|reached| !reached) {
        Some(link) => {
            let found = format!("a circle through {:?}", links[link].name);
            Err(InvalidInput::new("links", found, "a tree"))
        }
        None => Ok((root, above)),
    }
}
