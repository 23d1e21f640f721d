//! Distances in space: 16 points to one piece as a block in f32 and one by one in f64, and what the
//! index costs as the world grows.
//!
//! `cargo bench -p sidestep --bench space`
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark")]

use divan::counter::ItemsCount;
use rand::RngExt;
use sidestep::rng::{Purpose, stream};
use sidestep::space::{Hull, LANES, Mesh, Object, PointBlock, PointCloud, Pose, Shape, World};
use std::sync::Arc;

fn main() {
    divan::main();
}

const KINDS: [&str; 6] = ["sphere", "box", "cylinder", "capsule", "triangle", "hull"];

fn world(kind: &str) -> World {
    let tetrahedron = vec![[0.0; 3], [0.3, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.3]];
    let faces = [vec![0, 2, 1], vec![0, 1, 3], vec![1, 2, 3], vec![2, 0, 3]];
    let shape = match kind {
        "sphere" => Shape::sphere(0.1).unwrap(),
        "box" => Shape::cuboid([0.1, 0.2, 0.3]).unwrap(),
        "cylinder" => Shape::cylinder(0.1, 0.4).unwrap(),
        "capsule" => Shape::capsule(0.1, 0.4).unwrap(),
        "triangle" => Shape::Mesh(Arc::new(Mesh::new(tetrahedron, vec![[1, 2, 3]]).unwrap())),
        _ => Shape::Hull(Arc::new(Hull::new(tetrahedron, &faces).unwrap())),
    };
    let pose = Pose::from_rpy([0.1, 0.2, 0.3], [0.5, 0.0, 0.4]).unwrap();
    World::new(vec![Object::new(kind, vec![(pose, shape)])]).unwrap()
}

fn points() -> PointBlock {
    let mut rng = stream(1, Purpose::Task, 0, 0);
    [(); 3].map(|()| std::array::from_fn(|_| rng.random_range(-1.0_f32..1.0)))
}

#[divan::bench(args = KINDS, counters = [ItemsCount::new(LANES)])]
fn block(bencher: divan::Bencher<'_, '_>, kind: &str) {
    let (world, points) = (world(kind), [points()]);
    let (mut distances, mut normals) = ([[0.0; LANES]], [[[0.0; LANES]; 3]]);
    bencher.bench_local(|| {
        let points = divan::black_box(&points);
        world.block_distances(0, points, &mut distances, &mut normals);
        distances[0][0]
    });
}

#[divan::bench(args = KINDS, counters = [ItemsCount::new(LANES)])]
fn one_by_one(bencher: divan::Bencher<'_, '_>, kind: &str) {
    let (world, points) = (world(kind), points());
    bencher.bench_local(|| {
        let points = divan::black_box(&points);
        let at = |lane: usize| points.map(|axis| f64::from(axis[lane]));
        (0..LANES).map(|lane| world.distance(0, at(lane)).0).sum::<f64>()
    });
}

#[divan::bench(args = [10, 100, 1000, 10_000, 100_000, 1_000_000])]
fn near(bencher: divan::Bencher<'_, '_>, points: usize) {
    let mut rng = stream(2, Purpose::Task, 0, 0);
    // The same number of points a cubic metre, so that about four lie within reach.
    let side = (points as f64 / 1000.0).cbrt();
    let cloud = (0..points).map(|_| [(); 3].map(|()| rng.random_range(0.0..side))).collect();
    let shape = Shape::Points(Arc::new(PointCloud::new(cloud, 0.0).unwrap()));
    let world = World::new(vec![Object::new("cloud", vec![(Pose::IDENTITY, shape)])]).unwrap();
    let mut found = Vec::new();
    bencher.bench_local(|| {
        world.near(divan::black_box([0.5 * side; 3]), 0.1, &mut found);
        found.len()
    });
}
