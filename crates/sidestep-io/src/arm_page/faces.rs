//! What is around a robot as flat faces and balls, few enough to draw.

use sidestep::space::{Shape, Vector, World};

/// Sides of what is round.
const ROUND: usize = 16;
/// Faces longer than this are cut, so that they can be sorted by distance; metres.
const LONG: f64 = 0.3;
/// Most parts of a side.
const MOST_PARTS: usize = 6;
/// Most faces and balls; of more, some evenly.
const MOST: usize = 1500;

/// Faces, each a convex polygon in the world's frame, and balls `[x, y, z, radius]`; metres.
pub(super) fn of(world: &World) -> (Vec<Vec<Vector>>, Vec<[f64; 4]>) {
    let (mut faces, mut balls) = (Vec::new(), Vec::new());
    for (pose, shape) in world.objects().iter().flat_map(|object| object.shapes()) {
        let own = local(shape, &mut |center, radius| {
            let [x, y, z] = pose.apply(center);
            balls.push([x, y, z, radius]);
        });
        faces.extend(own.into_iter().map(|face| face.into_iter().map(|p| pose.apply(p)).collect()));
    }
    (some(faces), some(balls))
}

fn some<T>(list: Vec<T>) -> Vec<T> {
    let stride = list.len().div_ceil(MOST).max(1);
    list.into_iter().step_by(stride).collect()
}

/// The faces of a shape in its own frame.
fn local(shape: &Shape, ball: &mut dyn FnMut(Vector, f64)) -> Vec<Vec<Vector>> {
    match shape {
        Shape::Sphere { radius } => {
            ball([0.0; 3], *radius);
            Vec::new()
        }
        Shape::Box { half_extents } => cuboid(half_extents.map(|half| -half), *half_extents),
        Shape::Cylinder { radius, half_length } => round(*radius, *half_length),
        Shape::Capsule { radius, half_length } => {
            let count = (half_length / radius.max(1e-3) * 2.0).ceil().clamp(1.0, 40.0) as usize;
            for i in 0..=count {
                let z = half_length * (2.0 * i as f64 / count as f64 - 1.0);
                ball([0.0, 0.0, z], *radius);
            }
            Vec::new()
        }
        Shape::Hull(hull) => {
            let corner = |&i: &u32| hull.vertices()[i as usize];
            hull.faces().iter().map(|face| face.iter().map(corner).collect()).collect()
        }
        Shape::Mesh(mesh) => (0..mesh.triangles().len()).map(|i| mesh.corners(i).into()).collect(),
        Shape::HeightMap(_) => {
            let bounds = (0..shape.pieces()).filter_map(|i| shape.piece_bounds(i));
            // Of each column its top.
            let top = |min: Vector, max: Vector| {
                let z = max[2];
                vec![
                    [min[0], min[1], z],
                    [max[0], min[1], z],
                    [max[0], max[1], z],
                    [min[0], max[1], z],
                ]
            };
            bounds.map(|bounds| top(bounds.min, bounds.max)).collect()
        }
        Shape::Points(cloud) => {
            cloud.points().iter().for_each(|&point| ball(point, cloud.radius().max(0.003)));
            Vec::new()
        }
    }
}

fn cuboid(min: Vector, max: Vector) -> Vec<Vec<Vector>> {
    let mut faces = Vec::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let parts =
            |k: usize| ((max[k] - min[k]) / LONG).ceil().clamp(1.0, MOST_PARTS as f64) as usize;
        let (across, along) = (parts(u), parts(v));
        for side in [min[axis], max[axis]] {
            for i in 0..across {
                for j in 0..along {
                    let corner = |a: usize, b: usize| {
                        let mut p = [0.0; 3];
                        p[axis] = side;
                        p[u] = min[u] + (max[u] - min[u]) * (i + a) as f64 / across as f64;
                        p[v] = min[v] + (max[v] - min[v]) * (j + b) as f64 / along as f64;
                        p
                    };
                    faces.push(vec![corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
                }
            }
        }
    }
    faces
}

fn round(radius: f64, half_length: f64) -> Vec<Vec<Vector>> {
    let at = |i: usize, z: f64| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / ROUND as f64).sin_cos();
        [radius * cos, radius * sin, z]
    };
    let ends = [-half_length, half_length];
    let caps = ends.map(|z| (0..ROUND).map(|i| at(i, z)).collect());
    let side =
        |i: usize| vec![at(i, ends[0]), at(i + 1, ends[0]), at(i + 1, ends[1]), at(i, ends[1])];
    caps.into_iter().chain((0..ROUND).map(side)).collect()
}
