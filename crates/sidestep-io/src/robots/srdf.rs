//! SRDF: what people say about a robot beyond its URDF (<https://wiki.ros.org/srdf>).
//!
//! Groups of joints by chain, joints, links or other groups; named configurations; pairs of links that may touch or
//! never meet; virtual and passive joints; end effectors. Names are checked against a robot when they are asked for.

use std::collections::HashSet;

use roxmltree::Document;
use sidestep::InvalidInput;
use sidestep::arm::{JointKind, Model};

use super::xml::{Element, parse};
use crate::error::{FormatError, nearest};

const FORMAT: &str = "SRDF";

/// What an SRDF says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Srdf {
    /// The robot's name.
    pub name: String,
    /// Groups of joints, in the file's order.
    pub groups: Vec<Group>,
    /// Named configurations of groups.
    pub states: Vec<GroupState>,
    /// Pairs of links that need not be checked against each other.
    pub disabled_pairs: Vec<(String, String)>,
    /// How the robot's root may move in the world.
    pub virtual_joints: Vec<VirtualJoint>,
    /// Joints without a drive.
    pub passive_joints: Vec<String>,
    /// Tools.
    pub end_effectors: Vec<EndEffector>,
}

/// A group of joints to plan for.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// What belongs to it, in the file's order.
    pub parts: Vec<GroupPart>,
}

/// Something that belongs to a group.
#[derive(Debug, Clone, PartialEq)]
pub enum GroupPart {
    /// All joints between two links.
    Chain {
        /// The link nearer to the root; not itself moved by the chain.
        base: String,
        /// The link at the end.
        tip: String,
    },
    /// A joint, by name.
    Joint(String),
    /// The joint above a link, by the link's name.
    Link(String),
    /// All joints of another group, by name.
    Group(String),
}

/// A configuration with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupState {
    /// Its name.
    pub name: String,
    /// The group that it is of.
    pub group: String,
    /// Values by joint, rad or m.
    pub values: Vec<(String, f64)>,
}

/// A joint between the world and a link.
#[derive(Debug, Clone, PartialEq)]
pub struct VirtualJoint {
    /// Its name.
    pub name: String,
    /// Its type: fixed, planar or floating.
    pub kind: String,
    /// The world's frame.
    pub parent_frame: String,
    /// The link.
    pub child_link: String,
}

/// A tool.
#[derive(Debug, Clone, PartialEq)]
pub struct EndEffector {
    /// Its name.
    pub name: String,
    /// The group of its own joints.
    pub group: String,
    /// The link that it is fixed to.
    pub parent_link: String,
}

/// What a text says about a robot.
///
/// # Errors
/// If the text is no XML or no SRDF; the error names line and element.
pub fn read_srdf(text: &str) -> Result<Srdf, FormatError> {
    let document: Document<'_> = parse(FORMAT, text, "robot")?;
    let robot = Element::root(FORMAT, &document);
    let owned =
        |element: &Element<'_>, attribute| element.required_text(attribute).map(str::to_string);
    let mut srdf = Srdf { name: robot.text("name").unwrap_or_default().into(), ..Srdf::default() };
    for element in robot.children() {
        match element.name() {
            // A group without an element is a reference where groups nest; here it is an empty group.
            "group" => srdf.groups.push(group(&element)?),
            "group_state" => srdf.states.push(state(&element)?),
            "disable_collisions" => {
                let pair = (owned(&element, "link1")?, owned(&element, "link2")?);
                srdf.disabled_pairs.push(pair);
            }
            "virtual_joint" => srdf.virtual_joints.push(VirtualJoint {
                name: owned(&element, "name")?,
                kind: owned(&element, "type")?,
                parent_frame: owned(&element, "parent_frame")?,
                child_link: owned(&element, "child_link")?,
            }),
            "passive_joint" => srdf.passive_joints.push(owned(&element, "name")?),
            "end_effector" => srdf.end_effectors.push(EndEffector {
                name: owned(&element, "name")?,
                group: owned(&element, "group")?,
                parent_link: owned(&element, "parent_link")?,
            }),
            _ => {}
        }
    }
    Ok(srdf)
}

fn group(element: &Element<'_>) -> Result<Group, FormatError> {
    let mut parts = Vec::new();
    for part in element.children() {
        let text = |attribute| part.required_text(attribute).map(str::to_string);
        parts.push(match part.name() {
            "chain" => GroupPart::Chain { base: text("base_link")?, tip: text("tip_link")? },
            "joint" => GroupPart::Joint(text("name")?),
            "link" => GroupPart::Link(text("name")?),
            "group" => GroupPart::Group(text("name")?),
            _ => continue,
        });
    }
    Ok(Group { name: element.required_text("name")?.to_string(), parts })
}

