//! Plans many tasks with `auto` and checks every answer with arithmetic that shares nothing with the certificate:
//! segments are clipped against rectangles by Liang and Barsky's method, and *unsolvable* is held against a flood fill.
//!
//! `cargo bench -p sidestep-io --bench audit -- 100000 > reports/audit.json`
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a program that measures")]

use std::collections::VecDeque;
use std::time::Instant;

use rayon::prelude::*;
use sidestep::plan::{Auto, Options, Planner, Status, plan};
use sidestep::plane::points;
use sidestep::profile::Profile;
use sidestep::suite::Suite;
use sidestep::{Obstacle, PlaneTask, Task};

/// Test seeds of the suites easy and hard.
const SEEDS: [u64; 5] = [2, 12, 22, 32, 42];
/// Cells of the flood fill per pixel.
const FINE: usize = 8;

fn main() {
    let count: usize = std::env::args()
        .skip(1)
        .find(|word| word != "--bench")
        .map_or(100_000, |text| text.parse().unwrap());
    let begin = Instant::now();
    let planner = Planner::Auto(Auto::default());
    let options = Options::default();
    let share = count / (SEEDS.len() * 10);
    let (mut easy, mut hard) = (Tally::default(), Tally::default());
    for seed in SEEDS {
        easy.add(Suite::Easy.generate(9 * share, seed, &Profile::PAPER), &planner, &options);
        hard.add(Suite::Hard.generate(share, seed, &Profile::PAPER), &planner, &options);
    }
    let report = serde_json::json!({
        "what": "every answer of `auto`, checked by clipping and flood fill",
        "command": format!("cargo bench -p sidestep-io --bench audit -- {count}"),
        "seeds": SEEDS,
        "easy": easy.json(),
        "hard": hard.json(),
        "seconds": begin.elapsed().as_secs_f64(),
    });
    println!("{}", serde_json::to_string_pretty(&report).unwrap());
    assert_eq!(easy.colliding + hard.colliding, 0, "a plan that is called solved collides");
    assert_eq!(easy.falsely_unsolvable + hard.falsely_unsolvable, 0, "there is a way after all");
}

#[derive(Default)]
struct Tally {
    tasks: usize,
    solved: usize,
    unsolvable: usize,
    undecided: usize,
    colliding: usize,
    falsely_unsolvable: usize,
}

impl Tally {
    fn add(&mut self, tasks: Vec<Task>, planner: &Planner, options: &Options) {
        let answers: Vec<(Status, bool)> = tasks
            .par_iter()
            .map(|task| {
                let plan = plan(task, planner, options).unwrap();
                let task = task.plane().unwrap();
                let wrong = match &plan.status {
                    Status::Solved(certified) => {
                        let path = points(certified.trajectory());
                        path[0] != task.start
                            || *path.last().unwrap() != task.goal
                            || path.windows(2).any(|pair| collides(task, pair[0], pair[1]))
                    }
                    Status::Unsolvable(_) => flood_reaches(task),
                    _ => false,
                };
                (plan.status, wrong)
            })
            .collect();
        self.tasks += answers.len();
        for (status, wrong) in answers {
            match status {
                Status::Solved(_) => {
                    self.solved += 1;
                    self.colliding += usize::from(wrong);
                }
                Status::Unsolvable(_) => {
                    self.unsolvable += 1;
                    self.falsely_unsolvable += usize::from(wrong);
                }
                _ => self.undecided += 1,
            }
        }
    }

    fn json(&self) -> serde_json::Value {
        serde_json::json!({
            "tasks": self.tasks,
            "solved": self.solved,
            "unsolvable": self.unsolvable,
            "undecided": self.undecided,
            "colliding": self.colliding,
            "falsely_unsolvable": self.falsely_unsolvable,
        })
    }
}

/// Whether the segment meets the inside of a rectangle or leaves the bounds.
fn collides(task: PlaneTask<'_>, a: [f64; 2], b: [f64; 2]) -> bool {
    let bounds = task.world.bounds();
    let outside = |p: [f64; 2]| (0..2).any(|i| p[i] < bounds.min[i] || p[i] > bounds.max[i]);
    outside(a)
        || outside(b)
        || task.world.obstacles().iter().any(|obstacle| {
            let Obstacle::Rect(rect) = obstacle else { return true };
            let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
            for i in 0..2 {
                let d = b[i] - a[i];
                if d == 0.0 {
                    if a[i] <= rect.min[i] || a[i] >= rect.max[i] {
                        return false;
                    }
                    continue;
                }
                let (s, t) = ((rect.min[i] - a[i]) / d, (rect.max[i] - a[i]) / d);
                enter = enter.max(s.min(t));
                leave = leave.min(s.max(t));
            }
            enter < leave
        })
}

/// Whether the goal's cell is reached from the start's over cells that no rectangle touches: then there is a way.
fn flood_reaches(task: PlaneTask<'_>) -> bool {
    let side = 64 * FINE;
    let mut blocked = vec![false; side * side];
    for obstacle in task.world.obstacles() {
        let rect = obstacle.bounding_box();
        let range = |axis: usize| {
            let low = (rect.min[axis] * FINE as f64).floor().clamp(0.0, side as f64) as usize;
            let high = (rect.max[axis] * FINE as f64).ceil().clamp(0.0, side as f64) as usize;
            low..high
        };
        for row in range(1) {
            blocked[row * side..][range(0)].fill(true);
        }
    }
    let cell = |p: [f64; 2]| {
        let index = p.map(|x| ((x * FINE as f64) as usize).min(side - 1));
        index[1] * side + index[0]
    };
    let (start, goal) = (cell(task.start), cell(task.goal));
    let mut queue = VecDeque::from([start]);
    if blocked[start] {
        return false;
    }
    blocked[start] = true;
    while let Some(at) = queue.pop_front() {
        if at == goal {
            return true;
        }
        let (x, y) = (at % side, at / side);
        let neighbours = [
            (x > 0).then(|| at - 1),
            (x + 1 < side).then(|| at + 1),
            (y > 0).then(|| at - side),
            (y + 1 < side).then(|| at + side),
        ];
        for next in neighbours.into_iter().flatten() {
            if !std::mem::replace(&mut blocked[next], true) {
                queue.push_back(next);
            }
        }
    }
    false
}
