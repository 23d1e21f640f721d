//! What is wrong with a start, a goal or a path, in numbers, and what somebody may have meant.

use crate::plane::certificate::Certifier;
use crate::plane::geometry::{Circle, Point, Rect, add, lerp, scale};
use crate::plane::world::Obstacle;
use crate::plane::{PlaneTask, Robot, place_near, points};
use crate::trajectory::{ObstacleId, Trajectory, Violation};

/// The violation of a task's end in words: where the end lies, the bounds, the robot's size, how near the
/// obstacle is, and where the robot could stand instead. Other violations are those of [`explain_path`] without a path.
///
/// `task` is the task for the robot itself, `margin` what it was asked to keep from everything, in task units.
pub fn explain(task: &PlaneTask<'_>, margin: f64, violation: &Violation) -> String {
    let end = match violation {
        Violation::StartOutOfBounds | Violation::StartInCollision { .. } => task.start,
        Violation::GoalOutOfBounds | Violation::GoalInCollision { .. } => task.goal,
        _ => return told(task, violation),
    };
    let detail = match violation {
        Violation::StartOutOfBounds | Violation::GoalOutOfBounds => outside(task, margin, end),
        _ => collision(task, margin, end),
    };
    format!("{}: {detail}", told(task, violation))
}

/// The violation of a path in words: which segment meets what, and where first.
///
/// `task` and `margin` as in [`explain`].
pub fn explain_path(
    task: &PlaneTask<'_>,
    margin: f64,
    path: &Trajectory,
    violation: &Violation,
) -> String {
    let (path, words) = (points(path), told(task, violation));
    match violation {
        Violation::OutOfBounds { point: index, .. } => match path.get(*index) {
            Some(p) => format!("{words}, {}", outside(task, margin, *p)),
            None => words,
        },
        Violation::Collision { segment, .. } => {
            let ends = path.get(*segment..segment + 2);
            let met = ends.and_then(|ends| first_met(task, margin, [ends[0], ends[1]]));
            met.map_or(words.clone(), |p| format!("{words} at {}", point(p)))
        }
        _ => words,
    }
}

/// Bisections until a place on a segment is known to a trillionth of it.
const BISECTIONS: u32 = 40;

/// Where a robot that moves along a segment first meets something.
fn first_met(task: &PlaneTask<'_>, margin: f64, [a, b]: [Point; 2]) -> Option<Point> {
    let robot = Robot::disc(task.robot.radius() + margin).ok()?;
    let certifier = Certifier::new(task.world, robot);
    let (mut free, mut met) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (free + met);
        let whole = certifier.segment_is_free(a, lerp(a, b, middle));
        *(if whole { &mut free } else { &mut met }) = middle;
    }
    Some(lerp(a, b, met))
}

/// A violation with its obstacle as it stands in the world.
fn told(task: &PlaneTask<'_>, violation: &Violation) -> String {
    let (Violation::StartInCollision { obstacle }
    | Violation::GoalInCollision { obstacle }
    | Violation::Collision { obstacle, .. }) = violation
    else {
        return violation.to_string();
    };
    let words = match (obstacle, task.world.grid()) {
        (ObstacleId::Shape(index), _) => match task.world.obstacles().get(*index) {
            Some(shape) => format!("{obstacle}, {}", shape_words(shape)),
            None => return violation.to_string(),
        },
        (ObstacleId::Cell { column, row }, Some(grid)) => {
            let Rect { min, max } = grid.cell_rect(*column as i64, *row as i64);
            format!("the occupied cell of the map round {}", point(scale(add(min, max), 0.5)))
        }
        _ => return violation.to_string(),
    };
    violation.to_string().replace(&obstacle.to_string(), &words)
}

fn shape_words(shape: &Obstacle) -> String {
    match shape {
        Obstacle::Rect(rect) => format!("the rectangle {}", field(rect)),
        Obstacle::Circle(Circle { center, radius }) => {
            format!("the circle of radius {} round {}", number(*radius), point(*center))
        }
        Obstacle::Polygon(polygon) => {
            let corners = polygon.vertices().len();
            format!("the polygon of {corners} corners in {}", field(&shape.bounding_box()))
        }
    }
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

/// Where the robot could stand.
fn instead(task: &PlaneTask<'_>, margin: f64, end: Point) -> String {
    let Ok(robot) = Robot::disc(task.robot.radius() + margin) else { return String::new() };
    let certifier = Certifier::new(task.world, robot);
    let extent = task.world.bounds().extent();
    let free = place_near(end, extent, |p| certifier.point_is_free(p));
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
            (
                [9.0, 5.0],
                0.0,
                0.0,
                &[
                    "in collision with obstacle 0, the rectangle [8, 4] to [12, 6]: (9, 5) lies on or inside it",
                ],
            ),
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
    fn a_path_is_told_where_it_meets_what() {
        let said = |world: World, path: &[Point], radius: f64, margin: f64| {
            let robot = Robot::disc(radius).unwrap();
            let [start, goal] = [path[0], path[path.len() - 1]];
            let task = Task::in_plane("", Arc::new(world), robot, start, goal).unwrap();
            let path = Trajectory::from_points(path);
            let asked = task.with_margin(margin).unwrap();
            let violation = crate::certify(&asked, &path).unwrap_err();
            explain_path(&task.plane().unwrap(), margin, &path, &violation)
        };
        assert_eq!(
            said(field(), &[[1.0, 1.0], [2.0, 5.0], [18.0, 5.0]], 0.5, 0.25),
            "segment 1 of the trajectory collides with obstacle 0, the rectangle [8, 4] to [12, 6] at (7.25, 5)"
        );
        assert_eq!(
            said(field(), &[[1.0, 1.0], [21.0, 5.0], [2.0, 5.0]], 0.0, 0.0),
            "the trajectory leaves the bounds at point 1, on segment 0, (21, 5) is not in [0, 0] to [20, 10]"
        );
        let occupied = (0..800).map(|i| i % 40 == 20).collect();
        let grid = Grid::new(40, 20, 0.5, [0.0; 2], occupied).unwrap();
        let map = World::new(grid.rect(), Vec::new(), Some(grid));
        let told = said(map, &[[1.0, 1.0], [18.0, 1.0]], 0.25, 0.0);
        assert!(told.starts_with("segment 0 of the trajectory collides with the occupied cell of"));
        assert!(told.ends_with(" at (9.75, 1)"), "{told}");
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
