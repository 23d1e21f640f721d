//! Tests of the view.

use super::*;
use crate::network::{WaypointNet, WaypointScratch, WaypointShape};
use crate::objective::Objective;
use crate::plane::geometry::{Point, Rect};
use crate::plane::world::{Obstacle, World};
use crate::profile::Profile;
use crate::scene::{Query, Setting, Task};
use crate::suite::{candidate, varied};
use std::sync::Arc;

fn probes() -> Probes {
    Probes::named("probes:8x0.5,2").unwrap()
}

fn parts(names: &[&str]) -> Result<ViewParts, crate::error::InvalidInput> {
    ViewParts::from_names(&names.iter().map(|n| (*n).to_string()).collect::<Vec<_>>())
}

/// A view of these probes and nothing else.
fn plain(probes: &Probes) -> ViewParts {
    parts(&["waypoints", &probes.name()]).unwrap()
}

fn row_len(probes: &Probes) -> usize {
    plain(probes).row_len()
}

fn objective(task: &Task, profile: &Profile) -> Objective {
    Objective::new(&Query::of(task, profile), 7).unwrap()
}

/// The task turned by a right angle about the middle of its field.
fn turned(task: &Task) -> Task {
    moved(task, |p| [64.0 - p[1], p[0]])
}

/// The task with left and right exchanged.
fn mirrored(task: &Task) -> Task {
    moved(task, |p| [64.0 - p[0], p[1]])
}

fn moved(task: &Task, place: impl Fn(Point) -> Point) -> Task {
    let rect = |obstacle: &Obstacle| {
        let Rect { min, max } = obstacle.bounding_box();
        let (a, b) = (place(min), place(max));
        let least = [0, 1].map(|axis| a[axis].min(b[axis]));
        Obstacle::Rect(Rect::new(least, [0, 1].map(|axis| a[axis].max(b[axis]))).unwrap())
    };
    let plane = task.plane().unwrap();
    let obstacles = plane.world.obstacles().iter().map(rect).collect();
    let world = Arc::new(World::new(plane.world.bounds(), obstacles, None));
    let (start, goal) = (place(plane.start).into(), place(plane.goal).into());
    let setting = Setting::Plane { world, robot: plane.robot };
    Task { setting, start, goal, ..task.clone() }
}

/// Which segments are free.
fn free(objective: &Objective, x: &[f32]) -> Vec<bool> {
    let mut free = vec![false; objective.waypoints() + 1];
    objective.free_segments(x, &mut free);
    free
}

#[test]
fn a_turned_world_looks_the_same() {
    for index in 0..20 {
        let task = if index % 2 == 0 { candidate(1000, index) } else { varied(1000, index) };
        let mut seen = Vec::new();
        for task in [task.clone(), turned(&task)] {
            let objective = objective(&task, &Profile::DEFAULT);
            let mut view =
                WaypointView::new(&plain(&probes()), objective.plane().unwrap(), Look::default());
            let mut x = vec![0.0; 14];
            objective.straight_line(&mut x);
            let stride = row_len(&probes()) + 3;
            let mut rows = vec![9.0; 7 * stride];
            view.encode(
                objective.plane().unwrap(),
                Iterate { x: &x, free: &free(&objective, &x), gradient: &[] },
                None,
                &mut rows,
                stride,
            );
            view.apply(&ActionRule::PAPER, |i| [0.1 * i as f32, 0.3], &mut x);
            view.encode(
                objective.plane().unwrap(),
                Iterate { x: &x, free: &free(&objective, &x), gradient: &[] },
                None,
                &mut rows,
                stride,
            );
            seen.push((rows, free(&objective, &x)));
        }
        assert_eq!(seen[0].1, seen[1].1);
        // Where two obstacles are equally near, the gradient may be either's; allow for a few.
        let pairs = seen[0].0.iter().zip(&seen[1].0);
        let different = pairs.filter(|(a, b)| (*a - *b).abs() > 2e-3).count();
        assert!(different <= 6, "{index}: {different}");
    }
}

