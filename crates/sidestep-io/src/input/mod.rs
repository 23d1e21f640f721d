//! Tasks, or a map to ask about, from the bytes of whatever file a person has.
//!
//! What kind of file it is follows from its name, or where that says nothing (standard input) from its
//! first bytes; [`Format`] can also be given. Files that a file names (a map's image, a scenario's map)
//! are loaded by a function of the caller's.

mod format;
mod text;

use std::io;
use std::sync::Arc;

use sidestep::plane::geometry::Point;
use sidestep::{InvalidInput, PlaneTask, Robot, Task, World};

use crate::benchmarks::barn;
use crate::benchmarks::mpnet::Simple2d;
use crate::drawing::{Drawing, DrawingError};
use crate::error::{FormatError, Place, plain_or_quoted, quoted};
use crate::ros_map::{self, Unknown};
use crate::scenes::{Problem, read_problems};
use crate::task_json::{TaskFormat, read_tasks};
use crate::{grid_world, movingai};

pub use format::Format;
pub use text::decode;
pub(crate) use text::without_mark;

/// Most bytes of a file that is read whole. Reading takes up to some 40 bytes of memory a byte of JSON, 4
/// a pixel of a raw image, and for a grid what its cells take (see [`sidestep::plane::world::MAX_GRID_CELLS`]).
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// What is asked beside the file.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Question {
    /// A disc robot of this radius in place of the file's.
    pub robot_radius: Option<f64>,
    /// Start in place of the file's.
    pub start: Option<Point>,
    /// Goal in place of the file's.
    pub goal: Option<Point>,
    /// A distance that will be kept beside the radius; worlds without bounds get room for it.
    pub clearance: f64,
    /// What unknown cells of a ROS map count as.
    pub unknown: Unknown,
    /// How a picture's pixels become obstacles.
    pub drawing: Drawing,
    /// Draws what the file leaves open.
    pub seed: u64,
    /// The kind of file, where its name and bytes should not decide.
    pub format: Option<Format>,
}

impl Question {
    /// The task with the question's robot and ends.
    ///
    /// # Errors
    /// If the robot, the start or the goal is not allowed.
    pub fn asked(&self, task: &PlaneTask) -> Result<Task, InvalidInput> {
        let robot = self.robot_radius.map_or(Ok(task.robot), Robot::disc)?;
        let (start, goal) = (self.start.unwrap_or(task.start), self.goal.unwrap_or(task.goal));
        Task::in_plane(task.name, task.world.clone(), robot, start, goal)
    }
}

/// What a file holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// Tasks, at least one, with the question's robot and ends.
    Tasks(Vec<Task>),
    /// A map, which has no start and goal of its own.
    Map(Arc<World>),
    /// What a robot with joints is asked, at least one; the robot has files of its own.
    Problems(Vec<Problem>),
}

/// A file as it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// The tasks or the map.
    pub content: Content,
    /// What a person should know about how it was read, a sentence each.
    pub warnings: Vec<String>,
}

/// Why a file gives no tasks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InputError {
    /// The file is not what its format allows.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The question asks for what is not allowed.
    #[error(transparent)]
    Question(#[from] InvalidInput),
}

/// Loads the file of a name that stands in another file, relative to that file unless it is absolute.
pub type Load<'a> = &'a mut dyn FnMut(&str) -> io::Result<Vec<u8>>;

