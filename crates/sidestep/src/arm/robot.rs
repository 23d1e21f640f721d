//! [`Arm`]: a robot with joints, ready for planning.

use std::collections::{HashMap, HashSet};

use super::chain::Chain;
use super::model::{JointKind, Model};
use super::spheres::{Ball, Part, parts};
use crate::error::{InvalidInput, finite};
use crate::space::Pose;
use crate::space::vector::norm;

/// Most numbers of a configuration; work space of this size lives on the stack.
pub const MAX_DOF: usize = 32;

/// How far outside its limits a joint may stand, in rad or m: limits and configurations are written with few digits (π as 3.14159).
pub const LIMIT_TOLERANCE: f64 = 1e-5;

/// A joint that moves.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmJoint {
    /// Its name in the model.
    pub name: String,
    /// Rotation (rad) or translation (m).
    pub kind: JointKind,
    /// Least position.
    pub lower: f64,
    /// Largest position.
    pub upper: f64,
    /// Largest speed, if the model says.
    pub velocity: Option<f64>,
}

impl ArmJoint {
    /// Whether the joint may stand there: within its limits, give or take [`LIMIT_TOLERANCE`].
    pub fn allows(&self, value: f64) -> bool {
        self.lower - LIMIT_TOLERANCE <= value && value <= self.upper + LIMIT_TOLERANCE
    }
}

/// A robot with joints, compiled from a [`Model`] whose bodies are balls.
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    name: String,
    joints: Vec<ArmJoint>,
    pub(super) chain: Chain,
    pub(super) link_names: Vec<String>,
    pub(super) parts: Vec<Part>,
    pub(super) balls: Vec<Ball>,
    /// Pairs of parts that must not touch each other, by number.
    pub(super) pairs: Vec<[usize; 2]>,
    /// What the body keeps away from the world, metres.
    margin: f64,
}

impl Arm {
    /// Compiles a model.
    ///
    /// `joints` names the joints that move, in the order of a configuration's numbers; empty for every joint
    /// that can. All others are held where `held` says, or else at 0 or the limit nearest to it.
    /// Continuous joints are taken to go from -π to π. No two links collide with each other
    /// until [`Self::with_self_collisions`] says so.
    ///
    /// # Errors
    /// If a name is unknown, a joint is fixed or mimics another, there is none that moves or more
    /// than [`MAX_DOF`], a held value is not finite, or a body is not a ball.
    pub fn new(
        model: &Model,
        joints: &[&str],
        held: &HashMap<String, f64>,
    ) -> Result<Self, InvalidInput> {
        let moving = moving(model, joints)?;
        let held = held_values(model, held)?;
        let chain = Chain::new(model, &moving, &held)?;
        let (parts, balls) = parts(model, &chain)?;
        let joints = moving.iter().map(|&index| {
            let joint = &model.joints()[index];
            let turn = (-std::f64::consts::PI, std::f64::consts::PI);
            let (lower, upper) = match (joint.kind, joint.limits) {
                (JointKind::Continuous, _) | (_, None) => turn,
                (_, Some(limits)) => (limits.lower, limits.upper),
            };
            let velocity = joint.limits.and_then(|limits| limits.velocity);
            ArmJoint { name: joint.name.clone(), kind: joint.kind, lower, upper, velocity }
        });
        Ok(Self {
            name: model.name().to_string(),
            joints: joints.collect(),
            chain,
            link_names: model.links().iter().map(|link| link.name.clone()).collect(),
            parts,
            balls,
            pairs: Vec::new(),
            margin: 0.0,
        })
    }

