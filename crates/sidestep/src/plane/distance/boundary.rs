//! The boundary of a union of shapes: each shape's outline less what other shapes cover.
//!
//! Needed for the depth of a point inside overlapping obstacles: the way out leads to the union's
//! boundary, not to that of the shape it happens to be in. Other shapes are grown by a tolerance
//! before they cover, so that the shared side of two abutting boxes disappears; where two shapes
//! share a side facing the same way, the one that comes first keeps it.

use std::f64::consts::TAU;

use crate::plane::geometry::{
    Circle, Point, Rect, add, cross, distance, dot, lerp, norm, scale, sub,
};
use crate::plane::world::Obstacle;

/// Shapes from one question whether to go on to the next.
const SHAPES_A_QUESTION: usize = 16;

/// A circular arc, counter-clockwise from angle `from` over `sweep` radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Arc {
    pub center: Point,
    pub radius: f64,
    pub from: f64,
    pub sweep: f64,
}

/// The boundary pieces of a union, each with the obstacle on its left (segments) or inside (arcs).
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct UnionBoundary {
    pub segments: Vec<(Point, Point)>,
    pub arcs: Vec<Arc>,
}

impl UnionBoundary {
    /// The boundary of the union of `obstacles`; pieces closer than `tolerance` count as touching. None once `go_on` is false.
    pub fn new(obstacles: &[Obstacle], tolerance: f64, go_on: &dyn Fn() -> bool) -> Option<Self> {
        let boxes: Vec<_> =
            obstacles.iter().map(|o| o.bounding_box().inflated(2.0 * tolerance)).collect();
        let overlaps = Overlaps::new(boxes);
        let outlines: Vec<_> = obstacles.iter().map(outline).collect();
        let mut boundary = Self::default();
        let (mut covered, mut near) = (Vec::new(), Vec::new());
        for (own, shape) in obstacles.iter().enumerate() {
            if own.is_multiple_of(SHAPES_A_QUESTION) && !go_on() {
                return None;
            }
            overlaps.of(own, &mut near);
            match shape {
                Obstacle::Circle(circle) => {
                    boundary.add_circle(own, circle, &near, obstacles, &outlines, tolerance);
                }
                _ => {
                    for &(a, b) in &outlines[own] {
                        covered.clear();
                        for &other in &near {
                            let wins = own < other;
                            covered.extend(covered_part(
                                a,
                                b,
                                &obstacles[other],
                                &outlines[other],
                                wins,
                                tolerance,
                            ));
                        }
                        boundary.add_uncovered(a, b, &mut covered);
                    }
                }
            }
        }
        Some(boundary)
    }

    /// Adds what is left of segment `a b` after the covered fractions are taken out.
    fn add_uncovered(&mut self, a: Point, b: Point, covered: &mut [(f64, f64)]) {
        covered.sort_by(|p, q| p.0.total_cmp(&q.0));
        let mut from = 0.0;
        for &(begin, end) in covered.iter().chain([&(1.0, 1.0)]) {
            if begin > from {
                self.segments.push((lerp(a, b, from), lerp(a, b, begin)));
            }
            from = from.max(end);
        }
    }

    /// Adds the arcs of a circle that no other shape covers.
    fn add_circle(
        &mut self,
        own: usize,
        circle: &Circle,
        near: &[usize],
        obstacles: &[Obstacle],
        outlines: &[Vec<(Point, Point)>],
        tolerance: f64,
    ) {
        let mut angles = vec![0.0];
        for &other in near {
            if let Obstacle::Circle(second) = &obstacles[other] {
                circle_crossings(circle, second, &mut angles);
            }
            for &(a, b) in &outlines[other] {
                segment_crossings(circle, a, b, &mut angles);
            }
        }
        angles.sort_by(f64::total_cmp);
        angles.push(angles[0] + TAU);
        for pair in angles.windows(2) {
            let (from, sweep) = (pair[0], pair[1] - pair[0]);
            let middle = on_circle(circle, from + 0.5 * sweep);
            let is_covered = near.iter().any(|&other| match &obstacles[other] {
                Obstacle::Circle(second)
                    if distance(second.center, circle.center) <= tolerance
                        && (second.radius - circle.radius).abs() <= tolerance =>
                {
                    other < own
                }
                shape => shape.signed_distance(middle) < tolerance,
            });
            if sweep > 0.0 && !is_covered {
                self.arcs.push(Arc { center: circle.center, radius: circle.radius, from, sweep });
            }
        }
    }
}

