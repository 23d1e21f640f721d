//! Problems of robots with joints as a file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use sidestep::InvalidInput;
use sidestep::arm::Tool;
use sidestep::space::Pose;
use sidestep::suite::arms::{ArmSuite, planar_arm};
use sidestep_io::robots::{Preparation, prepare};
use sidestep_io::scenes::{Problem, write_problems};

use super::{GenerateArgs, MAX_COUNT, Written};
use crate::Global;
use crate::failure::Failure;
use crate::output;
use crate::robots::load::{RobotArgs, load};

/// What a command line says about problems of robots with joints.
#[derive(Args)]
pub struct ArmArgs {
    /// The robot: URDF, or a robot file of ours
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    #[command(flatten)]
    from: RobotArgs,
    /// The link that reaches for things, such as the hand [default: goals are drawn as configurations]
    #[arg(long, value_name = "LINK")]
    tool: Option<String>,
    /// The axis of that link that points forwards: x, y or z
    #[arg(long, default_value = "z", value_name = "AXIS", value_parser = ["x", "y", "z"])]
    tool_axis: String,
    /// How far along it the hand begins, whose fingers end some 0.1 further, in metres
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_name = "M")]
    tool_length: f64,
    /// How high the robot's base stands above the floor that the scenes stand on, in metres [default: 0.9 for box, 0.2
    /// for cage, else 0]
    #[arg(long, allow_negative_numbers = true, value_name = "M")]
    base_height: Option<f64>,
    /// Joints of the planar arm, 1 to 16
    #[arg(long, default_value_t = 3, allow_negative_numbers = true)]
    dof: usize,
}

/// The suite of that name, if it is one for robots with joints.
pub fn suite(name: &str) -> Option<ArmSuite> {
    name.parse().ok()
}

/// Fails if a suite in the plane is asked for with a robot.
pub fn refuse(args: &ArmArgs) -> Result<(), Failure> {
    match args.robot.is_some() || args.tool.is_some() {
        true => Err(Failure::at("--suite", "this one is in the plane and takes no --robot")),
        false => Ok(()),
    }
}

/// Draws the problems and writes them; of planar arms also the robot, beside them.
pub fn run(suite: ArmSuite, args: &GenerateArgs, global: &Global) -> Result<(), Failure> {
    let (arms, out) = (&args.arms, args.out.as_path());
    output::check_suffix(("--out", out), &["json"])?;
    if !(1..=MAX_COUNT).contains(&args.count) {
        let allowed = format!("a number from 1 to {MAX_COUNT}");
        return Err(InvalidInput::new("--count", args.count, allowed).into());
    }
    let planar = suite.is_planar();
    let (prepared, robot, inputs) = match (&arms.robot, planar) {
        (None, true) => {
            let model = planar_arm(arms.dof)
                .map_err(|error| InvalidInput { field: "--dof".into(), ..error })?;
            let name = PathBuf::from(format!("planar-arm-{}.json", arms.dof));
            let mut none = |file: &str, _| Err(InvalidInput::new("mesh", file, "none"));
            (prepare(model, None, &Preparation::default(), &mut none)?, name, Vec::new())
        }
        (Some(_), true) => {
            let message = format!("{} makes its own robot; give --dof N", suite.name());
            return Err(Failure::at("--robot", message));
        }
        (Some(path), false) => {
            let loaded = load(path, &arms.from, None)?;
            (loaded.prepared, seen_from(out, path), loaded.files)
        }
        (None, false) => {
            let need = "is for a robot with joints: give --robot URDF";
            return Err(Failure::at("--suite", format!("{} {need}", suite.name())));
        }
    };
    let beside = out.with_file_name(&robot);
    let mut outputs = vec![("--out", out)];
    if planar {
        outputs.push(("the robot of --out", &beside));
    }
    output::check_outputs(&outputs, &inputs)?;
    let tool = arms.tool.as_ref().map(|link| tool(arms, link)).transpose()?;
    let arm = Arc::new(prepared.arm);
    let label = format!("problems of {}, seed {}", suite.name(), args.seed);
    let bar = output::progress(&label, args.count as u64, global.quiet);
    let kept = || bar.inc(1);
    let drawn = suite.generate(&arm, tool.as_ref(), arms.base_height, args.count, args.seed, &kept);
    bar.finish_and_clear();
    let names = arm.joint_names();
    let (joints, held): (Arc<[String]>, Arc<[_]>) =
        (names.into(), prepared.file.held.clone().into());
    let robot: Arc<str> = robot.to_string_lossy().into();
    let problems: Vec<Problem> = drawn?
        .into_iter()
        .map(|problem| Problem {
            name: problem.name,
            robot: robot.clone(),
            joints: joints.clone(),
            fixed_joints: held.clone(),
            start: problem.start,
            goals: vec![problem.goal],
            world: problem.world,
        })
        .collect();
    if planar {
        output::write_file(&beside, prepared.file.to_json().as_bytes())?;
    }
    output::write_file(out, write_problems(&problems).as_bytes())?;
    if global.json {
        let (suite, seed, tasks) = (suite.name(), args.seed, problems.len());
        output::print_json(&Written { suite, seed, tasks, out })?;
    } else if !global.quiet {
        let (count, name, out) = (problems.len(), suite.name(), out.display());
        output::tell(&format!("{count} problems of {name} (seed {}): {out}", args.seed));
    }
    Ok(())
}

/// The tool of a link: its frame's x points along the axis that is named.
fn tool(args: &ArmArgs, link: &str) -> Result<Tool, Failure> {
    let quarter = std::f64::consts::FRAC_PI_2;
    let (turn, along) = match args.tool_axis.as_str() {
        "x" => ([0.0; 3], [args.tool_length, 0.0, 0.0]),
        "y" => ([0.0, 0.0, quarter], [0.0, args.tool_length, 0.0]),
        _ => ([0.0, -quarter, 0.0], [0.0, 0.0, args.tool_length]),
    };
    Ok(Tool { link: link.to_owned(), frame: Pose::from_rpy(turn, along)? })
}

/// A robot's file as a file beside `out` should call it.
fn seen_from(out: &Path, robot: &Path) -> PathBuf {
    let folder = |path: &Path| {
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        std::fs::canonicalize(parent.unwrap_or(Path::new("."))).ok()
    };
    match (folder(out), folder(robot), robot.file_name()) {
        (Some(a), Some(b), Some(name)) if a == b => name.into(),
        (_, Some(folder), Some(name)) => folder.join(name),
        _ => robot.into(),
    }
}
