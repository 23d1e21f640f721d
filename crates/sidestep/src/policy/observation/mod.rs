//! What a learned optimizer sees: named parts, concatenated in the order they are listed.
//!
//! Training and planning call this same encoder. The paper's agents see the gradient (20 numbers
//! for 10 waypoints), the gradient and obstacle cost (31), or one of the wider observations of its
//! section III.D.

mod own;

pub use own::OwnPart;

use crate::error::InvalidInput;
use crate::network::{FEATURES, IMAGE_SIDE};
use crate::objective::Objective;
use crate::plane::Subject;
use crate::plane::surroundings::boxes::{self, BoundingBox};
use crate::plane::surroundings::image::{self, Trail};
use crate::plane::surroundings::waypoint_image;
use crate::profile::NORMALISED_EXTENT;

/// One part of an observation. N is the number of waypoints, dof that of a configuration's coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ObservationPart {
    /// The gradient of U, `[N x dof]`.
    Gradient,
    /// The obstacle cost of each waypoint, then their mean: N + 1 numbers.
    ObstacleCost,
    /// The gradients of the last `count` steps, newest first, zero before the first: `[count x N x dof]`.
    PreviousGradients {
        /// How many earlier gradients.
        count: usize,
    },
    /// The waypoints from the field's centre in half-extents (`centred_all`), `[N x dof]`.
    Trajectory,
    /// Centre and size of each obstacle's bounding box in the same units, `[count x 4]`, zero
    /// where there are fewer.
    Obstacles {
        /// Most obstacles that a task may have.
        count: usize,
    },
    /// The same for the obstacles nearest to the straight line from start to goal, nearest first: an order that means
    /// something. Obstacles beyond `count` are not seen, so there may be any number.
    NearestObstacles {
        /// How many are seen.
        count: usize,
    },
    /// Centre from the waypoint and size, in normalised units, of the obstacles nearest to each waypoint: `[N x count x 4]`.
    WaypointObstacles {
        /// How many each waypoint sees.
        count: usize,
    },
    /// Start and goal in the same units: `[2 x dof]`.
    Ends,
    /// The workspace and the trajectory as an image, `[64 x 64]` (`image.rs`).
    Image,
    /// The same around each waypoint, in pictures of 16 x 16 that make one image `[64 x 64]`; of at most 16 waypoints
    /// (`waypoint_image.rs`).
    WaypointImage,
    /// A part of one's own.
    Own(OwnPart),
}

/// Most earlier gradients that an observation may hold.
const MAX_PREVIOUS: usize = 64;
/// Most obstacles that a waypoint may see.
const MAX_NEAR: usize = 64;
/// Most obstacles that an observation may hold.
const MAX_OBSTACLES: usize = 4096;

impl ObservationPart {
    /// The part's name: `gradient`, `obstacle-cost`, `previous-gradients:K`, `trajectory`, `obstacles:K`,
    /// `nearest-obstacles:K`, `waypoint-obstacles:K`, `ends`, `image`, `waypoint-image`.
    pub fn name(&self) -> String {
        match self {
            Self::Gradient => "gradient".into(),
            Self::ObstacleCost => "obstacle-cost".into(),
            Self::PreviousGradients { count } => format!("previous-gradients:{count}"),
            Self::Trajectory => "trajectory".into(),
            Self::Obstacles { count } => format!("obstacles:{count}"),
            Self::NearestObstacles { count } => format!("nearest-obstacles:{count}"),
            Self::WaypointObstacles { count } => format!("waypoint-obstacles:{count}"),
            Self::Ends => "ends".into(),
            Self::Image => "image".into(),
            Self::WaypointImage => "waypoint-image".into(),
            Self::Own(own) => format!("own:{}", own.name),
        }
    }

