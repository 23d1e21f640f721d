//! Hand-made worlds and tasks of the paper's kind, against brute force.

use std::collections::BinaryHeap;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::plane::geometry::{Circle, ConvexPolygon, Rect};
use crate::plane::world::{Grid, Obstacle};
use crate::trajectory::Violation;

const FIELD: Rect = Rect { min: [0.0, 0.0], max: [64.0, 64.0] };

pub(super) fn rect(x0: f64, y0: f64, x1: f64, y1: f64) -> Obstacle {
    Obstacle::Rect(Rect::new([x0, y0], [x1, y1]).unwrap())
}

pub(super) fn world(obstacles: Vec<Obstacle>) -> World {
    World::new(FIELD, obstacles, None)
}

/// Rectangles, start and goal drawn as in the paper, in pixels.
fn random_task(rng: &mut ChaCha8Rng) -> (Vec<Rect>, Point, Point) {
    let rects: Vec<Rect> = (0..10)
        .map(|_| {
            let min = [0, 1].map(|_| f64::from(rng.random_range(0..64)));
            let size = [0, 1].map(|_| f64::from(rng.random_range(10..20)));
            Rect { min, max: [min[0] + size[0], min[1] + size[1]] }
        })
        .collect();
    loop {
        let [start, goal] = [0, 1].map(|_| [0, 1].map(|_| f64::from(rng.random_range(1..63))));
        if !rects.iter().any(|rect| rect.contains(start) || rect.contains(goal)) {
            return (rects, start, goal);
        }
    }
}

/// The same rectangles as occupied cells of one pixel.
fn as_grid(rects: &[Rect]) -> World {
    let occupied = (0..64 * 64).map(|cell| {
        let center = [f64::from(cell % 64) + 0.5, f64::from(cell / 64) + 0.5];
        rects.iter().any(|rect| rect.contains(center))
    });
    let grid = Grid::new(64, 64, 1.0, [0.0, 0.0], occupied.collect()).unwrap();
    World::new(FIELD, Vec::new(), Some(grid))
}

/// The length of a found route after checking what every route must satisfy.
pub(super) fn length(query: &mut ShortestPath, start: Point, goal: Point) -> Option<f64> {
    match query.find(start, goal) {
        Route::Found { trajectory, length, lower_bound } => {
            let points = crate::plane::points(&trajectory);
            assert_eq!((points[0], points[points.len() - 1]), (start, goal));
            assert_eq!(query.certifier().check(&trajectory), Ok(()));
            assert!((trajectory.length() - length).abs() < 1e-9 * (1.0 + length));
            assert!(lower_bound <= length && lower_bound >= distance(start, goal) - 1e-9);
            Some(length)
        }
        Route::Unsolvable(Proof::Disconnected) => None,
        other => panic!("{other:?}"),
    }
}

