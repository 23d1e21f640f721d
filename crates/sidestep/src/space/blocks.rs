//! Distances of blocks of points to one piece in f32: the formulas of `primitives`, `triangle` and
//! `hull` without branches, a lane per point.
//!
//! **Error.** u = 2^-24, m = |p| + |t| + s with t the shape's origin and s its size. Moving p into
//! the shape's frame costs at most 2 u m for `p - t` (t rounded) and 7 u m for the rotation
//! (rounded entries, three products a row); distances are 1-Lipschitz, so it shifts them by no
//! more. A formula adds at most 5 u m for a primitive (a size rounded, a difference, a norm of
//! three) and 16 u m for a triangle or a plane (corner and unit normals rounded, a product of
//! three, twice; a point put on the wrong side of an edge plane is that near to it, and both
//! answers differ by no more than that). [`ERROR`] is 32 u.

use super::pose::Pose;
use super::shape::Shape;
use super::triangle::{Triangle, Triangle32, narrow};
use crate::kernels::{Isa, LANES, dispatch, madd};

/// Bound on the error of a distance, as a share of the lengths that go into it.
pub(super) const ERROR: f64 = 32.0 / (1 << 24) as f64;

/// A pose in f32.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame32 {
    rotation: [[f32; 3]; 3],
    translation: [f32; 3],
}

impl Frame32 {
    pub(super) fn new(pose: &Pose) -> Self {
        Self { rotation: pose.rotation().map(narrow), translation: narrow(pose.translation()) }
    }
}

/// `LANES` points, one coordinate after the other: `[axis][lane]`, f32.
pub type PointBlock = [[f32; LANES]; 3];

/// Points and the answers for them, equally many.
pub(super) struct Blocks<'a> {
    pub(super) points: &'a [PointBlock],
    pub(super) distances: &'a mut [[f32; LANES]],
    pub(super) normals: &'a mut [PointBlock],
}

/// See [`super::World::block_distances`].
pub(super) fn distances(
    isa: Isa,
    shape: &Shape,
    piece: usize,
    frame: &Frame32,
    blocks: &mut Blocks<'_>,
) {
    if let Some(primitive) = Primitive::of(shape, piece, frame) {
        return primitives(isa, &primitive, blocks);
    }
    match shape {
        Shape::Mesh(mesh) => {
            let triangle = Triangle32::new(&Triangle::new(mesh.corners(piece)));
            triangles(isa, frame, &triangle, blocks);
        }
        Shape::Hull(hull) => hulls(isa, frame, hull.narrow(), hull.radius() as f32, blocks),
        // A cell without a height: there is nothing.
        _ => {
            blocks.distances.fill([f32::INFINITY; LANES]);
            blocks.normals.fill([[0.0; LANES], [0.0; LANES], [1.0; LANES]]);
        }
    }
}

/// A piece that is a ball, box, cylinder or capsule, in f32: what loops over many can keep at hand.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Primitive {
    frame: Frame32,
    kind: Kind,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    Ball { center: [f32; 3], radius: f32 },
    Cuboid { center: [f32; 3], half: [f32; 3] },
    Cylinder { radius: f32, half_length: f32 },
    Capsule { radius: f32, half_length: f32 },
}

/// Runs a formula of the shape's frame on every lane. No closure: one that is not inlined would be compiled without the
/// instruction set's features.
macro_rules! each {
    ($frame:expr, $points:expr, $distances:expr, $normals:expr, |$p:ident| $formula:expr) => {{
        let (frame, points) = ($frame, $points);
        // Local, so that the compiler sees that a lane's answer is no other lane's point.
        let (mut d, mut n): ([f32; LANES], PointBlock) = Default::default();
        for lane in 0..LANES {
            let $p = into_frame::<ISA>(frame, [points[0][lane], points[1][lane], points[2][lane]]);
            let (there, direction) = $formula;
            d[lane] = there;
            n[0][lane] = dot::<ISA>(frame.rotation[0], direction);
            n[1][lane] = dot::<ISA>(frame.rotation[1], direction);
            n[2][lane] = dot::<ISA>(frame.rotation[2], direction);
        }
        (*$distances, *$normals) = (d, n);
    }};
}