/// Boxes by their left sides, to find which overlap one of them.
struct Overlaps {
    boxes: Vec<Rect>,
    /// Indices of the boxes, by left side.
    order: Vec<u32>,
    /// For each place in the order, the rightmost side up to there.
    rightmost: Vec<f64>,
}

impl Overlaps {
    fn new(boxes: Vec<Rect>) -> Self {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        order.sort_by(|&a, &b| boxes[a as usize].min[0].total_cmp(&boxes[b as usize].min[0]));
        let mut right = f64::NEG_INFINITY;
        let rightmost = order
            .iter()
            .map(|&index| {
                right = right.max(boxes[index as usize].max[0]);
                right
            })
            .collect();
        Self { boxes, order, rightmost }
    }

    /// The boxes other than `own` that overlap it or touch it, ascending.
    fn of(&self, own: usize, near: &mut Vec<usize>) {
        near.clear();
        let a = &self.boxes[own];
        let after = self.order.partition_point(|&i| self.boxes[i as usize].min[0] <= a.max[0]);
        for place in (0..after).rev() {
            if self.rightmost[place] < a.min[0] {
                break;
            }
            let other = self.order[place] as usize;
            let b = &self.boxes[other];
            if other != own && (0..2).all(|k| a.min[k] <= b.max[k] && b.min[k] <= a.max[k]) {
                near.push(other);
            }
        }
        near.sort_unstable();
    }
}

/// The sides of a rectangle or polygon, counter-clockwise; none for a circle.
fn outline(shape: &Obstacle) -> Vec<(Point, Point)> {
    match shape {
        Obstacle::Rect(rect) => {
            let corners = rect.corners();
            (0..4).map(|i| (corners[i], corners[(i + 1) % 4])).collect()
        }
        Obstacle::Polygon(polygon) => polygon.edges().collect(),
        Obstacle::Circle(_) => Vec::new(),
    }
}

fn on_circle(circle: &Circle, angle: f64) -> Point {
    add(circle.center, scale([angle.cos(), angle.sin()], circle.radius))
}

/// The fractions of segment `a b` inside `shape` grown by `tolerance`. A side of `shape` that the
/// segment lies on, facing the same way, covers it only if the segment does not win the tie.
fn covered_part(
    a: Point,
    b: Point,
    shape: &Obstacle,
    sides: &[(Point, Point)],
    wins: bool,
    tolerance: f64,
) -> Option<(f64, f64)> {
    let direction = sub(b, a);
    let (mut begin, mut end) = (0.0f64, 1.0f64);
    if let Obstacle::Circle(circle) = shape {
        let offset = sub(a, circle.center);
        let radius = circle.radius + tolerance;
        let (p, q) = (dot(offset, direction), dot(direction, direction));
        let discriminant = p * p - q * (dot(offset, offset) - radius * radius);
        if discriminant <= 0.0 {
            return None;
        }
        begin = begin.max((-p - discriminant.sqrt()) / q);
        end = end.min((-p + discriminant.sqrt()) / q);
    }
    for &(c, d) in sides {
        let side = sub(d, c);
        let length = norm(side);
        // Signed heights over the side's line, positive outside.
        let height = |p: Point| -cross(side, sub(p, c)) / length;
        let (at_a, at_b) = (height(a), height(b));
        let on_the_line = at_a.abs() <= tolerance && at_b.abs() <= tolerance;
        if on_the_line && dot(side, direction) > 0.0 && wins {
            return None;
        }
        let (at_a, at_b) = (at_a - tolerance, at_b - tolerance);
        match (at_a > 0.0, at_b > 0.0) {
            (true, true) => return None,
            (true, false) => begin = begin.max(at_a / (at_a - at_b)),
            (false, true) => end = end.min(at_a / (at_a - at_b)),
            (false, false) => {}
        }
    }
    (begin < end).then_some((begin, end))
}

