//! Tasks from whatever file a person has.

use std::path::Path;
use std::sync::Arc;

use sidestep::geometry::Point;
use sidestep::{Robot, Task, World};
use sidestep_io::{TaskFormat, grid_world, movingai, read_tasks, ros_map};

use crate::failure::Failure;

/// What a command line says about the task beside the file.
#[derive(Debug, Clone, Default)]
pub struct Overrides {
    /// Start in place of the file's.
    pub start: Option<Point>,
    /// Goal in place of the file's.
    pub goal: Option<Point>,
    /// A disc of this radius in place of the file's robot.
    pub robot_radius: Option<f64>,
    /// Treat unknown cells of a ROS map as free.
    pub unknown_is_free: bool,
}

/// Reads the tasks of a file: task `.json` or `.jsonl`, MovingAI `.map` or `.scen`, or a ROS map
/// `.yaml`. A map alone is one task, whose start and goal come from the command line.
pub fn read(path: &Path, overrides: &Overrides) -> Result<Vec<Task>, Failure> {
    let robot = Robot::disc(overrides.robot_radius.unwrap_or(0.0))?;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    let mut tasks = match extension.as_str() {
        "json" | "jsonl" | "ndjson" => read_task_file(path)?,
        "scen" => read_scenario(path, robot)?,
        "map" => vec![map_task(path, movingai_world(path)?, robot, overrides)?],
        "yaml" | "yml" => vec![map_task(path, ros_world(path, overrides)?, robot, overrides)?],
        _ => {
            let known = "a name that ends in .json, .jsonl, .map, .scen, .yaml or .yml";
            return Err(Failure::file(path, format!("unknown kind of file; expected {known}")));
        }
    };
    for task in &mut tasks {
        if overrides.robot_radius.is_some() {
            task.robot = robot;
        }
        let start = overrides.start.unwrap_or(task.start);
        let goal = overrides.goal.unwrap_or(task.goal);
        *task = Task::new(task.name.clone(), task.world.clone(), task.robot, start, goal)?;
    }
    if tasks.is_empty() {
        return Err(Failure::file(path, "holds no task"));
    }
    Ok(tasks)
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(|error| Failure::file(path, format!("cannot be read ({error})")))
}

/// The text of a file.
pub fn read_text(path: &Path) -> Result<String, Failure> {
    String::from_utf8(read_bytes(path)?)
        .map_err(|error| Failure::file(path, format!("is not UTF-8 text ({error})")))
}

fn read_task_file(path: &Path) -> Result<Vec<Task>, Failure> {
    let name = path.to_string_lossy();
    let format = TaskFormat::from_file_name(&name)
        .ok_or_else(|| Failure::file(path, "unknown kind of task file"))?;
    read_tasks(&read_text(path)?, format).map_err(|error| Failure::file(path, error))
}

fn movingai_world(path: &Path) -> Result<Arc<World>, Failure> {
    let grid =
        movingai::read_map(&read_bytes(path)?).map_err(|error| Failure::file(path, error))?;
    Ok(grid_world(grid))
}

fn read_scenario(path: &Path, robot: Robot) -> Result<Vec<Task>, Failure> {
    let queries =
        movingai::read_scen(&read_text(path)?).map_err(|error| Failure::file(path, error))?;
    let mut worlds: Vec<(String, Arc<World>)> = Vec::new();
    let mut tasks = Vec::with_capacity(queries.len());
    for query in &queries {
        let name = query.map_file_name();
        let known = worlds.iter().find(|(known, _)| known == name).map(|(_, world)| world.clone());
        let world = match known {
            Some(world) => world,
            None => {
                let world = movingai_world(&path.with_file_name(name))?;
                worlds.push((name.to_string(), world.clone()));
                world
            }
        };
        tasks.push(query.task(&world, robot).map_err(|error| Failure::file(path, error))?);
    }
    Ok(tasks)
}

fn ros_world(path: &Path, overrides: &Overrides) -> Result<Arc<World>, Failure> {
    let unknown =
        if overrides.unknown_is_free { ros_map::Unknown::Free } else { ros_map::Unknown::Occupied };
    let load = |image: &str| std::fs::read(path.parent().unwrap_or(Path::new("")).join(image));
    let grid = ros_map::read(&read_text(path)?, unknown, load)
        .map_err(|error| Failure::file(path, error))?;
    Ok(grid_world(grid))
}

fn map_task(
    path: &Path,
    world: Arc<World>,
    robot: Robot,
    overrides: &Overrides,
) -> Result<Task, Failure> {
    let (Some(start), Some(goal)) = (overrides.start, overrides.goal) else {
        let bounds = world.bounds();
        let range = format!("{:?} to {:?}", bounds.min, bounds.max);
        let need = "a map has no start and goal: give --start X,Y and --goal X,Y";
        return Err(Failure::file(path, format!("{need} within {range}")));
    };
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    Ok(Task::new(name, world, robot, start, goal)?)
}

/// Parses `X,Y`.
pub fn parse_point(text: &str) -> Result<Point, String> {
    let number = |part: &str| {
        let value: f64 = part.trim().parse().map_err(|_| format!("`{part}` is not a number"))?;
        if value.is_finite() { Ok(value) } else { Err(format!("`{part}` is not finite")) }
    };
    let (x, y) = text.split_once(',').ok_or("expected X,Y")?;
    Ok([number(x)?, number(y)?])
}