#[test]
fn hand_made_rows() {
    let check = |obstacles: &[Obstacle], radius: f64, a: Point, b: Point, expected: Option<f64>| {
        let mut query = ShortestPath::new(&world(obstacles.to_vec()), Robot::disc(radius).unwrap());
        for (start, goal) in [(a, b), (b, a)] {
            match (length(&mut query, start, goal), expected) {
                (Some(found), Some(expected)) => {
                    let error = if radius == 0.0 { 1e-5 } else { 2e-3 * expected };
                    assert!((found - expected).abs() < error, "{found} {expected} {obstacles:?}");
                }
                (found, expected) => assert_eq!(found, expected, "{obstacles:?} {a:?} {b:?}"),
            }
        }
    };
    let d = |a: Point, b: Point| distance(a, b);
    check(&[], 0.0, [1.0, 1.0], [60.0, 1.0], Some(59.0));
    let boxed = [rect(20.0, 20.0, 40.0, 40.0)];
    check(
        &boxed,
        0.0,
        [10.0, 30.0],
        [50.0, 30.0],
        Some(2.0 * d([10.0, 30.0], [20.0, 20.0]) + 20.0),
    );
    // Along a side, and from one side's corner.
    check(&boxed, 0.0, [20.0 - 1e-6, 10.0], [20.0 - 1e-6, 50.0], Some(40.0));
    // Abutting boxes: no way between, along the common side is fine.
    let abutting = [rect(20.0, 20.0, 30.0, 40.0), rect(30.0, 20.0, 40.0, 40.0)];
    check(&abutting, 0.0, [30.0, 10.0], [30.0, 50.0], Some(20.0 + 2.0 * 200.0_f64.sqrt()));
    check(
        &abutting,
        0.0,
        [10.0, 30.0],
        [50.0, 30.0],
        Some(2.0 * d([10.0, 30.0], [20.0, 20.0]) + 20.0),
    );
    // Boxes that touch in a corner, and wall with them off one quarter of the field.
    let pinched = [rect(0.0, 20.0, 20.0, 40.0), rect(20.0, 0.0, 40.0, 20.0)];
    check(&pinched, 0.0, [10.0, 10.0], [30.0, 30.0], None);
    check(&pinched, 0.0, [30.0, 30.0], [60.0, 30.0], Some(30.0));
    // Flush with the walls; and a gap one unit wide at the wall.
    check(&[rect(0.0, 30.0, 64.0, 34.0)], 0.0, [30.0, 10.0], [30.0, 50.0], None);
    check(&[rect(0.0, 30.0, 80.0, 34.0)], 0.0, [30.0, 10.0], [30.0, 50.0], None);
    let gap = [rect(0.0, 30.0, 63.0, 34.0)];
    check(&gap, 0.0, [63.0, 10.0], [63.5, 50.0], Some(d([63.0, 10.0], [63.5, 50.0])));
    check(&gap, 0.0, [33.0, 20.0], [33.0, 44.0], Some(2.0 * d([33.0, 20.0], [63.0, 30.0]) + 4.0));
    check(&gap, 0.5001, [33.0, 20.0], [33.0, 44.0], None);
    // Two tangents, two arcs round the gap's ends and the wall's thickness.
    let (reach, turn) = (1000.0_f64.sqrt(), std::f64::consts::FRAC_PI_2 - (1.0_f64 / 3.0).atan());
    let past =
        2.0 * ((1000.0 - 0.499_f64.powi(2)).sqrt() + 0.499 * (turn + (0.499 / reach).asin()));
    check(&gap, 0.499, [33.0, 20.0], [33.0, 44.0], Some(past + 4.0));
    let enclosed = [
        rect(20.0, 20.0, 22.0, 40.0),
        rect(38.0, 20.0, 40.0, 40.0),
        rect(20.0, 20.0, 40.0, 22.0),
        rect(20.0, 38.0, 40.0, 40.0),
    ];
    check(&enclosed, 0.0, [30.0, 30.0], [5.0, 5.0], None);
    check(&enclosed, 1.0, [30.0, 30.0], [5.0, 5.0], None);
    check(&enclosed, 1.0, [30.0, 30.0], [25.0, 35.0], Some(50.0_f64.sqrt()));
    // Round a circle: two tangents and an arc. The same for a disc round a smaller circle.
    let round = |radius: f64| {
        let tangent = (400.0 - radius * radius).sqrt();
        let angle = std::f64::consts::PI - 2.0 * (radius / 20.0).acos();
        2.0 * tangent + radius * angle
    };
    let circle = |radius: f64| [Obstacle::Circle(Circle::new([32.0, 32.0], radius).unwrap())];
    check(&circle(8.0), 1e-300, [12.0, 32.0], [52.0, 32.0], Some(round(8.0)));
    check(&circle(5.0), 3.0, [12.0, 32.0], [52.0, 32.0], Some(round(8.0)));
    // A disc that touches an arc, all but a hair, at its start.
    let touching = 20.0 - (1.0 + 1e-6) * 0.5_f64.sqrt();
    let away = d([touching, touching], [10.0, 32.0]);
    check(&boxed, 1.0, [touching, touching], [10.0, 32.0], Some(away));
    let reach = [32.0, 10.0];
    check(&boxed, 1.0, [touching, touching], reach, Some(d([touching, touching], reach)));
    let around = Some(40.0 + std::f64::consts::PI);
    check(&boxed, 1.0, [touching, touching], [60.0 - touching, 60.0 - touching], around);
    let triangle = ConvexPolygon::new(vec![[20.0, 20.0], [40.0, 20.0], [30.0, 21.0]]).unwrap();
    let triangle = [Obstacle::Polygon(triangle)];
    check(
        &triangle,
        0.0,
        [30.0, 15.0],
        [30.0, 22.0],
        Some(d([30.0, 15.0], [20.0, 20.0]) + d([20.0, 20.0], [30.0, 22.0])),
    );
}

