//! MoveIt's planning scenes and MotionBenchMaker's requests, as YAML.
//!
//! Source: the ROS messages `moveit_msgs/PlanningScene`, `CollisionObject`, `MotionPlanRequest` and
//! `shape_msgs/SolidPrimitive`, in the form that `rosbag`-like tools and MotionBenchMaker write:
//! `world.collision_objects[].{id, pose, primitives[].{type, dimensions}, primitive_poses[],
//! meshes[], mesh_poses[]}`. A box has full sizes, a cylinder height then radius; orientations are
//! xyzw; an object's pose stands before its shapes' poses. Octomaps, planes, cones and attached
//! objects are refused, for to leave an obstacle out is worse than to stop. Fields about other
//! things are passed over.

use std::sync::Arc;

use sidestep::space::{Mesh, Pose, Shape, World};

use super::objects::Objects;
use super::{json, tree};
use crate::error::FormatError;
use crate::json::{Json, Node};

/// The world of a planning scene.
pub(super) fn read(root: &Node<'_>) -> Result<World, FormatError> {
    let world = root.optional("world");
    let world = world.as_ref().unwrap_or(root);
    refuse_octomap(world)?;
    if let Some(state) = root.optional("robot_state")
        && let Some(attached) = state.optional("attached_collision_objects")
        && attached.items("an array")?.len() > 0
    {
        return Err(attached.wrong("no attached object: they are not read yet"));
    }
    let mut objects = Objects::default();
    if let Some(list) = world.optional("collision_objects").filter(|node| !is_null(node)) {
        for item in list.items("an array of collision objects")? {
            let (name, shapes) = read_object(&item)?;
            objects.add(name, shapes);
        }
    }
    objects.world(world)
}

fn is_null(node: &Node<'_>) -> bool {
    *node.value() == Json::Null
}

fn refuse_octomap(world: &Node<'_>) -> Result<(), FormatError> {
    let Some(map) = world.optional("octomap") else { return Ok(()) };
    let Some(tree) = map.optional("octomap") else { return Ok(()) };
    match tree.optional("data") {
        Some(data) if data.items("an array").is_ok_and(|items| items.len() > 0) => {
            Err(data.wrong("no octomap: give its points as a PCD file"))
        }
        _ => Ok(()),
    }
}

