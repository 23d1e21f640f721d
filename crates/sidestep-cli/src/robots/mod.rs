//! `sidestep robot`: what was read of a robot with joints, and the robot as a file of ours.

pub mod draw;
pub mod load;
mod meshes;
pub mod tasks;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde_json::{Value, json};
use sidestep::arm::JointKind;

use crate::Global;
use crate::failure::Failure;
use crate::output::{self, Output};
use load::{Loaded, RobotArgs, load};

const EXAMPLES: &str = "\
Examples:
  sidestep robot panda.urdf --srdf panda.srdf --group panda_arm --picture panda.png
  sidestep robot ur5.urdf --package ur_description=/opt/ur_description --out ur5.json
  sidestep robot ur5.json --json";

/// Arguments of `robot`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct RobotVerbArgs {
    /// URDF of a robot with joints, or a robot file that --out wrote
    robot: PathBuf,
    #[command(flatten, next_help_heading = "Robot")]
    from: RobotArgs,
    /// Write the robot here as it is planned for (.json): spheres, pairs and limits, ready at once
    #[arg(long, help_heading = "Output")]
    out: Option<PathBuf>,
    /// Draw the robot here from three sides, in its rest position (.svg or .png)
    #[arg(long, help_heading = "Output")]
    picture: Option<PathBuf>,
}

/// Reads the robot and says what it is.
pub fn run(args: &RobotVerbArgs, global: &Global) -> Result<(), Failure> {
    let mut outputs: Vec<Output<'_>> = Vec::new();
    let formats: [(_, _, &[&str]); 2] =
        [("--out", &args.out, &["json"]), ("--picture", &args.picture, &["svg", "png"])];
    for (flag, path, suffixes) in formats {
        let Some(path) = path else { continue };
        output::check_suffix((flag, path), suffixes)?;
        outputs.push((flag, path));
    }
    let begin = Instant::now();
    let loaded = load(&args.robot, &args.from, None)?;
    let ms = begin.elapsed().as_secs_f64() * 1e3;
    output::check_outputs(&outputs, &loaded.files)?;
    if let Some(path) = &args.out {
        output::write_file(path, loaded.prepared.file.to_json().as_bytes())?;
    }
    if let Some(path) = &args.picture {
        draw::picture(path, loaded.arm())?;
    }
    match global.json {
        true => output::print_json(&document(&loaded, ms)),
        false => output::print(&describe(&loaded, ms)),
    }
}

/// What was read, as JSON.
fn document(loaded: &Loaded, ms: f64) -> Value {
    let (prepared, arm) = (&loaded.prepared, loaded.arm());
    let model = &prepared.file.model;
    let joints: Vec<Value> = arm
        .joints()
        .iter()
        .map(|joint| {
            json!({
                "name": joint.name, "type": kind(joint.kind), "unit": unit(joint.kind),
                "lower": joint.lower, "upper": joint.upper, "velocity": joint.velocity,
            })
        })
        .collect();
    let spheres: Vec<Value> = model
        .links()
        .iter()
        .map(|link| json!({"name": link.name, "spheres": link.bodies.len()}))
        .collect();
    let covered: serde_json::Map<String, Value> =
        prepared.covered.iter().map(|&(kind, count)| (kind.to_owned(), json!(count))).collect();
    json!({
        "name": arm.name(),
        "links": spheres,
        "joints": model.joints().len(),
        "moving": joints,
        "held": prepared.file.held.iter().cloned().collect::<std::collections::BTreeMap<_, _>>(),
        "spheres": arm.ball_count(),
        "covered": covered,
        "overhang": prepared.file.overhang,
        "pairs_checked": arm.self_collision_pairs().collect::<Vec<_>>(),
        "pairs_that_may_touch": prepared.file.may_touch,
        "found": {
            "adjacent": prepared.adjacent, "always_touching": prepared.lasting,
            "unknown_links_of_srdf": prepared.unknown,
        },
        "groups": loaded.srdf.as_ref().map(|srdf| {
            let joints = |name: &str| srdf.joints_of(name, model).unwrap_or_default();
            srdf.groups.iter().map(|group| json!({"name": group.name, "joints": joints(&group.name)}))
                .collect::<Vec<_>>()
        }),
        "reach": arm.reach(),
        "ready_ms": ms,
    })
}

