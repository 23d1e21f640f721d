//! Balls that cover a solid, and stick out of it by no more than was asked.
//!
//! With d the signed distance to a convex solid, a ball around c of radius `e - d(c)` sticks out by
//! at most e, as d is 1-Lipschitz; so each point within has one largest ball. Chosen are, greedily,
//! those that cover the most of the surface that is still bare (V. Chvátal, "A greedy heuristic for
//! the set-covering problem", 1979; lazily, as gains only shrink: M. Minoux, 1978), among the
//! points of a grid. Samples only guide the choice. What is covered is *proved*: a triangle of the
//! surface lies in a ball with its three corners, and one that does not is halved; where halves
//! become smaller than e and lie in no ball, one is added there. The surface is what is covered: of
//! the inside, balls may leave holes, which nothing can enter that has not crossed the surface.

use std::collections::BinaryHeap;

use super::hull::Hull;
use super::shape::Shape;
use super::vector::{Vector, add, dot, norm, scale, sub};
use crate::error::InvalidInput;

/// Points of the grid along the longest side of the solid.
const GRID: f64 = 24.0;

/// Sides of the prism around a cylinder: it is 0.12 % wider.
const SIDES: usize = 64;
const TURN: f64 = std::f64::consts::TAU / SIDES as f64;

/// Most samples of a surface.
const SAMPLES: f64 = 20_000.0;

/// Most balls that a cover may need, by its overhang: more are refused before they are looked for.
const MOST_BALLS: f64 = 100_000.0;

/// Balls around a solid.
#[derive(Debug, Clone, PartialEq)]
pub struct Cover {
    /// Centres and radii, in the shape's frame, metres.
    pub balls: Vec<(Vector, f64)>,
    /// How far the balls stick out of the solid, metres: at most what was asked.
    pub overhang: f64,
}

impl Cover {
    /// Balls whose union holds the whole surface of a convex solid and sticks out of it by at most
    /// `overhang` metres.
    ///
    /// # Errors
    /// If the shape is not one convex solid (of a mesh, take the hull), or the overhang is not a
    /// number above 0 or so small that it needs some 100,000 balls.
    pub fn new(shape: &Shape, overhang: f64) -> Result<Self, InvalidInput> {
        let hull = match shape {
            Shape::Sphere { radius } => {
                return Ok(Self { balls: vec![([0.0; 3], *radius)], overhang: 0.0 });
            }
            Shape::Box { half_extents } => {
                let corner = |i: usize| {
                    [0, 1, 2]
                        .map(|k| if i >> k & 1 == 0 { -half_extents[k] } else { half_extents[k] })
                };
                Hull::around(&[0, 1, 2, 3, 4, 5, 6, 7].map(corner))?
            }
            Shape::Cylinder { radius, half_length } => prism(*radius, *half_length)?,
            Shape::Capsule { .. } => return Self::of_capsule(shape, overhang),
            Shape::Hull(hull) => Hull::clone(hull),
            _ => {
                let allowed = "a convex solid: of a mesh, its hull";
                return Err(InvalidInput::new("shape", shape.kind(), allowed));
            }
        };
        let area: f64 = hull.triangles().iter().map(|triangle| area(triangle.corners)).sum();
        // A ball whose centre is deep covers more, but a thin plate needs about this many.
        if !(overhang > 0.0 && area / (overhang * overhang) < MOST_BALLS) {
            let allowed = format!("at least {:.2e} m", (area / MOST_BALLS).sqrt());
            return Err(InvalidInput::new("overhang", overhang, allowed));
        }
        // A prism sticks out of its cylinder already.
        let around = hull.vertices().iter().map(|&p| shape.distance(0, p).0).fold(0.0, f64::max);
        if around > overhang / 8.0 {
            let least = 8.0 * around;
            let allowed = format!("at least {least:.2e} m, for a cylinder of this radius");
            return Err(InvalidInput::new("overhang", overhang, allowed));
        }
        let mut balls = greedy(&hull, overhang - around);
        let inner = if around > 0.0 { (0.5 * TURN).cos() } else { 1.0 };
        finish(&hull, overhang - around, inner, &mut balls);
        let beyond = balls.iter().map(|&(center, radius)| radius + shape.distance(0, center).0);
        Ok(Self { overhang: beyond.fold(0.0, f64::max), balls })
    }

    /// Balls in a row along the axis: those of radius R cover one of radius r swept between centres
    /// `2 √(R² - r²)` apart.
    fn of_capsule(shape: &Shape, overhang: f64) -> Result<Self, InvalidInput> {
        let Shape::Capsule { radius, half_length } = *shape else {
            return Err(InvalidInput::new("shape", shape.kind(), "a capsule"));
        };
        let apart = 2.0 * ((radius + overhang).powi(2) - radius * radius).sqrt();
        let count = (2.0 * half_length / apart).ceil();
        if !(overhang > 0.0 && count < MOST_BALLS) {
            return Err(InvalidInput::new("overhang", overhang, "a number above 0, not too small"));
        }
        if count == 0.0 {
            return Ok(Self { balls: vec![([0.0; 3], radius)], overhang: 0.0 });
        }
        // As many steps as are needed, evenly, and no larger balls than those steps need.
        let step = 2.0 * half_length / count;
        let large = (radius * radius + 0.25 * step * step).sqrt() * (1.0 + 1e-12);
        let at = |i: usize| ([0.0, 0.0, step * i as f64 - half_length], large);
        Ok(Self { balls: (0..=count as usize).map(at).collect(), overhang: large - radius })
    }
}