fn read_object(node: &Node<'_>) -> Result<(String, Vec<(Pose, Shape)>), FormatError> {
    let name = tree::name(&node.required("id", "the object's name")?)?;
    let base = match node.optional("pose") {
        Some(pose) if !is_null(&pose) => tree::ros_pose(&pose)?,
        _ => Pose::IDENTITY,
    };
    if let Some(operation) = node.optional("operation") {
        let adds = match operation.value() {
            Json::String(text) => text == "add",
            Json::Number(number) => *number == 0.0,
            _ => false,
        };
        if !adds {
            return Err(operation.wrong("add"));
        }
    }
    let mut shapes = Vec::new();
    for (list, poses, shape) in [
        ("primitives", "primitive_poses", read_primitive as fn(&Node<'_>) -> _),
        ("meshes", "mesh_poses", read_mesh),
    ] {
        let Some(list) = node.optional(list).filter(|node| !is_null(node)) else { continue };
        let items: Vec<_> = list.items("an array of shapes")?.collect();
        if items.is_empty() {
            continue;
        }
        let pose_list = node.optional(poses).filter(|node| !is_null(node));
        let Some(pose_list) = pose_list else {
            return Err(node.found(format!("no field {poses:?}"), "a pose for each shape"));
        };
        let placed: Vec<_> = pose_list.items("an array of poses")?.collect();
        if placed.len() != items.len() {
            let found = format!("{} poses", placed.len());
            return Err(pose_list.found(found, format!("{}, one for each shape", items.len())));
        }
        for (item, pose) in items.iter().zip(&placed) {
            shapes.push((base.compose(&tree::ros_pose(pose)?), shape(item)?));
        }
    }
    if let Some(planes) = node.optional("planes")
        && planes.items("an array").is_ok_and(|items| items.len() > 0)
    {
        return Err(planes.wrong("no planes: a large box serves"));
    }
    if shapes.is_empty() {
        return Err(node.found("an object without a shape", "primitives or meshes"));
    }
    Ok((name, shapes))
}

fn read_primitive(node: &Node<'_>) -> Result<Shape, FormatError> {
    const TYPES: &str = "box (1), sphere (2) or cylinder (3)";
    let kind = node.required("type", TYPES)?;
    let dimensions = node.required("dimensions", "an array of sizes")?;
    let made = match kind.value() {
        Json::String(text) if text.eq_ignore_ascii_case("box") => 1.0,
        Json::String(text) if text.eq_ignore_ascii_case("sphere") => 2.0,
        Json::String(text) if text.eq_ignore_ascii_case("cylinder") => 3.0,
        Json::Number(number) => *number,
        _ => 0.0,
    };
    let made = if made == 1.0 {
        let sizes: [f64; 3] = tree::numbers(&dimensions, "[x, y, z], the full sizes")?;
        Shape::cuboid(sizes.map(|size| 0.5 * size))
    } else if made == 2.0 {
        let [radius] = tree::numbers(&dimensions, "[radius]")?;
        Shape::sphere(radius)
    } else if made == 3.0 {
        let [height, radius] = tree::numbers(&dimensions, "[height, radius]")?;
        Shape::cylinder(radius, height)
    } else {
        return Err(kind.wrong(TYPES));
    };
    made.map_err(|invalid| dimensions.found(invalid.value, invalid.allowed))
}

/// `shape_msgs/Mesh`: `vertices` and `triangles`, each of which may be wrapped in `vertex_indices`.
fn read_mesh(node: &Node<'_>) -> Result<Shape, FormatError> {
    let vertices = json::vectors(&node.required("vertices", "an array of points")?)?;
    let list = node.required("triangles", "an array of three corners each")?;
    let triangles: Result<Vec<_>, _> = list
        .items("an array of three corners each")?
        .map(|item| match item.optional("vertex_indices") {
            Some(indices) => json::corners(&indices),
            None => json::corners(&item),
        })
        .collect();
    Mesh::new(vertices, triangles?)
        .map(|mesh| Shape::Mesh(Arc::new(mesh)))
        .map_err(|invalid| tree::below(node, invalid))
}

/// A MotionBenchMaker request: where a robot starts and where it should go, by joint names.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// The group of joints that moves, as the SRDF calls it.
    pub group: String,
    /// Where the robot's joints stand at the start: rad or m.
    pub start: Vec<(String, f64)>,
    /// Goals as joint values, any of which will do; at least one.
    pub goals: Vec<Vec<(String, f64)>>,
}

const REQUEST: &str = "motion plan request YAML";

/// Reads a request's YAML (`group_name`, `start_state.joint_state`,
/// `goal_constraints[].joint_constraints`).
///
/// # Errors
/// The first fault, with its field; goals as poses are refused.
pub fn read_request(bytes: &[u8]) -> Result<Request, FormatError> {
    let text = tree::text(REQUEST, bytes)?;
    let yaml = tree::yaml(REQUEST, text)?;
    let root = tree::root(REQUEST, text, &yaml);
    let group = root.required("group_name", "the name of a group")?.string()?.to_owned();
    let state = root.required("start_state", "the state of the robot")?;
    let joints = state.required("joint_state", "names and positions of joints")?;
    let names = joints.required("name", "an array of joint names")?;
    let names: Result<Vec<_>, _> =
        names.items("an array of joint names")?.map(|item| tree::name(&item)).collect();
    let names = names?;
    let positions = joints.required("position", "a number for each name")?;
    let values = tree::all_numbers(&positions, "a number for each name")?;
    if values.len() != names.len() {
        let found = format!("{} numbers", values.len());
        return Err(positions.found(found, format!("{}, one for each name", names.len())));
    }
    let list = root.required("goal_constraints", "an array of goals")?;
    let mut goals = Vec::new();
    for item in list.items("an array of goals")? {
        let joints = item.required("joint_constraints", "an array of joint constraints")?;
        let goal: Result<Vec<_>, _> = joints
            .items("an array of joint constraints")?
            .map(|joint| {
                let name = tree::name(&joint.required("joint_name", "a joint's name")?)?;
                Ok((name, joint.required("position", "a number")?.number()?))
            })
            .collect();
        let goal = goal?;
        if goal.is_empty() {
            return Err(joints.wrong("at least one joint: goals as poses are not read yet"));
        }
        goals.push(goal);
    }
    if goals.is_empty() {
        return Err(list.wrong("at least one goal"));
    }
    Ok(Request { group, start: names.into_iter().zip(values).collect(), goals })
}
