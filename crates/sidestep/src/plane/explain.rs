//! What is wrong with a start or goal, in numbers, and what somebody may have meant.

use crate::plane::certificate::Certifier;
use crate::plane::geometry::{Point, Rect, add, scale};
use crate::plane::{PlaneTask, Robot};
use crate::trajectory::{Trajectory, Violation};

/// Directions and distances in which a free point is looked for.
const DIRECTIONS: usize = 64;
const RINGS: usize = 48;

/// The violation of a task's end in words: where the end lies, the bounds, the robot's size, how near the
/// obstacle is, and where the robot could stand instead. Other violations are told as they are.
///
/// `task` is the task for the robot itself, `margin` what it was asked to keep from everything, in task units.
pub fn explain(task: &PlaneTask<'_>, margin: f64, violation: &Violation) -> String {
    let end = match violation {
        Violation::StartOutOfBounds | Violation::StartInCollision { .. } => task.start,
        Violation::GoalOutOfBounds | Violation::GoalInCollision { .. } => task.goal,
        _ => return violation.to_string(),
    };
    let detail = match violation {
        Violation::StartOutOfBounds | Violation::GoalOutOfBounds => outside(task, margin, end),
        _ => collision(task, margin, end),
    };
    format!("{violation}: {detail}")
}

fn outside(task: &PlaneTask<'_>, margin: f64, end: Point) -> String {
    let bounds = task.world.bounds();
    let (place, field) = (point(end), field(&bounds));
    let radius = task.robot.radius();
    if bounds.contains(end) {
        let body = body(radius, margin);
        let smallest = bounds.size()[0].min(bounds.size()[1]);
        return if 2.0 * (radius + margin) > smallest {
            format!("{body} at {place} does not fit into {field}")
        } else {
            format!("{body} at {place} reaches past {field}{}", instead(task, margin, end))
        };
    }
    let hint = if bounds.contains([end[1], end[0]]) {
        "; with x and y swapped it would lie inside".into()
    } else {
        cells(task, end).unwrap_or_default()
    };
    format!("{place} is not in {field}{hint}")
}

/// What a point means that lies in a map only as a cell of it.
fn cells(task: &PlaneTask<'_>, end: Point) -> Option<String> {
    let grid = task.world.grid()?;
    let size = [grid.width() as f64, grid.height() as f64];
    let is_cell = (0..2).all(|axis| (0.0..=size[axis]).contains(&end[axis]));
    let resolution = grid.resolution();
    if !is_cell || resolution == 1.0 {
        return None;
    }
    let place = point(add(grid.origin(), scale(end, resolution)));
    let unit = number(resolution);
    Some(format!("; in cells of {unit}, from the lower left corner, that would be {place}"))
}

fn collision(task: &PlaneTask<'_>, margin: f64, end: Point) -> String {
    let radius = task.robot.radius();
    let away = clearance(task, end);
    let place = point(end);
    let how = if away <= 0.0 {
        format!("{place} lies on or inside it")
    } else {
        let spare = match margin {
            0.0 => String::new(),
            _ if away > radius => {
                format!(" (the robot itself has {} to spare)", number(away - radius))
            }
            _ => String::new(),
        };
        format!("{place} is {} from it, too near for {}{spare}", number(away), body(radius, margin))
    };
    format!("{how}{}", instead(task, margin, end))
}

/// Distance from a point to what is nearest, walls included.
fn clearance(task: &PlaneTask<'_>, end: Point) -> f64 {
    let line = Trajectory::from_points(&[end, end]);
    Certifier::new(task.world, Robot::Point).clearance(&line)
}

