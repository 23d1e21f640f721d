//! Tasks from whatever file a person has.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use clap::Args;
use sidestep::plane::geometry::Point;
use sidestep::suite::queries::random_queries;
use sidestep::{Robot, Task, World};
use sidestep_io::drawing::Drawing;
use sidestep_io::input::{Content, Format, Question};
use sidestep_io::ros_map::Unknown;
use sidestep_io::scenes::Problem;

use crate::failure::Failure;
use crate::robots::tasks::{self, AskedArgs};
use crate::{output, source};

pub use crate::source::text as read_text;

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
    /// Side of a picture's pixel, in task units
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, value_name = "UNITS")]
    scale: f64,
    /// How dark a picture's pixel must be to be an obstacle, from 0 (white) to 1 (black)
    #[arg(long, default_value_t = 0.5, allow_negative_numbers = true)]
    threshold: f64,
    /// What is light in a picture is an obstacle, and what is dark is free
    #[arg(long)]
    light_is_obstacle: bool,
    /// Ask a map alone this many questions, start and goal drawn by --seed where the robot may stand
    #[arg(long, value_name = "N")]
    random_queries: Option<usize>,
    /// What kind of file it is: json, jsonl, barn, map, scen, ros, mpnet, problems or picture [default: by its name, or by what
    /// it holds]
    #[arg(long, value_name = "KIND", value_parser = parse_format)]
    format: Option<Format>,
    #[command(flatten, next_help_heading = "Robot with joints")]
    pub robot: AskedArgs,
    /// Every file that was read for the tasks.
    #[arg(skip)]
    files: Arc<Mutex<Vec<PathBuf>>>,
}

impl InputArgs {
    /// Every file that was read for the tasks so far, such as a map's image: outputs must not replace them.
    pub fn files(&self) -> Vec<PathBuf> {
        self.files.lock().map_or_else(|_| Vec::new(), |files| files.clone())
    }

    pub fn remember(&self, path: &Path) {
        if let Ok(mut files) = self.files.lock() {
            files.push(path.into());
        }
    }
}

/// The tasks of a file.
pub struct Input {
    /// At least one.
    pub tasks: Vec<Task>,
    /// For each task of a file of problems the goals that will do as well as its own; empty for other files.
    pub more_goals: Vec<Vec<Vec<f64>>>,
    /// What a person should know about how they were read; said on standard error already.
    pub warnings: Vec<String>,
}

/// Most random queries of one file.
const MOST_QUERIES: usize = 1_000_000;

/// Reads the tasks of a file or of standard input (`-`), of any kind that `sidestep_io` knows. A map alone
/// is one task, whose start and goal come from the question, or random queries.
pub fn read(path: &Path, args: &InputArgs, question: Question) -> Result<Input, Failure> {
    let question = Question {
        robot_radius: args.robot_radius,
        unknown: if args.unknown_is_free { Unknown::Free } else { Unknown::Occupied },
        format: args.format,
        drawing: Drawing {
            scale: args.scale,
            threshold: args.threshold,
            light: args.light_is_obstacle,
        },
        ..question
    };
    args.remember(path);
    let bytes = source::bytes(path)?;
    let mut load = |name: &str| {
        let path = path.parent().unwrap_or(Path::new("")).join(name);
        args.remember(&path);
        source::companion(&path)
    };
    let input = sidestep_io::input::read(&path.to_string_lossy(), &bytes, &question, &mut load)
        .map_err(|error| Failure::file(path, error))?;
    drop(bytes);
    for warning in &input.warnings {
        output::tell(&format!("warning: {}: {warning}", path.display()));
    }
    let mut warnings = input.warnings;
    let mut more_goals = Vec::new();
    let tasks = match input.content {
        Content::Problems(problems) => {
            let asked = tasks::of_problems(path, &problems, &args.robot)?;
            asked.files.iter().for_each(|path| args.remember(path));
            warnings.extend(asked.warnings);
            let more = |problem: &Problem| problem.goals.get(1..).unwrap_or_default().to_vec();
            more_goals = problems.iter().map(more).collect();
            asked.tasks
        }
        _ if args.robot.robot.is_some() => {
            let only = "--robot: these tasks have a robot in the plane; a scene in space is given by --scene";
            return Err(Failure::file(path, only));
        }
        Content::Map(world) => map_tasks(path, world, args, &question)?,
        Content::Tasks(_) if args.random_queries.is_some() => {
            let only = "--random-queries: only a map (.map, .yaml) has none of its own";
            return Err(Failure::file(path, only));
        }
        Content::Tasks(tasks) => tasks,
    };
    Ok(Input { tasks, more_goals, warnings })
}

fn map_tasks(
    path: &Path,
    world: Arc<World>,
    args: &InputArgs,
    question: &Question,
) -> Result<Vec<Task>, Failure> {
    let robot = Robot::disc(args.robot_radius.unwrap_or(0.0))?;
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    match (args.random_queries, (question.start, question.goal)) {
        (Some(count @ 1..=MOST_QUERIES), _) => {
            let mut tasks = random_queries(&name, &world, robot, count, question.seed)?;
            for task in &mut tasks {
                *task = question.asked(&task.plane()?)?;
            }
            Ok(tasks)
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

fn parse_format(name: &str) -> Result<Format, String> {
    name.parse().map_err(|error: sidestep::InvalidInput| error.to_string())
}

/// Numbers that somebody typed: `X,Y` in the plane, or one for each joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Configuration(pub Vec<f64>);

impl Configuration {
    /// The point that two numbers are.
    pub fn point(&self) -> Option<Point> {
        self.0.as_slice().try_into().ok()
    }
}

/// Parses a configuration: `X,Y`, or a number for each joint.
pub fn parse_configuration(text: &str) -> Result<Configuration, String> {
    let number = |part: &str| {
        let value: f64 = part.trim().parse().map_err(|_| format!("`{part}` is not a number"))?;
        if value.is_finite() { Ok(value) } else { Err(format!("`{part}` is not finite")) }
    };
    // As people write points elsewhere: (1, 2) or [1, 2].
    let inner = text.trim().trim_matches(['(', ')', '[', ']']);
    inner.split(',').map(number).collect::<Result<_, _>>().map(Configuration)
}
