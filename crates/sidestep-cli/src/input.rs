//! Tasks from whatever file a person has.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use clap::Args;
use sidestep::plane::geometry::Point;
use sidestep::suite::queries::random_queries;
use sidestep::{Robot, Task, World};
use sidestep_io::benchmarks::{barn, mpnet::Simple2d};
use sidestep_io::{TaskFormat, grid_world, movingai, read_tasks, ros_map};

use crate::failure::Failure;

/// What a command line says about tasks beside their file.
#[derive(Args, Debug, Clone, Default)]
pub struct InputArgs {
    /// A disc robot of this radius in place of the file's, in task units [default for BARN worlds:
    /// 0.333, the disc around a Clearpath Jackal]
    #[arg(long, alias = "radius", allow_negative_numbers = true)]
    robot_radius: Option<f64>,
    /// Treat unknown cells of a ROS map as free
    #[arg(long)]
    unknown_is_free: bool,
    /// Ask a map alone this many questions, start and goal drawn by --seed where the robot may stand
    #[arg(long, value_name = "N")]
    random_queries: Option<usize>,
    /// Every file that was read for the tasks, such as a map's image.
    #[arg(skip)]
    files: Arc<Mutex<Vec<PathBuf>>>,
}

impl InputArgs {
    /// Every file that was read for the tasks so far: outputs must not replace them.
    pub fn files(&self) -> Vec<PathBuf> {
        self.files.lock().map_or_else(|_| Vec::new(), |files| files.clone())
    }

    /// Reads a file, and remembers that it was.
    fn load(&self, path: &Path) -> std::io::Result<Vec<u8>> {
        if let Ok(mut files) = self.files.lock() {
            files.push(path.into());
        }
        std::fs::read(path)
    }

    fn bytes(&self, path: &Path) -> Result<Vec<u8>, Failure> {
        self.load(path).map_err(|error| unreadable(path, &error))
    }

    fn text(&self, path: &Path) -> Result<String, Failure> {
        as_text(path, self.bytes(path)?)
    }
}

/// Most random queries of one file.
const MOST_QUERIES: usize = 1_000_000;

/// Reads the tasks of a file: task `.json` or `.jsonl`, BARN worlds `.json`, MovingAI `.map` or
/// `.scen`, a ROS map `.yaml`, or MPNet worlds `.dat`. A map alone is one task, whose start and goal
/// come from the command line, or random queries. `seed` draws what the file leaves open.
pub fn read(
    path: &Path,
    args: &InputArgs,
    ends: (Option<Point>, Option<Point>),
    seed: u64,
) -> Result<Vec<Task>, Failure> {
    let robot = Robot::disc(args.robot_radius.unwrap_or(0.0))?;
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    let map = |world| map_tasks(path, world, robot, args, ends, seed);
    let mut tasks = match extension.as_str() {
        "json" | "jsonl" | "ndjson" => read_json(path, args)?,
        "scen" => read_scenario(path, args, robot)?,
        "map" => map(movingai_world(path, args)?)?,
        "yaml" | "yml" => map(ros_world(path, args)?)?,
        "dat" => read_mpnet(path, args, robot, seed)?,
        _ => {
            let known = "a name that ends in .json, .jsonl, .map, .scen, .yaml, .yml or .dat";
            return Err(Failure::file(path, format!("unknown kind of file; expected {known}")));
        }
    };
    if args.random_queries.is_some() && !matches!(extension.as_str(), "map" | "yaml" | "yml") {
        let only = "--random-queries: only a map (.map, .yaml) has none of its own";
        return Err(Failure::file(path, only));
    }
    for task in &mut tasks {
        let plane = task.plane()?;
        let robot = if args.robot_radius.is_some() { robot } else { plane.robot };
        let (start, goal) = (ends.0.unwrap_or(plane.start), ends.1.unwrap_or(plane.goal));
        *task = Task::in_plane(plane.name, plane.world.clone(), robot, start, goal)?;
    }
    if tasks.is_empty() {
        return Err(Failure::file(path, "holds no task"));
    }
    Ok(tasks)
}

fn unreadable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::file(path, format!("cannot be read ({error})"))
}

fn as_text(path: &Path, bytes: Vec<u8>) -> Result<String, Failure> {
    String::from_utf8(bytes)
        .map_err(|error| Failure::file(path, format!("is not UTF-8 text ({error})")))
}

