//! Prints what the exact machinery costs on random tasks of the paper's kind.
//!
//! `cargo run --release -p sidestep --example exact_timing`
#![allow(clippy::print_stdout, reason = "an example prints its findings")]

use std::hint::black_box;
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sidestep::geometry::{Point, Rect};
use sidestep::{Certifier, Obstacle, Robot, World};

const FIELD: Rect = Rect { min: [0.0, 0.0], max: [64.0, 64.0] };

/// Ten boxes with integer corners, as in the paper.
fn random_world(rng: &mut ChaCha8Rng) -> World {
    let obstacles = (0..10)
        .map(|_| {
            let min = [0, 1].map(|_| f64::from(rng.random_range(0..64)));
            let size = [0, 1].map(|_| f64::from(rng.random_range(10..20)));
            Obstacle::Rect(Rect { min, max: [min[0] + size[0], min[1] + size[1]] })
        })
        .collect();
    World::new(FIELD, obstacles, None)
}

fn main() {
    let mut rng = ChaCha8Rng::seed_from_u64(1000);
    for radius in [0.0, 1.0] {
        let certifier = Certifier::new(
            &random_world(&mut rng),
            if radius > 0.0 { Robot::Disc { radius } } else { Robot::Point },
        );
        for reach in [2.0, 10.0, 64.0] {
            let segments: Vec<(Point, Point)> = (0..10_000)
                .map(|_| {
                    let a: Point = [0, 1].map(|_| rng.random_range(1.0..63.0));
                    (a, a.map(|x| (x + rng.random_range(-reach..reach)).clamp(1.0, 63.0)))
                })
                .collect();
            let clock = Instant::now();
            let free = segments
                .iter()
                .filter(|(a, b)| certifier.segment_is_free(black_box(*a), black_box(*b)))
                .count();
            let nanoseconds = clock.elapsed().as_nanos() as f64 / segments.len() as f64;
            println!(
                "segment_is_free, 10 boxes, radius {radius}, steps to {reach}: \
                 {nanoseconds:.1} ns ({free} of {} free)",
                segments.len()
            );
        }
    }
}
