//! Obstacles added to a prepared map against the same world prepared anew.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::Obstacle;
use crate::plane::geometry::{Circle, ConvexPolygon, Point, Rect};
use crate::plane::shortest_path::Route;
use crate::plane::world::{Grid, World};
use crate::plane::{PlaneScene, Robot};
use crate::profile::Profile;

/// Side of the map, in task units.
const SIDE: f64 = 24.0;

fn shape(rng: &mut ChaCha8Rng, kind: usize, most: f64) -> Obstacle {
    let [x, y] = [0, 1].map(|_| rng.random_range(0.0..SIDE));
    let [w, h] = [0, 1].map(|_| rng.random_range(0.3..most));
    match kind % 3 {
        0 => Obstacle::Rect(Rect::new([x, y], [x + w, y + h]).unwrap()),
        1 => Obstacle::Circle(Circle::new([x, y], 0.5 * w).unwrap()),
        _ => Obstacle::Polygon(
            ConvexPolygon::new(vec![[x, y], [x + w, y + 0.1], [x + 0.5 * w, y + h]]).unwrap(),
        ),
    }
}

/// A map of rooms as cells, of many or of few shapes, or of nothing.
fn map(rng: &mut ChaCha8Rng, kind: usize) -> World {
    let bounds = Rect::new([0.0; 2], [SIDE; 2]).unwrap();
    let (cells, shapes) = [(true, 0), (false, 60), (false, 6), (true, 40), (false, 0)][kind % 5];
    let occupied = |i: usize, rng: &mut ChaCha8Rng| {
        let wall = (i % 48).is_multiple_of(11) || (i / 48).is_multiple_of(13);
        rng.random_range(0..60) < if wall { 45 } else { 1 }
    };
    let grid = cells.then(|| {
        let cells = (0..48 * 48).map(|i| occupied(i, rng)).collect();
        Grid::new(48, 48, 0.5, [0.0; 2], cells).unwrap()
    });
    World::new(bounds, (0..shapes).map(|i| shape(rng, i, 1.5)).collect(), grid)
}

fn check_ends(alike: &[&PlaneScene; 2], start: Point, goal: Point, what: &str) -> bool {
    let [layered, anew] = alike;
    let free = |scene: &PlaneScene, a, b| scene.certifier().segment_is_free(a, b);
    for (a, b) in [(start, goal), (start, start), (goal, goal)] {
        assert_eq!(free(layered, a, b), free(anew, a, b), "{what}");
    }
    free(anew, start, start) && free(anew, goal, goal)
}

#[test]
fn a_map_with_obstacles_answers_as_one_made_anew() {
    let mut rng = ChaCha8Rng::seed_from_u64(31_000);
    let (mut found, mut none, mut longer) = (0, 0, 0);
    for case in 0..60 {
        let robot = Robot::disc([0.0, 0.2, 0.4][case % 3]).unwrap();
        let world = Arc::new(map(&mut rng, case));
        let scene = PlaneScene::new(&world, robot, &Profile::DEFAULT);
        let count = [3, 12, 50][case / 5 % 3];
        let more: Vec<_> = (0..count).map(|i| shape(&mut rng, i + case, 4.0)).collect();
        let layered = scene.with_obstacles(&more[..count / 2]).with_obstacles(&more[count / 2..]);
        let anew = PlaneScene::new(layered.world(), robot, &Profile::DEFAULT);
        assert_eq!(layered.world().obstacles().len(), world.obstacles().len() + count);
        let (mut a, mut b) = (layered.shortest_path(), anew.shortest_path());
        for query in 0..8 {
            let [start, goal] = [0, 1].map(|_| [0, 1].map(|_| rng.random_range(0.5..SIDE - 0.5)));
            let what = format!("{case} {query}");
            if !check_ends(&[&layered, &anew], start, goal, &what) {
                continue;
            }
            let before = scene.shortest_path().find(start, goal).length();
            match (a.find(start, goal), b.find(start, goal)) {
                (
                    Route::Found { trajectory, length, lower_bound },
                    Route::Found { length: known, lower_bound: bound, .. },
                ) => {
                    assert_eq!(anew.certifier().check(&trajectory), Ok(()), "{what}");
                    assert!((length - known).abs() < 1e-6, "{what}: {length} {known}");
                    assert!((lower_bound - bound).abs() < 1e-6, "{what}: {lower_bound} {bound}");
                    found += 1;
                    longer += usize::from(before.is_none_or(|before| length > before + 1e-3));
                }
                (Route::Unsolvable(_), Route::Unsolvable(_)) => none += 1,
                (x, y) => panic!("{what}: {x:?} {y:?}"),
            }
        }
    }
    // Each kind of answer came up, and the obstacles were in the way.
    assert!(found > 100 && none > 10 && longer > 40, "{found} {none} {longer}");
}

#[test]
fn distances_to_a_map_with_obstacles_are_those_of_one_made_anew() {
    let mut rng = ChaCha8Rng::seed_from_u64(31_001);
    for case in 0..20 {
        let world = Arc::new(map(&mut rng, case));
        let scene = PlaneScene::new(&world, Robot::Point, &Profile::DEFAULT);
        let more: Vec<_> = (0..9).map(|i| shape(&mut rng, i, 4.0)).collect();
        let layered = scene.with_obstacles(&more);
        let anew = PlaneScene::new(layered.world(), Robot::Point, &Profile::DEFAULT);
        let (mut free, mut inside) = (0, 0);
        for _ in 0..300 {
            let p = [0, 1].map(|_| rng.random_range(0.0..6.4_f32));
            let (distance, gradient) = layered.field().at(p);
            let (known, slope) = anew.field().at(p);
            if known > 0.0 {
                assert_eq!((distance, gradient), (known, slope), "{case} {p:?}");
                free += 1;
            } else {
                // Where old and new shapes overlap, as deep as one of both.
                assert!(distance <= 0.0 && distance >= known - 1e-6, "{case} {p:?}");
                inside += 1;
            }
        }
        assert!(free > 50 && inside > 5, "{free} {inside}");
        let clearances = [layered, anew].map(|scene| scene.typical_clearance());
        assert_eq!(clearances[0], clearances[1]);
    }
}

#[test]
fn far_obstacles_that_ask_for_another_tolerance_are_met() {
    let world = Arc::new(map(&mut ChaCha8Rng::seed_from_u64(31_002), 0));
    let scene = PlaneScene::new(&world, Robot::Point, &Profile::DEFAULT);
    let far = Obstacle::Circle(Circle::new([-1e8, 0.0], 1e8 + 3.0).unwrap());
    let layered = scene.with_obstacles(&[far]);
    assert!(layered.certifier().margin() > scene.certifier().margin());
    assert!(!layered.certifier().point_is_free([2.0, 1.0]));
}