fn state(element: &Element<'_>) -> Result<GroupState, FormatError> {
    let mut values = Vec::new();
    for joint in element.all("joint") {
        // Joints with several numbers (planar, floating) cannot be planned for.
        values.push((joint.required_text("name")?.to_string(), joint.required_number("value")?));
    }
    Ok(GroupState {
        name: element.required_text("name")?.to_string(),
        group: element.required_text("group")?.to_string(),
        values,
    })
}

impl Srdf {
    /// The joints of a group that move by themselves, in the order in which the group names them, chains from base to
    /// tip; each once.
    ///
    /// # Errors
    /// If there is no such group, it holds itself, or it names something that the robot does not have.
    pub fn joints_of(&self, group: &str, model: &Model) -> Result<Vec<String>, InvalidInput> {
        let found = self.collect(group, model)?;
        let mut once = HashSet::new();
        let passive: HashSet<&str> = self.passive_joints.iter().map(String::as_str).collect();
        let moves = |&index: &usize| {
            let joint = &model.joints()[index];
            let driven = joint.kind != JointKind::Fixed && joint.mimic.is_none();
            driven && !passive.contains(joint.name.as_str()) && once.insert(index)
        };
        let names = found.into_iter().filter(moves).map(|index| model.joints()[index].name.clone());
        Ok(names.collect())
    }

    /// The joints of a group and of the groups in it, each group once.
    fn collect(&self, name: &str, model: &Model) -> Result<Vec<usize>, InvalidInput> {
        let of_group = |name: &str| {
            self.groups.iter().find(|group| group.name == name).ok_or_else(|| {
                let known: Vec<&str> =
                    self.groups.iter().map(|group| group.name.as_str()).collect();
                unknown("group", name, "a group", &known)
            })
        };
        let first = of_group(name)?;
        let (mut found, mut seen) = (Vec::new(), HashSet::from([name]));
        let mut open: Vec<(&str, &GroupPart)> =
            first.parts.iter().rev().map(|part| (name, part)).collect();
        while let Some((name, part)) = open.pop() {
            match part {
                GroupPart::Chain { base, tip } => {
                    found.extend(joints_between(model, base, tip, name)?);
                }
                // A virtual joint is no joint of the robot.
                GroupPart::Joint(joint) if self.virtual_joints.iter().any(|v| v.name == *joint) => {
                }
                GroupPart::Joint(joint) => {
                    found.push(model.joint(joint).ok_or_else(|| no_joint(name, joint, model))?);
                }
                GroupPart::Link(link) => {
                    let index = model.link(link).ok_or_else(|| no_link(name, link, model))?;
                    found.extend(model.joint_above(index));
                }
                GroupPart::Group(inner) => {
                    let group = of_group(inner)?;
                    if seen.insert(inner) {
                        open.extend(group.parts.iter().rev().map(|part| (inner.as_str(), part)));
                    }
                }
            }
        }
        Ok(found)
    }
}

/// The joints from a chain's base to its tip.
fn joints_between(
    model: &Model,
    base: &str,
    tip: &str,
    group: &str,
) -> Result<Vec<usize>, InvalidInput> {
    let link = |name: &str| model.link(name).ok_or_else(|| no_link(group, name, model));
    let (end, mut at) = (link(base)?, link(tip)?);
    let mut joints = Vec::new();
    while at != end {
        let Some(joint) = model.joint_above(at) else {
            let found = format!("{base:?}, which does not carry {tip:?}");
            return Err(InvalidInput::new(
                format!("group {group}.chain.base_link"),
                found,
                "a link between the robot's root and the chain's tip",
            ));
        };
        joints.push(joint);
        at = model.joints()[joint].parent;
    }
    joints.reverse();
    Ok(joints)
}

fn no_joint(group: &str, name: &str, model: &Model) -> InvalidInput {
    let known: Vec<&str> = model.joints().iter().map(|joint| joint.name.as_str()).collect();
    unknown(&format!("group {group}.joint"), name, "a joint of the robot", &known)
}

fn no_link(group: &str, name: &str, model: &Model) -> InvalidInput {
    let known: Vec<&str> = model.links().iter().map(|link| link.name.as_str()).collect();
    unknown(&format!("group {group}.link"), name, "a link of the robot", &known)
}

fn unknown(field: &str, name: &str, expected: &str, known: &[&str]) -> InvalidInput {
    let hint = nearest(name, known).map_or(String::new(), |near| format!(" (like {near:?})"));
    InvalidInput::new(field, format!("{name:?}"), format!("the name of {expected}{hint}"))
}