/// Rows of a straight line after one update, with what the map says of the ways.
fn look_at(task: &Task, look: Look) -> Vec<f32> {
    let names = ["waypoints", "probes:8x0.5,2", "map:6x16x1"].map(String::from);
    let parts = ViewParts::from_names(&names).unwrap();
    let objective = objective(task, &Profile::DEFAULT);
    let mut view = WaypointView::new(&parts, objective.plane().unwrap(), look);
    let map = TaskMap::new(&parts, parts.map.as_ref().unwrap(), objective.plane().unwrap())
        .other(objective.plane().unwrap(), look);
    let mut x = vec![0.0; 14];
    objective.straight_line(&mut x);
    let mut rows = vec![0.0; 7 * parts.row_len()];
    for _ in 0..2 {
        view.encode(
            objective.plane().unwrap(),
            Iterate { x: &x, free: &free(&objective, &x), gradient: &[] },
            Some(&map),
            &mut rows,
            parts.row_len(),
        );
        view.apply(&ActionRule::PAPER, |i| [0.1 * i as f32, 0.3], &mut x);
    }
    rows
}

#[test]
fn a_look_is_that_of_another_task() {
    for index in 0..20 {
        let task = if index % 2 == 0 { candidate(1000, index) } else { varied(1000, index) };
        let [ahead, back, ahead_mirrored, back_mirrored] =
            Look::ALL.map(|look| look_at(&task, look));
        let (start, goal) = (task.goal.clone(), task.start.clone());
        let reversed = Task { start, goal, ..task.clone() };
        let mirrored = mirrored(&task);
        let others = [
            (back, look_at(&reversed, Look::default()), 0.15),
            (back_mirrored, look_at(&reversed, Look::ALL[2]), 0.15),
            (ahead_mirrored, look_at(&mirrored, Look::default()), 0.15),
        ];
        for (this, other, close) in others {
            // At ties of distance the gradient, and of length the way, may be another; and start and goal lie between
            // the ways' points, of which the other one is taken in a mirror.
            let pairs = this.iter().zip(&other);
            let different = pairs.filter(|(a, b)| (*a - *b).abs() > close).count();
            assert!(different <= 16, "{index}: {different}");
            let same = ahead.iter().zip(&this).filter(|(a, b)| (*a - *b).abs() <= 2e-3).count();
            assert!(same + 100 < this.len(), "{index}: {same}");
        }
    }
}

#[test]
fn both_profiles_look_the_same() {
    let task = candidate(1000, 3);
    let rows = [Profile::DEFAULT, Profile::PAPER].map(|profile| {
        let objective = objective(&task, &profile);
        let mut x = vec![0.0; 14];
        objective.straight_line(&mut x);
        let stride = row_len(&probes());
        let mut rows = vec![0.0; 7 * stride];
        WaypointView::new(&plain(&probes()), objective.plane().unwrap(), Look::default()).encode(
            objective.plane().unwrap(),
            Iterate { x: &x, free: &free(&objective, &x), gradient: &[] },
            None,
            &mut rows,
            stride,
        );
        rows
    });
    for (a, b) in rows[0].iter().zip(&rows[1]) {
        assert!((a - b).abs() <= 1e-4, "{a} {b}");
    }
}

#[test]
fn rows_hold_what_the_table_says() {
    let rect = Rect::new([30.0, 26.0], [34.0, 40.0]).unwrap();
    let bounds = Rect::new([0.0; 2], [64.0; 2]).unwrap();
    let world = Arc::new(World::new(bounds, vec![Obstacle::Rect(rect)], None));
    let task = Task::in_plane("", world, crate::Robot::Point, [16.0, 32.0], [48.0, 32.0]).unwrap();
    let objective = Objective::new(&Query::of(&task, &Profile::DEFAULT), 1).unwrap();
    let probes = Probes::named("probes:4x1").unwrap();
    let mut view = WaypointView::new(&plain(&probes), objective.plane().unwrap(), Look::default());
    let mut row = vec![0.0; row_len(&probes)];
    // The one waypoint is at (24, 32): 0.6 from the rectangle, which blocks the segment after it.
    view.encode(
        objective.plane().unwrap(),
        Iterate { x: &[2.4, 3.2], free: &[true, false], gradient: &[] },
        None,
        &mut row,
        row_len(&probes),
    );
    let expect = [
        0.25,
        0.0,
        0.75,
        0.0,
        -1.6,
        0.0,
        4.8,
        0.0,
        0.0,
        0.0, // offsets, last update
        1.0,
        2.0 / 11.0,
        0.0,
        1.0,
        0.5,
        0.5, // shared, place
        1.0,
        1.0,
        -1.0,
        0.0, // distance
    ];
    for (at, (got, want)) in row.iter().zip(expect).enumerate() {
        assert!((got - want).abs() <= 1e-5, "{at}: {got} {want}");
    }
    let after = &row[28..36];
    // Points at (30, 32), (36, 32) and (42, 32): on the side, 0.2 behind it, 0.8 behind it. Of all seven the third is
    // deepest, (33, 32), 0.1 before the other side.
    let expect = [0.0, 0.2 / 0.6, 0.8 / 0.6, -0.1 / 0.15, 1.0, 0.0, 3.0 / 8.0, 0.0];
    for (got, want) in after.iter().zip(expect) {
        assert!((got - want).abs() <= 1e-5, "{after:?}");
    }
    assert_eq!(row[27], 1.0, "the segment before is free");
    // Probes ahead, left, behind, right: inside the rectangle by 0.2 + .., beside it.
    let ahead = row[36];
    assert!((ahead + 0.0).abs() <= 0.34 && ahead <= 0.0, "{ahead}");
    assert_eq!(free(&objective, &[2.4, 3.2]), [true, false]);
}

