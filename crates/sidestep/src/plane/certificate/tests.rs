//! Hand-made rows, and the fast paths against exact distances and samples.

use proptest::prelude::*;

use super::*;
use crate::plane::geometry::{Circle, ConvexPolygon, lerp};
use crate::plane::world::Grid;

const FIELD: Rect = Rect { min: [0.0, 0.0], max: [64.0, 64.0] };

fn rect(x0: f64, y0: f64, x1: f64, y1: f64) -> Obstacle {
    Obstacle::Rect(Rect::new([x0, y0], [x1, y1]).unwrap())
}

fn certifier(obstacles: Vec<Obstacle>, radius: f64) -> Certifier {
    Certifier::new(&World::new(FIELD, obstacles, None), Robot::disc(radius).unwrap())
}

fn grid_world(rows_from_top: &[&str], resolution: f64) -> World {
    let occupied: Vec<bool> =
        rows_from_top.iter().rev().flat_map(|row| row.bytes().map(|cell| cell == b'@')).collect();
    let (width, height) = (rows_from_top[0].len(), rows_from_top.len());
    let grid = Grid::new(width, height, resolution, [0.0, 0.0], occupied).unwrap();
    World::new(grid.rect(), Vec::new(), Some(grid))
}

#[test]
fn segments_against_shapes() {
    let check = |radius: f64, obstacles: &[Obstacle], a: Point, b: Point, expected: bool| {
        let certifier = certifier(obstacles.to_vec(), radius);
        assert_eq!(certifier.segment_is_free(a, b), expected, "{radius} {obstacles:?} {a:?} {b:?}");
        assert_eq!(certifier.segment_is_free(b, a), expected, "{radius} {obstacles:?} {b:?} {a:?}");
    };
    let boxed = [rect(10.0, 10.0, 20.0, 20.0)];
    check(0.0, &[], [0.0, 0.0], [64.0, 64.0], true);
    check(0.0, &[], [0.0, 0.0], [64.0, 64.1], false);
    check(0.0, &boxed, [5.0, 5.0], [25.0, 25.0], false);
    check(0.0, &boxed, [5.0, 9.9], [25.0, 9.9], true);
    // Touching a side or a corner is not certified; a hair away from it is.
    check(0.0, &boxed, [5.0, 10.0], [25.0, 10.0], false);
    check(0.0, &boxed, [5.0, 10.0 - 1e-6], [25.0, 10.0 - 1e-6], true);
    check(0.0, &boxed, [0.0, 20.0], [20.0, 0.0], false);
    check(0.0, &boxed, [0.0, 20.0 - 1e-6], [20.0 - 1e-6, 0.0], true);
    check(0.0, &boxed, [5.0, 15.0], [15.0, 5.0], false);
    check(0.0, &boxed, [12.0, 15.0], [18.0, 15.0], false);
    // No gap between boxes that share an edge, meet in a corner, or between a box and its wall.
    let abutting = [rect(10.0, 10.0, 20.0, 20.0), rect(20.0, 10.0, 30.0, 20.0)];
    check(0.0, &abutting, [20.0, 5.0], [20.0, 25.0], false);
    let pinched = [rect(10.0, 10.0, 20.0, 20.0), rect(20.0, 20.0, 30.0, 30.0)];
    check(0.0, &pinched, [15.0, 25.0], [25.0, 15.0], false);
    check(0.0, &[rect(50.0, 10.0, 64.0, 20.0)], [64.0, 5.0], [64.0, 25.0], false);
    check(0.0, &[], [64.0, 5.0], [64.0, 25.0], true);
    // A disc is round at corners: 45 degrees past one at distance sqrt(2) and a bit.
    check(1.0, &boxed, [8.0, 9.0], [9.0, 8.0], true);
    check(2.4, &boxed, [8.0, 8.5], [8.5, 8.0], true);
    check(2.5, &boxed, [8.0, 8.5], [8.5, 8.0], false);
    check(1.0, &boxed, [5.0, 9.0], [25.0, 9.0], false);
    check(1.0, &boxed, [5.0, 8.99], [25.0, 8.99], true);
    check(1.0, &[], [1.0, 1.0], [63.0, 63.0], true);
    check(1.0, &[], [0.99, 1.0], [63.0, 63.0], false);
    let circle = [Obstacle::Circle(Circle::new([15.0, 15.0], 5.0).unwrap())];
    check(0.0, &circle, [5.0, 10.0], [25.0, 10.0], false);
    check(0.0, &circle, [5.0, 9.999], [25.0, 9.999], true);
    check(1.0, &circle, [5.0, 9.0], [25.0, 9.0], false);
    let triangle = ConvexPolygon::new(vec![[10.0, 10.0], [20.0, 10.0], [10.0, 20.0]]).unwrap();
    let triangle = [Obstacle::Polygon(triangle)];
    check(0.0, &triangle, [16.0, 16.0], [25.0, 25.0], true);
    check(0.0, &triangle, [11.0, 11.0], [12.0, 12.0], false);
    check(0.0, &triangle, [9.0, 21.0], [21.0, 9.0], false);
    check(0.0, &triangle, [9.0, 21.001], [21.0, 9.001], true);
    check(0.0, &triangle, [9.0, 21.1], [21.1, 9.0], true);
    check(1.0, &triangle, [15.6, 15.6], [15.8, 15.6], false);
    // What is not a number is never free.
    check(0.0, &[], [f64::NAN, 1.0], [1.0, 1.0], false);
    check(0.0, &boxed, [1.0, 1.0], [f64::INFINITY, 1.0], false);
}