    /// The part of that name, where those of one's own are `own`.
    ///
    /// # Errors
    /// If there is no part of that name.
    pub fn named(name: &str, own: &[OwnPart]) -> Result<Self, InvalidInput> {
        let Some(word) = name.strip_prefix("own:") else { return name.parse() };
        let found = own.iter().find(|part| part.name == word);
        let known: Vec<_> = own.iter().map(|part| format!("own:{}", part.name)).collect();
        let allowed = match known.len() {
            0 => "the parts that are there, or one's own given in Rust with the policy".into(),
            _ => known.join(" or "),
        };
        found.map(|part| Self::Own(*part)).ok_or(InvalidInput::new("observation", name, allowed))
    }

    /// How many numbers the part takes for `waypoints` waypoints of `dof` coordinates.
    pub fn len(&self, waypoints: usize, dof: usize) -> usize {
        match self {
            Self::Gradient | Self::Trajectory => dof * waypoints,
            Self::ObstacleCost => waypoints + 1,
            Self::PreviousGradients { count } => count * dof * waypoints,
            Self::Obstacles { count } | Self::NearestObstacles { count } => 4 * count,
            Self::WaypointObstacles { count } => 4 * count * waypoints,
            Self::Ends => 2 * dof,
            Self::Image | Self::WaypointImage => IMAGE_SIDE * IMAGE_SIDE,
            Self::Own(own) => (own.len)(waypoints, dof),
        }
    }

    /// Never: an observation's parts hold at least one number each.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Whether it is an image, which convolutions read.
    pub fn is_image(&self) -> bool {
        matches!(self, Self::Image | Self::WaypointImage)
    }
}

impl std::str::FromStr for ObservationPart {
    type Err = InvalidInput;

    /// The part of that name.
    fn from_str(name: &str) -> Result<Self, InvalidInput> {
        let refuse = |allowed: String| InvalidInput::new("observation", name, allowed);
        let (word, number) = match name.split_once(':') {
            Some((word, number)) => (word, Some(number)),
            None => (name, None),
        };
        let count = |most: usize| {
            number
                .and_then(|n| n.parse::<usize>().ok())
                .filter(|n| (1..=most).contains(n))
                .ok_or_else(|| refuse(format!("{word}:K with K from 1 to {most}")))
        };
        match (word, number) {
            ("gradient", None) => Ok(Self::Gradient),
            ("obstacle-cost", None) => Ok(Self::ObstacleCost),
            ("trajectory", None) => Ok(Self::Trajectory),
            ("ends", None) => Ok(Self::Ends),
            ("image", None) => Ok(Self::Image),
            ("own", Some(_)) => Self::named(name, &[]),
            ("waypoint-image", None) => Ok(Self::WaypointImage),
            ("previous-gradients", _) => {
                Ok(Self::PreviousGradients { count: count(MAX_PREVIOUS)? })
            }
            ("obstacles", _) => Ok(Self::Obstacles { count: count(MAX_OBSTACLES)? }),
            ("nearest-obstacles", _) => Ok(Self::NearestObstacles { count: count(MAX_OBSTACLES)? }),
            ("waypoint-obstacles", _) => Ok(Self::WaypointObstacles { count: count(MAX_NEAR)? }),
            _ => Err(refuse(
                "gradient, obstacle-cost, previous-gradients:K, trajectory, ends, obstacles:K, \
                 nearest-obstacles:K, waypoint-obstacles:K, image or waypoint-image"
                    .into(),
            )),
        }
    }
}

impl std::fmt::Display for ObservationPart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.name())
    }
}

/// Checks that a list of parts makes an observation, and returns its length.
///
/// # Errors
/// If the list is empty, names a kind of part twice, has two images, the waypoints are more than one of the parts holds, or a part of
/// one's own is empty or too long.
pub fn observation_len(
    parts: &[ObservationPart],
    waypoints: usize,
    dof: usize,
) -> Result<usize, InvalidInput> {
    if parts.is_empty() {
        return Err(InvalidInput::new("observation", "no part", "at least one part"));
    }
    for (i, part) in parts.iter().enumerate() {
        let same_kind = |other: &&ObservationPart| match (other, part) {
            (ObservationPart::Own(other), ObservationPart::Own(own)) => other == own,
            _ => std::mem::discriminant(*other) == std::mem::discriminant(part),
        };
        if parts[..i].iter().any(|other| same_kind(&other)) {
            return Err(InvalidInput::new("observation", part.name(), "each kind of part once"));
        }
        if part.is_image() && parts[..i].iter().any(ObservationPart::is_image) {
            return Err(InvalidInput::new("observation", part.name(), "one image"));
        }
        if *part == ObservationPart::WaypointImage {
            waypoint_image::check(waypoints)?;
        }
        if let ObservationPart::Own(own) = part {
            own.check(waypoints, dof)?;
        }
    }
    Ok(parts.iter().map(|part| part.len(waypoints, dof)).sum())
}

