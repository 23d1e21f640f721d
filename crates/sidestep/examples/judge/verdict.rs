//! Whether a plan keeps clear of everything, exactly.

use sidestep::plane::geometry::{Point, Rect};
use sidestep::plane::points;
use sidestep::{PlaneTask, Trajectory};

use crate::exact::{Solid, is_inside, keeps_clear};

/// What is wrong with a path that is called solved; nothing where it is right.
pub fn fault(task: &PlaneTask<'_>, path: &Trajectory) -> Option<String> {
    let points = points(path);
    if points.first() != Some(&task.start) || points.last() != Some(&task.goal) {
        return Some("it does not lead from start to goal".into());
    }
    let radius = task.robot.radius();
    if let Some(point) = points.iter().position(|&p| !is_inside(&task.world.bounds(), p, radius)) {
        return Some(format!("point {point} leaves the bounds"));
    }
    let alone = (points.len() == 1).then(|| (points[0], points[0]));
    let segments = points.windows(2).map(|pair| (pair[0], pair[1])).chain(alone);
    segments.enumerate().find_map(|(segment, (a, b))| {
        let hit = |what: String| format!("segment {segment} meets {what}");
        let shapes = task.world.obstacles().iter().enumerate();
        let shape = shapes.filter(|(_, shape)| may_meet(a, b, &shape.bounding_box(), radius));
        let mut shape = shape.map(|(index, shape)| (index, Solid::from(shape)));
        let shape = shape.find(|(_, solid)| !keeps_clear(solid, a, b, radius));
        let shape = shape.map(|(index, _)| hit(format!("obstacle {index}")));
        shape.or_else(|| cell_in_the_way(task, a, b).map(|[x, y]| hit(format!("cell {x}, {y}"))))
    })
}

/// Whether a segment's box, grown by `radius` and rounding, overlaps another box.
fn may_meet(a: Point, b: Point, around: &Rect, radius: f64) -> bool {
    (0..2).all(|k| {
        let (low, high) = (a[k].min(b[k]), a[k].max(b[k]));
        let size = low.abs().max(high.abs()).max(around.min[k].abs()).max(around.max[k].abs());
        // A circle's box is rounded, and so are these differences.
        let hair = 8.0 * f64::EPSILON * (size + radius);
        around.min[k] - high <= radius + hair && low - around.max[k] <= radius + hair
    })
}

/// An occupied cell that the swept body meets.
fn cell_in_the_way(task: &PlaneTask<'_>, a: Point, b: Point) -> Option<[usize; 2]> {
    let (grid, radius) = (task.world.grid()?, task.robot.radius());
    let [columns, rows] = [0, 1].map(|k| {
        let count = if k == 0 { grid.width() } else { grid.height() };
        let index = |x: f64| (x - grid.origin()[k]) / grid.resolution();
        // A cell more on either side is far beyond rounding.
        let first = (index(a[k].min(b[k]) - radius) - 1.0).max(0.0) as usize;
        let last = (index(a[k].max(b[k]) + radius) + 2.0).max(0.0) as usize;
        first.min(count)..last.min(count)
    });
    rows.flat_map(|row| columns.clone().map(move |column| [column, row])).find(|&[column, row]| {
        grid.is_occupied(column as i64, row as i64)
            && may_meet(a, b, &grid.cell_rect(column as i64, row as i64), radius)
            && {
                let index = [column, row].map(|i| i as f64);
                let cell = Solid::Cell(grid.origin(), grid.resolution(), index);
                !keeps_clear(&cell, a, b, radius)
            }
    })
}
