//! What of a world enters the certificate's arithmetic, and the tolerance that its rounding needs.
//!
//! The tolerance is [`World::tolerance`], and at least [`ROUNDING`] times the largest magnitude that is computed
//! with. Where what lies far outside the bounds would raise it, that is first cut off: a rectangle's side
//! moves nearer, which changes no distance from inside the bounds, and what is nowhere near the bounds does not
//! count. Circles, polygons and grids cannot be cut exactly in floating point; they count as they are.

use crate::plane::Robot;
use crate::plane::geometry::Rect;
use crate::plane::world::{Obstacle, World};

/// Rounding of the certificate's arithmetic, as a part of the largest magnitude in it. A distance from a segment to
/// a shape is off by at most some 13 units of 2^-52 of that magnitude, and half of what is asked for has to be left.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// The shapes of a world as a certifier sees them, one for one, and the tolerance.
pub(super) struct Near {
    pub(super) obstacles: Vec<Obstacle>,
    pub(super) tolerance: f64,
}

impl Near {
    /// What a robot's certifier sees of a world.
    pub(super) fn new(world: &World, robot: Robot) -> Self {
        let obstacles = world.obstacles().to_vec();
        let least = world.tolerance();
        let own = magnitude(world.bounds()).max(robot.radius());
        let own = world.grid().map_or(own, |grid| own.max(magnitude(grid.rect())));
        let all = obstacles.iter().map(largest).fold(own, f64::max);
        if ROUNDING * all <= least {
            return Self { obstacles, tolerance: least };
        }
        let (bounds, extent) = (world.bounds(), world.bounds().extent());
        let obstacles: Vec<_> =
            obstacles.into_iter().map(|shape| cut(shape, bounds, extent)).collect();
        // What is further from the bounds than the robot reaches, by more than rounding, is clear anyway.
        let reach = |shape: &Obstacle| 2.0 * (extent + robot.radius()) + ROUNDING * largest(shape);
        let is_near = |shape: &&Obstacle| gap(&shape.bounding_box(), &bounds) <= reach(shape);
        let near = obstacles.iter().filter(is_near);
        let near = near.map(largest).fold(own, f64::max);
        Self { obstacles, tolerance: least.max(ROUNDING * near) }
    }
}

/// The largest magnitude of a coordinate.
fn magnitude(rect: Rect) -> f64 {
    rect.min.into_iter().chain(rect.max).fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// The largest magnitude of the numbers that define a shape.
fn largest(shape: &Obstacle) -> f64 {
    match shape {
        Obstacle::Rect(rect) => magnitude(*rect),
        Obstacle::Circle(circle) => {
            let [x, y] = circle.center.map(f64::abs);
            x.max(y).max(circle.radius)
        }
        Obstacle::Polygon(polygon) => {
            polygon.vertices().iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()))
        }
    }
}

/// The shape without what of a rectangle lies further than `extent` outside the bounds, or behind a side
/// that does.
fn cut(shape: Obstacle, bounds: Rect, extent: f64) -> Obstacle {
    let Obstacle::Rect(mut rect) = shape else { return shape };
    let around = bounds.inflated(extent);
    for axis in 0..2 {
        let (low, high) = (rect.min[axis], rect.max[axis]);
        rect.max[axis] = high.min(around.max[axis].max((low + extent).max(low.next_up())));
        rect.min[axis] = low.max(around.min[axis].min((high - extent).min(high.next_down())));
    }
    Obstacle::Rect(rect)
}

/// The larger of the gaps between two rectangles along the axes.
fn gap(a: &Rect, b: &Rect) -> f64 {
    let along = |axis: usize| (a.min[axis] - b.max[axis]).max(b.min[axis] - a.max[axis]);
    along(0).max(along(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::geometry::Circle;

    #[test]
    fn the_tolerance_follows_what_is_near() {
        let field = |low: f64, high: f64| Rect::new([low; 2], [high; 2]).unwrap();
        let rect = |low: f64, high: f64| Obstacle::Rect(field(low, high));
        let circle = |x: f64, radius| Obstacle::Circle(Circle::new([x, x], radius).unwrap());
        let check = |bounds: Rect, obstacles: &[Obstacle], radius: f64, expected: f64| {
            let world = World::new(bounds, obstacles.to_vec(), None);
            let near = Near::new(&world, Robot::disc(radius).unwrap());
            let got = near.tolerance;
            assert!((got / expected - 1.0).abs() < 1e-12, "{got} {expected} {obstacles:?}");
        };
        check(field(0.0, 64.0), &[rect(3.0, 9.0), circle(70.0, 9.0)], 1.0, 1e-9 * 64.0);
        // Huge fields do not close doors, and far coordinates take what they need.
        check(field(-1e7, 1e7), &[], 0.0, 1e-5);
        check(field(-1e9, 1e9), &[rect(4.0, 1e9)], 0.0, 1e-5);
        check(field(5e8, 5e8 + 100.0), &[], 0.0, ROUNDING * (5e8 + 100.0));
        // Rectangles are cut, near circles count, far shapes do not.
        check(field(0.0, 1.0), &[rect(-1e9, 0.5)], 0.0, 1e-9);
        check(field(0.0, 1.0), &[rect(0.5, 1e9)], 0.0, 1e-9);
        check(field(0.0, 1.0), &[rect(-1e9, 1e9)], 0.0, 1e-9);
        check(field(0.0, 1.0), &[circle(-1e8, 1.5e8)], 0.0, ROUNDING * 1.5e8);
        check(field(0.0, 1.0), &[circle(-1e8, 0.9e8)], 0.0, 1e-9);
        check(field(0.0, 1e-6), &[circle(3.0, 1.0), rect(1e8, 1e9)], 0.0, 1e-15);
        check(field(0.0, 1e-9), &[circle(1e9, 1e9 - 1e-7)], 0.0, ROUNDING * 1e9);
    }

    #[test]
    fn cutting_changes_no_distance_from_inside() {
        let bounds = Rect::new([1.0, 2.0], [4.0, 3.0]).unwrap();
        let sides = [-1e9, -7.0, -2.5, 0.0, 1.5, 2.5, 3.5, 5.0, 7.5, 1e3, 1e9];
        for (i, &low) in sides.iter().enumerate() {
            for &high in &sides[i + 1..] {
                for (low_y, high_y) in [(low, high), (2.2, 2.4), (-1e8, 2.5), (1e7, 1e8)] {
                    let whole = Rect::new([low, low_y], [high, high_y]).unwrap();
                    let Obstacle::Rect(part) = cut(Obstacle::Rect(whole), bounds, bounds.extent())
                    else {
                        panic!("a rectangle stays one")
                    };
                    for p in [[1.0, 2.0], [2.5, 2.5], [4.0, 3.0], [3.0, 2.1]] {
                        let [cut, of] = [part, whole].map(|rect| rect.signed_distance(p).max(0.0));
                        assert_eq!(cut, of, "{whole:?} {p:?}");
                    }
                }
            }
        }
    }
}