/// Angles on `circle` where it crosses the circle `second`.
fn circle_crossings(circle: &Circle, second: &Circle, angles: &mut Vec<f64>) {
    let to_second = sub(second.center, circle.center);
    let d = norm(to_second);
    if d == 0.0 {
        return;
    }
    // Law of cosines: the crossing lies at angle acos(...) to either side of the line of centres.
    let cosine =
        (d * d + circle.radius.powi(2) - second.radius.powi(2)) / (2.0 * d * circle.radius);
    if cosine.abs() <= 1.0 {
        let middle = to_second[1].atan2(to_second[0]);
        angles.push((middle - cosine.acos()).rem_euclid(TAU));
        angles.push((middle + cosine.acos()).rem_euclid(TAU));
    }
}

/// Angles on `circle` where it crosses segment `a b`.
fn segment_crossings(circle: &Circle, a: Point, b: Point, angles: &mut Vec<f64>) {
    let (offset, direction) = (sub(a, circle.center), sub(b, a));
    let (p, q) = (dot(offset, direction), dot(direction, direction));
    let discriminant = p * p - q * (dot(offset, offset) - circle.radius.powi(2));
    if discriminant <= 0.0 || q == 0.0 {
        return;
    }
    for root in [-discriminant.sqrt(), discriminant.sqrt()] {
        let t = (-p + root) / q;
        if (0.0..=1.0).contains(&t) {
            let point = add(offset, scale(direction, t));
            angles.push(point[1].atan2(point[0]).rem_euclid(TAU));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rect(x0: f64, y0: f64, x1: f64, y1: f64) -> Obstacle {
        Obstacle::Rect(Rect::new([x0, y0], [x1, y1]).unwrap())
    }

    #[test]
    fn perimeters() {
        let circle = |x, y, r| Obstacle::Circle(Circle::new([x, y], r).unwrap());
        let check = |name, obstacles: &[Obstacle], expected: f64| {
            let boundary = UnionBoundary::new(obstacles, 1e-9, &|| true).unwrap();
            let segments: f64 = boundary.segments.iter().map(|&(a, b)| distance(a, b)).sum();
            let arcs: f64 = boundary.arcs.iter().map(|arc| arc.radius * arc.sweep).sum();
            assert!((segments + arcs - expected).abs() < 1e-6, "{name}: {segments} + {arcs}");
        };
        check("one", &[rect(0., 0., 2., 1.)], 6.0);
        check("abutting", &[rect(0., 0., 2., 1.), rect(2., 0., 3., 1.)], 8.0);
        check("same", &[rect(0., 0., 2., 1.), rect(0., 0., 2., 1.)], 6.0);
        check("same right side", &[rect(0., 0., 2., 2.), rect(1., 0., 2., 1.)], 8.0);
        check("cross", &[rect(0., 1., 3., 2.), rect(1., 0., 2., 3.)], 12.0);
        check("inside", &[rect(0., 0., 9., 9.), rect(3., 3., 4., 4.)], 36.0);
        check("circles apart", &[circle(0., 0., 1.), circle(5., 0., 1.)], 2.0 * TAU);
        check("same circle", &[circle(0., 0., 1.), circle(0., 0., 1.)], TAU);
        check("half covered", &[circle(0., 0., 1.), rect(-9., -9., 9., 0.)], 52.0 + TAU / 2.0);
    }
}
