//! Task JSON to tasks.

use std::sync::Arc;

use sidestep::plane::geometry::{Circle, ConvexPolygon, Rect};
use sidestep::{Grid, Obstacle, Robot, Task, World};

use super::{FORMAT, TASK_FORMAT, TaskFormat, rows};
use crate::error::{FormatError, Place};
use crate::input::without_mark;
use crate::json::{Json, Node, Source, parse};
use crate::most_cells;

const TASK_FIELDS: [&str; 8] =
    ["format", "name", "bounds", "obstacles", "grid", "robot", "start", "goal"];
const SHAPES: [&str; 3] = ["rect", "circle", "polygon"];
const RECT: &str = "[[x0, y0], [x1, y1]] with x0 < x1 and y0 < y1";
const POLYGON: &str = "an array of at least 3 points [x, y]";

/// The tasks of a file's text, at least one.
///
/// # Errors
/// The first fault, with its line, column, field, value and what is allowed.
pub fn read_tasks(text: &str, format: TaskFormat) -> Result<Vec<Task>, FormatError> {
    let text = without_mark(text);
    let mut tasks = Vec::new();
    match format {
        TaskFormat::Json => read_document(text, 1, &mut tasks)?,
        TaskFormat::JsonLines => {
            for (index, line) in text.lines().enumerate() {
                if !line.trim().is_empty() {
                    let json = parse(FORMAT, line, index + 1)?;
                    let source = Source { format: FORMAT, text: line, first_line: index + 1 };
                    tasks.push(read_task(&Node::root(source, &json))?);
                }
            }
        }
    }
    if tasks.is_empty() {
        return Err(FormatError::new(FORMAT, Place::default(), "no task", "at least one task"));
    }
    Ok(tasks)
}

fn read_document(text: &str, first_line: usize, tasks: &mut Vec<Task>) -> Result<(), FormatError> {
    let json = parse(FORMAT, text, first_line)?;
    let root = Node::root(Source { format: FORMAT, text, first_line }, &json);
    if matches!(json, Json::Array(_)) {
        for item in root.items("an array of tasks")? {
            tasks.push(read_task(&item)?);
        }
    } else {
        tasks.push(read_task(&root)?);
    }
    Ok(())
}

fn read_task(node: &Node<'_>) -> Result<Task, FormatError> {
    node.object(&TASK_FIELDS)?;
    let format = node.required("format", "\"sidestep.task/1\"")?;
    if format.string()? != TASK_FORMAT {
        return Err(format.wrong(format!("{TASK_FORMAT:?}, the one version this program reads")));
    }
    let name = match node.optional("name") {
        Some(name) => name.string()?.to_owned(),
        None => String::new(),
    };
    let bounds = read_rect(&node.required("bounds", RECT)?)?;
    let mut obstacles = Vec::new();
    if let Some(list) = node.optional("obstacles") {
        for item in list.items("an array of obstacles")? {
            obstacles.push(read_obstacle(&item)?);
        }
    }
    let grid = match node.optional("grid") {
        Some(grid) if *grid.value() != Json::Null => Some(read_grid(&grid)?),
        _ => None,
    };
    let robot = match node.optional("robot") {
        Some(robot) => read_robot(&robot)?,
        None => Robot::Point,
    };
    let point = |key| node.required(key, "a point [x, y]").and_then(|node| node.point());
    let (start, goal) = (point("start")?, point("goal")?);
    let world = Arc::new(World::new(bounds, obstacles, grid));
    Task::in_plane(name, world, robot, start, goal).map_err(|invalid| {
        let field = format!(".{}", invalid.field);
        node.refused(&field, invalid)
    })
}

fn read_rect(node: &Node<'_>) -> Result<Rect, FormatError> {
    let [min, max] = node.pair(RECT)?;
    Rect::new(min.point()?, max.point()?).map_err(|mut invalid| {
        let in_json = |text: &str| text.replace("min", "[0]").replace("max", "[1]");
        let field = in_json(&invalid.field);
        invalid.allowed = invalid.allowed.replace("than min", "than [0]");
        node.refused(&field, invalid)
    })
}

fn read_obstacle(node: &Node<'_>) -> Result<Obstacle, FormatError> {
    let (shape, value) = node.only_field(&SHAPES)?;
    match shape {
        "rect" => Ok(Obstacle::Rect(read_rect(&value)?)),
        "circle" => {
            value.object(&["center", "radius"])?;
            let center = value.required("center", "a point [x, y]")?.point()?;
            let radius = value.required("radius", "a number above 0")?.number()?;
            let circle = Circle::new(center, radius);
            circle.map(Obstacle::Circle).map_err(|invalid| {
                let field = format!(".{}", invalid.field);
                value.refused(&field, invalid)
            })
        }
        _ => {
            let vertices: Result<Vec<_>, _> =
                value.items(POLYGON)?.map(|vertex| vertex.point()).collect();
            let polygon = ConvexPolygon::new(vertices?);
            polygon.map(Obstacle::Polygon).map_err(|invalid| {
                let field = invalid.field.replacen("polygon", "", 1);
                value.refused(&field, invalid)
            })
        }
    }
}

fn read_robot(node: &Node<'_>) -> Result<Robot, FormatError> {
    const ROBOT: &str = "\"point\" or {\"disc\": {\"radius\": r}}";
    match node.value() {
        Json::String(name) if name == "point" => Ok(Robot::Point),
        Json::Object(_) => {
            let (_, disc) = node.only_field(&["disc"])?;
            disc.object(&["radius"])?;
            let radius = disc.required("radius", "a number of at least 0")?.number()?;
            Robot::disc(radius).map_err(|invalid| disc.refused(".radius", invalid))
        }
        _ => Err(node.wrong(ROBOT)),
    }
}

fn read_grid(node: &Node<'_>) -> Result<Grid, FormatError> {
    node.object(&["resolution", "origin", "rows"])?;
    let resolution = node.required("resolution", "the side of a cell, above 0")?.number()?;
    let origin = match node.optional("origin") {
        Some(origin) => origin.point()?,
        None => [0.0, 0.0],
    };
    let list = node.required("rows", "an array of strings, the top row first")?;
    // All widths are checked before any cell is allocated.
    let mut texts = Vec::new();
    let (mut width, mut bytes) = (0, 0);
    for item in list.items("an array of strings, the top row first")? {
        let text = item.string()?;
        let cells = rows::width(text).map_err(|(found, expected)| item.found(found, expected))?;
        if texts.is_empty() {
            width = cells;
        } else if cells != width {
            return Err(item.found(
                format!("a row of {cells} cells"),
                format!("{width} cells, as the first row has"),
            ));
        }
        texts.push(text);
        bytes += text.len();
        let most = most_cells(bytes);
        if texts.len() > most / width {
            return Err(list.found(
                format!("more than {} rows of {width} cells in {bytes} bytes", texts.len() - 1),
                format!("at most {most} cells"),
            ));
        }
    }
    if texts.is_empty() {
        return Err(list.found("no row", "at least one row"));
    }
    let mut cells = Vec::with_capacity(width * texts.len());
    for text in texts.iter().rev() {
        rows::append(text, &mut cells);
    }
    Grid::new(width, texts.len(), resolution, origin, cells).map_err(|invalid| {
        let field = invalid.field.replacen("grid", "", 1);
        node.refused(&field, invalid)
    })
}
