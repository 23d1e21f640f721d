//! The certificate against rational arithmetic: what it passes keeps clear exactly, and what it refuses comes nearer
//! than a tolerance and a half; ordinary, touching, far, tiny and shifted worlds.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test")]

#[path = "../examples/judge/exact.rs"]
mod exact;

use proptest::prelude::*;
use sidestep::plane::geometry::{Circle, ConvexPolygon, Point, Rect};
use sidestep::{Certifier, Grid, Obstacle, Robot, Trajectory, World};

use exact::{Number, Solid, clear_in, is_inside, keeps_clear};

/// Numbers of a coarse lattice and some that rounding does not like, from -1 to 9.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (-4..=36_i32).prop_map(|i| f64::from(i) / 4.0),
        2 => (-10..=90_i32).prop_map(|i| f64::from(i) * 0.1),
        2 => -1.0..9.0_f64,
        1 => prop_oneof![Just(1.0 / 3.0), Just(0.1 + 0.2), Just(8.0_f64.next_down())],
    ]
}

fn point() -> impl Strategy<Value = Point> {
    [coordinate(), coordinate()]
}

/// A length of a side or radius, hardly anything or far more than the field.
fn size() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => (1..=16_i32).prop_map(|i| f64::from(i) / 4.0),
        2 => 1e-3..4.0_f64,
        1 => (-12.0..8.0_f64).prop_map(|power| 10_f64.powf(power)),
        1 => (1..9_i32).prop_map(|power| 10_f64.powi(power)),
    ]
}

/// Shapes that reach to about the point from any side; how they are given follows from `kind`.
fn shape() -> impl Strategy<Value = (u8, Point, Point, f64)> {
    (0..6_u8, point(), [size(), size()], 0.0..std::f64::consts::TAU)
}

/// How the world is scaled, then moved.
fn frame() -> impl Strategy<Value = (f64, Point)> {
    prop_oneof![
        4 => Just((1.0, [0.0, 0.0])),
        1 => Just((1e-6, [0.0, 0.0])),
        1 => Just((1e-9, [0.0, 0.0])),
        1 => Just((1e3, [0.1, 0.7])),
        1 => Just((1.0, [500_000.0, 4_649_776.25])),
        1 => Just((0.01, [166_021.44, 9_328_093.8])),
        1 => Just((1e-3, [-3e8, 7e8])),
    ]
}

fn place((scale, shift): (f64, Point), p: Point) -> Point {
    [p[0] * scale + shift[0], p[1] * scale + shift[1]]
}

