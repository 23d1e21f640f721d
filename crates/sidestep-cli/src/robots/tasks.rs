//! What a robot with joints is asked, as tasks: of a file of problems, or of a scene and two configurations.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use sidestep::scene::Setting;
use sidestep::space::World;
use sidestep::{InvalidInput, Task};
use sidestep_io::input::decode;
use sidestep_io::scenes::{Problem, SceneOptions, read_scene};

use super::load::{Loaded, RobotArgs, load};
use crate::failure::Failure;
use crate::{output, source};

/// A robot with joints, where tasks may be its.
#[derive(Args, Debug, Clone, Default)]
pub struct AskedArgs {
    /// A robot with joints: its URDF, or a robot file of ours [default for problems: the file that they name]
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    #[command(flatten)]
    pub from: RobotArgs,
}

/// Tasks of a robot with joints, and where they come from.
pub struct Asked {
    /// The tasks, which share the robot.
    pub tasks: Vec<Task>,
    /// What to know about how they were read; said on standard error already.
    pub warnings: Vec<String>,
    /// Every file that was read for them but their own.
    pub files: Vec<PathBuf>,
}

impl Asked {
    fn new(loaded: Loaded, tasks: Vec<Task>, file: &Path) -> Self {
        let warnings = warnings(&loaded);
        for warning in &warnings {
            output::tell(&format!("warning: {}: {warning}", file.display()));
        }
        Self { tasks, warnings, files: loaded.files }
    }
}

/// What a person should know about a robot that was read.
fn warnings(loaded: &Loaded) -> Vec<String> {
    let prepared = &loaded.prepared;
    let mut warnings = Vec::new();
    if !prepared.covered.is_empty() {
        warnings.push(format!(
            "{} balls cover the collision shapes and stick out by up to {:.1} mm",
            prepared.arm.ball_count(),
            1e3 * prepared.file.overhang
        ));
    }
    if let Some(link) = prepared.unknown.first() {
        let count = prepared.unknown.len();
        warnings.push(format!("the SRDF names {count} link(s) that the robot lacks, as {link:?}"));
    }
    for (a, b) in &prepared.lasting {
        warnings.push(format!("{a} and {b} always touch: not checked against each other"));
    }
    warnings
}

/// Problems of a file as tasks. Of several goals the first is asked for.
pub fn of_problems(path: &Path, problems: &[Problem], args: &AskedArgs) -> Result<Asked, Failure> {
    let Some(first) = problems.first() else { return Err(Failure::file(path, "no problem")) };
    let robot = match &args.robot {
        Some(robot) => robot.clone(),
        None => {
            let named = path.parent().unwrap_or(Path::new("")).join(&*first.robot);
            let name = &first.robot;
            if named.extension().is_none() {
                let found = format!("the problems are for {name:?}, which names no file");
                return Err(Failure::file(path, format!("{found}: give --robot FILE")));
            }
            named
        }
    };
    let loaded = load(&robot, &args.from, Some(first))?;
    let arm = Arc::new(loaded.arm().clone());
    let task = |problem: &Problem| {
        let setting = Setting::Arm { arm: Arc::clone(&arm), world: Arc::clone(&problem.world) };
        let goal = problem.goals.first().cloned().unwrap_or_default();
        Task::new(&problem.name, setting, problem.start.clone(), goal)
            .map_err(|error| Failure::file(path, error.inside(&problem.name)))
    };
    let tasks = problems.iter().map(task).collect::<Result<_, Failure>>()?;
    Ok(Asked::new(loaded, tasks, path))
}

/// The one task of a robot, a scene and two configurations.
pub fn of_scene(
    args: &AskedArgs,
    scene: Option<&Path>,
    ends: [Vec<f64>; 2],
) -> Result<Asked, Failure> {
    let Some(robot) = &args.robot else { return Err(Failure("--robot FILE is needed".into())) };
    let [start, goal] = ends;
    if start.len() != goal.len() {
        let found = format!("{} numbers, where --start has {}", goal.len(), start.len());
        return Err(Failure::at("--goal", found));
    }
    let loaded = of_so_many_joints(robot, &args.from, start.len())?;
    let mut files = Vec::new();
    let world = match scene {
        Some(path) => read_world(path, &mut files)?,
        None => World::default(),
    };
    let arm = Arc::new(loaded.arm().clone());
    let name = arm.name().to_owned();
    let setting = Setting::Arm { arm, world: Arc::new(world) };
    let task = Task::new(name, setting, start, goal)?;
    let mut asked = Asked::new(loaded, vec![task], robot);
    asked.files.append(&mut files);
    Ok(asked)
}

/// The robot with so many joints: those that the arguments name, or all, or those of the only group of the SRDF with
/// so many.
fn of_so_many_joints(path: &Path, args: &RobotArgs, count: usize) -> Result<Loaded, Failure> {
    let loaded = load(path, args, None)?;
    let joints = loaded.arm().joints();
    if joints.len() == count {
        return Ok(loaded);
    }
    let model = &loaded.prepared.file.model;
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    for group in loaded.srdf.iter().flat_map(|srdf| &srdf.groups) {
        if let Some(srdf) = &loaded.srdf
            && let Ok(joints) = srdf.joints_of(&group.name, model)
            && groups.iter().all(|(_, known)| *known != joints)
        {
            groups.push((&group.name, joints));
        }
    }
    let is_open = args.group.is_none() && args.joints.is_empty();
    let mut fitting = groups.iter().filter(|(_, joints)| joints.len() == count);
    if let (true, Some((group, _)), None) = (is_open, fitting.next(), fitting.next()) {
        let args = RobotArgs { group: Some((*group).into()), ..args.clone() };
        return load(path, &args, None);
    }
    let names: Vec<&str> = joints.iter().map(|joint| joint.name.as_str()).collect();
    let mut allowed = format!("{}, one a joint: {}", joints.len(), names.join(", "));
    if !groups.is_empty() {
        let list: Vec<String> =
            groups.iter().map(|(name, joints)| format!("{name} ({})", joints.len())).collect();
        allowed += &format!("; --group names another: {}", list.join(", "));
    }
    Err(InvalidInput::new("--start", format!("{count} numbers"), allowed).into())
}

/// A world in space, of any kind that can be read.
fn read_world(path: &Path, files: &mut Vec<PathBuf>) -> Result<World, Failure> {
    files.push(path.to_path_buf());
    let bytes = source::bytes(path)?;
    let bytes = match decode("a scene", &bytes) {
        // Byte order marks and UTF-16, as everywhere; clouds and meshes may be binary.
        Ok(text) => text.into_owned().into_bytes(),
        Err(_) => bytes,
    };
    let mut load = |name: &str| {
        let path = path.parent().unwrap_or(Path::new("")).join(name);
        files.push(path.clone());
        source::companion(&path)
    };
    read_scene(&path.to_string_lossy(), &bytes, SceneOptions::default(), &mut load)
        .map_err(|error| Failure::file(path, error))
}
