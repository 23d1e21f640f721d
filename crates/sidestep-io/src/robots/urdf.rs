//! URDF: the Unified Robot Description Format of ROS (<https://wiki.ros.org/urdf/XML>).
//!
//! Read: links with all their collision geometries (sphere, box, cylinder, capsule, mesh with scale), joints of type
//! fixed, revolute, continuous and prismatic with origin, axis, limits and mimic. What is about looks, masses, controllers or
//! simulators is skipped. Floating and planar joints are refused: a base that moves is no joint to plan for here.

use std::collections::HashMap;

use sidestep::InvalidInput;
use sidestep::arm::{Body, BodyShape, Joint, JointKind, Limits, Link, MAX_LINKS, Mimic, Model};
use sidestep::space::Pose;

use super::xml::{Element, parse};
use crate::error::{FormatError, Place, nearest, quoted};

const FORMAT: &str = "URDF";

/// A robot from its URDF. `text` is the file's content after xacro, if it was made by that.
///
/// # Errors
/// If the text is no XML, or no URDF of a robot that is one tree; the error names line and element.
pub fn read_urdf(text: &str) -> Result<Model, FormatError> {
    let document = parse(FORMAT, text, "robot")?;
    let robot = Element::root(FORMAT, &document);
    refuse_xacro(&robot)?;
    let (mut links, mut elements) = (Vec::new(), HashMap::new());
    let mut link_of = HashMap::new();
    if let Some(element) = robot.all("link").nth(MAX_LINKS) {
        return Err(element.wrong("one more link", format!("at most {MAX_LINKS} links")));
    }
    for element in robot.all("link") {
        let name = element.required_text("name")?;
        if link_of.insert(name, links.len()).is_some() {
            return Err(element.wrong_at("name", format!("{} again", quoted(name)), "a new name"));
        }
        elements.insert(format!("link {name}"), element);
        links.push(Link { name: name.to_string(), bodies: bodies(&element)? });
    }
    if links.is_empty() {
        return Err(robot.wrong("no <link>", "links and joints"));
    }
    let mut joint_of = HashMap::new();
    for element in robot.all("joint") {
        let name = element.required_text("name")?;
        if joint_of.insert(name, joint_of.len()).is_some() {
            return Err(element.wrong_at("name", format!("{} again", quoted(name)), "a new name"));
        }
        elements.insert(format!("joint {name}"), element);
    }
    let mut joints = Vec::with_capacity(joint_of.len());
    for element in robot.all("joint") {
        joints.push(joint(&element, &link_of, &joint_of)?);
    }
    let name = robot.text("name").unwrap_or("robot");
    Model::new(name, links, joints).map_err(|invalid| placed(&invalid, &elements))
}

/// The core's objection, at the line of the element that it names.
fn placed(invalid: &InvalidInput, elements: &HashMap<String, Element<'_>>) -> FormatError {
    let named = |field: &str| {
        // `joint elbow.limit.upper`; names may hold dots, so the longest known beginning counts.
        let ends = field.char_indices().filter(|&(_, c)| c == '.').map(|(at, _)| at);
        let ends = ends.chain([field.len()]).collect::<Vec<_>>();
        ends.into_iter().rev().find_map(|end| elements.get(&field[..end])).map(Element::line)
    };
    let place = Place { line: named(&invalid.field), ..Place::field(invalid.field.clone()) };
    FormatError::new(FORMAT, place, &invalid.value, invalid.allowed.clone())
}

fn refuse_xacro(robot: &Element<'_>) -> Result<(), FormatError> {
    let of_xacro = |element: &Element<'_>| {
        element.node.tag_name().namespace().is_some_and(|space| space.contains("xacro"))
    };
    match robot.children().find(of_xacro) {
        Some(element) => Err(element.wrong(
            "a xacro macro",
            "URDF; run `xacro FILE` first (pip install xacrodoc has it without ROS)",
        )),
        None => Ok(()),
    }
}