impl Primitive {
    /// The primitive that this piece of a shape is, if it is one.
    pub(super) fn of(shape: &Shape, piece: usize, frame: &Frame32) -> Option<Self> {
        let kind = match shape {
            Shape::Sphere { radius } => Kind::Ball { center: [0.0; 3], radius: *radius as f32 },
            Shape::Box { half_extents } => {
                Kind::Cuboid { center: [0.0; 3], half: narrow(*half_extents) }
            }
            Shape::Cylinder { radius, half_length } => {
                Kind::Cylinder { radius: *radius as f32, half_length: *half_length as f32 }
            }
            Shape::Capsule { radius, half_length } => {
                Kind::Capsule { radius: *radius as f32, half_length: *half_length as f32 }
            }
            Shape::Points(cloud) => {
                let center = narrow(cloud.points()[piece]);
                Kind::Ball { center, radius: cloud.radius() as f32 }
            }
            Shape::HeightMap(map) => {
                let cell = map.cell(piece)?;
                let half = narrow([0, 1, 2].map(|k| 0.5 * (cell.max[k] - cell.min[k])));
                Kind::Cuboid { center: narrow(cell.center()), half }
            }
            Shape::Mesh(_) | Shape::Hull(_) => return None,
        };
        Some(Self { frame: *frame, kind })
    }

    /// Distances of sixteen points, and the normals there.
    #[inline(always)]
    pub(crate) fn answer<const ISA: u8>(
        &self,
        points: &PointBlock,
        distances: &mut [f32; LANES],
        normals: &mut PointBlock,
    ) {
        let frame = &self.frame;
        match self.kind {
            Kind::Ball { center, radius } => {
                each!(frame, points, distances, normals, |p| ball::<ISA>(sub(p, center), radius));
            }
            Kind::Cuboid { center, half } => {
                each!(frame, points, distances, normals, |p| cuboid::<ISA>(sub(p, center), half));
            }
            Kind::Cylinder { radius, half_length } => {
                each!(frame, points, distances, normals, |p| {
                    cylinder::<ISA>(p, radius, half_length)
                });
            }
            Kind::Capsule { radius, half_length } => {
                each!(frame, points, distances, normals, |p| capsule::<ISA>(
                    p,
                    radius,
                    half_length
                ));
            }
        }
    }

    /// Distances of sixteen points alone, to the same bits.
    #[inline(always)]
    pub(crate) fn distances<const ISA: u8>(&self, points: &PointBlock) -> [f32; LANES] {
        let (mut distances, mut normals): ([f32; LANES], PointBlock) = Default::default();
        self.answer::<ISA>(points, &mut distances, &mut normals);
        distances
    }
}