#[test]
fn names_of_probes_are_checked() {
    assert_eq!(Probes::named(&probes().name()).unwrap(), probes());
    for name in
        ["probes", "probes:0x1", "probes:4x", "probes:4x-1", "probes:4xnan", "probes:999x1,2"]
    {
        assert_eq!(Probes::named(name).unwrap_err().field, "observation", "{name}");
    }
    let parts = |names: &[&str]| {
        ViewParts::from_names(&names.iter().map(|n| (*n).to_string()).collect::<Vec<_>>())
    };
    assert!(parts(&["waypoints", "probes:4x1"]).is_ok());
    assert!(parts(&["gradient", "probes:4x1"]).is_err());
}

#[test]
fn a_picture_and_a_gradient_are_parts_by_name() {
    let seen = parts(&["picture:64", "probes:4x1", "map:6x16x1", "gradient"]).unwrap();
    assert_eq!((seen.picture, seen.gradient), (Some(64), true));
    let without = parts(&["waypoints", "probes:4x1", "map:6x16x1"]).unwrap();
    assert_eq!(seen.row_len(), without.row_len() + 2);
    for names in [
        &["picture:0", "probes:4x1"][..],
        &["picture:65", "probes:4x1"],
        &["picture:4096", "probes:4x1"],
        &["picture:", "probes:4x1"],
        &["waypoints", "probes:4x1", "gradient", "map:6x16x1"],
        &["waypoints", "probes:4x1", "gradient", "gradient"],
    ] {
        assert_eq!(parts(names).unwrap_err().field, "observation", "{names:?}");
    }
}

/// A straight line through a field with these obstacles, as a view of these parts sees it; and its gradient.
fn seen(names: &[&str], obstacles: Vec<Obstacle>, look: Look) -> (Vec<f32>, Vec<f32>) {
    let parts = parts(names).unwrap();
    let field = Rect::new([0.0; 2], [64.0; 2]).unwrap();
    let world = Arc::new(World::new(field, obstacles, None));
    let setting = Setting::Plane { world, robot: crate::plane::Robot::Point };
    let task = Task::new("", setting, vec![5.0, 9.0], vec![50.0, 8.0]).unwrap();
    let mut objective = objective(&task, &Profile::DEFAULT);
    let mut view = WaypointView::new(&parts, objective.plane().unwrap(), look);
    let map = parts.map.as_ref().map(|shape| {
        let subject = objective.plane().unwrap();
        TaskMap::new(&parts, shape, subject).other(subject, look)
    });
    let mut x = vec![0.0; 14];
    objective.straight_line(&mut x);
    let mut gradient = vec![0.0; 14];
    objective.cost_and_gradient(&x, &mut gradient);
    let free = free(&objective, &x);
    let mut rows = vec![0.0; 7 * parts.row_len()];
    let iterate = Iterate { x: &x, free: &free, gradient: &gradient };
    let subject = objective.plane().unwrap();
    view.encode(subject, iterate, map.as_ref(), &mut rows, parts.row_len());
    (rows, gradient)
}

fn wall(right: f64) -> Obstacle {
    Obstacle::Rect(Rect::new([20.0, 0.0], [right, 40.0]).unwrap())
}