#[test]
fn ends_that_are_not_free_are_named() {
    let mut query = ShortestPath::new(&world(vec![rect(20.0, 20.0, 40.0, 40.0)]), Robot::Point);
    let obstacle = crate::trajectory::ObstacleId::Shape(0);
    let mut check = |start, goal, expected| {
        assert_eq!(query.find(start, goal), Route::Unsolvable(Proof::End(expected)));
    };
    check([30.0, 30.0], [1.0, 1.0], Violation::StartInCollision { obstacle });
    check([1.0, 1.0], [20.0, 20.0], Violation::GoalInCollision { obstacle });
    check([1.0, 1.0], [65.0, 20.0], Violation::GoalOutOfBounds);
    check([f64::NAN, 1.0], [65.0, 20.0], Violation::NotFinite { point: 0 });
}

/// Quarter-pixel cells connected over their sides, from the cells round the start.
fn flood(rects: &[Rect], start: Point, goal: Point) -> bool {
    const N: usize = 256;
    let covered = |cell: usize| {
        let center = [(cell % N) as f64 / 4.0 + 0.125, (cell / N) as f64 / 4.0 + 0.125];
        rects.iter().any(|rect| rect.contains(center))
    };
    let cell = |p: Point| (4.0 * p[1]) as usize * N + (4.0 * p[0]) as usize;
    let mut seen: Vec<bool> = (0..N * N).map(covered).collect();
    let mut stack = vec![cell(start)];
    while let Some(at) = stack.pop() {
        if std::mem::replace(&mut seen[at], true) {
            continue;
        }
        let (column, row) = (at % N, at / N);
        stack.extend((column > 0).then(|| at - 1));
        stack.extend((column < N - 1).then_some(at + 1));
        stack.extend((row > 0).then(|| at.wrapping_sub(N)));
        stack.extend((row < N - 1).then_some(at + N));
    }
    let mut reached: Vec<bool> = (0..N * N).map(covered).collect();
    reached.iter_mut().zip(&seen).for_each(|(covered, &seen)| *covered = seen && !*covered);
    reached[cell(goal)]
}

/// Dijkstra over all pairs of nodes that see each other.
pub(super) fn reference(layer: &Layer, start: Point, goal: Point) -> Option<f64> {
    let mut nodes: Vec<Point> = layer.corners.iter().map(|corner| corner.at).collect();
    nodes.extend([start, goal]);
    let n = nodes.len();
    let mut cost = vec![f64::INFINITY; n];
    let mut done = vec![false; n];
    cost[n - 2] = 0.0;
    loop {
        let at = (0..n).filter(|&i| !done[i]).min_by(|&i, &j| cost[i].total_cmp(&cost[j]))?;
        if cost[at].is_infinite() {
            return None;
        }
        if at == n - 1 {
            return Some(cost[at]);
        }
        done[at] = true;
        for to in 0..n {
            let total = cost[at] + distance(nodes[at], nodes[to]);
            if total < cost[to] && layer.certifier.segment_is_free(nodes[at], nodes[to]) {
                cost[to] = total;
            }
        }
    }
}

/// Dijkstra over points half a pixel apart, each with 32 neighbours.
fn lattice_length(query: &ShortestPath, start: Point, goal: Point) -> Option<f64> {
    const N: i32 = 129;
    let mut steps = Vec::new();
    for dx in -4_i32..=4 {
        for dy in -4_i32..=4 {
            let gcd = (1..=4).rev().find(|k| dx % k == 0 && dy % k == 0).unwrap_or(1);
            if gcd == 1 && (dx.abs().max(dy.abs()) <= 3 || dx.abs() + dy.abs() <= 5) {
                steps.push((dx, dy));
            }
        }
    }
    let point = |node: i32| [f64::from(node % N) / 2.0, f64::from(node / N) / 2.0];
    let node = |p: Point| (p[1] * 2.0) as i32 * N + (p[0] * 2.0) as i32;
    let mut cost = vec![u64::MAX; (N * N) as usize];
    let mut queue = BinaryHeap::from([(std::cmp::Reverse(0_u64), node(start))]);
    while let Some((std::cmp::Reverse(so_far), at)) = queue.pop() {
        if at == node(goal) {
            return Some(so_far as f64 * 1e-9);
        }
        if so_far > cost[at as usize] {
            continue;
        }
        for &(dx, dy) in &steps {
            let (x, y) = (at % N + dx, at / N + dy);
            if !(0..N).contains(&x) || !(0..N).contains(&y) {
                continue;
            }
            let to = y * N + x;
            let total = so_far + (distance(point(at), point(to)) * 1e9) as u64;
            if total < cost[to as usize] && query.certifier().segment_is_free(point(at), point(to))
            {
                cost[to as usize] = total;
                queue.push((std::cmp::Reverse(total), to));
            }
        }
    }
    None
}