fn area([a, b, c]: [Vector; 3]) -> f64 {
    0.5 * norm(super::vector::cross(sub(b, a), sub(c, a)))
}

/// A prism around a cylinder, about z.
fn prism(radius: f64, half_length: f64) -> Result<Hull, InvalidInput> {
    let outer = radius / (0.5 * TURN).cos();
    let corner = |i: usize, z: f64| {
        let (sin, cos) = (i as f64 * TURN).sin_cos();
        [outer * cos, outer * sin, z]
    };
    let corners = (0..SIDES).flat_map(|i| [corner(i, -half_length), corner(i, half_length)]);
    Hull::around(&corners.collect::<Vec<_>>())
}

/// Points on the surface, about evenly apart.
fn samples(hull: &Hull, overhang: f64) -> Vec<Vector> {
    let total: f64 = hull.triangles().iter().map(|triangle| area(triangle.corners)).sum();
    let apart = (overhang / 3.0).max((total / SAMPLES).sqrt());
    let mut points = Vec::new();
    for triangle in hull.triangles() {
        let [a, b, c] = triangle.corners;
        let (ab, ac) = (sub(b, a), sub(c, a));
        let longest = norm(ab).max(norm(ac)).max(norm(sub(c, b)));
        let n = (longest / apart).ceil().max(1.0) as usize;
        for i in 0..=n {
            for j in 0..=n - i {
                let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
                points.push(add(a, add(scale(ab, u), scale(ac, v))));
            }
        }
    }
    points
}

/// A ball and how many bare samples it covered when that was last counted.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    gain: usize,
    /// Ties go to the first of the grid.
    ball: std::cmp::Reverse<usize>,
}

/// The balls that cover the samples.
fn greedy(hull: &Hull, overhang: f64) -> Vec<(Vector, f64)> {
    let bounds = hull.bounds();
    let size = [0, 1, 2].map(|k| bounds.max[k] - bounds.min[k]);
    let step = size.iter().copied().fold(0.0, f64::max) / GRID;
    let mut candidates = Vec::new();
    let count = size.map(|size| (size / step).ceil().max(1.0) as usize);
    let grid = (0..count[0] * count[1] * count[2]).map(|i| {
        let cell = [i % count[0], i / count[0] % count[1], i / (count[0] * count[1])];
        [0, 1, 2].map(|k| bounds.min[k] + size[k] * (cell[k] as f64 + 0.5) / count[k] as f64)
    });
    // The middle too, which an even number of points leaves out.
    let middle = [0, 1, 2].map(|k| bounds.min[k] + 0.5 * size[k]);
    for center in std::iter::once(middle).chain(grid) {
        let (distance, _) = hull.distance(center);
        if distance < 0.0 {
            candidates.push((center, overhang - distance));
        }
    }
    let mut bare = samples(hull, overhang);
    let gain = |&(center, radius): &(Vector, f64), bare: &[Vector]| {
        let within = |p: &&Vector| {
            let away = sub(**p, center);
            dot(away, away) <= radius * radius
        };
        bare.iter().filter(within).count()
    };
    let mut queue: BinaryHeap<Candidate> = candidates
        .iter()
        .enumerate()
        .map(|(i, ball)| Candidate { gain: gain(ball, &bare), ball: std::cmp::Reverse(i) })
        .collect();
    let mut balls = Vec::new();
    while let Some(best) = queue.pop() {
        let ball = candidates[best.ball.0];
        let now = gain(&ball, &bare);
        if now == 0 {
            continue;
        }
        // Others cannot have gained since they were counted.
        if queue.peek().is_some_and(|next| next.gain > now) {
            queue.push(Candidate { gain: now, ..best });
            continue;
        }
        let (center, radius) = ball;
        bare.retain(|&p| norm(sub(p, center)) > radius);
        balls.push(ball);
    }
    balls
}

/// Adds balls until the whole surface is proved covered. Of a prism around a cylinder that is what lies
/// between its sides and the same sides nearer to the axis by the factor `inner`.
fn finish(hull: &Hull, overhang: f64, inner: f64, balls: &mut Vec<(Vector, f64)>) {
    for triangle in hull.triangles() {
        while let Some(center) = bare_spot(triangle.corners, balls, overhang, inner) {
            balls.push((center, overhang - hull.distance(center).0.min(0.0)));
        }
    }
}