/// Who sees a picture sees nothing that the picture does not show: two worlds of the same picture look the same.
#[test]
fn a_picture_is_all_that_is_seen_of_the_world() {
    let names = ["picture:32", "probes:8x0.5,2", "map:6x16x1"];
    let rows = |obstacles| seen(&names, obstacles, Look::default()).0;
    // A hair that no pixel shows.
    let hair = Obstacle::Rect(Rect::new([41.5, 41.5], [41.5001, 41.5001]).unwrap());
    assert_eq!(rows(vec![wall(30.0), hair]), rows(vec![wall(30.0)]));
    assert_ne!(rows(vec![wall(31.0)]), rows(vec![wall(30.0)]));
    // The share of segments that are not free, by shades.
    assert!(rows(vec![wall(30.0)])[14] > 0.0);
    assert!(rows(vec![])[14].abs() < 1e-9);
}

#[test]
fn a_view_with_the_gradient_shows_it_along_and_across_whatever_the_look() {
    for look in Look::ALL {
        let names = ["waypoints", "probes:4x1", "gradient"];
        let (rows, gradient) = seen(&names, vec![wall(30.0)], look);
        let stride = rows.len() / 7;
        for (i, row) in rows.chunks_exact(stride).enumerate() {
            let place = if look.backwards { 6 - i } else { i };
            let size = gradient[2 * place].hypot(gradient[2 * place + 1]);
            let [along, across] = [row[stride - 2], row[stride - 1]];
            assert!((along.hypot(across) - 2.0 * size).abs() < 1e-5);
        }
        assert!(gradient.iter().any(|slope| slope.abs() > 1e-3));
    }
}

/// A loss of the network's outputs, its gradient through rows and map against differences.
#[test]
fn gradients_flow_through_the_map() {
    let names = ["waypoints", "probes:4x1", "map:6x16x1,2"].map(String::from);
    let parts = ViewParts::from_names(&names).unwrap();
    let shape = WaypointShape {
        inputs: parts.row_len(),
        width: 16,
        dilations: vec![1],
        outputs: 2,
        map: parts.map.clone(),
    };
    let mut rng = crate::rng::stream(3, crate::rng::Purpose::Parameters, 0, 0);
    let count = shape.parameter_count().unwrap();
    let draw = |_| 0.3 * crate::rng::standard_normal(&mut rng)[0];
    let mut net = WaypointNet::new(&shape, (0..count).map(draw).collect()).unwrap();
    let task = candidate(1000, 5);
    let objective = objective(&task, &Profile::DEFAULT);
    let mut x = vec![0.0; 14];
    objective.straight_line(&mut x);
    let mut map = TaskMap::new(&parts, parts.map.as_ref().unwrap(), objective.plane().unwrap());
    let mut scratch = WaypointScratch::default();
    let stride = net.input_stride();
    let loss = |net: &WaypointNet, map: &mut TaskMap, scratch: &mut WaypointScratch| {
        net.read_map(map.scratch());
        let mut view = WaypointView::new(&parts, objective.plane().unwrap(), Look::default());
        view.encode(
            objective.plane().unwrap(),
            Iterate { x: &x, free: &free(&objective, &x), gradient: &[] },
            Some(map),
            scratch.input(7, stride),
            stride,
        );
        net.forward(scratch, 7);
        (0..7).map(|i| f64::from(scratch.output(i)[0] - 0.5 * scratch.output(i)[1])).sum::<f64>()
    };
    net.begin_map(map.scratch());
    loss(&net, &mut map, &mut scratch);
    let mut gradient = vec![0.0; count];
    net.backward([[1.0, -0.5]; 7].as_flattened(), &mut scratch, &mut gradient);
    map.collect_rows(&x, scratch.input_slopes(), stride, parts.row_len());
    net.map_backward(map.scratch(), &mut gradient);
    let (mut close, mut all, mut flows) = (0, 0, 0);
    for index in (0..count).step_by(11) {
        let h = 2e-3_f32;
        let mut at = |change: f32| {
            net.update(|parameters| parameters[index] += change);
            loss(&net, &mut map, &mut scratch)
        };
        let slope = (at(h) - at(-2.0 * h)) / f64::from(2.0 * h);
        at(h);
        let got = f64::from(gradient[index]);
        all += 1;
        flows += usize::from(got != 0.0);
        close += usize::from((slope - got).abs() <= 0.02 * (1.0 + slope.abs()));
    }
    // The others are at a kink of a rectified unit.
    assert!(close * 100 >= all * 95, "{close} of {all}");
    assert!(flows * 2 > all, "{flows} of {all}");
}