    /// The same robot, whose links must not touch each other, but for the pairs in `allowed`.
    /// Links that do not move against each other are never checked.
    ///
    /// # Errors
    /// If a pair names a link that the robot does not have.
    pub fn with_self_collisions(
        mut self,
        allowed: &[(String, String)],
    ) -> Result<Self, InvalidInput> {
        let known: HashMap<&str, usize> = self
            .parts
            .iter()
            .enumerate()
            .map(|(index, part)| (part.name.as_str(), index))
            .collect();
        let names: HashSet<&str> = self.link_names.iter().map(String::as_str).collect();
        let mut free = HashSet::new();
        for (index, (a, b)) in allowed.iter().enumerate() {
            for name in [a, b] {
                if !names.contains(name.as_str()) {
                    let field = format!("disable_collisions[{index}]");
                    return Err(InvalidInput::new(field, format!("{name:?}"), "a link's name"));
                }
            }
            // Links without a body need no permission.
            if let (Some(&a), Some(&b)) = (known.get(a.as_str()), known.get(b.as_str())) {
                free.insert([a.min(b), a.max(b)]);
            }
        }
        let count = self.parts.len();
        let all = (0..count).flat_map(|a| (a + 1..count).map(move |b| [a, b]));
        let checked = all.filter(|pair| !free.contains(pair));
        self.pairs = checked.filter(|&[a, b]| self.parts[a].slot != self.parts[b].slot).collect();
        Ok(self)
    }

    /// The same robot, which keeps `margin` metres away from everything in the world (not from itself).
    ///
    /// # Errors
    /// If the margin is negative or above 10 m.
    pub fn with_margin(mut self, margin: f64) -> Result<Self, InvalidInput> {
        if !(0.0..=10.0).contains(&margin) {
            return Err(InvalidInput::new("margin", margin, "a number from 0 to 10, in metres"));
        }
        self.margin = margin;
        Ok(self)
    }

    /// What the body keeps away from the world, in metres.
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// The number of a link in the model; 0, the root's or the first's, if there is none of that name.
    pub(super) fn link_index(&self, name: &str) -> usize {
        self.link_names.iter().position(|link| link == name).unwrap_or(0)
    }

    /// The name of a link by its number in the model.
    pub fn link_name(&self, link: usize) -> Option<&str> {
        self.link_names.get(link).map(String::as_str)
    }

    /// The robot's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How many numbers a configuration has.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// The joints that move, in the order of a configuration's numbers.
    pub fn joints(&self) -> &[ArmJoint] {
        &self.joints
    }

    /// The names of the joints that move, in the order of a configuration's numbers.
    pub fn joint_names(&self) -> Vec<String> {
        self.joints.iter().map(|joint| joint.name.clone()).collect()
    }

    /// All balls of the body, each in the frame of what it moves with.
    pub fn ball_count(&self) -> usize {
        self.balls.len()
    }

    /// The names of pairs of links that must not touch each other.
    pub fn self_collision_pairs(&self) -> impl Iterator<Item = (&str, &str)> {
        self.pairs.iter().map(|&[a, b]| (self.parts[a].name.as_str(), self.parts[b].name.as_str()))
    }

    /// Checks that a configuration has the right length and lies within the limits, give or take [`LIMIT_TOLERANCE`].
    ///
    /// # Errors
    /// Names the joint, its value and its limits; `field` comes before it.
    pub fn check(&self, field: &str, configuration: &[f64]) -> Result<(), InvalidInput> {
        if configuration.len() != self.dof() {
            let allowed = format!("{} numbers, one for each joint", self.dof());
            return Err(InvalidInput::new(field, configuration.len(), allowed));
        }
        for (joint, &value) in self.joints.iter().zip(configuration) {
            if !joint.allows(value) {
                let allowed = format!("within the limits {} to {}", joint.lower, joint.upper);
                let field = format!("{field}.{}", joint.name);
                return Err(InvalidInput::new(field, value, allowed));
            }
        }
        Ok(())
    }

    /// Where a link stands in the root link's frame, f64; none if there is no link of that name.
    /// The configuration must have [`Self::dof`] numbers.
    pub fn link_pose(&self, link: &str, configuration: &[f64]) -> Option<Pose> {
        let index = self.link_names.iter().position(|name| name == link)?;
        let (slot, place) = &self.chain.links[index];
        Some(self.chain.frames(configuration)[*slot].compose(place))
    }

