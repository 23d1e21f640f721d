//! From what a robot's files say to a robot that can plan: which joints move, spheres for bodies, and pairs of links
//! that may touch.

use std::collections::HashMap;
use std::sync::Arc;

use sidestep::InvalidInput;
use sidestep::arm::{Arm, Body, BodyShape, Model};
use sidestep::space::{Hull, Pose, Vector};

use super::robot_json::RobotFile;
use super::srdf::Srdf;

/// What to choose beside the files.
#[derive(Debug, Clone, PartialEq)]
pub struct Preparation {
    /// The joints that move, in the order of a configuration's numbers.
    pub moving: Moving,
    /// Where other joints stand: rad or m; else at 0 or the limit nearest to it.
    pub held: Vec<(String, f64)>,
    /// How far the spheres that cover shapes may stick out of them, metres.
    pub overhang: f64,
}

/// Which joints move.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Moving {
    /// All that can.
    All,
    /// Those of a group of the SRDF.
    Group(String),
    /// These.
    Joints(Vec<String>),
}

/// Far enough for most tasks, and some 400 spheres on a robot of seven joints.
pub const DEFAULT_OVERHANG: f64 = 0.01;

impl Default for Preparation {
    /// All joints, covers to a centimetre.
    fn default() -> Self {
        Self { moving: Moving::All, held: Vec::new(), overhang: DEFAULT_OVERHANG }
    }
}

/// A robot and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// The robot.
    pub file: RobotFile,
    /// The robot, compiled.
    pub arm: Arm,
    /// Shapes of the URDF that were covered with spheres, by kind: `mesh`, 12.
    pub covered: Vec<(&'static str, usize)>,
    /// Pairs of links that may touch because the SRDF says so, found in the robot.
    pub named: usize,
    /// Names of links in the SRDF's pairs that the robot does not have.
    pub unknown: Vec<String>,
    /// Pairs that may touch because a joint joins them; only without an SRDF.
    pub adjacent: Vec<(String, String)>,
    /// Pairs that touched in all of 256 random configurations and so are not checked.
    pub lasting: Vec<(String, String)>,
}

/// Gives the convex hull of a mesh by its file's name and the factors of its coordinates.
pub type LoadHull<'a> = &'a mut dyn FnMut(&str, Vector) -> Result<Arc<Hull>, InvalidInput>;

/// Prepares a robot. `hull` is asked for meshes, if there are any.
///
/// # Errors
/// If a name is unknown, a joint cannot move, a mesh cannot be had or a shape cannot be covered so closely.
pub fn prepare(
    model: Model,
    srdf: Option<&Srdf>,
    preparation: &Preparation,
    hull: LoadHull<'_>,
) -> Result<Prepared, InvalidInput> {
    let covered = shapes_to_cover(&model);
    let (model, overhang) = match covered.is_empty() {
        true => (model, 0.0),
        false => model.covered(preparation.overhang, hull)?,
    };
    let model = plain_spheres(model)?;
    let moving: Vec<String> = match &preparation.moving {
        Moving::All => Vec::new(),
        Moving::Joints(names) => names.clone(),
        Moving::Group(name) => match srdf {
            Some(srdf) => srdf.joints_of(name, &model)?,
            None => {
                let need = "an SRDF, which names groups";
                return Err(InvalidInput::new("group", format!("{name:?}"), need));
            }
        },
    };
    let (mut named, mut unknown, mut adjacent) = (Vec::new(), Vec::new(), Vec::new());
    match srdf {
        Some(srdf) => {
            for (a, b) in &srdf.disabled_pairs {
                let strange = [a, b].into_iter().filter(|link| model.link(link).is_none());
                let known = unknown.len();
                unknown.extend(strange.cloned());
                if unknown.len() == known {
                    named.push((a.clone(), b.clone()));
                }
            }
            unknown.sort();
            unknown.dedup();
        }
        None => adjacent = neighbours(&model),
    }
    let names: Vec<&str> = moving.iter().map(String::as_str).collect();
    let held: HashMap<String, f64> = preparation.held.iter().cloned().collect();
    let mut may_touch = if srdf.is_some() { named.clone() } else { adjacent.clone() };
    let arm = Arm::new(&model, &names, &held)?.with_self_collisions(&may_touch)?;
    let (arm, lasting) = arm.without_lasting_contacts();
    may_touch.extend(lasting.iter().cloned());
    let moving = arm.joint_names();
    let held = preparation.held.clone();
    let file = RobotFile { model, moving, held, may_touch, overhang };
    Ok(Prepared { file, arm, covered, named: named.len(), unknown, adjacent, lasting })
}

/// How many shapes of each kind are no spheres.
fn shapes_to_cover(model: &Model) -> Vec<(&'static str, usize)> {
    let mut kinds: Vec<(&'static str, usize)> = Vec::new();
    for body in model.links().iter().flat_map(|link| &link.bodies) {
        let kind = match body.shape {
            BodyShape::Sphere { .. } => continue,
            BodyShape::Box { .. } => "box",
            BodyShape::Cylinder { .. } => "cylinder",
            BodyShape::Capsule { .. } => "capsule",
            BodyShape::Mesh { .. } => "mesh",
        };
        match kinds.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, count)) => *count += 1,
            None => kinds.push((kind, 1)),
        }
    }
    kinds
}

/// The same spheres without the turns of their frames, which mean nothing.
fn plain_spheres(model: Model) -> Result<Model, InvalidInput> {
    let plain = |body: &Body| {
        let origin = Pose::at(body.origin.translation())?;
        Ok(Body { origin, shape: body.shape.clone() })
    };
    let bodies: Result<Vec<Vec<Body>>, InvalidInput> =
        model.links().iter().map(|link| link.bodies.iter().map(plain).collect()).collect();
    model.with_bodies(bodies?)
}

/// Links with a body, each with the nearest one above it that has one.
fn neighbours(model: &Model) -> Vec<(String, String)> {
    let links = model.links();
    let mut pairs = Vec::new();
    for (index, link) in links.iter().enumerate().filter(|(_, link)| !link.bodies.is_empty()) {
        let mut at = model.joint_above(index).map(|joint| model.joints()[joint].parent);
        while let Some(above) = at {
            if !links[above].bodies.is_empty() {
                pairs.push((links[above].name.clone(), link.name.clone()));
                break;
            }
            at = model.joint_above(above).map(|joint| model.joints()[joint].parent);
        }
    }
    pairs
}