/// Where the image begins in an observation of these parts, if there is one.
pub fn image_place(parts: &[ObservationPart], waypoints: usize, dof: usize) -> Option<usize> {
    let index = parts.iter().position(ObservationPart::is_image)?;
    Some(parts[..index].iter().map(|part| part.len(waypoints, dof)).sum())
}

/// Name of the architecture that reads an observation of these parts: `cnn` where there is an image, else `mlp`.
pub fn architecture_for(parts: &[ObservationPart]) -> &'static str {
    if parts.iter().any(ObservationPart::is_image) { "cnn" } else { "mlp" }
}

/// Sizes of the layers of a network that reads `parts` of so many waypoints of `dof` coordinates, with these hidden layers.
pub fn sizes_for(
    parts: &[ObservationPart],
    waypoints: usize,
    dof: usize,
    hidden: &[usize],
    outputs: usize,
) -> Vec<usize> {
    let mut sizes = vec![parts.iter().map(|part| part.len(waypoints, dof)).sum()];
    sizes.extend(image_place(parts, waypoints, dof).map(|_| FEATURES));
    sizes.extend_from_slice(hidden);
    sizes.push(outputs);
    sizes
}

/// Writes observations of one task, and remembers what its parts need from earlier steps.
#[derive(Debug, Clone)]
pub struct Encoder {
    parts: Vec<ObservationPart>,
    /// Earlier gradients, newest first: `[count x N x 2]`.
    previous: Vec<f32>,
    /// The obstacles parts, which do not change during a task.
    obstacles: Vec<f32>,
    nearest: Vec<f32>,
    boxes: Vec<BoundingBox>,
    /// The workspace without a trajectory, for the images.
    workspace: Vec<f32>,
    trail: Trail,
}

impl Encoder {
    /// An encoder for a task of `objective`.
    ///
    /// # Errors
    /// If the parts contradict each other or the world has more obstacles than the observation.
    pub fn new(parts: &[ObservationPart], objective: &Objective) -> Result<Self, InvalidInput> {
        observation_len(parts, objective.waypoints(), objective.dof())?;
        let plane = |part: &ObservationPart| {
            let refuse =
                || InvalidInput::new("observation", part.name(), "parts that need no plane");
            objective.plane().ok_or_else(refuse)
        };
        let mut encoder = Self {
            parts: parts.to_vec(),
            previous: vec![],
            obstacles: vec![],
            nearest: vec![],
            boxes: vec![],
            workspace: vec![],
            trail: Trail::default(),
        };
        for part in parts {
            match *part {
                ObservationPart::PreviousGradients { count } => {
                    encoder.previous = vec![0.0; count * objective.dim()];
                }
                ObservationPart::Obstacles { count } => {
                    encoder.obstacles = boxes::obstacle_boxes(plane(part)?, count)?;
                }
                ObservationPart::Image => {
                    encoder.workspace = image::workspace(plane(part)?.scene.world());
                }
                ObservationPart::WaypointImage => {
                    encoder.workspace = waypoint_image::depths(plane(part)?);
                }
                ObservationPart::NearestObstacles { count } => {
                    encoder.nearest = boxes::nearest_boxes(plane(part)?, count)?;
                }
                ObservationPart::WaypointObstacles { count } => {
                    encoder.boxes = boxes::all_boxes(plane(part)?, count)?;
                }
                _ => {}
            }
        }
        Ok(encoder)
    }