#[test]
fn segments_against_cells() {
    let world = grid_world(&["....", ".@..", "..@.", "...."], 2.0);
    let check = |radius: f64, a: Point, b: Point, expected: bool| {
        let certifier = Certifier::new(&world, Robot::disc(radius).unwrap());
        assert_eq!(certifier.segment_is_free(a, b), expected, "{radius} {a:?} {b:?}");
        assert_eq!(certifier.segment_is_free(b, a), expected, "{radius} {b:?} {a:?}");
    };
    check(0.0, [0.0, 0.0], [8.0, 0.0], true);
    check(0.0, [1.0, 1.0], [3.0, 5.0], false);
    check(0.0, [3.0, 3.0], [5.0, 5.0], false);
    check(0.0, [4.0, 4.0], [4.0, 4.0], false);
    check(0.0, [2.0, 0.0], [2.0, 8.0], false);
    check(0.0, [1.999, 0.0], [1.999, 8.0], true);
    check(0.0, [0.0, 2.0], [8.0, 2.0], false);
    check(0.0, [0.0, 1.999], [8.0, 1.999], true);
    check(0.0, [3.0, 1.5], [0.5, 5.0], true);
    check(1.0, [1.0, 1.0], [1.0, 7.0], false);
    check(1.0, [1.0, 1.0], [7.0, 1.0], false);
    check(0.9, [1.0, 1.0], [1.0, 7.0], true);
    check(0.9, [1.0, 2.0], [3.0, 0.9], true);
    check(1.0, [2.0, 2.0], [3.2, 1.2], true);
    check(1.0, [2.0, 2.0], [3.4, 1.4], false);
}

#[test]
fn violations_are_named() {
    let certifier = certifier(vec![rect(10.0, 10.0, 20.0, 20.0)], 1.0);
    let check = |points: &[Point], expected: Result<(), Violation>| {
        assert_eq!(certifier.check(&Trajectory::from_points(points)), expected, "{points:?}");
        assert_eq!(certifier.is_certified(points), expected.is_ok(), "{points:?}");
    };
    let obstacle = ObstacleId::Shape(0);
    check(&[], Err(Violation::EmptyTrajectory));
    check(&[[5.0, 5.0]], Ok(()));
    check(&[[5.0, 5.0], [30.0, 5.0], [30.0, 30.0]], Ok(()));
    check(&[[5.0, 5.0], [f64::NAN, 5.0]], Err(Violation::NotFinite { point: 1 }));
    check(&[[0.5, 5.0], [30.0, 5.0]], Err(Violation::StartOutOfBounds));
    check(&[[30.0, 5.0], [64.0, 5.0]], Err(Violation::GoalOutOfBounds));
    check(&[[9.5, 15.0], [5.0, 5.0]], Err(Violation::StartInCollision { obstacle }));
    check(&[[5.0, 5.0], [15.0, 15.0]], Err(Violation::GoalInCollision { obstacle }));
    check(
        &[[5.0, 5.0], [5.0, 70.0], [30.0, 30.0]],
        Err(Violation::OutOfBounds { segment: 0, point: 1 }),
    );
    check(
        &[[5.0, 5.0], [6.0, 6.0], [30.0, 30.0]],
        Err(Violation::Collision { segment: 1, obstacle }),
    );
    let message = Violation::Collision { segment: 1, obstacle }.to_string();
    assert_eq!(message, "segment 1 of the trajectory collides with obstacle 0");

    let cell = Certifier::new(&grid_world(&["...", ".@.", "..."], 1.0), Robot::Point);
    assert_eq!(
        cell.check(&Trajectory::from_points(&[[0.5, 1.5], [2.5, 1.5]])),
        Err(Violation::Collision { segment: 0, obstacle: ObstacleId::Cell { column: 1, row: 1 } })
    );
}

#[test]
fn clearance_rows() {
    let check = |certifier: &Certifier, points: &[Point], expected: f64| {
        let clearance = certifier.clearance(&Trajectory::from_points(points));
        assert!((clearance - expected).abs() < 1e-9 || clearance == expected, "{clearance}");
    };
    let boxed = certifier(vec![rect(10.0, 10.0, 20.0, 20.0)], 1.0);
    check(&boxed, &[], f64::INFINITY);
    check(&boxed, &[[30.0, 2.0], [40.0, 2.0]], 1.0);
    check(&boxed, &[[7.0, 6.0], [6.0, 6.0]], 4.0);
    check(&boxed, &[[7.0, 7.0]], 18.0_f64.sqrt() - 1.0);
    check(&boxed, &[[5.0, 15.0], [30.0, 15.0]], -1.0);
    let cells =
        Certifier::new(&grid_world(&["......", "...@..", "......", "......"], 2.0), Robot::Point);
    check(&cells, &[[5.0, 3.0], [5.0, 2.0]], 2.0_f64.sqrt());
    check(&cells, &[[7.0, 3.0], [7.0, 2.0]], 1.0);
    check(&cells, &[[7.0, 3.0], [7.0, 5.0]], 0.0);
}