/// What was read, in lines.
fn describe(loaded: &Loaded, ms: f64) -> String {
    let (prepared, arm) = (&loaded.prepared, loaded.arm());
    let model = &prepared.file.model;
    let mut text = format!(
        "{}: {} links, {} joints of which {} move, reach {:.2} m, ready in {ms:.0} ms\n",
        arm.name(),
        model.links().len(),
        model.joints().len(),
        arm.dof(),
        arm.reach()
    );
    let width = arm.joints().iter().map(|joint| joint.name.chars().count()).max().unwrap_or(0);
    for joint in arm.joints() {
        let unit = unit(joint.kind);
        let speed = match joint.velocity {
            Some(velocity) => format!(", at most {velocity} {unit}/s"),
            None => ", no speed limit".into(),
        };
        text += &format!(
            "  {:width$}  {:10} {:.4} to {:.4} {unit}{speed}\n",
            joint.name,
            kind(joint.kind),
            joint.lower,
            joint.upper
        );
    }
    let overhang = prepared.file.overhang;
    let bodies = if prepared.covered.is_empty() && overhang == 0.0 {
        "as they were given".to_string()
    } else {
        let kinds: Vec<String> =
            prepared.covered.iter().map(|(kind, count)| format!("{count} x {kind}")).collect();
        let of = if kinds.is_empty() { String::new() } else { format!(" {}", kinds.join(", ")) };
        format!("they cover{of} and stick out by {:.1} mm at most", 1e3 * overhang)
    };
    text += &format!("{} spheres: {bodies}\n", arm.ball_count());
    let bare: Vec<&str> = model
        .links()
        .iter()
        .filter(|link| link.bodies.is_empty())
        .map(|link| link.name.as_str())
        .collect();
    if !bare.is_empty() {
        text += &format!("links without a body, which cannot collide: {}\n", bare.join(", "));
    }
    let pairs = arm.self_collision_pairs().count();
    text += &format!("{pairs} pairs of links are checked against each other; not checked are\n");
    let mut reason = |pairs: usize, why: &str, names: &[(String, String)]| {
        if pairs > 0 {
            let some = names.iter().take(8).map(|(a, b)| format!("{a} - {b}"));
            let some: Vec<String> = some.collect();
            let more = if names.len() > 8 { ", .." } else { "" };
            let list = if some.is_empty() {
                String::new()
            } else {
                format!(": {}{more}", some.join(", "))
            };
            text += &format!("  {pairs} {why}{list}\n");
        }
    };
    reason(prepared.named, "that the file allows to touch", &[]);
    reason(prepared.adjacent.len(), "that a joint joins (no SRDF)", &prepared.adjacent);
    let why = "that touched in all of 256 random configurations";
    reason(prepared.lasting.len(), why, &prepared.lasting);
    if !prepared.unknown.is_empty() {
        let names = prepared.unknown.join(", ");
        text += &format!("the SRDF speaks of links that the robot does not have: {names}\n");
    }
    if let Some(srdf) = &loaded.srdf {
        for group in &srdf.groups {
            if let Ok(joints) = srdf.joints_of(&group.name, model) {
                text += &format!("group {}: {}\n", group.name, joints.join(", "));
            }
        }
    }
    text
}

/// A joint's kind in a word.
fn kind(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Fixed => "fixed",
        JointKind::Revolute => "revolute",
        JointKind::Continuous => "continuous",
        JointKind::Prismatic => "prismatic",
    }
}

/// The unit of a joint's position.
fn unit(kind: JointKind) -> &'static str {
    if kind == JointKind::Prismatic { "m" } else { "rad" }
}