    /// Length of the observation.
    pub fn len(&self, objective: &Objective) -> usize {
        self.parts.iter().map(|part| part.len(objective.waypoints(), objective.dof())).sum()
    }

    /// Never: an observation holds at least one number.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Forgets earlier steps.
    pub fn reset(&mut self) {
        self.previous.fill(0.0);
    }

    /// Earlier gradients that the encoder remembers, for checkpoints.
    pub fn memory(&self) -> &[f32] {
        &self.previous
    }

    /// Puts back what [`Encoder::memory`] gave; a slice of another length is ignored.
    pub fn restore(&mut self, memory: &[f32]) {
        if memory.len() == self.previous.len() {
            self.previous.copy_from_slice(memory);
        }
    }

    /// Writes the observation of the waypoints `x`, whose `gradient` `objective` has just computed.
    pub fn encode(&mut self, objective: &Objective, x: &[f32], gradient: &[f32], out: &mut [f32]) {
        let mut rest = out;
        for part in &self.parts {
            let (part_out, after) = std::mem::take(&mut rest)
                .split_at_mut(part.len(objective.waypoints(), objective.dof()));
            rest = after;
            match part {
                ObservationPart::Gradient => part_out.copy_from_slice(gradient),
                ObservationPart::Trajectory => centred_all(objective, x, part_out),
                ObservationPart::ObstacleCost => {
                    let (costs, mean) = part_out.split_at_mut(objective.waypoints());
                    for (out, cost) in costs.iter_mut().zip(objective.waypoint_costs()) {
                        *out = cost;
                    }
                    mean[0] = costs.iter().sum::<f32>() / costs.len() as f32;
                }
                ObservationPart::PreviousGradients { .. } => {
                    part_out.copy_from_slice(&self.previous);
                    let kept = self.previous.len() - gradient.len();
                    self.previous.copy_within(..kept, gradient.len());
                    self.previous[..gradient.len()].copy_from_slice(gradient);
                }
                ObservationPart::Obstacles { .. } => part_out.copy_from_slice(&self.obstacles),
                ObservationPart::NearestObstacles { .. } => part_out.copy_from_slice(&self.nearest),
                ObservationPart::Image => {
                    part_out.copy_from_slice(&self.workspace);
                    follow(&mut self.trail, objective.plane(), x);
                    self.trail.draw(part_out);
                }
                ObservationPart::WaypointImage => {
                    follow(&mut self.trail, objective.plane(), x);
                    waypoint_image::draw(&self.workspace, &self.trail, part_out);
                }
                ObservationPart::WaypointObstacles { count } => {
                    boxes::around_all(&self.boxes, x, *count, part_out);
                }
                ObservationPart::Own(own) => (own.write)(objective, x, gradient, part_out),
                ObservationPart::Ends => {
                    let (start, goal) = part_out.split_at_mut(objective.dof());
                    centred_all(objective, objective.start(), start);
                    centred_all(objective, objective.goal(), goal);
                }
            }
        }
    }
}

/// Draws the trajectory in the plane; `Encoder::new` refused images of others.
fn follow(trail: &mut Trail, subject: Option<Subject<'_>>, x: &[f32]) {
    if let Some(subject) = subject {
        trail.follow(subject, x);
    }
}

/// Half of the field's larger side, in normalised units.
const HALF_EXTENT: f32 = 0.5 * NORMALISED_EXTENT as f32;

/// Configurations `[.. x dof]` from the middle of their limits, in half-extents: in [-1, 1]. Positions of 0 to 6.4 beside gradients
/// of a tenth would saturate the hidden units, and the gradient would go under (docs/research/wide-observations.md).
fn centred_all(objective: &Objective, x: &[f32], out: &mut [f32]) {
    let limits = objective.scene().normalised_limits();
    for (out, p) in out.chunks_exact_mut(limits.len()).zip(x.chunks_exact(limits.len())) {
        for ((out, p), [least, most]) in out.iter_mut().zip(p).zip(limits) {
            *out = (p - 0.5 * (least + most)) / HALF_EXTENT;
        }
    }
}

#[cfg(test)]
mod tests;