    /// All balls in the root link's frame, f64; sorted as [`Self::link_of_ball`] says. The
    /// configuration must have [`Self::dof`] numbers.
    pub fn balls_at(&self, configuration: &[f64]) -> Vec<Ball> {
        let frames = self.chain.frames(configuration);
        let placed = self.parts.iter().flat_map(|part| {
            let frame = &frames[part.slot];
            self.balls[part.balls.clone()]
                .iter()
                .map(|ball| Ball { center: frame.apply(ball.center), radius: ball.radius })
        });
        placed.collect()
    }

    /// The name of the link that a ball belongs to.
    pub fn link_of_ball(&self, ball: usize) -> &str {
        let part = self.parts.iter().find(|part| part.balls.contains(&ball));
        part.map_or("", |part| part.name.as_str())
    }

    /// No point of the body is ever farther than this from the root link's origin, in metres.
    pub fn reach(&self) -> f64 {
        let mut far = vec![0.0_f64; self.chain.slots.len() + 1];
        for (index, slot) in self.chain.slots.iter().enumerate() {
            let joint = &self.joints[slot.coordinate];
            let travel = [joint.lower, joint.upper]
                .map(|end| (slot.multiplier * end + slot.offset).abs())
                .into_iter()
                .fold(0.0, f64::max)
                + slot.multiplier.abs() * LIMIT_TOLERANCE;
            let travel = if slot.prismatic { travel } else { 0.0 };
            far[index + 1] = far[slot.parent] + norm(slot.constant.translation()) + travel;
        }
        let reach = |part: &Part| far[part.slot] + norm(part.around.center) + part.around.radius;
        self.parts.iter().map(reach).fold(0.0, f64::max)
    }
}

/// The joints that move, by index.
fn moving(model: &Model, names: &[&str]) -> Result<Vec<usize>, InvalidInput> {
    let moving: Vec<usize> = if names.is_empty() {
        let moves = |&index: &usize| {
            let joint = &model.joints()[index];
            joint.kind != JointKind::Fixed && joint.mimic.is_none()
        };
        (0..model.joints().len()).filter(moves).collect()
    } else {
        let find = |(index, name): (usize, &&str)| {
            model.joint(name).ok_or_else(|| {
                let known: Vec<&str> =
                    model.joints().iter().map(|joint| joint.name.as_str()).collect();
                let near = known.iter().min_by_key(|k| strsim::damerau_levenshtein(k, name));
                let hint = near.map_or(String::new(), |near| format!(" such as {near:?}"));
                let field = format!("joints[{index}]");
                InvalidInput::new(field, format!("{name:?}"), format!("a joint's name{hint}"))
            })
        };
        names.iter().enumerate().map(find).collect::<Result<_, _>>()?
    };
    if moving.is_empty() || moving.len() > MAX_DOF {
        let allowed = format!("1 to {MAX_DOF} joints that move");
        return Err(InvalidInput::new("joints", moving.len(), allowed));
    }
    Ok(moving)
}

/// For each joint the value at which it is held if it does not move.
fn held_values(model: &Model, held: &HashMap<String, f64>) -> Result<Vec<f64>, InvalidInput> {
    for name in held.keys() {
        if model.joint(name).is_none() {
            return Err(InvalidInput::new("held", format!("{name:?}"), "a joint's name"));
        }
    }
    let value = |joint: &super::Joint| match (held.get(&joint.name), joint.limits) {
        (Some(&value), _) => finite(&format!("held.{}", joint.name), value),
        (None, Some(limits))
            if matches!(joint.kind, JointKind::Revolute | JointKind::Prismatic) =>
        {
            Ok(0.0_f64.clamp(limits.lower, limits.upper))
        }
        (None, _) => Ok(0.0),
    };
    model.joints().iter().map(value).collect()
}
