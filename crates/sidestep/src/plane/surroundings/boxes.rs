//! Obstacles as numbers: centre and size of each bounding box.

use super::centred;
use crate::error::InvalidInput;
use crate::plane::Subject;
use crate::plane::world::{Obstacle, World};

/// `[count x 4]` of bounding box centre and size; shapes only, in the world's order.
pub(crate) fn obstacle_boxes(subject: Subject<'_>, count: usize) -> Result<Vec<f32>, InvalidInput> {
    let world = subject.scene.world();
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
        out.copy_from_slice(&centre_and_size(obstacle, subject));
    }
    Ok(out)
}

/// `[count x 4]`, the boxes nearest to the straight line from start to goal; ties keep the world's order.
pub(crate) fn nearest_boxes(subject: Subject<'_>, count: usize) -> Result<Vec<f32>, InvalidInput> {
    let world = subject.scene.world();
    refuse_grid(world, "nearest-obstacles", count)?;
    let mut boxes: Vec<[f32; 4]> =
        world.obstacles().iter().map(|obstacle| centre_and_size(obstacle, subject)).collect();
    let (start, goal) = (centred(subject, subject.start), centred(subject, subject.goal));
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
pub(crate) fn all_boxes(
    subject: Subject<'_>,
    count: usize,
) -> Result<Vec<BoundingBox>, InvalidInput> {
    let world = subject.scene.world();
    refuse_grid(world, "waypoint-obstacles", count)?;
    let frame = subject.scene.frame();
    let normalised = |obstacle: &Obstacle| {
        let bounds = obstacle.bounding_box();
        let [min, max] = [bounds.min, bounds.max].map(|p| frame.to_normalised(p));
        let half = |axis: usize| 0.5 * (max[axis] - min[axis]);
        BoundingBox { centre: [0, 1].map(|a| 0.5 * (min[a] + max[a])), half: [half(0), half(1)] }
    };
    Ok(world.obstacles().iter().map(normalised).collect())
}

/// Lengths are multiplied by this: gradients are of a tenth, and should not go under beside them.
const SCALE: f32 = 0.1;

/// A bounding box, in normalised units.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundingBox {
    centre: [f32; 2],
    half: [f32; 2],
}

impl BoundingBox {
    /// Signed distance of a point.
    fn distance(&self, p: [f32; 2]) -> f32 {
        let [u, v] = [0, 1].map(|a| (p[a] - self.centre[a]).abs() - self.half[a]);
        u.max(0.0).hypot(v.max(0.0)) + u.max(v).min(0.0)
    }
}

/// What each of the waypoints `x [N x 2]` sees of its `count` nearest boxes, `[N x count x 4]`; see [`around`].
pub(crate) fn around_all(boxes: &[BoundingBox], x: &[f32], count: usize, out: &mut [f32]) {
    for (&p, out) in x.as_chunks::<2>().0.iter().zip(out.chunks_exact_mut(4 * count)) {
        around(boxes, p, out);
    }
}

/// Offset to the centre (clamped to 2, in normalised units) and size of the `out.len() / 4` boxes nearest to `p`, nearest first;
/// zero where there are fewer.
fn around(boxes: &[BoundingBox], p: [f32; 2], out: &mut [f32]) {
    out.fill(0.0);
    let mut before = (f32::NEG_INFINITY, 0);
    for out in out.chunks_exact_mut(4) {
        let ranks = boxes.iter().enumerate().map(|(index, near)| (near.distance(p), index + 1));
        let next = ranks
            .filter(|rank| *rank > before)
            .min_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        let Some(rank) = next else { return };
        let BoundingBox { centre, half } = boxes[rank.1 - 1];
        for axis in 0..2 {
            out[axis] = SCALE * (centre[axis] - p[axis]).clamp(-2.0, 2.0);
            out[2 + axis] = SCALE * 2.0 * half[axis];
        }
        before = rank;
    }
}

/// Centre and size of an obstacle's bounding box, from the field's centre in half-extents.
fn centre_and_size(obstacle: &Obstacle, subject: Subject<'_>) -> [f32; 4] {
    let (frame, bounds) = (subject.scene.frame(), obstacle.bounding_box());
    let [min, max] = [bounds.min, bounds.max].map(|p| centred(subject, frame.to_normalised(p)));
    [0.5 * (min[0] + max[0]), 0.5 * (min[1] + max[1]), max[0] - min[0], max[1] - min[1]]
}
