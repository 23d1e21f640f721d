//! What a learned optimizer sees: named parts, concatenated in the order they are listed.
//!
//! Training and planning call this same encoder. The paper's agents see the gradient (20 numbers
//! for 10 waypoints), the gradient and obstacle cost (31), or one of the wider observations of its
//! section III.D.

use crate::error::InvalidInput;
use crate::objective::Objective;
use crate::world::{Obstacle, World};

/// One part of an observation. N is the number of waypoints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ObservationPart {
    /// The gradient of U, `[N x 2]`.
    Gradient,
    /// The obstacle cost of each waypoint, then their mean: N + 1 numbers.
    ObstacleCost,
    /// The gradients of the last `count` steps, newest first, zero before the first: `[count x N x 2]`.
    PreviousGradients {
        /// How many earlier gradients.
        count: usize,
    },
    /// The waypoints in normalised units, `[N x 2]`.
    Trajectory,
    /// Centre and size of each obstacle's bounding box in normalised units, `[count x 4]`, zero
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
    /// Start and goal in normalised units: 4 numbers.
    Ends,
}

/// Most earlier gradients that an observation may hold.
const MAX_PREVIOUS: usize = 64;
/// Most obstacles that an observation may hold.
const MAX_OBSTACLES: usize = 4096;

impl ObservationPart {
    /// The part's name: `gradient`, `obstacle-cost`, `previous-gradients:K`, `trajectory`, `obstacles:K`,
    /// `nearest-obstacles:K`, `ends`.
    pub fn name(&self) -> String {
        match self {
            Self::Gradient => "gradient".into(),
            Self::ObstacleCost => "obstacle-cost".into(),
            Self::PreviousGradients { count } => format!("previous-gradients:{count}"),
            Self::Trajectory => "trajectory".into(),
            Self::Obstacles { count } => format!("obstacles:{count}"),
            Self::NearestObstacles { count } => format!("nearest-obstacles:{count}"),
            Self::Ends => "ends".into(),
        }
    }

    /// The part of that name.
    ///
    /// # Errors
    /// If there is none, or its number is out of range.
    pub fn named(name: &str) -> Result<Self, InvalidInput> {
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
            ("previous-gradients", _) => {
                Ok(Self::PreviousGradients { count: count(MAX_PREVIOUS)? })
            }
            ("obstacles", _) => Ok(Self::Obstacles { count: count(MAX_OBSTACLES)? }),
            ("nearest-obstacles", _) => {
                Ok(Self::NearestObstacles { count: count(MAX_OBSTACLES)? })
            }
            _ => Err(refuse(
                "gradient, obstacle-cost, previous-gradients:K, trajectory, ends, obstacles:K or \
                 nearest-obstacles:K"
                    .into(),
            )),
        }
    }

    /// How many numbers the part takes for `waypoints` waypoints.
    pub fn len(&self, waypoints: usize) -> usize {
        match self {
            Self::Gradient | Self::Trajectory => 2 * waypoints,
            Self::ObstacleCost => waypoints + 1,
            Self::PreviousGradients { count } => count * 2 * waypoints,
            Self::Obstacles { count } | Self::NearestObstacles { count } => 4 * count,
            Self::Ends => 4,
        }
    }

    /// Never: each part holds at least one number.
    pub fn is_empty(&self) -> bool {
        false
    }
}

/// Checks that a list of parts makes an observation, and returns its length.
///
/// # Errors
/// If the list is empty or names a kind of part twice.
pub fn observation_len(parts: &[ObservationPart], waypoints: usize) -> Result<usize, InvalidInput> {
    if parts.is_empty() {
        return Err(InvalidInput::new("observation", "no part", "at least one part"));
    }
    for (i, part) in parts.iter().enumerate() {
        let same_kind = |other: &&ObservationPart| {
            std::mem::discriminant(*other) == std::mem::discriminant(part)
        };
        if parts[..i].iter().any(|other| same_kind(&other)) {
            return Err(InvalidInput::new("observation", part.name(), "each kind of part once"));
        }
    }
    Ok(parts.iter().map(|part| part.len(waypoints)).sum())
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
}

