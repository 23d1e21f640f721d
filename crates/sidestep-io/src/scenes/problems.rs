//! What a robot with joints is asked: our own JSON, and MotionBenchMaker's problems as JSON.
//!
//! ```json
//! {
//!   "format": "sidestep.problems/1",
//!   "robot": "panda.urdf",
//!   "joints": ["panda_joint1", "panda_joint2"],
//!   "fixed_joints": {"panda_finger_joint1": 0.04},
//!   "problems": [
//!     {"name": "reach", "start": [0, -0.785], "goals": [[1.2, 0.3]], "objects": []}
//!   ]
//! }
//! ```
//!
//! Radians, or metres for joints that slide. `robot` is a name or the path of a URDF; `joints`
//! names the numbers of `start` and `goals` in order; `objects` is as in a scene (`json.rs`).
//! Several goals: any of them will do. The JSON Schema is `schemas/problems-1.schema.json`.
//!
//! `sidestep-arm-problems/0` holds MotionBenchMaker's problems (C. Chamzas et al.,
//! "MotionBenchMaker", IEEE RA-L 7(2), 2022), converted: one flat list of boxes and cylinders for
//! each problem, with `set` and `index` for a name and quaternions wxyz.

use std::sync::Arc;

use sidestep::InvalidInput;
use sidestep::arm::{Arm, Model};
use sidestep::space::{Shape, World};

use super::objects::Objects;
use super::{Load, json, tree};
use crate::error::FormatError;
use crate::json::{Json, Node, parse};
use crate::robots::Srdf;

/// What `format` says in problems of this version.
pub const PROBLEM_FORMAT: &str = "sidestep.problems/1";
const CONVERTED: &str = "sidestep-arm-problems/0";
const FORMAT: &str = "problems JSON";

/// A start, goals and a world for a robot with joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// What it is called, such as `cage/12`.
    pub name: String,
    /// The robot's name or the path of its URDF, as the file says it.
    pub robot: Arc<str>,
    /// The joints of the configurations, in order; at least one.
    pub joints: Arc<[String]>,
    /// Where other joints stand: rad, or m for joints that slide.
    pub fixed_joints: Arc<[(String, f64)]>,
    /// The start, a number a joint: rad or m.
    pub start: Vec<f64>,
    /// The goals, any of which will do; at least one, each a number a joint.
    pub goals: Vec<Vec<f64>>,
    /// What is around the robot, in the frame of its base.
    pub world: Arc<World>,
}

impl Problem {
    /// The robot of a URDF and an SRDF as this problem asks for it: its joints move, others are held where
    /// it says, and links are checked against each other but for the SRDF's pairs and for those that always
    /// touch, whose names come with it. Joints and links that the URDF lacks are passed over.
    ///
    /// # Errors
    /// As [`Arm::new`].
    pub fn arm(
        &self,
        model: &Model,
        srdf: &Srdf,
    ) -> Result<(Arm, Vec<(String, String)>), InvalidInput> {
        let joints: Vec<&str> = self.joints.iter().map(String::as_str).collect();
        let held = self.fixed_joints.iter().filter(|(name, _)| model.joint(name).is_some());
        let is_known = |link: &str| model.link(link).is_some();
        let disabled = srdf.disabled_pairs.iter().filter(|(a, b)| is_known(a) && is_known(b));
        let disabled: Vec<(String, String)> = disabled.cloned().collect();
        let arm = Arm::new(model, &joints, &held.cloned().collect())?;
        Ok(arm.with_self_collisions(&disabled)?.without_lasting_contacts())
    }
}

/// The problems of a file's text, in its order; at least one.
///
/// # Errors
/// The first fault, with its line, column, field, value and what is allowed.
pub fn read_problems(bytes: &[u8], load: Load<'_>) -> Result<Vec<Problem>, FormatError> {
    let text = tree::text(FORMAT, bytes)?;
    let document = parse(FORMAT, text, 1)?;
    let root = tree::root(FORMAT, text, &document);
    let format = root.required("format", &format!("{PROBLEM_FORMAT:?}"))?;
    let converted = match format.string()? {
        PROBLEM_FORMAT => false,
        CONVERTED => true,
        _ => {
            let known = [PROBLEM_FORMAT, CONVERTED];
            let near = json::similar(format.value(), &known)
                .map(|near| format!(" (did you mean {near:?}?)"));
            let expected = format!("{:?}{}", PROBLEM_FORMAT, near.unwrap_or_default());
            return Err(format.wrong(expected));
        }
    };
    if !converted {
        root.object(&["format", "robot", "joints", "fixed_joints", "problems"])?;
    }
    let shared = Shared::read(&root)?;
    let list = root.required("problems", "an array of problems")?;
    let items = list.items("an array of problems")?;
    let mut problems = Vec::with_capacity(items.len());
    for item in items {
        problems.push(shared.problem(&item, converted, load)?);
    }
    if problems.is_empty() {
        return Err(list.wrong("at least one problem"));
    }
    Ok(problems)
}

