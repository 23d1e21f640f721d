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
    match shape {
        Shape::Sphere { radius } => balls(isa, frame, [0.0; 3], *radius as f32, blocks),
        Shape::Box { half_extents } => {
            cuboids(isa, frame, [0.0; 3], narrow(*half_extents), blocks);
        }
        Shape::Cylinder { radius, half_length } => {
            cylinders(isa, frame, *radius as f32, *half_length as f32, blocks);
        }
        Shape::Capsule { radius, half_length } => {
            capsules(isa, frame, *radius as f32, *half_length as f32, blocks);
        }
        Shape::Points(cloud) => {
            let center = narrow(cloud.points()[piece]);
            balls(isa, frame, center, cloud.radius() as f32, blocks);
        }
        Shape::Mesh(mesh) => {
            let triangle = Triangle32::new(&Triangle::new(mesh.corners(piece)));
            triangles(isa, frame, &triangle, blocks);
        }
        Shape::Hull(hull) => hulls(isa, frame, hull.narrow(), hull.radius() as f32, blocks),
        Shape::HeightMap(map) => match map.cell(piece) {
            Some(cell) => {
                let half = narrow([0, 1, 2].map(|k| 0.5 * (cell.max[k] - cell.min[k])));
                cuboids(isa, frame, narrow(cell.center()), half, blocks);
            }
            None => {
                blocks.distances.fill([f32::INFINITY; LANES]);
                blocks.normals.fill([[0.0; LANES], [0.0; LANES], [1.0; LANES]]);
            }
        },
    }
}

dispatch! {
    fn balls(frame: &Frame32, center: [f32; 3], radius: f32, blocks: &mut Blocks<'_>) = balls_body;
}
dispatch! {
    fn cuboids(
        frame: &Frame32, center: [f32; 3], half: [f32; 3], blocks: &mut Blocks<'_>,
    ) = cuboids_body;
}
dispatch! {
    fn cylinders(
        frame: &Frame32, radius: f32, half_length: f32, blocks: &mut Blocks<'_>,
    ) = cylinders_body;
}
dispatch! {
    fn capsules(
        frame: &Frame32, radius: f32, half_length: f32, blocks: &mut Blocks<'_>,
    ) = capsules_body;
}
dispatch! {
    fn triangles(frame: &Frame32, triangle: &Triangle32, blocks: &mut Blocks<'_>) = triangles_body;
}
dispatch! {
    fn hulls(
        frame: &Frame32, faces: &[Triangle32], radius: f32, blocks: &mut Blocks<'_>,
    ) = hulls_body;
}

/// Runs a formula of the shape's frame on every lane.
#[inline(always)]
fn each<const ISA: u8>(
    frame: &Frame32,
    blocks: &mut Blocks<'_>,
    formula: impl Fn([f32; 3]) -> (f32, [f32; 3]),
) {
    let answers = blocks.distances.iter_mut().zip(blocks.normals.iter_mut());
    for (block, (distance, normal)) in blocks.points.iter().zip(answers) {
        // Local, so that the compiler sees that a lane's answer is no other lane's point.
        let (mut d, mut n): ([f32; LANES], PointBlock) = Default::default();
        for lane in 0..LANES {
            let p = [block[0][lane], block[1][lane], block[2][lane]];
            let (there, direction) = formula(into_frame::<ISA>(frame, p));
            d[lane] = there;
            for k in 0..3 {
                n[k][lane] = dot::<ISA>(frame.rotation[k], direction);
            }
        }
        (*distance, *normal) = (d, n);
    }
}

#[inline(always)]
fn balls_body<const ISA: u8>(
    frame: &Frame32,
    center: [f32; 3],
    radius: f32,
    blocks: &mut Blocks<'_>,
) {
    each::<ISA>(frame, blocks, |p| ball::<ISA>(sub(p, center), radius));
}

#[inline(always)]
fn cuboids_body<const ISA: u8>(
    frame: &Frame32,
    center: [f32; 3],
    half: [f32; 3],
    blocks: &mut Blocks<'_>,
) {
    each::<ISA>(frame, blocks, |p| cuboid::<ISA>(sub(p, center), half));
}

#[inline(always)]
fn cylinders_body<const ISA: u8>(
    frame: &Frame32,
    radius: f32,
    half_length: f32,
    blocks: &mut Blocks<'_>,
) {
    each::<ISA>(frame, blocks, |p| cylinder::<ISA>(p, radius, half_length));
}

#[inline(always)]
fn capsules_body<const ISA: u8>(
    frame: &Frame32,
    radius: f32,
    half_length: f32,
    blocks: &mut Blocks<'_>,
) {
    each::<ISA>(frame, blocks, |p| {
        let along = larger(-half_length, smaller(p[2], half_length));
        let (distance, n) = ball::<ISA>([p[0], p[1], p[2] - along], radius);
        let on_axis = distance == -radius && half_length > 0.0;
        (distance, [if on_axis { 1.0 } else { n[0] }, n[1], if on_axis { 0.0 } else { n[2] }])
    });
}

#[inline(always)]
fn triangles_body<const ISA: u8>(frame: &Frame32, triangle: &Triangle32, blocks: &mut Blocks<'_>) {
    each::<ISA>(frame, blocks, |p| to_triangle::<ISA>(p, triangle));
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
            let n = [0, 1, 2].map(|k| if outside { face.1[k][lane] } else { plane.1[k][lane] });
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
    let n = p.map(|v| v * inverse);
    (length - radius, [n[0], n[1], if length > 0.0 { n[2] } else { 1.0 }])
}

#[inline(always)]
fn cuboid<const ISA: u8>(p: [f32; 3], half: [f32; 3]) -> (f32, [f32; 3]) {
    let q = [p[0].abs() - half[0], p[1].abs() - half[1], p[2].abs() - half[2]];
    let beyond = q.map(|v| larger(v, 0.0));
    let length = dot::<ISA>(beyond, beyond).sqrt();
    let outside = length > 0.0;
    let inverse = if outside { 1.0 / length } else { 0.0 };
    // Which face is nearest from inside, the lowest axis of equals.
    let x = q[0] >= q[1] && q[0] >= q[2];
    let y = !x && q[1] >= q[2];
    let within = larger(q[0], larger(q[1], q[2]));
    let inner =
        [if x { 1.0 } else { 0.0 }, if y { 1.0 } else { 0.0 }, if x || y { 0.0 } else { 1.0 }];
    let n = [0, 1, 2].map(|k: usize| {
        let size: f32 = if outside { beyond[k] * inverse } else { inner[k] };
        size.copysign(p[k])
    });
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
fn to_triangle<const ISA: u8>(p: [f32; 3], triangle: &Triangle32) -> (f32, [f32; 3]) {
    let from = triangle.corners.map(|corner| sub(p, corner));
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
    [0, 1, 2].map(|k: usize| dot::<ISA>([r[0][k], r[1][k], r[2][k]], q))
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