/// The text of a file.
pub fn read_text(path: &Path) -> Result<String, Failure> {
    as_text(path, std::fs::read(path).map_err(|error| unreadable(path, &error))?)
}

/// Tasks in our own format, or BARN worlds.
fn read_json(path: &Path, args: &InputArgs) -> Result<Vec<Task>, Failure> {
    let text = args.text(path)?;
    if barn::is_barn(&text) {
        let radius = args.robot_radius.unwrap_or(barn::JACKAL_RADIUS);
        return barn::read(&text, radius).map_err(|error| Failure::file(path, error));
    }
    let format = TaskFormat::from_file_name(&path.to_string_lossy())
        .ok_or_else(|| Failure::file(path, "unknown kind of task file"))?;
    read_tasks(&text, format).map_err(|error| Failure::file(path, error))
}

/// MPNet's Simple2D: the worlds' file, with the blocks' file `obs.dat` beside it.
fn read_mpnet(
    path: &Path,
    args: &InputArgs,
    robot: Robot,
    seed: u64,
) -> Result<Vec<Task>, Failure> {
    let blocks = path.with_file_name("obs.dat");
    if path == blocks {
        let need = "holds MPNet's blocks only; give the worlds' file, obs_perm2.dat, beside it";
        return Err(Failure::file(path, need));
    }
    let worlds = Simple2d::read(&args.bytes(&blocks)?, &args.bytes(path)?)
        .map_err(|error| Failure::file(path, error))?;
    let task = |index| worlds.task(index, robot, seed).map_err(|error| Failure::file(path, error));
    (0..worlds.len()).map(task).collect()
}

fn movingai_world(path: &Path, args: &InputArgs) -> Result<Arc<World>, Failure> {
    let grid =
        movingai::read_map(&args.bytes(path)?).map_err(|error| Failure::file(path, error))?;
    Ok(grid_world(grid))
}

fn read_scenario(path: &Path, args: &InputArgs, robot: Robot) -> Result<Vec<Task>, Failure> {
    let queries =
        movingai::read_scen(&args.text(path)?).map_err(|error| Failure::file(path, error))?;
    let mut worlds: Vec<(String, Arc<World>)> = Vec::new();
    let mut tasks = Vec::with_capacity(queries.len());
    for query in &queries {
        let name = query.map_file_name();
        let known = worlds.iter().find(|(known, _)| known == name).map(|(_, world)| world.clone());
        let world = match known {
            Some(world) => world,
            None => {
                let world = movingai_world(&path.with_file_name(name), args)?;
                worlds.push((name.to_string(), world.clone()));
                world
            }
        };
        tasks.push(query.task(&world, robot).map_err(|error| Failure::file(path, error))?);
    }
    Ok(tasks)
}

fn ros_world(path: &Path, args: &InputArgs) -> Result<Arc<World>, Failure> {
    let unknown =
        if args.unknown_is_free { ros_map::Unknown::Free } else { ros_map::Unknown::Occupied };
    let load = |image: &str| args.load(&path.parent().unwrap_or(Path::new("")).join(image));
    let grid = ros_map::read(&args.text(path)?, unknown, load)
        .map_err(|error| Failure::file(path, error))?;
    Ok(grid_world(grid))
}

fn map_tasks(
    path: &Path,
    world: Arc<World>,
    robot: Robot,
    args: &InputArgs,
    ends: (Option<Point>, Option<Point>),
    seed: u64,
) -> Result<Vec<Task>, Failure> {
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    match (args.random_queries, ends) {
        (Some(count @ 1..=MOST_QUERIES), _) => {
            Ok(random_queries(&name, &world, robot, count, seed)?)
        }
        (Some(count), _) => {
            let allowed = format!("{count} is not a number from 1 to {MOST_QUERIES}");
            Err(Failure::at("--random-queries", allowed))
        }
        (None, (Some(start), Some(goal))) => {
            Ok(vec![Task::in_plane(name, world, robot, start, goal)?])
        }
        (None, _) => {
            let bounds = world.bounds();
            let range = format!("{:?} to {:?}", bounds.min, bounds.max);
            let need = "a map has no start and goal: give --start X,Y and --goal X,Y";
            let or = "or --random-queries N";
            Err(Failure::file(path, format!("{need} within {range}, {or}")))
        }
    }
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
