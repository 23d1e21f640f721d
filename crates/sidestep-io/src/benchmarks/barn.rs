//! The worlds of the BARN navigation benchmark: corridors of 4.5 m x 9.6 m with upright cylinders.
//!
//! Source: D. Perille, A. Truong, X. Xiao, P. Stone, "Benchmarking Metric Ground Navigation", SSRR 2020,
//! DOI 10.1109/SSRR50563.2020.9292572. The file gathers the worlds as one JSON document:
//! `{"start": [x, y], "goal": [x, y], "worlds": {"0": [[x, y, radius], ...], ...}}`, all in metres.
//!
//! The side walls are rows of touching cylinders, so a point can slip between two of them where a
//! robot cannot; the bounds reach [`MARGIN`] past everything that the robot could touch.

use std::sync::Arc;

use sidestep::plane::geometry::{Circle, Rect};
use sidestep::{Obstacle, Robot, Task, World};

use crate::error::{FormatError, Place};
use crate::json::{Json, Node, Source, parse};

const FORMAT: &str = "BARN worlds";

/// Free space between the outermost obstacle, start or goal disc and the bounds, in metres.
pub const MARGIN: f64 = 0.5;

/// Radius in metres of the disc around the benchmark's robot, a Clearpath Jackal of 0.508 m x
/// 0.430 m, whatever its heading.
pub const JACKAL_RADIUS: f64 = 0.333;

/// Whether a JSON text looks like these worlds rather than like a task.
pub fn is_barn(text: &str) -> bool {
    let Ok(Json::Object(fields)) = parse(FORMAT, text, 1) else { return false };
    let has = |name: &str| fields.iter().any(|(key, _)| key == name);
    has("worlds") && !has("format")
}

/// All worlds of the file as tasks `barn/0`, `barn/2`, ... in the order of their numbers.
///
/// # Errors
/// If the document or the radius (in metres, at least 0) is not as described.
pub fn read(text: &str, robot_radius: f64) -> Result<Vec<Task>, FormatError> {
    let robot = Robot::disc(robot_radius).map_err(|invalid| {
        FormatError::new(FORMAT, Place::field(invalid.field), invalid.value, invalid.allowed)
    })?;
    let json = parse(FORMAT, text, 1)?;
    let root = Node::root(Source { format: FORMAT, text, first_line: 1 }, &json);
    let start = root.required("start", "a point [x, y]")?;
    let goal = root.required("goal", "a point [x, y]")?;
    let worlds = root.required("worlds", "an object of worlds by number")?;
    let Json::Object(fields) = worlds.value() else {
        return Err(worlds.wrong("an object of worlds by number"));
    };
    let mut tasks = Vec::with_capacity(fields.len());
    for (key, _) in fields {
        let world = worlds.required(key, "a world")?;
        let number: u32 = key.parse().map_err(|_| world.found(key, "a world's number"))?;
        let mut obstacles = Vec::new();
        for item in world.items("an array of cylinders [x, y, radius]")? {
            obstacles.push(cylinder(&item)?);
        }
        let (start, goal) = (start.point()?, goal.point()?);
        let mut bounds = Rect { min: start, max: start };
        let ends = [start, goal].map(|p| Rect { min: p, max: p }.inflated(robot_radius));
        let boxes = obstacles.iter().map(Obstacle::bounding_box);
        for shape in boxes.chain(ends) {
            for axis in 0..2 {
                bounds.min[axis] = bounds.min[axis].min(shape.min[axis]);
                bounds.max[axis] = bounds.max[axis].max(shape.max[axis]);
            }
        }
        let bounds = bounds.inflated(MARGIN);
        let bounds = Rect::new(bounds.min, bounds.max)
            .map_err(|invalid| world.found(invalid.value, invalid.allowed))?;
        let world_value = Arc::new(World::new(bounds, obstacles, None));
        let task = Task::in_plane(format!("barn/{number}"), world_value, robot, start, goal)
            .map_err(|invalid| root.refused(&format!(".{}", invalid.field), invalid))?;
        tasks.push((number, task));
    }
    tasks.sort_by_key(|&(number, _)| number);
    Ok(tasks.into_iter().map(|(_, task)| task).collect())
}

fn cylinder(node: &Node<'_>) -> Result<Obstacle, FormatError> {
    const EXPECTED: &str = "a cylinder [x, y, radius]";
    let numbers: Vec<f64> = {
        let items = node.items(EXPECTED)?;
        items.map(|item| item.number()).collect::<Result<_, _>>()?
    };
    let &[x, y, radius] = numbers.as_slice() else {
        return Err(node.wrong(EXPECTED));
    };
    let circle = Circle::new([x, y], radius);
    circle.map(Obstacle::Circle).map_err(|invalid| node.found(invalid.value, invalid.allowed))
}
