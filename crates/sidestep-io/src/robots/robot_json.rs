//! A robot as our own JSON: what is left of a URDF, an SRDF and meshes when they are loaded, so that it need not be
//! done again.
//!
//! ```json
//! {
//!   "format": "sidestep.robot/1",
//!   "name": "two links",
//!   "links": [{"name": "base", "spheres": []}, {"name": "arm", "spheres": [[0.2, 0, 0, 0.05]]}],
//!   "joints": [{"name": "turn", "type": "revolute", "parent": "base", "child": "arm",
//!     "position": [0, 0, 0.3], "axis": [0, 0, 1], "limits": {"lower": -1, "upper": 1, "velocity": 2}}],
//!   "moving": ["turn"],
//!   "held": {},
//!   "may_touch": [["base", "arm"]],
//!   "overhang": 0.01
//! }
//! ```
//!
//! Metres and radians. A sphere is `[x, y, z, radius]` in its link's frame; `rotation` (three rows, the identity where
//! it is missing) and `position` place a joint in its parent's frame; `moving` orders the numbers of a configuration; a
//! joint that neither moves nor is held in `held` stands at 0 or the limit nearest to it. `may_touch` names the pairs of
//! links that are not checked against each other. `overhang` is how far the spheres stick out of what they cover at
//! most; 0 where they are the robot's own. The JSON Schema is `schemas/robot-1.schema.json`.

use std::collections::HashMap;

use serde_json::{Map, Value, json};
use sidestep::InvalidInput;
use sidestep::arm::{Arm, Body, BodyShape, Joint, JointKind, Limits, Link, Mimic, Model};
use sidestep::space::{Pose, Vector};

use crate::error::FormatError;
use crate::json::{Node, Source, parse};

/// What `format` says in a robot of this version.
pub const ROBOT_FORMAT: &str = "sidestep.robot/1";
const FORMAT: &str = "robot JSON";

const KINDS: [(&str, JointKind); 4] = [
    ("fixed", JointKind::Fixed),
    ("revolute", JointKind::Revolute),
    ("continuous", JointKind::Continuous),
    ("prismatic", JointKind::Prismatic),
];

/// A robot, ready to be compiled.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotFile {
    /// Links, whose bodies are all spheres, and joints.
    pub model: Model,
    /// The joints that move, in the order of a configuration's numbers; at least one.
    pub moving: Vec<String>,
    /// Where other joints stand: rad or m.
    pub held: Vec<(String, f64)>,
    /// Pairs of links that are not checked against each other.
    pub may_touch: Vec<(String, String)>,
    /// How far the spheres stick out of the shapes that they cover at most, metres; 0 where they were given.
    pub overhang: f64,
}

impl RobotFile {
    /// The robot, compiled.
    ///
    /// # Errors
    /// As [`Arm::new`] and [`Arm::with_self_collisions`].
    pub fn arm(&self) -> Result<Arm, InvalidInput> {
        let moving: Vec<&str> = self.moving.iter().map(String::as_str).collect();
        let held: HashMap<String, f64> = self.held.iter().cloned().collect();
        Arm::new(&self.model, &moving, &held)?.with_self_collisions(&self.may_touch)
    }

    /// The text of its file, from which [`read_robot`] makes the same robot, to the bit.
    pub fn to_json(&self) -> String {
        let links = self.model.links();
        let link = |link: &Link| json!({"name": link.name, "spheres": spheres(link)}).to_string();
        let joint = |joint: &Joint| self.joint(joint).to_string();
        let held: Map<String, Value> =
            self.held.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
        let rows = |rows: Vec<String>| rows.join(",\n");
        format!(
            "{{\n\"format\": {}, \"name\": {},\n\"links\": [\n{}\n],\n\"joints\": [\n{}\n],\n\
             \"moving\": {},\n\"held\": {},\n\"may_touch\": {},\n\"overhang\": {}\n}}\n",
            json!(ROBOT_FORMAT),
            json!(self.model.name()),
            rows(links.iter().map(link).collect()),
            rows(self.model.joints().iter().map(joint).collect()),
            json!(self.moving),
            Value::Object(held),
            json!(self.may_touch),
            json!(self.overhang)
        )
    }

