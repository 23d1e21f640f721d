//! The worlds of the BARN navigation benchmark: corridors of 4.5 m x 9.6 m with upright cylinders.
//!
//! Source: D. Perille, A. Truong, X. Xiao, P. Stone, "Benchmarking Metric Ground Navigation", SSRR 2020,
//! DOI 10.1109/SSRR50563.2020.9292572. The file gathers the worlds as one JSON document:
//! `{"start": [x, y], "goal": [x, y], "worlds": {"0": [[x, y, radius], ...], ...}}`, all in metres.
//!
//! The worlds lie on an open plane, which task bounds cannot be. Here they reach so far that the robot can
//! go round everything: nothing is unsolvable, and no way longer, because of them (`room`). The side
//! walls are rows of touching cylinders, so a point can slip between two of them where a robot cannot.

use std::sync::Arc;

use sidestep::error::MAX_COORDINATE;
use sidestep::plane::geometry::{Circle, Point, Rect};
use sidestep::{Obstacle, Robot, Task, World};

use crate::error::{FormatError, Place, quoted};
use crate::input::without_mark;
use crate::json::{Json, Node, Source, parse};

const FORMAT: &str = "BARN worlds";

/// Free space between the robot on its way round everything and the bounds, in metres.
const SPACE: f64 = 0.5;

/// Radius in metres of the disc around the benchmark's robot, a Clearpath Jackal of 0.508 m x
/// 0.430 m, whatever its heading.
pub const JACKAL_RADIUS: f64 = 0.333;

/// Whether a JSON text looks like these worlds rather than like a task.
pub fn is_barn(text: &str) -> bool {
    // Most files need no second reading.
    if !text.contains("\"worlds\"") {
        return false;
    }
    let Ok(Json::Object(fields)) = parse(FORMAT, without_mark(text), 1) else { return false };
    let has = |name: &str| fields.iter().any(|(key, _)| key == name);
    has("worlds") && !has("format")
}

/// What is asked of the robot in every world.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Question {
    /// The robot's radius in metres, at least 0.
    pub robot_radius: f64,
    /// A distance that will be kept from obstacles beside that, for which the bounds leave room.
    pub clearance: f64,
    /// Start in place of the file's.
    pub start: Option<Point>,
    /// Goal in place of the file's.
    pub goal: Option<Point>,
}

/// All worlds of the file as tasks `barn/0`, `barn/2`, ... in the order of their numbers.
///
/// # Errors
/// If the document or the radius is not as described.
pub fn read(text: &str, question: &Question) -> Result<Vec<Task>, FormatError> {
    let robot = Robot::disc(question.robot_radius).map_err(|invalid| {
        FormatError::new(FORMAT, Place::field(invalid.field), invalid.value, invalid.allowed)
    })?;
    let text = without_mark(text);
    let json = parse(FORMAT, text, 1)?;
    let root = Node::root(Source { format: FORMAT, text, first_line: 1 }, &json);
    let end = |key| root.required(key, "a point [x, y]").and_then(|node| node.point());
    let (start, goal) = (end("start")?, end("goal")?);
    let (start, goal) = (question.start.unwrap_or(start), question.goal.unwrap_or(goal));
    // What is no distance is refused where it is kept.
    let clearance =
        if question.clearance > 0.0 { question.clearance.min(MAX_COORDINATE) } else { 0.0 };
    let worlds = root.required("worlds", "an object of worlds by number")?;
    let mut tasks = Vec::new();
    for (key, world) in worlds.fields("an object of worlds by number")? {
        let number: u32 = key.parse().map_err(|_| world.found(quoted(key), "a world's number"))?;
        let mut obstacles = Vec::new();
        for item in world.items("an array of cylinders [x, y, radius]")? {
            obstacles.push(cylinder(&item)?);
        }
        let room = room(&obstacles, [start, goal], robot.radius() + clearance);
        let bounds = Rect::new(room.min, room.max)
            .map_err(|invalid| world.found(invalid.value, invalid.allowed))?;
        let world_value = Arc::new(World::new(bounds, obstacles, None));
        let task = Task::in_plane(format!("barn/{number}"), world_value, robot, start, goal)
            .map_err(|invalid| root.refused(&format!(".{}", invalid.field), invalid))?;
        tasks.push((number, task));
    }
    if tasks.is_empty() {
        return Err(worlds.found("no world", "at least one world"));
    }
    tasks.sort_by_key(|&(number, _)| number);
    Ok(tasks.into_iter().map(|(_, task)| task).collect())
}

/// Bounds that cost a robot of this radius nothing: a shortest way lies in the convex hull of the ends
/// and of the obstacles grown by the radius, and its body in that grown by the radius again.
fn room(obstacles: &[Obstacle], ends: [Point; 2], radius: f64) -> Rect {
    let mut room = Rect { min: ends[0], max: ends[0] };
    let ends = ends.map(|p| Rect { min: p, max: p }.inflated(radius));
    let around = obstacles.iter().map(|shape| shape.bounding_box().inflated(2.0 * radius));
    for shape in around.chain(ends) {
        for axis in 0..2 {
            room.min[axis] = room.min[axis].min(shape.min[axis]);
            room.max[axis] = room.max[axis].max(shape.max[axis]);
        }
    }
    room.inflated(SPACE)
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