impl Encoder {
    /// An encoder for a task of `objective`.
    ///
    /// # Errors
    /// If the parts contradict each other or the world has more obstacles than the observation.
    pub fn new(
        parts: &[ObservationPart],
        objective: &Objective,
        world: &World,
    ) -> Result<Self, InvalidInput> {
        observation_len(parts, objective.waypoints())?;
        let mut encoder =
            Self { parts: parts.to_vec(), previous: vec![], obstacles: vec![], nearest: vec![] };
        for part in parts {
            match *part {
                ObservationPart::PreviousGradients { count } => {
                    encoder.previous = vec![0.0; count * objective.dim()];
                }
                ObservationPart::Obstacles { count } => {
                    encoder.obstacles = obstacle_boxes(world, objective, count)?;
                }
                ObservationPart::NearestObstacles { count } => {
                    encoder.nearest = nearest_boxes(world, objective, count)?;
                }
                _ => {}
            }
        }
        Ok(encoder)
    }

    /// Length of the observation.
    pub fn len(&self, objective: &Objective) -> usize {
        self.parts.iter().map(|part| part.len(objective.waypoints())).sum()
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
            let (part_out, after) =
                std::mem::take(&mut rest).split_at_mut(part.len(objective.waypoints()));
            rest = after;
            match part {
                ObservationPart::Gradient => part_out.copy_from_slice(gradient),
                ObservationPart::Trajectory => part_out.copy_from_slice(x),
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
                ObservationPart::Ends => {
                    part_out[..2].copy_from_slice(&objective.start());
                    part_out[2..].copy_from_slice(&objective.goal());
                }
            }
        }
    }
}

/// `[count x 4]` of bounding box centre and size; shapes only, in the world's order.
fn obstacle_boxes(
    world: &World,
    objective: &Objective,
    count: usize,
) -> Result<Vec<f32>, InvalidInput> {
    let obstacles = world.obstacles();
    if obstacles.len() > count || world.grid().is_some() {
        let kind = if world.grid().is_some() { "an occupancy grid" } else { "shapes" };
        return Err(InvalidInput::new(
            "task.obstacles",
            format!("{} obstacles ({kind})", obstacles.len()),
            format!("at most {count} shapes, as the policy's observation obstacles:{count} holds"),
        ));
    }
    let mut out = vec![0.0; 4 * count];
    for (obstacle, out) in obstacles.iter().zip(out.chunks_mut(4)) {
        out.copy_from_slice(&centre_and_size(obstacle, objective));
    }
    Ok(out)
}

/// `[count x 4]`, the boxes nearest to the straight line from start to goal; ties keep the world's order.
fn nearest_boxes(
    world: &World,
    objective: &Objective,
    count: usize,
) -> Result<Vec<f32>, InvalidInput> {
    if world.grid().is_some() {
        return Err(InvalidInput::new(
            "task.grid",
            "an occupancy grid",
            format!("shapes only, for the policy's observation nearest-obstacles:{count}"),
        ));
    }
    let mut boxes: Vec<[f32; 4]> =
        world.obstacles().iter().map(|obstacle| centre_and_size(obstacle, objective)).collect();
    let (start, goal) = (objective.start(), objective.goal());
    let along = [goal[0] - start[0], goal[1] - start[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    // From the box's centre to the segment; the size is left out, which keeps the order smooth in it.
    let from_line = |[x, y, ..]: &[f32; 4]| {
        let offset = [x - start[0], y - start[1]];
        let t = (offset[0] * along[0] + offset[1] * along[1]) / square.max(f32::MIN_POSITIVE);
        let t = t.clamp(0.0, 1.0);
        (offset[0] - t * along[0]).hypot(offset[1] - t * along[1])
    };
    boxes.sort_by(|a, b| from_line(a).total_cmp(&from_line(b)));
    boxes.resize(count, [0.0; 4]);
    Ok(boxes.into_iter().flatten().collect())
}

/// Centre and size of an obstacle's bounding box, normalised units.
fn centre_and_size(obstacle: &Obstacle, objective: &Objective) -> [f32; 4] {
    let (frame, bounds) = (objective.scene().frame(), obstacle.bounding_box());
    let (min, max) = (frame.to_normalised(bounds.min), frame.to_normalised(bounds.max));
    [0.5 * (min[0] + max[0]), 0.5 * (min[1] + max[1]), max[0] - min[0], max[1] - min[1]]
}