fn joint(
    element: &Element<'_>,
    links: &HashMap<&str, usize>,
    joints: &HashMap<&str, usize>,
) -> Result<Joint, FormatError> {
    const KINDS: &str = "fixed, revolute, continuous or prismatic";
    let kind = match element.required_text("type")? {
        "fixed" => JointKind::Fixed,
        "revolute" => JointKind::Revolute,
        "continuous" => JointKind::Continuous,
        "prismatic" => JointKind::Prismatic,
        found @ ("floating" | "planar") => {
            let expected = format!("{KINDS}; a base that moves must be fixed in the world");
            return Err(element.wrong_at("type", quoted(found), expected));
        }
        found => return Err(element.wrong_at("type", quoted(found), KINDS)),
    };
    let link = |end| -> Result<usize, FormatError> {
        let element = element.required(end)?;
        let name = element.required_text("link")?;
        links.get(name).copied().ok_or_else(|| unknown(&element, "link", name, links))
    };
    let axis = element
        .child("axis")
        .map_or(Ok([1.0, 0.0, 0.0]), |axis| axis.numbers("xyz", [1.0, 0.0, 0.0]))?;
    let limits = element.child("limit").map(|limit| -> Result<Limits, FormatError> {
        let [lower] = limit.numbers("lower", [0.0])?;
        let [upper] = limit.numbers("upper", [0.0])?;
        let (velocity, effort) = (limit.number("velocity")?, limit.number("effort")?);
        Ok(Limits { lower, upper, velocity, effort })
    });
    let mimic = element.child("mimic").map(|mimic| -> Result<Mimic, FormatError> {
        let name = mimic.required_text("joint")?;
        let joint =
            joints.get(name).copied().ok_or_else(|| unknown(&mimic, "joint", name, joints))?;
        let [multiplier] = mimic.numbers("multiplier", [1.0])?;
        let [offset] = mimic.numbers("offset", [0.0])?;
        Ok(Mimic { joint, multiplier, offset })
    });
    Ok(Joint {
        name: element.required_text("name")?.to_string(),
        kind,
        parent: link("parent")?,
        child: link("child")?,
        origin: origin(element)?,
        axis,
        limits: limits.transpose()?,
        mimic: mimic.transpose()?,
    })
}

/// A name that nothing has, with the nearest that something has.
fn unknown(
    element: &Element<'_>,
    attribute: &str,
    name: &str,
    known: &HashMap<&str, usize>,
) -> FormatError {
    let mut names: Vec<&str> = known.keys().copied().collect();
    names.sort_unstable();
    let hint = nearest(name, &names).map_or(String::new(), |near| format!(" (like {near:?})"));
    element.wrong_at(
        attribute,
        quoted(name),
        format!("the name of a {attribute} of this robot{hint}"),
    )
}

/// The pose of `<origin xyz rpy>`, or none of either.
fn origin(element: &Element<'_>) -> Result<Pose, FormatError> {
    let Some(origin) = element.child("origin") else { return Ok(Pose::IDENTITY) };
    let (xyz, rpy) = (origin.numbers("xyz", [0.0; 3])?, origin.numbers("rpy", [0.0; 3])?);
    Pose::from_rpy(rpy, xyz).map_err(|invalid| {
        origin.wrong(format!("{} = {}", invalid.field, invalid.value), invalid.allowed)
    })
}

/// The shapes of all `<collision>` of a link.
fn bodies(link: &Element<'_>) -> Result<Vec<Body>, FormatError> {
    let body = |collision: Element<'_>| {
        let geometry = collision.required("geometry")?;
        Ok(Body { origin: origin(&collision)?, shape: shape(&geometry)? })
    };
    link.all("collision").map(body).collect()
}

fn shape(geometry: &Element<'_>) -> Result<BodyShape, FormatError> {
    const EXPECTED: &str = "<sphere>, <box>, <cylinder>, <capsule> or <mesh>";
    let Some(shape) = geometry.children().next() else {
        return Err(geometry.wrong("nothing", EXPECTED));
    };
    let above_zero = |attribute: &str, value: f64| {
        if value > 0.0 {
            Ok(value)
        } else {
            Err(shape.wrong_at(attribute, value, "a number above 0, in metres"))
        }
    };
    let length = |attribute| above_zero(attribute, shape.required_number(attribute)?);
    Ok(match shape.name() {
        "sphere" => BodyShape::Sphere { radius: length("radius")? },
        "cylinder" => BodyShape::Cylinder { radius: length("radius")?, length: length("length")? },
        "capsule" => BodyShape::Capsule { radius: length("radius")?, length: length("length")? },
        "box" => {
            shape.required_text("size")?;
            let size = shape.numbers("size", [0.0; 3])?;
            for side in size {
                above_zero("size", side)?;
            }
            BodyShape::Box { half_extents: size.map(|side| 0.5 * side) }
        }
        "mesh" => BodyShape::Mesh {
            file: shape.required_text("filename")?.to_string(),
            scale: shape.numbers("scale", [1.0; 3])?,
        },
        found => return Err(shape.wrong(format!("<{found}>"), EXPECTED)),
    })
}