/// Whether a text is such a file, by its first words: the format may stand behind other fields.
pub(crate) fn is_problems(text: &str) -> bool {
    let family = PROBLEM_FORMAT.rsplit_once('/').map_or(PROBLEM_FORMAT, |(family, _)| family);
    [family, "sidestep-arm-problems"].iter().any(|name| text.contains(&format!("\"{name}/")))
}

/// What all problems of a file have.
struct Shared {
    robot: Arc<str>,
    joints: Arc<[String]>,
    fixed_joints: Arc<[(String, f64)]>,
}

impl Shared {
    fn read(root: &Node<'_>) -> Result<Self, FormatError> {
        let robot = root.required("robot", "a robot's name or the path of its URDF")?.string()?;
        let list = root.required("joints", "an array of joint names")?;
        let mut joints: Vec<String> = Vec::new();
        for item in list.items("an array of joint names")? {
            let name = item.string()?;
            if joints.iter().any(|known| known == name) {
                return Err(item.wrong("each joint once"));
            }
            joints.push(name.to_owned());
        }
        if joints.is_empty() {
            return Err(list.wrong("at least one joint"));
        }
        let mut fixed_joints = Vec::new();
        if let Some(fixed) = root.optional("fixed_joints") {
            for (name, value) in tree::fields(&fixed)? {
                // MotionBenchMaker gives a list, for joints with several axes.
                let value = match value.value() {
                    Json::Array(_) => tree::numbers::<1>(&value, "one number")?[0],
                    _ => value.number()?,
                };
                fixed_joints.push((name.to_owned(), value));
            }
        }
        let (joints, fixed_joints) = (joints.into(), fixed_joints.into());
        Ok(Self { robot: robot.into(), joints, fixed_joints })
    }

    fn problem(
        &self,
        node: &Node<'_>,
        converted: bool,
        load: Load<'_>,
    ) -> Result<Problem, FormatError> {
        let (name, world) = if converted {
            node.object(&["set", "index", "start", "goals", "obstacles"])?;
            let set = node.required("set", "the name of a set")?.string()?;
            let index = node.required("index", "a number")?.number()?;
            (format!("{set}/{index}"), read_obstacles(node)?)
        } else {
            node.object(&["name", "start", "goals", "objects"])?;
            let objects = node.required("objects", "an array of objects")?;
            let name = node.required("name", "a name")?.string()?.to_owned();
            (name, json::read_objects(&objects, load)?)
        };
        let start = self.configuration(&node.required("start", "a number for each joint")?)?;
        let list = node.required("goals", "an array of configurations")?;
        let goals: Result<Vec<_>, _> = list
            .items("an array of configurations")?
            .map(|item| self.configuration(&item))
            .collect();
        let goals = goals?;
        if goals.is_empty() {
            return Err(list.wrong("at least one goal"));
        }
        Ok(Problem {
            name,
            robot: self.robot.clone(),
            joints: self.joints.clone(),
            fixed_joints: self.fixed_joints.clone(),
            start,
            goals,
            world: Arc::new(world),
        })
    }

    fn configuration(&self, node: &Node<'_>) -> Result<Vec<f64>, FormatError> {
        let count = self.joints.len();
        let expected = format!("{count} numbers, one for each of \"joints\"");
        let numbers = tree::all_numbers(node, &expected)?;
        if numbers.len() != count {
            return Err(node.found(format!("{} numbers", numbers.len()), expected));
        }
        Ok(numbers)
    }
}

fn read_obstacles(problem: &Node<'_>) -> Result<World, FormatError> {
    let list = problem.required("obstacles", "an array of obstacles")?;
    let mut objects = Objects::default();
    for item in list.items("an array of obstacles")? {
        let name = item.required("name", "a name")?.string()?.to_owned();
        let number = |key| item.required(key, "a number above 0").and_then(|node| node.number());
        let shape = item.required("shape", "box, cylinder or sphere")?;
        let made = match shape.string()? {
            "box" => {
                let half = item.required("half_extents", "three numbers above 0")?;
                Shape::cuboid(tree::vector(&half)?)
            }
            "cylinder" => Shape::cylinder(number("radius")?, number("length")?),
            "sphere" => Shape::sphere(number("radius")?),
            _ => return Err(shape.wrong("box, cylinder or sphere")),
        };
        let made = made.map_err(|invalid| tree::below(&item, invalid))?;
        let position = tree::vector(&item.required("position", "three numbers")?)?;
        let quaternion = item.required("quaternion", "a unit quaternion [w, x, y, z]")?;
        let wxyz = tree::numbers(&quaternion, "a unit quaternion [w, x, y, z]")?;
        let pose = sidestep::space::Pose::from_wxyz(wxyz, position)
            .map_err(|invalid| tree::below(&item, invalid))?;
        objects.add(name, vec![(pose, made)]);
    }
    objects.world(&list)
}
