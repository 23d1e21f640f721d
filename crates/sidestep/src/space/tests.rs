//! Distances against their slow twin, support functions; the index against a look at every piece;
//! blocks against both.
//!
//! The signed distance to a convex set is `sup over |u| = 1 of u p - σ(u)` with σ the set's support
//! function (R. Rockafellar, "Convex Analysis", 1970, for points inside as for those outside). So a
//! distance d with normal n is proved right by `d = n p - σ(n)` and `d >= u p - σ(u)` for other u,
//! and the supremum of linear functions is convex and 1-Lipschitz.

use std::sync::Arc;

use proptest::prelude::*;

use super::blocks::{self, Blocks, Frame32};
use super::vector::{add, dot, norm, scale, sub, unit};
use super::*;
use crate::kernels::Isa;

/// `max of u x` over the points x of a piece, in the shape's frame.
fn support(shape: &Shape, piece: usize, u: Vector) -> f64 {
    let across = (u[0] * u[0] + u[1] * u[1]).sqrt();
    let among = |points: &[Vector]| points.iter().map(|&x| dot(u, x)).fold(f64::MIN, f64::max);
    match shape {
        Shape::Sphere { radius } => radius * norm(u),
        Shape::Box { half_extents } => (0..3).map(|k| u[k].abs() * half_extents[k]).sum(),
        Shape::Cylinder { radius, half_length } => radius * across + half_length * u[2].abs(),
        Shape::Capsule { radius, half_length } => radius * norm(u) + half_length * u[2].abs(),
        Shape::Hull(hull) => among(hull.vertices()),
        Shape::Mesh(mesh) => among(&mesh.corners(piece)),
        Shape::Points(cloud) => dot(u, cloud.points()[piece]) + cloud.radius() * norm(u),
        Shape::HeightMap(map) => map.cell(piece).map_or(f64::NEG_INFINITY, |cell| {
            (0..3).map(|k| (u[k] * cell.min[k]).max(u[k] * cell.max[k])).sum()
        }),
    }
}

fn octahedron(size: Vector, shift: Vector) -> Shape {
    let corners = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
    let vertices = corners.map(|c| [0, 1, 2].map(|k| f64::from(c[k]) * size[k] + shift[k]));
    let faces =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    Shape::Hull(Arc::new(Hull::new(vertices.to_vec(), &faces.map(|f| f.to_vec())).unwrap()))
}

fn turned_box(half: Vector, rpy: Vector) -> Shape {
    let turn = Pose::from_rpy(rpy, [0.0; 3]).unwrap();
    let corner = |i: usize| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -half[k] } else { half[k] });
    let corners: Vec<Vector> = (0..8).map(|i| turn.apply(corner(i))).collect();
    Shape::Hull(Arc::new(Hull::around(&corners).unwrap()))
}

fn vectors(range: f64) -> impl Strategy<Value = Vector> {
    prop::array::uniform3(-range..range)
}

fn directions() -> impl Strategy<Value = Vector> {
    vectors(1.0).prop_filter_map("too short", |v| if norm(v) > 0.1 { unit(v) } else { None })
}

fn poses() -> impl Strategy<Value = Pose> {
    (vectors(3.2), vectors(1.0)).prop_map(|(rpy, at)| Pose::from_rpy(rpy, at).unwrap())
}

fn shapes() -> impl Strategy<Value = Shape> {
    let size = || prop::array::uniform3(0.01..0.8_f64);
    let mesh = |corners: Vec<Vector>| {
        let last = corners.len() as u32;
        let triangles = (2..last).map(|c| [c - 2, c - 1, c]).collect();
        Shape::Mesh(Arc::new(Mesh::new(corners, triangles).unwrap()))
    };
    prop_oneof![
        (0.01..0.8_f64).prop_map(|radius| Shape::sphere(radius).unwrap()),
        size().prop_map(|half| Shape::cuboid(half).unwrap()),
        size().prop_map(|[r, l, _]| Shape::cylinder(r, l).unwrap()),
        size().prop_map(|[r, l, _]| Shape::capsule(r, l - 0.01).unwrap()),
        (size(), vectors(0.5)).prop_map(|(size, shift)| octahedron(size, shift)),
        // Two triangles in each face's plane.
        (size(), vectors(3.2)).prop_map(|(half, rpy)| turned_box(half, rpy)),
        prop::collection::vec(vectors(0.8), 3..8).prop_map(mesh),
        // Thin triangles, and such that are points.
        prop::collection::vec((-0.8..0.8_f64, -1e-7..1e-7_f64), 3..8)
            .prop_map(move |c| mesh(c.into_iter().map(|(x, y)| [x, x + y, x - y]).collect())),
        vectors(0.5).prop_map(move |c| mesh(vec![c; 3])),
        prop::collection::vec(vectors(0.8), 1..8)
            .prop_map(|p| Shape::Points(Arc::new(PointCloud::new(p, 0.05).unwrap()))),
        prop::collection::vec(-0.2..0.5_f64, 6)
            .prop_map(|h| Shape::HeightMap(Arc::new(HeightMap::new(3, 0.2, 0.0, h).unwrap()))),
    ]
}

