//! Against the exact shortest path, and frozen values.

use std::sync::Arc;

use super::*;
use crate::plane::Robot;
use crate::plane::geometry::{Point, Rect};
use crate::plane::shortest_path::{Route, ShortestPath};
use crate::plane::world::{Obstacle, World};
use crate::profile::Profile;
use crate::rng::{Purpose, stream};
use crate::scene::{PlaneTask, Task};

const FIELD: Rect = Rect { min: [0.0, 0.0], max: [64.0, 64.0] };

fn task(rects: Vec<Rect>, robot: Robot, start: Point, goal: Point) -> Task {
    let world = World::new(FIELD, rects.into_iter().map(Obstacle::Rect).collect(), None);
    Task::in_plane("", Arc::new(world), robot, start, goal).unwrap()
}

fn plan(planner: &RrtConnect, task: &Task, index: u64) -> RrtRun {
    let query = Query::of(task, &Profile::DEFAULT);
    planner.plan(&query, &mut stream(1000, Purpose::Planner, index, 0))
}

fn random_task(index: u64, robot: Robot) -> Task {
    let mut rng = stream(1000, Purpose::Task, index, 0);
    let mut draw = |range: std::ops::Range<i32>| f64::from(rng.random_range(range));
    let rects = (0..10)
        .map(|_| {
            let min = [draw(0..64), draw(0..64)];
            Rect { min, max: [min[0] + draw(10..20), min[1] + draw(10..20)] }
        })
        .collect();
    let ends = [[draw(1..63), draw(1..63)], [draw(1..63), draw(1..63)]];
    task(rects, robot, ends[0], ends[1])
}

#[test]
fn solves_what_can_be_solved() {
    let planner = RrtConnect::default();
    for robot in [Robot::Point, Robot::Disc { radius: 0.8 }] {
        let (mut solvable, mut solved, mut ratio) = (0, 0, 0.0);
        for index in 0..400 {
            let task = random_task(index, robot);
            let run = plan(&planner, &task, index);
            let PlaneTask { world, start, goal, .. } = task.plane().unwrap();
            let route = ShortestPath::new(world, robot).find(start, goal);
            match (route, run.trajectory) {
                (Route::Found { lower_bound, .. }, Some(found)) => {
                    (solvable, solved) = (solvable + 1, solved + 1);
                    assert!(crate::certify(&task, &found).is_ok(), "{index}");
                    ratio += found.length() / lower_bound.max(1e-9);
                }
                (Route::Found { .. }, None) => solvable += 1,
                (Route::Unsolvable(_), found) => assert_eq!(found, None, "{index}"),
                (Route::Undecided(_), _) => {}
            }
        }
        assert!(solvable > 90 && solved * 100 >= solvable * 99, "{solved} of {solvable}");
        assert!(ratio / f64::from(solved) < 1.1, "{}", ratio / f64::from(solved));
    }
}

#[test]
fn hand_made_rows() {
    let wall = Rect { min: [0.0, 30.0], max: [64.0, 34.0] };
    let gap = Rect { min: [0.0, 30.0], max: [62.0, 34.0] };
    let few = RrtConnect { max_samples: 300, ..RrtConnect::default() };
    let check = |rects: &[Rect], robot, start, goal, expected: bool| {
        let run = plan(&few, &task(rects.to_vec(), robot, start, goal), 0);
        assert_eq!(run.trajectory.is_some(), expected, "{rects:?} {start:?} {goal:?}");
        assert!(run.samples <= few.max_samples);
    };
    check(&[], Robot::Point, [1.0, 1.0], [60.0, 60.0], true);
    check(&[wall], Robot::Point, [1.0, 1.0], [60.0, 60.0], false);
    check(&[gap], Robot::Point, [1.0, 1.0], [1.0, 60.0], true);
    check(&[gap], Robot::Disc { radius: 1.5 }, [2.0, 2.0], [2.0, 60.0], false);
    check(&[gap], Robot::Point, [1.0, 31.0], [1.0, 60.0], false);
    check(&[gap], Robot::Point, [1.0, 1.0], [1.0, 66.0], false);
}

#[test]
fn short_cuts_only_shorten() {
    let raw = RrtConnect { shortcut_rounds: 0, ..RrtConnect::default() };
    let (mut bent, mut shortened) = (0, 0);
    for index in 0..100 {
        let task = random_task(index, Robot::Point);
        let query = Query::of(&task, &Profile::DEFAULT);
        let Some(found) = plan(&raw, &task, index).trajectory else { continue };
        let mut after = found.clone();
        let is_free = |from: &[f64], to: &[f64]| query.scene().motion_is_free(from, to);
        shortcut(&mut after, is_free, 20, &mut stream(0, Purpose::Planner, index, 1));
        assert!(query.certify(after.clone()).is_ok());
        assert!(after.length() <= found.length() + 1e-9);
        bent += usize::from(found.len() > 2);
        shortened += usize::from(after.length() < found.length() - 1e-6);
    }
    assert!(bent > 10 && shortened * 10 >= bent * 9, "{shortened} of {bent}");
}

#[test]
fn parameters_are_checked() {
    let good = RrtConnect::default();
    assert!(good.validate().is_ok());
    for (planner, field) in [
        (RrtConnect { max_samples: 0, ..good }, "max_samples"),
        (RrtConnect { step: 0.0, ..good }, "step"),
        (RrtConnect { step: f64::NAN, ..good }, "step"),
        (RrtConnect { step: 1.5, ..good }, "step"),
    ] {
        assert_eq!(planner.validate().unwrap_err().field, field);
    }
}

#[test]
fn value_stability() {
    let gap = Rect { min: [0.0, 30.0], max: [62.0, 34.0] };
    let run =
        plan(&RrtConnect::default(), &task(vec![gap], Robot::Point, [1.0, 1.0], [1.0, 60.0]), 3);
    let length = run.trajectory.map_or(0.0, |trajectory| trajectory.length());
    assert_eq!((run.samples, run.nodes, run.checks), (1019, 519, 2139));
    assert!((length - 140.832_080_049_140_5).abs() < 1e-9, "{length}");
}