dispatch! {
    fn primitives(primitive: &Primitive, blocks: &mut Blocks<'_>) = primitives_body;
}
dispatch! {
    fn triangles(frame: &Frame32, triangle: &Triangle32, blocks: &mut Blocks<'_>) = triangles_body;
}
dispatch! {
    fn hulls(
        frame: &Frame32, faces: &[Triangle32], radius: f32, blocks: &mut Blocks<'_>,
    ) = hulls_body;
}

#[inline(always)]
fn primitives_body<const ISA: u8>(primitive: &Primitive, blocks: &mut Blocks<'_>) {
    let answers = blocks.distances.iter_mut().zip(blocks.normals.iter_mut());
    for (points, (distances, normals)) in blocks.points.iter().zip(answers) {
        primitive.answer::<ISA>(points, distances, normals);
    }
}

#[inline(always)]
fn triangles_body<const ISA: u8>(frame: &Frame32, triangle: &Triangle32, blocks: &mut Blocks<'_>) {
    let answers = blocks.distances.iter_mut().zip(blocks.normals.iter_mut());
    for (points, (distances, normals)) in blocks.points.iter().zip(answers) {
        each!(frame, points, distances, normals, |p| to_triangle::<ISA>(p, triangle));
    }
}

#[inline(always)]
fn hulls_body<const ISA: u8>(
    frame: &Frame32,
    faces: &[Triangle32],
    radius: f32,
    blocks: &mut Blocks<'_>,
) {
    let answers = blocks.distances.iter_mut().zip(blocks.normals.iter_mut());
    for (block, (distance, normal)) in blocks.points.iter().zip(answers) {
        let mut local: PointBlock = [[0.0; LANES]; 3];
        // Of two faces in a plane, rounding may put a point behind the one that it is nearest to.
        let mut behind = [0.0; LANES];
        for lane in 0..LANES {
            let p = into_frame::<ISA>(frame, [block[0][lane], block[1][lane], block[2][lane]]);
            (local[0][lane], local[1][lane], local[2][lane]) = (p[0], p[1], p[2]);
            behind[lane] = -(ERROR as f32) * (p[0].abs() + p[1].abs() + p[2].abs() + radius);
        }
        // The largest plane decides inside, the nearest face that a point is in front of outside.
        let mut plane = ([f32::NEG_INFINITY; LANES], [[0.0; LANES]; 3]);
        let mut face = ([f32::INFINITY; LANES], [[0.0; LANES]; 3]);
        for triangle in faces {
            let mut heights = [0.0; LANES];
            for lane in 0..LANES {
                let p = [local[0][lane], local[1][lane], local[2][lane]];
                let height = dot::<ISA>(triangle.normal, sub(p, triangle.corners[0]));
                heights[lane] = height;
                let higher = height > plane.0[lane];
                plane.0[lane] = if higher { height } else { plane.0[lane] };
                for k in 0..3 {
                    plane.1[k][lane] = if higher { triangle.normal[k] } else { plane.1[k][lane] };
                }
            }
            let candidate = (0..LANES).any(|l| heights[l] > behind[l] && heights[l] < face.0[l]);
            if !candidate {
                continue;
            }
            for lane in 0..LANES {
                let p = [local[0][lane], local[1][lane], local[2][lane]];
                let (d, n) = to_triangle::<ISA>(p, triangle);
                let nearer = heights[lane] > behind[lane] && d < face.0[lane];
                face.0[lane] = if nearer { d } else { face.0[lane] };
                for k in 0..3 {
                    face.1[k][lane] = if nearer { n[k] } else { face.1[k][lane] };
                }
            }
        }
        for lane in 0..LANES {
            let outside = plane.0[lane] > 0.0;
            distance[lane] = if outside { face.0[lane] } else { plane.0[lane] };
            let mut n = [0.0; 3];
            for k in 0..3 {
                n[k] = if outside { face.1[k][lane] } else { plane.1[k][lane] };
            }
            for k in 0..3 {
                normal[k][lane] = dot::<ISA>(frame.rotation[k], n);
            }
        }
    }
}

#[inline(always)]
fn ball<const ISA: u8>(p: [f32; 3], radius: f32) -> (f32, [f32; 3]) {
    let length = dot::<ISA>(p, p).sqrt();
    let inverse = if length > 0.0 { 1.0 / length } else { 0.0 };
    let up = if length > 0.0 { p[2] * inverse } else { 1.0 };
    (length - radius, [p[0] * inverse, p[1] * inverse, up])
}

#[inline(always)]
fn cuboid<const ISA: u8>(p: [f32; 3], half: [f32; 3]) -> (f32, [f32; 3]) {
    let q = [p[0].abs() - half[0], p[1].abs() - half[1], p[2].abs() - half[2]];
    let beyond = [larger(q[0], 0.0), larger(q[1], 0.0), larger(q[2], 0.0)];
    let length = dot::<ISA>(beyond, beyond).sqrt();
    let outside = length > 0.0;
    let inverse = if outside { 1.0 / length } else { 0.0 };
    // Which face is nearest from inside, the lowest axis of equals.
    let x = q[0] >= q[1] && q[0] >= q[2];
    let y = !x && q[1] >= q[2];
    let within = larger(q[0], larger(q[1], q[2]));
    let inner =
        [if x { 1.0 } else { 0.0 }, if y { 1.0 } else { 0.0 }, if x || y { 0.0 } else { 1.0 }];
    let mut n: [f32; 3] = inner;
    for k in 0..3 {
        let size = if outside { beyond[k] * inverse } else { inner[k] };
        n[k] = size.copysign(p[k]);
    }
    (if outside { length } else { within }, n)
}

#[inline(always)]
fn cylinder<const ISA: u8>(p: [f32; 3], radius: f32, half_length: f32) -> (f32, [f32; 3]) {
    let r = madd::<ISA>(p[0], p[0], p[1] * p[1]).sqrt();
    let inverse = if r > 0.0 { 1.0 / r } else { 0.0 };
    let radial = [if r > 0.0 { p[0] * inverse } else { 1.0 }, p[1] * inverse];
    let (side, end) = (r - radius, p[2].abs() - half_length);
    let (a, b) = (larger(side, 0.0), larger(end, 0.0));
    let length = madd::<ISA>(a, a, b * b).sqrt();
    let outside = length > 0.0;
    let inverse = if outside { 1.0 / length } else { 0.0 };
    let by_side = side >= end;
    let a = if outside {
        a * inverse
    } else if by_side {
        1.0
    } else {
        0.0
    };
    let b = if outside {
        b * inverse
    } else if by_side {
        0.0
    } else {
        1.0
    };
    let within = larger(side, end);
    (if outside { length } else { within }, [a * radial[0], a * radial[1], b.copysign(p[2])])
}

#[inline(always)]
fn capsule<const ISA: u8>(p: [f32; 3], radius: f32, half_length: f32) -> (f32, [f32; 3]) {
    let along = larger(-half_length, smaller(p[2], half_length));
    let (distance, n) = ball::<ISA>([p[0], p[1], p[2] - along], radius);
    let on_axis = distance == -radius && half_length > 0.0;
    (distance, [if on_axis { 1.0 } else { n[0] }, n[1], if on_axis { 0.0 } else { n[2] }])
}

#[inline(always)]
fn to_triangle<const ISA: u8>(p: [f32; 3], triangle: &Triangle32) -> (f32, [f32; 3]) {
    let [a, b, c] = triangle.corners;
    let from = [sub(p, a), sub(p, b), sub(p, c)];
    let height = dot::<ISA>(triangle.normal, from[0]);
    // How far beyond the edge planes; a triangle without a plane is never above it.
    let mut beyond = triangle.never_above;
    let (mut square, mut across) = (f32::INFINITY, [0.0; 3]);
    for i in 0..3 {
        beyond = larger(beyond, dot::<ISA>(triangle.outward[i], from[i]));
        let t = dot::<ISA>(triangle.along[i], from[i]) * triangle.inverse_square[i];
        let t = larger(0.0, smaller(t, 1.0));
        let candidate = [
            madd::<ISA>(-t, triangle.along[i][0], from[i][0]),
            madd::<ISA>(-t, triangle.along[i][1], from[i][1]),
            madd::<ISA>(-t, triangle.along[i][2], from[i][2]),
        ];
        let candidate_square = dot::<ISA>(candidate, candidate);
        let nearer = candidate_square < square;
        square = if nearer { candidate_square } else { square };
        across[0] = if nearer { candidate[0] } else { across[0] };
        across[1] = if nearer { candidate[1] } else { across[1] };
        across[2] = if nearer { candidate[2] } else { across[2] };
    }
    let to_edge = square.sqrt();
    let inverse = if to_edge > 0.0 { 1.0 / to_edge } else { 0.0 };
    let above = beyond <= 0.0;
    let sign = 1.0_f32.copysign(height);
    // On the triangle's rim there is no direction but its normal.
    let by_plane = if to_edge > 0.0 { above } else { true };
    let n = [
        if by_plane { sign * triangle.normal[0] } else { across[0] * inverse },
        if by_plane { sign * triangle.normal[1] } else { across[1] * inverse },
        if by_plane { sign * triangle.normal[2] } else { across[2] * inverse },
    ];
    (if above { height.abs() } else { to_edge }, n)
}

#[inline(always)]
fn into_frame<const ISA: u8>(frame: &Frame32, p: [f32; 3]) -> [f32; 3] {
    let q = sub(p, frame.translation);
    let r = &frame.rotation;
    let x = dot::<ISA>([r[0][0], r[1][0], r[2][0]], q);
    let y = dot::<ISA>([r[0][1], r[1][1], r[2][1]], q);
    let z = dot::<ISA>([r[0][2], r[1][2], r[2][2]], q);
    [x, y, z]
}

#[inline(always)]
fn dot<const ISA: u8>(a: [f32; 3], b: [f32; 3]) -> f32 {
    madd::<ISA>(a[2], b[2], madd::<ISA>(a[1], b[1], a[0] * b[0]))
}

#[inline(always)]
fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `max` as one instruction: what it answers for NaN does not matter here.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
