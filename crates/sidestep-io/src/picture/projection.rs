//! What a shape in space looks like from far away: outlines in a plane.

use sidestep::space::{Pose, Shape, Vector};

/// A direction to look from: unit vectors to the right and upwards in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// What stands under the picture.
    pub name: &'static str,
    right: Vector,
    up: Vector,
}

/// Corners of a circle.
const ROUND: usize = 28;
/// Most pieces of a mesh, a height map or a cloud that are drawn; of more, some evenly.
const MOST_PIECES: usize = 4000;

impl View {
    /// From above: x to the right, y upwards.
    pub const TOP: Self = Self { name: "from above", right: [1.0, 0.0, 0.0], up: [0.0, 1.0, 0.0] };
    /// From the right side of the robot: x to the right, z upwards.
    pub const SIDE: Self =
        Self { name: "from the side", right: [1.0, 0.0, 0.0], up: [0.0, 0.0, 1.0] };
    /// From the front: y to the right, z upwards.
    pub const FRONT: Self =
        Self { name: "from the front", right: [0.0, 1.0, 0.0], up: [0.0, 0.0, 1.0] };
    /// From the front right and above.
    pub const ASLANT: Self = Self {
        name: "aslant",
        right: [0.573_576_436_351_046, 0.819_152_044_288_991_8, 0.0],
        up: [-0.346_188_613_058_798, 0.242_403_876_506_104, 0.906_307_787_036_65],
    };

    /// A point in the picture, metres.
    pub(super) fn project(&self, p: Vector) -> [f64; 2] {
        [dot(self.right, p), dot(self.up, p)]
    }

    /// How far towards the eye a point lies.
    pub(super) fn depth(&self, p: Vector) -> f64 {
        let ([a, b, c], [d, e, f]) = (self.right, self.up);
        dot([b * f - c * e, c * d - a * f, a * e - b * d], p)
    }
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A drawn part of a shape.
pub(super) enum Outline {
    /// A convex polygon.
    Polygon(Vec<[f64; 2]>),
    /// A disc: centre and radius.
    Disc([f64; 2], f64),
}

/// The outlines of a shape at a pose, in metres.
pub(super) fn outlines(view: &View, pose: &Pose, shape: &Shape) -> Vec<Outline> {
    let place = |p: Vector| view.project(pose.apply(p));
    let hull_of =
        |points: &[Vector]| Outline::Polygon(convex(points.iter().map(|&p| place(p)).collect()));
    let ring = |radius: f64, z: f64| {
        (0..ROUND).map(move |i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / ROUND as f64).sin_cos();
            [radius * cos, radius * sin, z]
        })
    };
    match shape {
        Shape::Sphere { radius } => vec![Outline::Disc(place([0.0; 3]), *radius)],
        Shape::Box { half_extents } => {
            vec![hull_of(&corners(half_extents.map(|half| -half), *half_extents))]
        }
        Shape::Cylinder { radius, half_length } => {
            let ends = ring(*radius, -half_length).chain(ring(*radius, *half_length));
            vec![hull_of(&ends.collect::<Vec<_>>())]
        }
        Shape::Capsule { radius, half_length } => {
            let around = |z: f64| {
                let [x, y] = place([0.0, 0.0, z]);
                ring(*radius, 0.0).map(move |[a, b, _]| [x + a, y + b])
            };
            let points = around(-half_length).chain(around(*half_length)).collect();
            vec![Outline::Polygon(convex(points))]
        }
        Shape::Hull(hull) => vec![hull_of(hull.vertices())],
        Shape::Mesh(mesh) => {
            let count = mesh.triangles().len();
            some(count).map(|i| hull_of(&mesh.corners(i))).collect()
        }
        Shape::HeightMap(_) => some(shape.pieces())
            .filter_map(|i| shape.piece_bounds(i))
            .map(|bounds| hull_of(&corners(bounds.min, bounds.max)))
            .collect(),
        Shape::Points(cloud) => {
            let points = cloud.points();
            let disc = |i: usize| Outline::Disc(place(points[i]), cloud.radius().max(0.002));
            some(points.len()).map(disc).collect()
        }
    }
}

/// Some of `count` pieces, evenly.
fn some(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(MOST_PIECES).max(1))
}

fn corners(min: Vector, max: Vector) -> Vec<Vector> {
    (0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { min[k] } else { max[k] })).collect()
}

/// The convex hull of points in the plane, counterclockwise (A. M. Andrew's chains, 1979).
fn convex(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut hull: Vec<[f64; 2]> = Vec::new();
    for pass in 0..2 {
        let base = hull.len();
        for i in 0..points.len() {
            let p = points[if pass == 0 { i } else { points.len() - 1 - i }];
            while hull.len() >= base + 2
                && turn(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
    }
    hull
}
