//! Tasks to task JSON. Numbers take the shortest form that reads back to the same f64.

use sidestep::plane::geometry::{Point, Rect};
use sidestep::{Grid, InvalidInput, Obstacle, PlaneTask, Robot, Task};

use super::{TASK_FORMAT, TaskFormat, rows};

/// One task as one line of JSON, without a line end.
///
/// # Errors
/// If the robot is not one of the plane.
pub fn write_task(task: &Task) -> Result<String, InvalidInput> {
    let mut text = String::new();
    for line in lines(task)? {
        if text.ends_with(',') {
            text.push(' ');
        }
        text += line.trim_start();
    }
    Ok(text)
}

/// Tasks as a file's text: for `Json` one object, or an array unless there is exactly one task,
/// laid out with one obstacle a line; for `JsonLines` one task a line.
///
/// # Errors
/// If a robot is not one of the plane.
pub fn write_tasks(tasks: &[Task], format: TaskFormat) -> Result<String, InvalidInput> {
    match (format, tasks) {
        (TaskFormat::JsonLines, _) => {
            tasks.iter().map(|task| Ok(write_task(task)? + "\n")).collect()
        }
        (TaskFormat::Json, [task]) => Ok(lines(task)?.join("\n") + "\n"),
        (TaskFormat::Json, _) => {
            let documents: Result<Vec<String>, InvalidInput> =
                tasks.iter().map(|task| Ok(lines(task)?.join("\n"))).collect();
            Ok(format!("[\n{}\n]\n", documents?.join(",\n")))
        }
    }
}

/// The document laid out in lines, indented.
fn lines(task: &Task) -> Result<Vec<String>, InvalidInput> {
    let PlaneTask { name, world, robot, start, goal } = task.plane()?;
    let mut lines = vec!["{".to_owned(), format!("  \"format\": {TASK_FORMAT:?},")];
    if !name.is_empty() {
        lines.push(format!("  \"name\": {},", string(name)));
    }
    lines.push(format!("  \"bounds\": {},", rect(&world.bounds())));
    list(&mut lines, "  ", "obstacles", world.obstacles().iter().map(obstacle));
    if let Some(grid) = world.grid() {
        lines.push(format!(
            "  \"grid\": {{\"resolution\": {}, \"origin\": {},",
            number(grid.resolution()),
            point(grid.origin())
        ));
        list(&mut lines, "    ", "rows", grid_rows(grid));
        if let Some(last) = lines.last_mut() {
            last.insert(last.len() - 1, '}');
        }
    }
    let robot = match robot {
        Robot::Point => "\"point\"".to_owned(),
        Robot::Disc { radius } => format!("{{\"disc\": {{\"radius\": {}}}}}", number(radius)),
    };
    lines.push(format!("  \"robot\": {robot},"));
    lines.push(format!("  \"start\": {},", point(start)));
    lines.push(format!("  \"goal\": {}", point(goal)));
    lines.push("}".to_owned());
    Ok(lines)
}

/// A field that holds an array, one item a line.
fn list(
    lines: &mut Vec<String>,
    indent: &str,
    key: &str,
    items: impl ExactSizeIterator<Item = String>,
) {
    let last = items.len();
    if last == 0 {
        lines.push(format!("{indent}{key:?}: [],"));
        return;
    }
    lines.push(format!("{indent}{key:?}: ["));
    for (i, item) in items.enumerate() {
        lines.push(format!("{indent}  {item}{}", if i + 1 < last { "," } else { "" }));
    }
    lines.push(format!("{indent}],"));
}

fn grid_rows(grid: &Grid) -> impl ExactSizeIterator<Item = String> + '_ {
    // Top row first; the core holds the bottom row first.
    let all = grid.cells().len();
    grid.cells().chunks(grid.width()).rev().map(move |row| format!("{:?}", rows::text(row, all)))
}

fn obstacle(obstacle: &Obstacle) -> String {
    match obstacle {
        Obstacle::Rect(r) => format!("{{\"rect\": {}}}", rect(r)),
        Obstacle::Circle(circle) => format!(
            "{{\"circle\": {{\"center\": {}, \"radius\": {}}}}}",
            point(circle.center),
            number(circle.radius)
        ),
        Obstacle::Polygon(polygon) => {
            let vertices: Vec<String> = polygon.vertices().iter().map(|&v| point(v)).collect();
            format!("{{\"polygon\": [{}]}}", vertices.join(", "))
        }
    }
}

fn rect(rect: &Rect) -> String {
    format!("[{}, {}]", point(rect.min), point(rect.max))
}

fn point(p: Point) -> String {
    format!("[{}, {}]", number(p[0]), number(p[1]))
}

/// The shortest decimal that reads back to `value`; `null`, which the reader refuses by name, for a
/// value that JSON has no number for.
fn number(value: f64) -> String {
    if !value.is_finite() {
        "null".to_owned()
    } else if value != 0.0 && !(1e-5..1e15).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        value.to_string()
    }
}

fn string(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
