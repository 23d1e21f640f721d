//! A robot with joints from the files that a person names: a URDF, with an SRDF and meshes, or a robot file of ours.

use std::path::{Path, PathBuf};

use clap::Args;
use sidestep::arm::Arm;
use sidestep_io::robots::{
    self, DEFAULT_OVERHANG, Moving, Preparation, Prepared, RobotFile, Srdf, prepare,
};
use sidestep_io::scenes::Problem;

use super::meshes::Meshes;
use crate::failure::Failure;
use crate::source;

/// What a command line says about a robot beside its URDF.
#[derive(Args, Debug, Clone, Default)]
pub struct RobotArgs {
    /// SRDF of the robot: groups, named configurations, pairs of links that may touch [default: the one beside the URDF]
    #[arg(long, value_name = "FILE")]
    pub srdf: Option<PathBuf>,
    /// Where a package of `package://NAME/...` lies [default: looked for around the URDF, then in
    /// ROS_PACKAGE_PATH and AMENT_PREFIX_PATH]
    #[arg(long, value_name = "NAME=DIR", value_parser = parse_package)]
    pub package: Vec<(String, PathBuf)>,
    /// The joints of this group of the SRDF move
    #[arg(long, conflicts_with = "joints")]
    pub group: Option<String>,
    /// These joints move, in the order of a configuration's numbers: NAME,NAME [default: all that can]
    #[arg(long, value_delimiter = ',', value_name = "NAMES")]
    pub joints: Vec<String>,
    /// Where other joints stand: NAME=VALUE,NAME=VALUE in rad or m [default: 0 or the limit nearest to it]
    #[arg(long, value_delimiter = ',', value_parser = parse_value, value_name = "VALUES")]
    pub held: Vec<(String, f64)>,
    /// How far the spheres that cover boxes, cylinders and meshes may stick out of them, in metres
    #[arg(long, default_value_t = DEFAULT_OVERHANG, allow_negative_numbers = true, value_name = "M")]
    pub overhang: f64,
}

/// A robot that was read.
pub struct Loaded {
    /// The robot and how it came about.
    pub prepared: Prepared,
    /// What its SRDF says, if there is one.
    pub srdf: Option<Srdf>,
    /// Every file that was read.
    pub files: Vec<PathBuf>,
}

impl Loaded {
    /// The robot, compiled.
    pub fn arm(&self) -> &Arm {
        &self.prepared.arm
    }
}

/// Reads a robot; a problem's joints and held joints stand in for what the command line leaves open.
pub fn load(path: &Path, args: &RobotArgs, problem: Option<&Problem>) -> Result<Loaded, Failure> {
    if !(args.overhang > 0.0 && args.overhang <= 1.0) {
        let reason = format!("{} is not a number above 0 and at most 1, in metres", args.overhang);
        return Err(Failure::at("--overhang", reason));
    }
    let text = source::text(path)?;
    let mut files = vec![path.to_path_buf()];
    let is_own = robots::is_robot(&text);
    let beside = if is_own { None } else { beside(path) };
    let srdf = match args.srdf.as_ref().or(beside.as_ref()) {
        Some(path) => {
            files.push(path.clone());
            let text = source::text(path)?;
            Some(robots::read_srdf(&text).map_err(|error| Failure::file(path, error))?)
        }
        None => None,
    };
    let prepared = if is_own {
        let file = robots::read_robot(&text).map_err(|error| Failure::file(path, error))?;
        from_own(path, file, args, srdf.as_ref(), problem)?
    } else {
        let model = robots::read_urdf(&text).map_err(|error| Failure::file(path, error))?;
        let known = |name: &str| model.joint(name).is_some();
        let preparation = Preparation {
            moving: moving(args, problem),
            held: held(args, problem, known),
            overhang: args.overhang,
        };
        let mut meshes = Meshes::new(path, &args.package);
        let prepared = prepare(model, srdf.as_ref(), &preparation, &mut |file, scale| {
            meshes.hull(file, scale)
        });
        files.append(&mut meshes.read);
        prepared.map_err(|error| Failure::file(path, with_groups(&error, srdf.as_ref())))?
    };
    Ok(Loaded { prepared, srdf, files })
}

/// The SRDF beside a URDF, where there is one: of the same name, but for `_spherized`.
fn beside(urdf: &Path) -> Option<PathBuf> {
    let stem = urdf.file_stem()?.to_str()?;
    let names = [stem, stem.trim_end_matches("_spherized")];
    names.iter().map(|name| urdf.with_file_name(format!("{name}.srdf"))).find(|p| p.is_file())
}

/// A robot of our own file, whose joints may be chosen anew.
fn from_own(
    path: &Path,
    file: RobotFile,
    args: &RobotArgs,
    srdf: Option<&Srdf>,
    problem: Option<&Problem>,
) -> Result<Prepared, Failure> {
    let mut file = file;
    let refuse = |error: sidestep::InvalidInput| Failure::file(path, error);
    match moving(args, problem) {
        Moving::All => {}
        Moving::Joints(names) => file.moving = names,
        Moving::Group(name) => match srdf {
            Some(srdf) => file.moving = srdf.joints_of(&name, &file.model).map_err(refuse)?,
            None => return Err(Failure::at("--group", "needs --srdf FILE, which names groups")),
        },
    }
    let known = |name: &str| file.model.joint(name).is_some();
    for (name, value) in held(args, problem, known) {
        file.held.retain(|(other, _)| *other != name);
        file.held.push((name, value));
    }
    let arm = file.arm().map_err(refuse)?;
    let (covered, unknown, adjacent, lasting) = Default::default();
    let named = file.may_touch.len();
    Ok(Prepared { file, arm, covered, named, unknown, adjacent, lasting })
}

fn moving(args: &RobotArgs, problem: Option<&Problem>) -> Moving {
    match (&args.group, problem) {
        (Some(group), _) => Moving::Group(group.clone()),
        (None, _) if !args.joints.is_empty() => Moving::Joints(args.joints.clone()),
        (None, Some(problem)) => Moving::Joints(problem.joints.to_vec()),
        (None, None) => Moving::All,
    }
}

/// What is held where; a problem may name joints that the robot lacks.
fn held(
    args: &RobotArgs,
    problem: Option<&Problem>,
    known: impl Fn(&str) -> bool,
) -> Vec<(String, f64)> {
    let given = problem.map_or(&[][..], |problem| &problem.fixed_joints);
    let given = given
        .iter()
        .filter(|(name, _)| known(name) && !args.held.iter().any(|(other, _)| other == name));
    given.chain(&args.held).cloned().collect()
}

/// An error with the groups that there are, where it is about one.
fn with_groups(error: &sidestep::InvalidInput, srdf: Option<&Srdf>) -> String {
    match srdf {
        Some(srdf) if error.field == "group" => {
            let names: Vec<&str> = srdf.groups.iter().map(|group| group.name.as_str()).collect();
            format!("{error}; there are {}", names.join(", "))
        }
        _ => error.to_string(),
    }
}

/// Parses `NAME=DIR`.
fn parse_package(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => {
            Ok((name.to_owned(), folder.into()))
        }
        _ => Err("expected NAME=DIR, a package and its folder".into()),
    }
}

/// Parses `NAME=VALUE`.
pub fn parse_value(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    let value: f64 = value.trim().parse().map_err(|_| format!("`{value}` is not a number"))?;
    match name.trim() {
        "" => Err("expected NAME=VALUE".into()),
        _ if !value.is_finite() => Err(format!("`{value}` is not finite")),
        name => Ok((name.to_owned(), value)),
    }
}