#[test]
fn agrees_with_flood_reference_and_grid_on_random_tasks() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_000);
    let mut unsolvable = 0;
    for index in 0..2000 {
        let (rects, start, goal) = random_task(&mut rng);
        let obstacles = rects.iter().copied().map(Obstacle::Rect).collect();
        let mut query = ShortestPath::new(&world(obstacles), Robot::Point);
        let found = length(&mut query, start, goal);
        assert_eq!(found.is_some(), flood(&rects, start, goal), "task {index}");
        unsolvable += usize::from(found.is_none());
        let close = |other: Option<f64>, what: &str| {
            let near = match (found, other) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-5,
                (a, b) => a == b,
            };
            assert!(near, "task {index}: {found:?}, {what} {other:?}");
        };
        close(length(&mut query, goal, start), "backwards");
        close(reference(&query.layers.outside, start, goal), "reference");
        close(length(&mut ShortestPath::new(&as_grid(&rects), Robot::Point), start, goal), "grid");
        if index % 50 == 0 {
            let lattice = lattice_length(&query, start, goal);
            let (found, lattice) = (found.unwrap_or(0.0), lattice.unwrap_or(0.0));
            assert!(found <= lattice + 1e-5 && lattice <= 1.03 * found + 0.5, "{found} {lattice}");
        }
    }
    assert!((10..60).contains(&unsolvable), "{unsolvable} of 2000 unsolvable");
}

#[test]
fn discs_agree_with_grids_and_stay_within_their_bounds() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_001);
    let (mut undecided, mut solved) = (0, 0);
    for index in 0..300 {
        let (rects, start, goal) = random_task(&mut rng);
        let robot = Robot::disc([0.3, 0.75, 1.4][index % 3]).unwrap();
        let obstacles = rects.iter().copied().map(Obstacle::Rect).collect();
        let mut shapes = ShortestPath::new(&world(obstacles), robot);
        let mut cells = ShortestPath::new(&as_grid(&rects), robot);
        match (shapes.find(start, goal), cells.find(start, goal)) {
            (
                Route::Found { trajectory, length, lower_bound },
                Route::Found { length: other, lower_bound: other_bound, .. },
            ) => {
                solved += 1;
                assert_eq!(shapes.certifier().check(&trajectory), Ok(()));
                assert_eq!(cells.certifier().check(&trajectory), Ok(()));
                let (high, low) = (length.min(other), lower_bound.max(other_bound));
                assert!(low <= high + 1e-9, "task {index}: {low} {high}");
                // Narrow places may be passed by one and not by the other.
                assert!(length <= 1.01 * lower_bound || index % 50 == 0, "{length} {lower_bound}");
            }
            (Route::Undecided(_), _) | (_, Route::Undecided(_)) => undecided += 1,
            (Route::Unsolvable(_), Route::Unsolvable(_)) => {}
            other => panic!("task {index}: {other:?}"),
        }
    }
    assert!(solved > 200 && undecided <= 3, "{solved} solved, {undecided} undecided");
}

#[test]
fn narrow_passages_are_refined() {
    // A gap of length 5 between the corners (20, 30) and (23, 34), in a wall across the field.
    let wall = [rect(0.0, 20.0, 20.0, 30.0), rect(23.0, 34.0, 64.0, 44.0)];
    let closed = [rect(0.0, 0.0, 20.0, 1.0), rect(23.0, 63.0, 64.0, 64.0)];
    let sides = [rect(0.0, 10.0, 20.0, 20.0), rect(23.0, 44.0, 64.0, 63.0)];
    let floor = [rect(0.0, 1.0, 20.0, 10.0)];
    let shapes: Vec<_> = [&wall[..], &closed, &sides, &floor].concat();
    let check = |radius: f64, expected: &str| {
        let mut query = ShortestPath::new(&world(shapes.clone()), Robot::disc(radius).unwrap());
        let found = match query.find([4.0, 40.0], [40.0, 20.0]) {
            Route::Found { length, lower_bound, .. } if length < 1.001 * lower_bound => "found",
            Route::Unsolvable(_) => "unsolvable",
            Route::Undecided(Doubt::NarrowPassage { .. }) => "undecided",
            _ => "other",
        };
        assert_eq!(found, expected, "{radius}");
    };
    check(2.0, "found");
    check(2.49, "found");
    check(2.499, "found");
    check(2.4999, "found");
    check(2.5, "undecided");
    check(2.51, "unsolvable");
    check(2.6, "unsolvable");
}

