//! Tasks survive writing and reading bit for bit, and no text makes the reader panic.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::sync::Arc;

use proptest::prelude::*;
use sidestep::plane::geometry::{Circle, ConvexPolygon, Point, Rect};
use sidestep::{Grid, Obstacle, Robot, Task, World};
use sidestep_io::{TaskFormat, read_tasks, write_task, write_tasks};

/// Coordinates of every size that a task may hold, 0 and -0 among them.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -100.0..100.0,
        1 => -1e9..1e9,
        1 => -1e-7..1e-7,
        1 => prop::sample::select(vec![0.0, -0.0, 1.0, 1e9, -1e9, 5e-324, 0.1 + 0.2]),
    ]
}

fn point() -> impl Strategy<Value = Point> {
    [coordinate(), coordinate()]
}

fn rect() -> impl Strategy<Value = Rect> {
    (point(), point()).prop_filter_map("positive size", |(a, b)| {
        let low = [a[0].min(b[0]), a[1].min(b[1])];
        let high = [a[0].max(b[0]), a[1].max(b[1])];
        Rect::new(low, high).ok()
    })
}

fn obstacle() -> impl Strategy<Value = Obstacle> {
    let circle = (point(), 1e-9..1e3).prop_map(|(c, r)| Circle::new(c, r).unwrap());
    let polygon = prop::collection::vec(point(), 3..5)
        .prop_filter_map("convex", |vertices| ConvexPolygon::new(vertices).ok());
    prop_oneof![
        rect().prop_map(Obstacle::Rect),
        circle.prop_map(Obstacle::Circle),
        polygon.prop_map(Obstacle::Polygon),
    ]
}

fn grid() -> impl Strategy<Value = Grid> {
    // Wide grids are written in runs, so widths on both sides of the limit are tried.
    (prop_oneof![1..20_usize, 120..200_usize], 1..6_usize).prop_flat_map(|(width, height)| {
        let cells = prop::collection::vec(prop::bool::weighted(0.1), width * height);
        (cells, 1e-3..10.0, [-100.0..100.0, -100.0..100.0]).prop_map(
            move |(cells, resolution, origin)| {
                Grid::new(width, height, resolution, origin, cells).unwrap()
            },
        )
    })
}

fn task() -> impl Strategy<Value = Task> {
    let robot = prop_oneof![
        Just(Robot::Point),
        (1e-6..100.0).prop_map(|radius| Robot::disc(radius).unwrap())
    ];
    let obstacles = prop::collection::vec(obstacle(), 0..6);
    (any::<String>(), rect(), obstacles, prop::option::of(grid()), robot, point(), point())
        .prop_map(|(name, bounds, obstacles, grid, robot, start, goal)| {
            let world = Arc::new(World::new(bounds, obstacles, grid));
            Task::in_plane(name, world, robot, start, goal).unwrap()
        })
}

/// Equal to the last bit: `==` alone would let -0 pass for 0.
fn assert_same(read: &[Task], written: &[Task]) {
    assert_eq!(read, written);
    assert_eq!(format!("{read:?}"), format!("{written:?}"));
}

proptest! {
    #[test]
    fn write_then_read_is_the_identity(tasks in prop::collection::vec(task(), 1..4)) {
        for format in [TaskFormat::Json, TaskFormat::JsonLines] {
            let text = write_tasks(&tasks, format).unwrap();
            assert_same(&read_tasks(&text, format).unwrap(), &tasks);
        }
        let line = write_task(&tasks[0]).unwrap();
        prop_assert!(!line.contains('\n'));
        assert_same(&read_tasks(&line, TaskFormat::Json).unwrap(), &tasks[..1]);
    }

    #[test]
    fn damaged_documents_never_panic(
        task in task(),
        cuts in prop::collection::vec((any::<prop::sample::Index>(), any::<char>()), 1..4),
    ) {
        let mut characters: Vec<char> = write_task(&task).unwrap().chars().collect();
        for (at, character) in cuts {
            let at = at.index(characters.len());
            characters[at] = character;
        }
        let text: String = characters.into_iter().collect();
        for format in [TaskFormat::Json, TaskFormat::JsonLines] {
            if let Err(error) = read_tasks(&text, format) {
                prop_assert!(!error.to_string().is_empty());
            }
        }
    }

    #[test]
    fn any_text_never_panics(text in any::<String>()) {
        let _ = read_tasks(&text, TaskFormat::Json);
        let _ = read_tasks(&text, TaskFormat::JsonLines);
    }
}

#[test]
fn layout() {
    let world = World::new(
        Rect::new([0.0, 0.0], [64.0, 48.0]).unwrap(),
        vec![
            Obstacle::Rect(Rect::new([1.0, 2.0], [3.5, 4.0]).unwrap()),
            Obstacle::Circle(Circle::new([0.1, 1e-7], 2.0).unwrap()),
        ],
        Some(
            Grid::new(3, 2, 0.5, [0.0, 0.0], vec![true, false, false, false, true, true]).unwrap(),
        ),
    );
    let robot = Robot::disc(0.5).unwrap();
    let task = Task::in_plane("a \"b\"", Arc::new(world), robot, [1.0, 1.0], [9.0, 9.0]).unwrap();
    let expected = r##"{
  "format": "sidestep.task/1",
  "name": "a \"b\"",
  "bounds": [[0, 0], [64, 48]],
  "obstacles": [
    {"rect": [[1, 2], [3.5, 4]]},
    {"circle": {"center": [0.1, 1e-7], "radius": 2}}
  ],
  "grid": {"resolution": 0.5, "origin": [0, 0],
    "rows": [
      ".##",
      "#.."
    ]},
  "robot": {"disc": {"radius": 0.5}},
  "start": [1, 1],
  "goal": [9, 9]
}
"##;
    assert_eq!(write_tasks(std::slice::from_ref(&task), TaskFormat::Json).unwrap(), expected);
    let line = r##"{"format": "sidestep.task/1", "name": "a \"b\"", "bounds": [[0, 0], [64, 48]], "obstacles": [{"rect": [[1, 2], [3.5, 4]]}, {"circle": {"center": [0.1, 1e-7], "radius": 2}}], "grid": {"resolution": 0.5, "origin": [0, 0], "rows": [".##", "#.."]}, "robot": {"disc": {"radius": 0.5}}, "start": [1, 1], "goal": [9, 9]}"##;
    assert_eq!(write_task(&task).unwrap(), line);
}

#[test]
fn what_rows_repeat_is_bounded_by_their_length() {
    let task = |row: &str, rows: usize| {
        let rows = vec![format!("{row:?}"); rows].join(",");
        format!(
            "{{\"format\": \"sidestep.task/1\", \"bounds\": [[0, 0], [1, 1]], \"start\": [0, 0], \
             \"goal\": [1, 1], \"grid\": {{\"resolution\": 1, \"rows\": [{rows}]}}}}"
        )
    };
    let error = read_tasks(&task("8192.", 8193), TaskFormat::Json).unwrap_err().to_string();
    let expected = "grid.rows: found more than 8192 rows of 8192 cells in 40965 bytes; expected at most 67108864";
    assert!(error.contains(expected), "{error}");
    assert!(read_tasks(&task("4096.", 4096), TaskFormat::Json).is_ok());
}