/// Where the robot could stand, looked for on growing rings.
fn instead(task: &PlaneTask<'_>, margin: f64, end: Point) -> String {
    let Ok(robot) = Robot::disc(task.robot.radius() + margin) else { return String::new() };
    let certifier = Certifier::new(task.world, robot);
    let extent = task.world.bounds().extent();
    let on_ring = |ring: usize| {
        let radius = extent * 2f64.powf(0.25 * (ring as f64 - RINGS as f64));
        (0..DIRECTIONS).map(move |k| {
            let angle = std::f64::consts::TAU * k as f64 / DIRECTIONS as f64;
            add(end, scale([angle.cos(), angle.sin()], radius))
        })
    };
    let free = (0..=RINGS).flat_map(on_ring).find(|&p| certifier.point_is_free(p));
    free.map_or_else(String::new, |p| format!("; {} is free", point(p)))
}

fn body(radius: f64, margin: f64) -> String {
    let robot = match radius {
        0.0 => "a point robot".to_string(),
        _ => format!("a robot of radius {}", number(radius)),
    };
    match margin {
        0.0 => robot,
        _ => format!("{robot} with a margin of {}", number(margin)),
    }
}

fn field(bounds: &Rect) -> String {
    let [min, max] =
        [bounds.min, bounds.max].map(|[x, y]| format!("[{}, {}]", number(x), number(y)));
    format!("{min} to {max}")
}

fn point(p: Point) -> String {
    format!("({}, {})", number(p[0]), number(p[1]))
}

/// A number with six decimals at most.
fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::plan::{Options, Planner, Status, plan};
    use crate::plane::world::{Grid, Obstacle, World};
    use crate::scene::Task;

    /// What a task with a start and a margin is told, in a field of 20 x 10 with a block in it.
    fn told(world: World, start: Point, radius: f64, margin: f64) -> String {
        let robot = Robot::disc(radius).unwrap();
        let task = Task::in_plane("", Arc::new(world), robot, start, [1.0, 1.0]).unwrap();
        let asked = task.with_margin(margin).unwrap();
        let plan = plan(&asked, &Planner::ShortestPath, &Options::default()).unwrap();
        let Status::Invalid(violation) = plan.status else { panic!("{plan:?}") };
        explain(&task.plane().unwrap(), margin, &violation)
    }

    fn field() -> World {
        let bounds = Rect { min: [0.0; 2], max: [20.0, 10.0] };
        let block = Rect { min: [8.0, 4.0], max: [12.0, 6.0] };
        World::new(bounds, vec![Obstacle::Rect(block)], None)
    }

    #[test]
    fn ends_are_explained() {
        for (start, radius, margin, parts) in [
            (
                [4.0, 15.0],
                0.0,
                0.0,
                &["(4, 15) is not in [0, 0] to [20, 10]", "x and y swapped"][..],
            ),
            ([40.0, 15.0], 0.0, 0.0, &["(40, 15) is not in [0, 0] to [20, 10]"]),
            ([0.1, 5.0], 0.2, 0.0, &["a robot of radius 0.2 at (0.1, 5) reaches past", "is free"]),
            ([5.0, 5.0], 6.0, 0.0, &["a robot of radius 6 at (5, 5) does not fit into"]),
            ([5.0, 5.0], 0.0, 6.0, &["a point robot with a margin of 6 at (5, 5) does not fit"]),
            ([9.0, 5.0], 0.0, 0.0, &["in collision with obstacle 0: (9, 5) lies on or inside it"]),
            (
                [7.9, 5.0],
                0.05,
                0.25,
                &[
                    "(7.9, 5) is 0.1 from it, too near for a robot of radius 0.05 with a margin of 0.25",
                    "the robot itself has 0.05 to spare",
                    "is free",
                ],
            ),
        ] {
            let told = told(field(), start, radius, margin);
            for part in parts {
                assert!(told.contains(part), "{start:?}: {told}");
            }
        }
    }

    #[test]
    fn cells_of_a_map_are_told_from_metres() {
        let grid = Grid::new(100, 60, 0.05, [-1.0, 0.0], vec![false; 6000]).unwrap();
        let world = World::new(grid.rect(), Vec::new(), Some(grid));
        let told = told(world, [80.0, 40.0], 0.0, 0.0);
        assert!(
            told.contains("in cells of 0.05, from the lower left corner, that would be (3, 2)"),
            "{told}"
        );
    }
}