/// Shapes of all kinds on a coarse lattice, so that touching happens.
fn shape() -> impl Strategy<Value = Obstacle> {
    let lattice = |range: std::ops::Range<i32>| range.prop_map(|i| f64::from(i) / 2.0);
    prop_oneof![
        (lattice(0..100), lattice(0..100), lattice(1..30), lattice(1..30))
            .prop_map(|(x, y, w, h)| rect(x, y, x + w, y + h)),
        (lattice(0..128), lattice(0..128), lattice(1..16))
            .prop_map(|(x, y, r)| Obstacle::Circle(Circle::new([x, y], r).unwrap())),
        (lattice(0..100), lattice(0..100), lattice(1..30), lattice(1..30)).prop_map(
            |(x, y, w, h)| {
                let corners = vec![[x, y], [x + w, y], [x + w / 2.0, y + h]];
                Obstacle::Polygon(ConvexPolygon::new(corners).unwrap())
            }
        ),
    ]
}

fn point() -> impl Strategy<Value = Point> {
    (0..=256_i32, 0..=256_i32).prop_map(|(x, y)| [f64::from(x) / 4.0, f64::from(y) / 4.0])
}

proptest! {
    /// The fast paths (blocks of boxes, buckets) against the exact distance to each shape.
    #[test]
    fn fast_paths_match_distances(
        shapes in prop::collection::vec(shape(), 1..60),
        radius in prop_oneof![Just(0.0), 0.0..4.0],
        a in point(),
        b in point(),
    ) {
        let certifier = certifier(shapes.clone(), radius);
        let least = shapes
            .iter()
            .map(|shape| segment_obstacle_distance(a, b, shape))
            .fold(f64::INFINITY, f64::min);
        let inside = certifier.bounds().contains(a) && certifier.bounds().contains(b);
        prop_assert_eq!(certifier.segment_is_free(a, b), inside && least > certifier.margin());
        let named = certifier.check(&Trajectory::from_points(&[a, b]));
        prop_assert_eq!(named.is_ok(), inside && least > certifier.margin());
    }

    /// The exact distance is never above the distance at a sample, and near the least of them.
    #[test]
    fn distances_match_samples(shape in shape(), a in point(), b in point()) {
        let samples = 2000;
        let sampled = (0..=samples)
            .map(|i| shape.signed_distance(lerp(a, b, f64::from(i) / f64::from(samples))).max(0.0))
            .fold(f64::INFINITY, f64::min);
        let exact = segment_obstacle_distance(a, b, &shape);
        let spacing = crate::plane::geometry::distance(a, b) / f64::from(samples);
        prop_assert!(exact <= sampled + 1e-9 && sampled <= exact + spacing + 1e-9,
            "{exact} {sampled}");
    }

    /// Cells against the same squares as shapes.
    #[test]
    fn cells_match_boxes(
        occupied in prop::collection::vec(prop::bool::weighted(0.1), 70 * 9),
        radius in prop_oneof![Just(0.0), 0.0..3.0],
        ends in [(0..=140_i32, 0..=18_i32), (0..=140_i32, 0..=18_i32)],
    ) {
        let grid = Grid::new(70, 9, 0.5, [-3.0, 1.0], occupied.clone()).unwrap();
        let squares = (0..occupied.len())
            .filter(|&cell| occupied[cell])
            .map(|cell| Obstacle::Rect(grid.cell_rect((cell % 70) as i64, (cell / 70) as i64)))
            .collect();
        let robot = Robot::disc(radius).unwrap();
        let bounds = grid.rect();
        let shapes = Certifier::new(&World::new(bounds, squares, None), robot);
        let cells = Certifier::new(&World::new(bounds, Vec::new(), Some(grid)), robot);
        let [a, b] = ends.map(|(x, y)| [f64::from(x) / 4.0 - 3.0, f64::from(y) / 4.0 + 1.0]);
        prop_assert_eq!(cells.segment_is_free(a, b), shapes.segment_is_free(a, b));
        let path = Trajectory::from_points(&[a, b]);
        prop_assert!((cells.clearance(&path) - shapes.clearance(&path)).abs() < 1e-9);
    }
}

#[test]
fn a_robot_that_does_not_fit_among_many_shapes_is_nowhere_free() {
    let bounds = Rect::new([0.0; 2], [70.0, 4.5]).unwrap();
    let square = |i: i32| {
        let x = f64::from(i);
        Obstacle::Rect(Rect::new([x, 1.0], [x + 0.5, 1.5]).unwrap())
    };
    let world = World::new(bounds, (0..60).map(square).collect(), None);
    let certifier = Certifier::new(&world, Robot::disc(2.6).unwrap());
    assert!(!certifier.point_is_free([35.0, 2.2]));
}