fn world(shapes: Vec<(Pose, Shape)>) -> World {
    let objects = shapes.into_iter().enumerate();
    let objects = objects.map(|(i, shape)| Object::new(format!("object {i}"), vec![shape]));
    World::new(objects.collect()).unwrap()
}

/// A coordinate in which edges, faces and centres are often met.
fn meeting() -> impl Strategy<Value = Vector> {
    let round = vectors(1.0).prop_map(|p| p.map(|v| (v * 5.0).round() / 5.0));
    prop_oneof![vectors(1.5), round]
}

/// Needles of triangles 1e-7 high, seen from afar and from beside a side, where rounding once turned the direction along them.
#[test]
fn needles_are_seen_across() {
    let far = [
        [-0.6040996944448945, -0.6040997555770085, -0.6040996333127806],
        [0.5756461767975939, 0.5756461853954492, 0.5756461681997386],
        [-0.7326515513324658, -0.73265155660144, -0.7326515460634917],
    ];
    let near = [
        [-0.6977301655468492; 3],
        [0.03597250561665183, 0.03597255532697744, 0.035972455906326216],
        [0.0, 9.029640886919596e-8, -9.029640886919596e-8],
    ];
    for (corners, p) in [(far, [0.8, -0.4, -0.4]), (near, [-0.2; 3])] {
        let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        let shape = Shape::Mesh(Arc::new(mesh));
        let (distance, normal) = shape.distance(0, p);
        let attained = dot(normal, p) - support(&shape, 0, normal);
        assert!((attained - distance).abs() < 1e-14, "{distance} attains {attained}");
    }
}

proptest! {
    #[test]
    fn distance_matches_reference(
        shape in shapes(), p in meeting(), others in prop::collection::vec(directions(), 50),
    ) {
        for piece in 0..shape.pieces() {
            let (distance, normal) = shape.distance(piece, p);
            if distance == f64::INFINITY {
                continue;
            }
            prop_assert!((norm(normal) - 1.0).abs() < 1e-9, "{normal:?}");
            let attained = dot(normal, p) - support(&shape, piece, normal);
            prop_assert!((attained - distance).abs() < 1e-9, "{distance} attains {attained}");
            for &u in &others {
                prop_assert!(dot(u, p) - support(&shape, piece, u) <= distance + 1e-9);
            }
        }
    }

    #[test]
    fn normal_is_the_gradient(shape in shapes(), pose in poses(), p in vectors(1.5)) {
        let world = world(vec![(pose, shape)]);
        for piece in 0..world.pieces() as PieceId {
            let (distance, normal) = world.distance(piece, p);
            let step = 1e-6;
            let at = |k: usize, by: f64| {
                let mut q = p;
                q[k] += by;
                world.distance(piece, q).0
            };
            let slopes = [0, 1, 2].map(|k| (at(k, step) - at(k, -step)) / (2.0 * step));
            // Across a kink the slope of the difference is shorter than one and no gradient.
            if distance.is_finite() && (norm(slopes) - 1.0).abs() < 1e-6 {
                prop_assert!(norm(sub(slopes, normal)) < 2e-3, "{slopes:?} {normal:?}");
            }
        }
    }

    #[test]
    fn near_finds_every_piece_within_reach(
        shapes in prop::collection::vec((poses(), shapes()), 0..20),
        center in vectors(2.0),
        reach in 0.0..1.5_f64,
    ) {
        let world = world(shapes);
        let mut found = Vec::new();
        world.near(center, reach, &mut found);
        found.sort_unstable();
        prop_assert!(found.windows(2).all(|pair| pair[0] < pair[1]));
        for piece in 0..world.pieces() as PieceId {
            if world.distance(piece, center).0 <= reach {
                prop_assert!(found.binary_search(&piece).is_ok(), "piece {piece}");
            }
        }
    }

    #[test]
    fn blocks_match_reference(
        shape in shapes(), pose in poses(), points in prop::collection::vec(meeting(), 2 * LANES),
    ) {
        let world = world(vec![(pose, shape.clone())]);
        let mut lanes = vec![[[0.0; LANES]; 3]; 2];
        for (i, p) in points.iter().enumerate() {
            for k in 0..3 {
                lanes[i / LANES][k][i % LANES] = p[k] as f32;
            }
        }
        let frame = Frame32::new(&pose);
        for piece in 0..world.pieces() {
            let answers: Vec<_> = Isa::available()
                .map(|isa| {
                    let mut distances = vec![[0.0; LANES]; 2];
                    let mut normals = vec![[[0.0; LANES]; 3]; 2];
                    let (d, n) = (&mut distances[..], &mut normals[..]);
 let mut blocks = Blocks { points: &lanes, distances: d, normals: n };
 blocks::distances(isa, &shape, piece, &frame, &mut blocks);
                    (distances, normals)
                })
                .collect();
            let bound = world.block_error(piece as PieceId, 3.0_f64.sqrt() * 1.5);
            for (distances, normals) in &answers {
                for i in 0..points.len() {
                    let (block, lane) = (i / LANES, i % LANES);
                    let p = lanes[block].map(|axis| f64::from(axis[lane]));
                    let (exact, _) = world.distance(piece as PieceId, p);
                    let found = f64::from(distances[block][lane]);
                    if exact == f64::INFINITY {
                        prop_assert_eq!(found, exact);
                        continue;
                    }
                    let error = (found - exact).abs();
                    prop_assert!(error <= bound, "{found} for {exact}, bound {bound}");
                    // A normal's error is the distance's over the distance.
                    let n = normals[block].map(|axis| f64::from(axis[lane]));
                    let away = add(p, scale(n, 0.1));
                    let gained = world.distance(piece as PieceId, away).0 - exact;
                    prop_assert!((norm(n) - 1.0).abs() < 1e-4, "{n:?}");
                    if exact.abs() > 0.01 {
                        prop_assert!(gained > 0.0999 || exact < 0.0, "{gained}");
                    }
                }
            }
            prop_assert!(answers.iter().skip(1).all(|a| a == &answers[answers.len() - 1]));
        }
    }
}