    fn joint(&self, joint: &Joint) -> Value {
        let name = |link: usize| json!(self.model.links()[link].name);
        let kind = KINDS.iter().find(|(_, kind)| *kind == joint.kind).map_or("", |(name, _)| name);
        let mut value = Map::new();
        let mut set = |key: &str, field: Value| value.insert(key.to_owned(), field);
        set("name", json!(joint.name));
        set("type", json!(kind));
        set("parent", name(joint.parent));
        set("child", name(joint.child));
        set("position", json!(joint.origin.translation()));
        if joint.origin.rotation() != Pose::IDENTITY.rotation() {
            set("rotation", json!(joint.origin.rotation()));
        }
        if joint.kind != JointKind::Fixed {
            set("axis", json!(joint.axis));
        }
        if let Some(limits) = &joint.limits {
            let mut fields = Map::new();
            fields.insert("lower".into(), json!(limits.lower));
            fields.insert("upper".into(), json!(limits.upper));
            for (key, limit) in [("velocity", limits.velocity), ("effort", limits.effort)] {
                if let Some(limit) = limit {
                    fields.insert(key.into(), json!(limit));
                }
            }
            set("limits", Value::Object(fields));
        }
        if let Some(mimic) = &joint.mimic {
            let followed = &self.model.joints()[mimic.joint].name;
            let (multiplier, offset) = (mimic.multiplier, mimic.offset);
            let fields = json!({"joint": followed, "multiplier": multiplier, "offset": offset});
            set("mimic", fields);
        }
        Value::Object(value)
    }
}

fn spheres(link: &Link) -> Vec<[f64; 4]> {
    let sphere = |body: &Body| match body.shape {
        BodyShape::Sphere { radius } => {
            let [x, y, z] = body.origin.translation();
            Some([x, y, z, radius])
        }
        _ => None,
    };
    link.bodies.iter().filter_map(sphere).collect()
}

/// The robot of a file's text.
///
/// # Errors
/// The first fault, with its line, column, field, value and what is allowed.
pub fn read_robot(text: &str) -> Result<RobotFile, FormatError> {
    let text = crate::input::without_mark(text);
    let document = parse(FORMAT, text, 1)?;
    let root = Node::root(Source { format: FORMAT, text, first_line: 1 }, &document);
    let fields = ["format", "name", "links", "joints", "moving", "held", "may_touch", "overhang"];
    let format = root.required("format", &format!("{ROBOT_FORMAT:?}"))?;
    if format.string()? != ROBOT_FORMAT {
        return Err(format.wrong(format!("{ROBOT_FORMAT:?}, the version that this program reads")));
    }
    root.object(&fields)?;
    let name = root.required("name", "the robot's name")?.string()?;
    let list = root.required("links", "an array of links")?;
    let links: Vec<Link> =
        list.items("an array of links")?.map(|node| link(&node)).collect::<Result<_, _>>()?;
    let index: HashMap<&str, usize> =
        links.iter().enumerate().map(|(i, link)| (link.name.as_str(), i)).collect();
    let list = root.required("joints", "an array of joints")?;
    let items: Vec<Node<'_>> = list.items("an array of joints")?.collect();
    let mut names = HashMap::new();
    for (i, node) in items.iter().enumerate() {
        node.object(&JOINT)?;
        names.insert(node.required("name", "a name")?.string()?, i);
    }
    let joints = items.iter().map(|node| joint(node, &index, &names));
    let joints: Vec<Joint> = joints.collect::<Result<_, _>>()?;
    drop(index);
    let model = Model::new(name, links, joints).map_err(|invalid| root.refused("", invalid))?;
    let moving = strings(&root.required("moving", "the names of joints")?)?;
    if moving.is_empty() {
        return Err(root.found("no joint in \"moving\"", "at least one"));
    }
    let mut held = Vec::new();
    if let Some(node) = root.optional("held") {
        for (name, value) in node.fields("an object of joints' names and numbers")? {
            held.push((name.to_owned(), value.number()?));
        }
    }
    let mut may_touch = Vec::new();
    if let Some(node) = root.optional("may_touch") {
        for pair in node.items("an array of pairs of links")? {
            let [a, b] = pair.pair("two links' names")?;
            may_touch.push((a.string()?.to_owned(), b.string()?.to_owned()));
        }
    }
    let overhang = match root.optional("overhang") {
        Some(node) if node.number()? < 0.0 => return Err(node.wrong("at least 0, in metres")),
        Some(node) => node.number()?,
        None => 0.0,
    };
    let file = RobotFile { model, moving, held, may_touch, overhang };
    file.arm().map_err(|invalid| root.refused("", invalid))?;
    Ok(file)
}

const JOINT: [&str; 9] =
    ["name", "type", "parent", "child", "position", "rotation", "axis", "limits", "mimic"];