/// The middle of a part of a triangle that is smaller than a ball there and in no ball; nothing if the
/// triangle is covered.
fn bare_spot(
    triangle: [Vector; 3],
    balls: &[(Vector, f64)],
    overhang: f64,
    inner: f64,
) -> Option<Vector> {
    let mut open = vec![triangle];
    while let Some(corners) = open.pop() {
        let covers = |&(center, radius): &(Vector, f64)| {
            // A hair less, so that rounding proves nothing.
            let square = radius * radius * (1.0 - 1e-9);
            let within = |p: Vector| {
                let away = sub(p, center);
                dot(away, away) <= square
            };
            corners.iter().all(|&[x, y, z]| {
                within([x, y, z]) && (inner == 1.0 || within([inner * x, inner * y, z]))
            })
        };
        if balls.iter().any(covers) {
            continue;
        }
        let side = |i: usize| norm(sub(corners[(i + 1) % 3], corners[i]));
        let longest = (1..3).fold(0, |best, i| if side(i) > side(best) { i } else { best });
        if side(longest) < overhang {
            let [a, b, c] = corners;
            return Some(scale(add(a, add(b, c)), 1.0 / 3.0));
        }
        let [a, b, c] = [0, 1, 2].map(|i| corners[(longest + i) % 3]);
        let middle = scale(add(a, b), 0.5);
        open.extend([[a, middle, c], [middle, b, c]]);
    }
    None
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use proptest::prelude::*;

    fn solids() -> impl Strategy<Value = Shape> {
        let sizes = || prop::array::uniform3(0.02..0.2_f64);
        let points = prop::collection::vec(prop::array::uniform3(-0.2..0.2_f64), 8..30);
        prop_oneof![
            sizes().prop_map(|half| Shape::cuboid(half).unwrap()),
            sizes().prop_map(|[r, l, _]| Shape::cylinder(r, l).unwrap()),
            sizes().prop_map(|[r, l, _]| Shape::capsule(r, l).unwrap()),
            points.prop_map(|p| Shape::Hull(Arc::new(Hull::around(&p).unwrap()))),
        ]
    }

    /// A point on the surface: where a ray from within leaves the solid.
    fn on_surface(shape: &Shape, direction: Vector) -> Vector {
        let inside = match shape {
            Shape::Hull(hull) => {
                let sum = hull.vertices().iter().fold([0.0; 3], |sum, &v| add(sum, v));
                scale(sum, 1.0 / hull.vertices().len() as f64)
            }
            _ => [0.0; 3],
        };
        let (mut near, mut far) = (0.0, 10.0);
        for _ in 0..60 {
            let middle = 0.5 * (near + far);
            let p = add(inside, scale(direction, middle));
            if shape.distance(0, p).0 < 0.0 { near = middle } else { far = middle }
        }
        add(inside, scale(direction, near))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(8))]
        #[test]
        fn no_surface_is_bare_and_nothing_sticks_out(
            shape in solids(),
            overhang in 0.005..0.05_f64,
            rays in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 300),
        ) {
            let cover = Cover::new(&shape, overhang).unwrap();
            prop_assert!(cover.overhang <= overhang + 1e-12);
            for ray in rays {
                let Some(direction) = super::super::vector::unit(ray) else { continue };
                let p = on_surface(&shape, direction);
                let bare = cover.balls.iter().map(|&(c, r)| norm(sub(p, c)) - r);
                prop_assert!(bare.fold(f64::INFINITY, f64::min) <= 1e-9, "{p:?} is bare");
            }
            for &(center, radius) in &cover.balls {
                prop_assert!(shape.distance(0, center).0 + radius <= cover.overhang + 1e-12);
            }
        }
    }

    #[test]
    fn known_covers() {
        let count = |shape: &Shape, overhang| Cover::new(shape, overhang).unwrap().balls.len();
        assert_eq!(count(&Shape::sphere(0.1).unwrap(), 0.01), 1);
        assert_eq!(count(&Shape::capsule(0.1, 0.0).unwrap(), 0.01), 1);
        // Corners of a cube lie √3 from its middle: one ball of overhang √3 - 1 does.
        assert_eq!(count(&Shape::cuboid([1.0; 3]).unwrap(), 0.74), 1);
        let few = count(&Shape::cuboid([0.1, 0.05, 0.05]).unwrap(), 0.02);
        // A ball that reaches into a corner lies at most 0.02 / (√3 - 1) deep and covers 0.027 of each
        // edge from there: 8 corners, some 20 more along the edges, the rest on faces.
        assert!((28..=56).contains(&few), "{few}");
    }

    #[test]
    fn refuses_what_cannot_be_covered() {
        let mesh = super::super::Mesh::new(vec![[0.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
        let cuboid = || Shape::cuboid([1.0; 3]).unwrap();
        for (shape, overhang, field) in [
            (Shape::Mesh(Arc::new(mesh)), 0.1, "shape"),
            (cuboid(), 0.0, "overhang"),
            (cuboid(), f64::NAN, "overhang"),
            (cuboid(), 1e-6, "overhang"),
            (Shape::cylinder(1.0, 0.1).unwrap(), 9e-3, "overhang"),
            (Shape::capsule(1.0, 1.0).unwrap(), 0.0, "overhang"),
            (Shape::capsule(1.0, 1.0).unwrap(), 1e-12, "overhang"),
        ] {
            assert_eq!(Cover::new(&shape, overhang).unwrap_err().field, field);
        }
    }
}
