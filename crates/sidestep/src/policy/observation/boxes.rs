//! Obstacles as numbers: centre and size of each bounding box.

use super::centred;
use crate::error::InvalidInput;
use crate::objective::Objective;
use crate::plane::world::{Obstacle, World};

/// `[count x 4]` of bounding box centre and size; shapes only, in the world's order.
pub(super) fn obstacle_boxes(
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
pub(super) fn nearest_boxes(
    world: &World,
    objective: &Objective,
    count: usize,
) -> Result<Vec<f32>, InvalidInput> {
    refuse_grid(world, "nearest-obstacles", count)?;
    let mut boxes: Vec<[f32; 4]> =
        world.obstacles().iter().map(|obstacle| centre_and_size(obstacle, objective)).collect();
    let (start, goal) =
        (centred(objective, objective.start()), centred(objective, objective.goal()));
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

/// A grid has no boxes to list.
fn refuse_grid(world: &World, part: &str, count: usize) -> Result<(), InvalidInput> {
    if world.grid().is_none() {
        return Ok(());
    }
    let allowed = format!("shapes only, for the policy's observation {part}:{count}");
    Err(InvalidInput::new("task.grid", "an occupancy grid", allowed))
}

/// Bounding boxes of a task's obstacles, for [`around`].
pub(super) fn all_boxes(
    world: &World,
    objective: &Objective,
    count: usize,
) -> Result<Vec<Box>, InvalidInput> {
    refuse_grid(world, "waypoint-obstacles", count)?;
    let frame = objective.scene().frame();
    let normalised = |obstacle: &Obstacle| {
        let bounds = obstacle.bounding_box();
        let [min, max] = [bounds.min, bounds.max].map(|p| frame.to_normalised(p));
        let half = |axis: usize| 0.5 * (max[axis] - min[axis]);
        Box { centre: [0, 1].map(|a| 0.5 * (min[a] + max[a])), half: [half(0), half(1)] }
    };
    Ok(world.obstacles().iter().map(normalised).collect())
}

/// Lengths are multiplied by this: gradients are of a tenth, and should not go under beside them.
const SCALE: f32 = 0.1;

/// A bounding box, in normalised units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Box {
    centre: [f32; 2],
    half: [f32; 2],
}

impl Box {
    /// Signed distance of a point.
    fn distance(&self, p: [f32; 2]) -> f32 {
        let [u, v] = [0, 1].map(|a| (p[a] - self.centre[a]).abs() - self.half[a]);
        u.max(0.0).hypot(v.max(0.0)) + u.max(v).min(0.0)
    }
}

/// Offset to the centre (clamped to 2, in normalised units) and size of the `out.len() / 4` boxes nearest to `p`, nearest first;
/// zero where there are fewer.
pub(super) fn around(boxes: &[Box], p: [f32; 2], out: &mut [f32]) {
    out.fill(0.0);
    let mut before = (f32::NEG_INFINITY, 0);
    for out in out.chunks_exact_mut(4) {
        let ranks = boxes.iter().enumerate().map(|(index, near)| (near.distance(p), index + 1));
        let next = ranks
            .filter(|rank| *rank > before)
            .min_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        let Some(rank) = next else { return };
        let Box { centre, half } = boxes[rank.1 - 1];
        for axis in 0..2 {
            out[axis] = SCALE * (centre[axis] - p[axis]).clamp(-2.0, 2.0);
            out[2 + axis] = SCALE * 2.0 * half[axis];
        }
        before = rank;
    }
}

/// Centre and size of an obstacle's bounding box, from the field's centre in half-extents.
fn centre_and_size(obstacle: &Obstacle, objective: &Objective) -> [f32; 4] {
    let (frame, bounds) = (objective.scene().frame(), obstacle.bounding_box());
    let [min, max] = [bounds.min, bounds.max].map(|p| centred(objective, frame.to_normalised(p)));
    [0.5 * (min[0] + max[0]), 0.5 * (min[1] + max[1]), max[0] - min[0], max[1] - min[1]]
}