fn link(node: &Node<'_>) -> Result<Link, FormatError> {
    node.object(&["name", "spheres"])?;
    let name = node.required("name", "a name")?.string()?.to_owned();
    let mut bodies = Vec::new();
    if let Some(list) = node.optional("spheres") {
        for sphere in list.items("an array of spheres")? {
            let [x, y, z, radius] = numbers(&sphere, "[x, y, z, radius]")?;
            let origin = Pose::at([x, y, z]).map_err(|invalid| sphere.refused("", invalid))?;
            if radius <= 0.0 {
                return Err(sphere.wrong("[x, y, z, radius] with a radius above 0"));
            }
            bodies.push(Body { origin, shape: BodyShape::Sphere { radius } });
        }
    }
    Ok(Link { name, bodies })
}

fn joint(
    node: &Node<'_>,
    links: &HashMap<&str, usize>,
    joints: &HashMap<&str, usize>,
) -> Result<Joint, FormatError> {
    let link = |key: &'static str| {
        let field = node.required(key, "a link's name")?;
        links.get(field.string()?).copied().ok_or_else(|| field.wrong("a link's name"))
    };
    let field = node.required("type", "a kind of joint")?;
    let kind = field.string()?;
    let kind = KINDS.iter().find(|(name, _)| *name == kind).map(|&(_, kind)| kind);
    let kind = kind.ok_or_else(|| field.wrong("fixed, revolute, continuous or prismatic"))?;
    let position = vector(node, "position", [0.0; 3])?;
    let rotation = match node.optional("rotation") {
        Some(rows) => {
            const EXPECTED: &str = "three rows of three numbers";
            let rows: Vec<Vector> = rows
                .items(EXPECTED)?
                .map(|row| numbers(&row, EXPECTED))
                .collect::<Result<_, _>>()?;
            let rows = rows.try_into();
            rows.map_err(|rows: Vec<Vector>| {
                node.found(format!("a rotation of {} rows", rows.len()), EXPECTED)
            })?
        }
        None => Pose::IDENTITY.rotation(),
    };
    let origin =
        Pose::from_rotation(rotation, position).map_err(|invalid| node.refused("", invalid))?;
    let limits = node.optional("limits").map(|limits| read_limits(&limits)).transpose()?;
    let mimic = match node.optional("mimic") {
        Some(mimic) => {
            mimic.object(&["joint", "multiplier", "offset"])?;
            let followed = mimic.required("joint", "a joint's name")?;
            let joint = joints.get(followed.string()?).copied();
            let joint = joint.ok_or_else(|| followed.wrong("a joint's name"))?;
            let number = |key, missing| mimic.optional(key).map_or(Ok(missing), |n| n.number());
            let (multiplier, offset) = (number("multiplier", 1.0)?, number("offset", 0.0)?);
            Some(Mimic { joint, multiplier, offset })
        }
        None => None,
    };
    Ok(Joint {
        name: node.required("name", "a name")?.string()?.to_owned(),
        kind,
        parent: link("parent")?,
        child: link("child")?,
        origin,
        axis: vector(node, "axis", [1.0, 0.0, 0.0])?,
        limits,
        mimic,
    })
}

fn read_limits(node: &Node<'_>) -> Result<Limits, FormatError> {
    node.object(&["lower", "upper", "velocity", "effort"])?;
    let required = |key| node.required(key, "a number").and_then(|value| value.number());
    let optional = |key| node.optional(key).map(|value| value.number()).transpose();
    Ok(Limits {
        lower: required("lower")?,
        upper: required("upper")?,
        velocity: optional("velocity")?,
        effort: optional("effort")?,
    })
}

fn vector(node: &Node<'_>, key: &str, missing: Vector) -> Result<Vector, FormatError> {
    node.optional(key).map_or(Ok(missing), |value| numbers(&value, "three numbers"))
}

fn numbers<const N: usize>(node: &Node<'_>, expected: &str) -> Result<[f64; N], FormatError> {
    let items: Vec<f64> =
        node.items(expected)?.map(|item| item.number()).collect::<Result<_, _>>()?;
    items.try_into().map_err(|_| node.wrong(expected))
}

fn strings(node: &Node<'_>) -> Result<Vec<String>, FormatError> {
    const EXPECTED: &str = "an array of names";
    node.items(EXPECTED)?.map(|item| item.string().map(str::to_owned)).collect()
}

/// Whether a text is a robot of this format, or means to be.
pub fn is_robot(text: &str) -> bool {
    text.trim_start().starts_with('{')
}