/// Reads a file called `name` (a path or `-`) with these bytes.
///
/// # Errors
/// If the kind of file is not known, the file or one that it names is not what its format allows, or the
/// question's robot, start or goal is not allowed.
pub fn read(
    name: &str,
    bytes: &[u8],
    question: &Question,
    load: Load,
) -> Result<Input, InputError> {
    let robot = Robot::disc(question.robot_radius.unwrap_or(0.0))?;
    let format = match question.format {
        Some(format) => format,
        None => Format::of(name, bytes)?,
    };
    let mut warnings = Vec::new();
    let text = |what| decode(what, bytes);
    let mut tasks = match format {
        Format::Json | Format::JsonLines => {
            let lines = format == Format::JsonLines;
            let kind = if lines { TaskFormat::JsonLines } else { TaskFormat::Json };
            read_tasks(&text("task JSON")?, kind)?
        }
        Format::Barn => {
            let question = barn::Question {
                robot_radius: question.robot_radius.unwrap_or(barn::JACKAL_RADIUS),
                clearance: question.clearance,
                start: question.start,
                goal: question.goal,
            };
            barn::read(&text("BARN worlds")?, &question)?
        }
        Format::MovingAiScen => scenario(&text("MovingAI scen")?, robot, load)?,
        Format::Mpnet => mpnet(name, bytes, robot, question.seed, load)?,
        Format::Problems => {
            let problems = read_problems(text("problems JSON")?.as_bytes(), load)?;
            return Ok(Input { content: Content::Problems(problems), warnings });
        }
        Format::MovingAiMap => {
            let world = grid_world(movingai::read_map(bytes)?);
            return Ok(Input { content: Content::Map(world), warnings });
        }
        Format::Picture => {
            let grid = question.drawing.read(bytes).map_err(|error| match error {
                DrawingError::Format(error) => InputError::Format(error),
                DrawingError::Setting(error) => InputError::Question(error),
            })?;
            return Ok(Input { content: Content::Map(grid_world(grid)), warnings });
        }
        Format::RosMap => {
            let map = ros_map::read(&text("ROS map YAML")?, question.unknown, load)?;
            warnings.extend(map.warnings);
            return Ok(Input { content: Content::Map(grid_world(map.grid)), warnings });
        }
    };
    for task in &mut tasks {
        *task = question.asked(&task.plane()?)?;
    }
    if tasks.is_empty() {
        let found = FormatError::new(format.title(), Place::default(), "no task", "at least one");
        return Err(found.into());
    }
    Ok(Input { content: Content::Tasks(tasks), warnings })
}

/// The queries of a scenario, each map loaded once.
fn scenario(text: &str, robot: Robot, load: Load) -> Result<Vec<Task>, FormatError> {
    let queries = movingai::read_scen(text)?;
    let mut worlds: Vec<(String, Arc<World>)> = Vec::new();
    let mut tasks = Vec::with_capacity(queries.len());
    for query in &queries {
        let name = query.map_file_name();
        let known = worlds.iter().find(|(known, _)| known == name).map(|(_, world)| world.clone());
        let world = match known {
            Some(world) => world,
            None => {
                let bytes = companion("MovingAI scen", "map", name, load)?;
                let map = movingai::read_map(&bytes);
                let world = grid_world(map.map_err(|error| inside(name, error))?);
                worlds.push((name.to_string(), world.clone()));
                world
            }
        };
        tasks.push(query.task(&world, robot)?);
    }
    Ok(tasks)
}

/// An error of a file that another file names.
fn inside(name: &str, mut error: FormatError) -> FormatError {
    let file = plain_or_quoted(name);
    let path = std::mem::take(&mut error.place.path);
    error.place.path = if path.is_empty() { file } else { format!("{path} of {file}") };
    error
}

/// MPNet's Simple2D: the worlds' file, with the blocks' file `obs.dat` beside it.
fn mpnet(
    name: &str,
    bytes: &[u8],
    robot: Robot,
    seed: u64,
    load: Load,
) -> Result<Vec<Task>, FormatError> {
    const BLOCKS: &str = "obs.dat";
    if name.rsplit(['/', '\\']).next() == Some(BLOCKS) {
        let found = "MPNet's blocks only";
        let expected = "the worlds' file, obs_perm2.dat, beside it";
        return Err(FormatError::new("MPNet Simple2D", Place::default(), found, expected));
    }
    let blocks = companion("MPNet Simple2D", "blocks", BLOCKS, load)?;
    let worlds = Simple2d::read(&blocks, bytes)?;
    (0..worlds.len()).map(|index| worlds.task(index, robot, seed)).collect()
}

fn companion(
    format: &'static str,
    field: &str,
    name: &str,
    load: Load,
) -> Result<Vec<u8>, FormatError> {
    load(name).map_err(|error| {
        let found = format!("{}, which cannot be read ({error})", quoted(name));
        FormatError::new(format, Place::field(field), found, "a file beside it")
    })
}
