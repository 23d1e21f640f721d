//! Grids and worlds of many shapes: candidates by sight against the plain search.

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::tests::{length, rect, reference, world};
use super::*;
use crate::plane::geometry::{Circle, ConvexPolygon};
use crate::plane::world::{Grid, Obstacle};

/// Octile shortest path over cell centres, diagonal moves only where both cells beside are free
/// (the rule of the MovingAI benchmarks), times two to count half cells.
fn octile(grid: &Grid, start: (i64, i64), goal: (i64, i64)) -> Option<f64> {
    let mut cost = std::collections::BTreeMap::new();
    let mut queue = std::collections::BTreeSet::from([(0_u64, start)]);
    let free = |x: i64, y: i64| {
        (0..grid.width() as i64).contains(&x)
            && (0..grid.height() as i64).contains(&y)
            && !grid.is_occupied(x, y)
    };
    while let Some((so_far, at)) = queue.pop_first() {
        if at == goal {
            return Some(so_far as f64 * 1e-9);
        }
        if cost.get(&at).is_some_and(|&known| known < so_far) {
            continue;
        }
        for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
            let to = (at.0 + dx, at.1 + dy);
            if !free(to.0, to.1) || !free(to.0, at.1) || !free(at.0, to.1) {
                continue;
            }
            let total = so_far + (f64::from((dx * dx + dy * dy) as i32).sqrt() * 1e9) as u64;
            if cost.get(&to).is_none_or(|&known| total < known) {
                cost.insert(to, total);
                queue.insert((total, to));
            }
        }
    }
    None
}

/// A maze with many corners: rooms with doors, and rubble.
fn rooms(size: usize, rng: &mut ChaCha8Rng) -> World {
    let mut occupied = vec![false; size * size];
    for (index, cell) in occupied.iter_mut().enumerate() {
        let (x, y) = (index % size, index / size);
        let wall = x % 11 == 0 || y % 13 == 0;
        *cell = if wall { rng.random_range(0..6) > 0 } else { rng.random_range(0..30) == 0 };
    }
    let grid = Grid::new(size, size, 0.5, [-7.0, 3.0], occupied).unwrap();
    World::new(grid.rect(), Vec::new(), Some(grid))
}

#[test]
fn sight_and_rules_lose_nothing_on_grids() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_002);
    for index in 0..12 {
        let map = rooms(40, &mut rng);
        let grid = map.grid().unwrap();
        let robot = Robot::disc([0.0, 0.2, 0.45][index % 3]).unwrap();
        let mut query = ShortestPath::new(&map, robot);
        assert!(query.layers.outside.sight.is_some());
        let mut blind = query.clone();
        Arc::make_mut(&mut blind.layers.outside).sight = None;
        for _ in 0..6 {
            let mut cell = || (rng.random_range(0..40_i64), rng.random_range(0..40_i64));
            let (from, to) = (cell(), cell());
            let center = |(x, y): (i64, i64)| {
                let rect = grid.cell_rect(x, y);
                [0, 1].map(|axis| 0.5 * (rect.min[axis] + rect.max[axis]))
            };
            let (start, goal) = (center(from), center(to));
            let free = |p| query.certifier().point_is_free(p);
            if !free(start) || !free(goal) {
                continue;
            }
            // The flood's answer is the search's.
            let (known, plain) = (query.find(start, goal), blind.find(start, goal));
            match (known.length(), plain.length()) {
                (Some(a), Some(b)) => assert!((a - b).abs() < 1e-6, "{index}: {a} {b}"),
                (a, b) => assert_eq!(a, b, "{index}"),
            }
            if let Some(full) = reference(&query.layers.outside, start, goal) {
                assert!((full - known.length().unwrap()).abs() < 1e-6);
            }
            if robot == Robot::Point {
                let steps = octile(grid, from, to).map(|cells| 0.5 * cells);
                if let Some(steps) = steps {
                    assert!(length(&mut query, start, goal).unwrap() <= steps + 1e-6);
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    /// Shapes of all kinds at once, many of them: routes are certified, the bounds are in order,
    /// both directions agree, and many shapes (buckets, sight) agree with the plain search.
    #[test]
    fn mixed_shapes(seed in any::<u64>(), count in 3_usize..60, radius in prop_oneof![Just(0.0), 0.1..2.0]) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |least: i32, most: i32| f64::from(rng.random_range(least..most)) / 2.0;
        let shapes: Vec<Obstacle> = (0..count)
            .map(|index| {
                let (x, y, w, h) = (draw(0, 120), draw(0, 120), draw(2, 12), draw(2, 12));
                match index % 3 {
                    0 => rect(x, y, x + w, y + h),
                    1 => Obstacle::Circle(Circle::new([x, y], w / 2.0).unwrap()),
                    _ => {
                        let corners = vec![[x, y], [x + w, y + 0.5], [x + w / 2.0, y + h]];
                        Obstacle::Polygon(ConvexPolygon::new(corners).unwrap())
                    }
                }
            })
            .collect();
        let mut query = ShortestPath::new(&world(shapes), Robot::disc(radius).unwrap());
        let mut blind = query.clone();
        Arc::make_mut(&mut blind.layers.outside).sight = None;
        for _ in 0..3 {
            let [start, goal] = [0, 1].map(|_| [draw(4, 124), draw(4, 124)]);
            let (there, back) = (query.find(start, goal), query.find(goal, start));
            let plain = blind.find(start, goal);
            match (&there, &back, &plain) {
                (Route::Found { trajectory, length, lower_bound }, Route::Found { length: other, .. }, _) => {
                    prop_assert_eq!(query.certifier().check(trajectory), Ok(()));
                    prop_assert!((length - other).abs() < 1e-6);
                    prop_assert!(lower_bound <= length);
                    prop_assert!((length - plain.length().unwrap()).abs() < 1e-6);
                }
                (Route::Unsolvable(_), Route::Unsolvable(_), Route::Unsolvable(_)) => {}
                (Route::Undecided(_), Route::Undecided(_), Route::Undecided(_)) => {}
                other => prop_assert!(false, "{other:?}"),
            }
        }
    }
}