#[test]
fn a_search_can_be_broken_off() {
    let bars = vec![rect(20.0, 0.0, 22.0, 60.0), rect(40.0, 4.0, 42.0, 64.0)];
    let mut query = ShortestPath::new(&world(bars), Robot::disc(0.5).unwrap());
    let (start, goal) = ([4.0, 32.0], [60.0, 32.0]);
    let broken_off = Route::Undecided(Doubt::BrokenOff);
    assert_eq!(query.find_while(start, goal, &|| false), broken_off);
    // A straight line needs no search.
    assert!(query.find_while(start, [5.0, 32.0], &|| false).length().is_some());
    assert!(query.find(start, goal).length().is_some());
}

#[test]
fn no_proof_beside_a_path_through_a_gap_of_a_few_tolerances() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_002);
    let mut counts = [0; 3];
    for index in 0..3000 {
        // A wall with one door, as boxes, polygons or cells, in a field of any size and place.
        let scale = 10_f64.powi(rng.random_range(-6..5));
        let at = [0.0, 0.1, 1e3, 5e6][rng.random_range(0..4)];
        let radius = if index % 3 == 0 { scale * rng.random_range(0.01..2.0) } else { 0.0 };
        let place = |x: f64, y: f64| [at + scale * x, at + scale * y];
        let bounds = Rect { min: place(0.0, 0.0), max: place(10.0, 10.0) };
        let robot = Robot::disc(radius).unwrap();
        let tolerance = Certifier::new(&World::new(bounds, Vec::new(), None), robot).tolerance();
        let y = at + scale * rng.random_range(4.0..6.0);
        let half = radius + tolerance * rng.random_range(-0.5..3.0);
        let (left, right) = (at + scale * 4.0, at + scale * rng.random_range(4.1..6.0));
        let lower = Rect { min: [left, at - scale], max: [right, y - half] };
        let upper = Rect { min: [left, y + half], max: [right, at + 11.0 * scale] };
        let shape = |rect: Rect| match index % 2 {
            0 => Obstacle::Rect(rect),
            _ => Obstacle::Polygon(ConvexPolygon::from_convex(rect.corners().to_vec())),
        };
        let world = World::new(bounds, vec![shape(lower), shape(upper)], None);
        let mut query = ShortestPath::new(&world, robot);
        let (start, goal) = (place(2.1, 5.0), place(7.9, 5.0));
        let outside = 1.5 * radius + 2.0 * tolerance;
        let path = [start, [left - outside, y], [right + outside, y], goal];
        let certified = query.certifier().is_certified(&path);
        let route = query.find(start, goal);
        let proved = matches!(route, Route::Unsolvable(Proof::Disconnected));
        let context = format!("{index}: {half} {tolerance} {route:?}");
        assert!(!(certified && proved), "{context}");
        if let Route::Found { trajectory, .. } = &route {
            assert_eq!(query.certifier().check(trajectory), Ok(()), "{context}");
        }
        counts[usize::from(proved) + 2 * usize::from(!proved && route.length().is_none())] += 1;
    }
    // All three answers happen, and few are undecided that could be decided.
    assert!(counts.iter().all(|&count| count > 300), "{counts:?}");
}

#[test]
fn rasters_are_bounded_by_their_sides() {
    let bounds = Rect { min: [0.0; 2], max: [1e9, 1e-6] };
    let grid = Grid::new(1, 1, 1e-3, [0.0; 2], vec![false]).unwrap();
    let bars = (0..300).map(|i| {
        let x = 3e6 * f64::from(i);
        rect(x + 1e6, -9.0, x + 2e6, -2.0)
    });
    let obstacles: Vec<_> = bars.chain([rect(7e8, -1.0, 8e8, 1.0)]).collect();
    for (bounds, turn) in [(bounds, false), (Rect { min: [0.0; 2], max: [1e-6, 1e9] }, true)] {
        let turned = |shape: &Obstacle| {
            let Rect { min: [x0, y0], max: [x1, y1] } = shape.bounding_box();
            if turn { rect(y0, x0, y1, x1) } else { rect(x0, y0, x1, y1) }
        };
        let obstacles = obstacles.iter().map(turned).collect();
        let world = World::new(bounds, obstacles, Some(grid.clone()));
        let certifier = Certifier::new(&world, Robot::Point);
        let raster = raster::Raster::new(&certifier, &|| true).unwrap();
        assert!(raster.width().max(raster.height()) <= 1 << 21);
        let end = |x: f64| if turn { [5e-7, x] } else { [x, 5e-7] };
        let route = ShortestPath::new(&world, Robot::Point).find(end(1.0), end(9e8));
        assert!(matches!(route, Route::Unsolvable(Proof::Disconnected)), "{route:?}");
    }
}
