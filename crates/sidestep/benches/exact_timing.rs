//! Prints what the exact machinery costs on random tasks of the paper's kind.
//!
//! `cargo bench -p sidestep --bench exact_timing`
#![allow(clippy::print_stdout, reason = "an example prints its findings")]

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sidestep::plan::rrt_connect::RrtConnect;
use sidestep::plane::geometry::{Point, Rect};
use sidestep::profile::Profile;
use sidestep::{Certifier, Obstacle, Query, Robot, Route, ShortestPath, Task, World};

/// Random tasks for each measurement.
const TASKS: usize = 5000;
const FIELD: Rect = Rect { min: [0.0, 0.0], max: [64.0, 64.0] };

/// Ten boxes with integer corners, and a start and goal outside them, as in the paper.
fn random_task(rng: &mut ChaCha8Rng) -> (World, Point, Point) {
    let rects: Vec<Rect> = (0..10)
        .map(|_| {
            let min = [0, 1].map(|_| f64::from(rng.random_range(0..64)));
            let size = [0, 1].map(|_| f64::from(rng.random_range(10..20)));
            Rect { min, max: [min[0] + size[0], min[1] + size[1]] }
        })
        .collect();
    loop {
        let [start, goal] = [0, 1].map(|_| [0, 1].map(|_| f64::from(rng.random_range(1..63))));
        if !rects.iter().any(|rect| rect.contains(start) || rect.contains(goal)) {
            let obstacles = rects.into_iter().map(Obstacle::Rect).collect();
            return (World::new(FIELD, obstacles, None), start, goal);
        }
    }
}

fn main() {
    let mut rng = ChaCha8Rng::seed_from_u64(1000);
    for robot in [Robot::Point, Robot::Disc { radius: 1.0 }] {
        time_certifier(&mut rng, robot);
    }
    for robot in [Robot::Point, Robot::Disc { radius: 1.0 }] {
        time_shortest_path(&mut rng, robot);
    }
    for step in [0.1, 0.2, 0.4, 1.0] {
        for shortcut_rounds in [0, 8, 32] {
            let planner = RrtConnect { step, shortcut_rounds, ..RrtConnect::default() };
            time_rrt_connect(&mut ChaCha8Rng::seed_from_u64(1001), &planner);
        }
    }
}

fn time_certifier(rng: &mut ChaCha8Rng, robot: Robot) {
    let certifier = Certifier::new(&random_task(rng).0, robot);
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
            "segment_is_free, 10 boxes, {robot:?}, steps to {reach}: {nanoseconds:.1} ns \
             ({free} of {} free)",
            segments.len()
        );
    }
}

fn time_shortest_path(rng: &mut ChaCha8Rng, robot: Robot) {
    let (mut cold, mut warm) = (Vec::new(), Vec::new());
    let (mut found, mut unsolvable, mut undecided, mut straight) = (0, 0, 0, 0);
    let mut gap: f64 = 0.0;
    for _ in 0..TASKS {
        let (world, start, goal) = random_task(rng);
        let clock = Instant::now();
        let mut query = ShortestPath::new(&world, robot);
        black_box(query.find(start, goal));
        cold.push(clock.elapsed().as_nanos() as f64 * 1e-3);
        let clock = Instant::now();
        let route = query.find(start, goal);
        warm.push(clock.elapsed().as_nanos() as f64 * 1e-3);
        match route {
            Route::Found { trajectory, length, lower_bound } => {
                found += 1;
                straight += usize::from(trajectory.len() == 2);
                gap = gap.max(length / lower_bound.max(1e-12) - 1.0);
            }
            Route::Unsolvable(_) => unsolvable += 1,
            Route::Undecided(_) => undecided += 1,
        }
    }
    println!(
        "shortest path, {robot:?}, {TASKS} tasks: {found} found ({straight} straight), \
         {unsolvable} unsolvable, {undecided} undecided, largest gap of the bounds {:.4} %",
        100.0 * gap
    );
    println!("  with construction: {}", quantiles(&mut cold));
    println!("  warm:              {}", quantiles(&mut warm));
}

fn time_rrt_connect(rng: &mut ChaCha8Rng, planner: &RrtConnect) {
    let (mut times, mut ratios, mut solvable, mut checks) = (Vec::new(), Vec::new(), 0, 0);
    let mut planner_rng = ChaCha8Rng::seed_from_u64(0);
    for _ in 0..TASKS {
        let (world, start, goal) = random_task(rng);
        let best = ShortestPath::new(&world, Robot::Point).find(start, goal).length();
        let Ok(task) = Task::in_plane("", Arc::new(world), Robot::Point, start, goal) else {
            continue;
        };
        let query = Query::of(&task, &Profile::DEFAULT);
        let Some(best) = best else { continue };
        solvable += 1;
        let clock = Instant::now();
        let run = planner.plan(&query, &mut planner_rng);
        times.push(clock.elapsed().as_nanos() as f64 * 1e-3);
        checks += run.checks;
        if let Some(found) = run.trajectory {
            ratios.push(found.length() / best.max(1e-12));
        }
    }
    ratios.sort_by(f64::total_cmp);
    println!(
        "rrt-connect, {planner:?}: {} of {solvable} solved, {:.1} checks, length / shortest: \
         mean {:.3}, 95 % {:.3}; {}",
        ratios.len(),
        checks as f64 / f64::from(solvable),
        ratios.iter().sum::<f64>() / ratios.len() as f64,
        ratios[ratios.len() * 95 / 100],
        quantiles(&mut times)
    );
}

/// Median, 95th percentile and largest of times in microseconds.
fn quantiles(times: &mut [f64]) -> String {
    times.sort_by(f64::total_cmp);
    let at = |part: f64| times[((times.len() - 1) as f64 * part) as usize];
    format!("median {:.1} us, 95 % {:.1} us, most {:.1} us", at(0.5), at(0.95), at(1.0))
}
