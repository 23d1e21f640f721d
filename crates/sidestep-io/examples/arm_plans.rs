//! Plans problems for a robot with joints with `auto` and writes the plans, for others to judge.
//!
//! ```text
//! cargo run --release -p sidestep-io --example arm_plans -- robot.urdf robot.srdf plans.jsonl \
//!     --problems problems.json
//! ```
//!
//! With `--meshes DIR --overhang M` the URDF's shapes are covered by balls that stick out by at most M
//! metres; `package://` and relative paths are looked for under DIR. Without, the bodies must be balls.
//! `oracle/judge_arms.py` judges the plans.
#![allow(clippy::print_stdout, reason = "an example prints its result")]

use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use serde_json::json;
use sidestep::arm::Arm;
use sidestep::scene::Setting;
use sidestep::space::Hull;
use sidestep::{InvalidInput, Options, Planner, Status, Task, plan};
use sidestep_io::robots::{read_srdf, read_urdf};
use sidestep_io::scenes::{Problem, mesh, read_problems};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let mut plain = Vec::new();
    let mut flags: HashMap<String, String> = HashMap::new();
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.strip_prefix("--") {
            Some(flag) => {
                let value = args.next().ok_or_else(|| format!("--{flag} needs a value"))?;
                flags.insert(flag.to_owned(), value);
            }
            None => plain.push(arg),
        }
    }
    let [urdf, srdf, out] = plain.as_slice() else {
        return Err("three files are needed: robot.urdf robot.srdf plans.jsonl".into());
    };
    let mut model = read_urdf(&std::fs::read_to_string(urdf)?)?;
    let srdf = read_srdf(&std::fs::read_to_string(srdf)?)?;
    if let Some(folder) = flags.get("meshes") {
        let overhang = flags.get("overhang").map_or(Ok(0.01), |text| text.parse())?;
        let begun = Instant::now();
        let mut hull = |file: &str, scale: [f64; 3]| load_hull(Path::new(folder), file, scale);
        let (covered, worst) = model.covered(overhang, &mut hull)?;
        model = covered;
        let balls: usize = model.links().iter().map(|link| link.bodies.len()).sum();
        let ms = begun.elapsed().as_secs_f64() * 1e3;
        println!("{balls} balls cover it, {:.2} mm beyond at most, {ms:.0} ms", 1e3 * worst);
    }
    let file = flags.get("problems").ok_or("--problems FILE is needed")?;
    let mut none = |_: &str| Err(std::io::Error::other("no file"));
    let problems = read_problems(&std::fs::read(file)?, &mut none)?;
    let first = problems.first().ok_or("no problem")?;
    let (arm, lasting) = first.arm(&model, &srdf)?;
    for (a, b) in &lasting {
        eprintln!("{a} and {b} always touch: not checked against each other");
    }
    plan_all(&Arc::new(arm), &problems, out)
}

fn plan_all(arm: &Arc<Arm>, problems: &[Problem], out: &str) -> Result<(), Failure> {
    let planner = Planner::default();
    let mut file = std::io::BufWriter::new(std::fs::File::create(out)?);
    let (mut solved, mut invalid) = (0, 0);
    for (index, problem) in problems.iter().enumerate() {
        let setting = Setting::Arm { arm: Arc::clone(arm), world: Arc::clone(&problem.world) };
        let (start, goal) = (problem.start.clone(), problem.goals[0].clone());
        let task = Task::new(&problem.name, setting, start, goal)?;
        let options = Options { index: index as u64, ..Options::default() };
        let begun = Instant::now();
        let answer = plan(&task, &planner, &options)?;
        let us = begun.elapsed().as_secs_f64() * 1e6;
        invalid += usize::from(matches!(answer.status, Status::Invalid(_)));
        if let Some(path) = answer.certified() {
            solved += 1;
            let rows: Vec<&[f64]> = path.configurations().collect();
            let joints = &problem.joints[..];
            let plan = json!({"problem": problem.name, "joints": joints, "path": rows, "us": us});
            writeln!(file, "{plan}")?;
        }
    }
    file.flush()?;
    println!(
        "{} problems, {invalid} with an end that is not free, {solved} solved",
        problems.len()
    );
    Ok(())
}

fn load_hull(folder: &Path, file: &str, scale: [f64; 3]) -> Result<Arc<Hull>, InvalidInput> {
    let refused = |found: &dyn std::fmt::Display| {
        InvalidInput::new(format!("mesh {file:?}"), found, "an STL or OBJ file under --meshes")
    };
    let path: PathBuf = folder.join(file.trim_start_matches("package://"));
    let bytes = std::fs::read(path).map_err(|error| refused(&error))?;
    match mesh::shape(file, &bytes, scale, true).map_err(|error| refused(&error))? {
        sidestep::space::Shape::Hull(hull) => Ok(hull),
        other => Err(refused(&other.kind())),
    }
}