#[test]
fn distances_that_one_can_see() {
    let check = |shape: Shape, p: Vector, expected: f64, normal: Vector| {
        let (distance, n) = shape.distance(0, p);
        assert!((distance - expected).abs() < 1e-12, "{shape:?} at {p:?}: {distance}");
        assert!(norm(sub(n, normal)) < 1e-12, "{shape:?} at {p:?}: {n:?}");
    };
    let (x, z) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let cuboid = Shape::cuboid([1.0, 2.0, 3.0]).unwrap();
    check(cuboid.clone(), [4.0, 6.0, 0.0], 5.0, [0.6, 0.8, 0.0]);
    check(cuboid.clone(), [0.5, 0.0, 0.0], -0.5, x);
    check(cuboid, [0.0; 3], -1.0, x);
    let cylinder = Shape::cylinder(1.0, 4.0).unwrap();
    check(cylinder.clone(), [4.0, 0.0, 6.0], 5.0, [0.6, 0.0, 0.8]);
    check(cylinder.clone(), [0.0, 0.0, 1.9], -0.1, z);
    check(cylinder, [0.0; 3], -1.0, x);
    let capsule = Shape::capsule(1.0, 4.0).unwrap();
    check(capsule.clone(), [3.0, 0.0, 6.0], 4.0, [0.6, 0.0, 0.8]);
    check(capsule, [0.0, 0.0, 1.0], -1.0, x);
    check(octahedron([1.0; 3], [0.0; 3]), [0.0, 0.0, 3.0], 2.0, z);
    check(Shape::sphere(1.0).unwrap(), [0.0; 3], -1.0, z);
}

#[test]
fn refuses_what_is_no_world() {
    let at = Pose::IDENTITY;
    let ball = || Shape::sphere(1.0).unwrap();
    let object = |name: &str, shape| Object::new(name, vec![(at, shape)]);
    let flat = Shape::Box { half_extents: [1.0, 0.0, 1.0] };
    for (objects, message) in [
        (vec![object("", ball())], "objects[0].name: \"\" is not allowed"),
        (vec![object("a", ball()), object("a", ball())], "objects[1].name: \"a\""),
        (vec![Object::new("a", vec![])], "objects[0].shapes: none"),
        (vec![object("a", flat)], "objects[0].shapes[0].half_extents[1]: 0"),
        (vec![object("a", Shape::Sphere { radius: f64::NAN })], "objects[0].shapes[0].radius: NaN"),
    ] {
        let error = World::new(objects).unwrap_err().to_string();
        assert!(error.starts_with(message), "{error}");
    }
    assert!(World::new(vec![]).is_ok_and(|world| world.pieces() == 0 && world.bounds().is_none()));
    assert!(Shape::cylinder(0.1, -1.0).is_err() && Shape::capsule(0.1, 0.0).is_ok());
    assert!(HeightMap::new(2, 0.1, 0.0, vec![0.0; 3]).is_err());
    assert!(Mesh::new(vec![[0.0; 3]], vec![[0, 0, 1]]).is_err());
    assert!(PointCloud::new(vec![], 0.1).is_err());
}

#[test]
fn refuses_what_is_no_hull() {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = vec![vec![0, 2, 1], vec![0, 1, 3], vec![1, 2, 3], vec![2, 0, 3]];
    assert!(Hull::new(corners.clone(), &faces).is_ok());
    let mut dent = corners.clone();
    dent.push([0.6; 3]);
    let reversed: Vec<Vec<u32>> =
        faces.iter().map(|face| face.iter().rev().copied().collect()).collect();
    let flat = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    for (vertices, faces, field) in [
        (corners.clone(), faces[..3].to_vec(), "faces"),
        (corners.clone(), vec![vec![0, 1]], "faces[0]"),
        (corners.clone(), vec![vec![0, 1, 9]], "faces[0]"),
        (corners, reversed, "vertices[3]"),
        (dent, faces.clone(), "vertices[4]"),
        (flat, faces, "faces"),
    ] {
        assert_eq!(Hull::new(vertices, &faces).unwrap_err().field, field);
    }
}