fn obstacle((kind, near, [w, h], angle): (u8, Point, Point, f64), scale: f64) -> Option<Obstacle> {
    let [x, y] = near;
    let (w, h) = (w * scale, h * scale);
    let rect = |min, max| Rect::new(min, max).ok().map(Obstacle::Rect);
    match kind {
        0 => rect([x - w, y - h], near),
        1 => rect(near, [x + w, y + h]),
        2 => rect([x - w, y - h], [x + h, y + w]),
        3 => Circle::new([x + w * angle.cos(), y + w * angle.sin()], w).ok().map(Obstacle::Circle),
        4 => Circle::new([x + w, y], w).ok().map(Obstacle::Circle),
        _ => {
            let turn = |by: f64, reach: f64| {
                [x + reach * (angle + by).cos(), y + reach * (angle + by).sin()]
            };
            let corners = vec![near, turn(0.0, w), turn(1.1, h.max(w)), turn(2.0, w)];
            ConvexPolygon::new(corners).ok().map(Obstacle::Polygon)
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn shapes_match_rational_arithmetic(
        frame in frame(),
        shapes in prop::collection::vec(shape(), 1..5),
        radius in prop_oneof![2 => Just(0.0), 1 => (1..8_i32).prop_map(|i| f64::from(i) / 8.0), 1 => 1e-12..1.0_f64],
        ends in prop::collection::vec(point(), 2..7),
    ) {
        let bounds = Rect { min: place(frame, [0.0; 2]), max: place(frame, [8.0; 2]) };
        let obstacles: Vec<_> = shapes
            .into_iter()
            .filter_map(|(kind, near, size, angle)| {
                obstacle((kind, place(frame, near), size, angle), frame.0)
            })
            .collect();
        check(&World::new(bounds, obstacles, None), radius * frame.0, frame, &ends)?;
    }

    #[test]
    fn cells_match_rational_arithmetic(
        frame in frame(),
        occupied in prop::collection::vec(prop::bool::weighted(0.2), 12 * 9),
        resolution in prop_oneof![Just(1.0), Just(0.5), Just(0.05), Just(0.3), Just(2.0 / 3.0)],
        radius in prop_oneof![1 => Just(0.0), 1 => (1..8_i32).prop_map(|i| f64::from(i) / 8.0), 1 => 1e-12..1.0_f64],
        ends in prop::collection::vec(point(), 2..7),
    ) {
        let bounds = Rect { min: place(frame, [0.0; 2]), max: place(frame, [8.0; 2]) };
        let origin = place(frame, [-0.25, 0.1]);
        let grid = Grid::new(12, 9, resolution * frame.0, origin, occupied);
        check(&World::new(bounds, Vec::new(), Some(grid.unwrap())), radius * frame.0, frame, &ends)?;
    }
}

/// Every segment between neighbours of `ends`, and every end alone.
fn check(
    world: &World,
    radius: f64,
    frame: (f64, Point),
    ends: &[Point],
) -> Result<(), TestCaseError> {
    let robot = Robot::disc(radius).unwrap();
    let certifier = Certifier::new(world, robot);
    // Mitred corners refuse 1.42 tolerances, and rounding a little more.
    let most = radius + 1.5 * (certifier.margin() - radius);
    let (solids, bounds) = (solids(world), world.bounds());
    let ends: Vec<_> = ends.iter().map(|&p| place(frame, p)).collect();
    for pair in ends.windows(2) {
        for (a, b) in [(pair[0], pair[1]), (pair[0], pair[0])] {
            let free = certifier.segment_is_free(a, b);
            let inside = is_inside(&bounds, a, radius) && is_inside(&bounds, b, radius);
            let clear = |reach| solids.iter().all(|solid| keeps_clear(solid, a, b, reach));
            if free {
                prop_assert!(inside, "{a:?} {b:?} leaves the bounds of {world:?}");
                prop_assert!(clear(radius), "{a:?} {b:?} meets an obstacle of {world:?}");
                let clearance = certifier.clearance(&Trajectory::from_points(&[a, b]));
                // The body may touch a wall, and nothing else.
                let off_walls = is_inside(&bounds, a, most) && is_inside(&bounds, b, most);
                prop_assert!(clearance > 0.0 || !off_walls, "{clearance}");
            } else {
                prop_assert!(!inside || !clear(most), "{a:?} {b:?} is refused in {world:?}");
            }
        }
    }
    Ok(())
}

fn solids(world: &World) -> Vec<Solid> {
    let mut solids: Vec<Solid> = world.obstacles().iter().map(Solid::from).collect();
    if let Some(grid) = world.grid() {
        let occupied = grid.cells().iter().enumerate().filter(|(_, occupied)| **occupied);
        solids.extend(occupied.map(|(cell, _)| {
            let index = [cell % grid.width(), cell / grid.width()].map(|i| i as f64);
            Solid::Cell(grid.origin(), grid.resolution(), index)
        }));
    }
    solids
}

#[test]
fn intervals_and_rational_numbers_agree_where_intervals_decide() {
    let square = Solid::Polygon(vec![[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]]);
    let mut decided = 0;
    for i in 0..40 {
        for radius in [0.0, 0.1, 0.3] {
            let x = -0.4 + 0.03 * f64::from(i);
            let quick = clear_in::<exact::Interval>(&square, [x, -0.2], [x, 0.7], radius);
            let exact = clear_in::<num_rational::BigRational>(&square, [x, -0.2], [x, 0.7], radius);
            assert!(exact.is_some() && (quick.is_none() || quick == exact), "{x} {radius}");
            decided += usize::from(quick.is_some());
        }
    }
    assert!(decided > 100, "{decided}");
    assert!(exact::Interval::of(0.1).times(&exact::Interval::of(3.0)).sign().is_some());
}
