//! Obstacles move step by step, and each planner plans again: from its last plan, or anew. One thread.
//!
//! `cargo bench -p sidestep-io --bench replanning -- 200 > reports/replanning.json`
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a program that measures")]

use std::sync::Arc;
use std::time::Instant;

use rand::RngExt;
use sidestep::optimizer::Method;
use sidestep::plan::{Auto, Options, Planner, plan};
use sidestep::plane::geometry::Rect;
use sidestep::policy::shipped;
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::scene::{Query, Setting};
use sidestep::suite::Suite;
use sidestep::{Certifier, Obstacle, Route, Task, Trajectory, World};

/// Moves of each task.
const MOVES: usize = 30;
/// Farthest that an obstacle moves along an axis at once, in pixels.
const FAR: f64 = 3.0;

struct Row {
    name: &'static str,
    planner: Planner,
    steps: usize,
    is_warm: bool,
    last: Option<Trajectory>,
    asked: usize,
    solved: usize,
    kept: usize,
    times: Vec<f64>,
}

fn main() {
    let count: usize = std::env::args()
        .skip(1)
        .find(|word| word != "--bench")
        .map_or(200, |text| text.parse().unwrap());
    let learned = || Method::Learned(shipped::sidestep_1());
    let descent = || Method::GradientDescent { step: None };
    let row = |name, planner, steps, is_warm| Row {
        name,
        planner,
        steps,
        is_warm,
        last: None,
        asked: 0,
        solved: 0,
        kept: 0,
        times: Vec::new(),
    };
    let mut rows = [
        row("sidestep-1, from the last plan", Planner::Optimizer(learned()), 40, true),
        row("sidestep-1, anew", Planner::Optimizer(learned()), 40, false),
        row("gradient descent, from the last plan", Planner::Optimizer(descent()), 200, true),
        row("gradient descent, anew", Planner::Optimizer(descent()), 200, false),
        row("auto, from the last plan", Planner::Auto(Auto::default()), 40, true),
        row("auto, anew", Planner::Auto(Auto::default()), 40, false),
        row("shortest path, anew", Planner::ShortestPath, 0, false),
    ];
    let begin = Instant::now();
    let tasks = Suite::Easy.generate(count, 2, &Profile::PAPER);
    for (index, task) in tasks.iter().enumerate() {
        let mut task = task.clone();
        let mut rng = stream(2, Purpose::Query, index as u64, 0);
        rows.iter_mut().for_each(|row| row.last = None);
        for moved in 0..=MOVES {
            if moved > 0 {
                task = after_a_move(&task, &mut rng);
            }
            let query = Query::of(&task, &Profile::DEFAULT);
            let route = query.scene().exact(query.start(), query.goal(), &|| true);
            let is_solvable = matches!(route, Some(Route::Found { .. }));
            for row in &mut rows {
                row.plan(&task, is_solvable && moved > 0);
            }
        }
    }
    let table: Vec<_> = rows.iter_mut().map(Row::json).collect();
    let report = serde_json::json!({
        "what": "replanning after one of ten obstacles moved by up to 3 px along each axis",
        "command": format!("cargo bench -p sidestep-io --bench replanning -- {count}"),
        "tasks": count,
        "moves": MOVES,
        "seed": 2,
        "rows": table,
        "seconds": begin.elapsed().as_secs_f64(),
    });
    println!("{}", serde_json::to_string_pretty(&report).unwrap());
}

impl Row {
    fn plan(&mut self, task: &Task, counts: bool) {
        let warm_start = self.last.clone().filter(|_| self.is_warm);
        let options = Options { steps: self.steps, warm_start, ..Options::default() };
        let begin = Instant::now();
        let plan = plan(task, &self.planner, &options).unwrap();
        let time = begin.elapsed().as_secs_f64();
        let solved = plan.is_solved();
        if counts {
            self.asked += 1;
            self.solved += usize::from(solved);
            self.kept += usize::from(solved && plan.steps == 0);
            self.times.push(1e6 * time);
        }
        // A failed walk is no start worth keeping.
        self.last = plan.certified().cloned();
    }

    fn json(&mut self) -> serde_json::Value {
        self.times.sort_by(f64::total_cmp);
        let at = |share: f64| self.times[((self.times.len() - 1) as f64 * share) as usize];
        serde_json::json!({
            "planner": self.name,
            "solvable_questions": self.asked,
            "success_of_solvable": self.solved as f64 / self.asked as f64,
            "first_trajectory_free": self.kept as f64 / self.asked as f64,
            "us_median": at(0.5),
            "us_mean": self.times.iter().sum::<f64>() / self.times.len() as f64,
            "us_p95": at(0.95),
        })
    }
}

/// The task with one obstacle moved so that start and goal stay free.
fn after_a_move(task: &Task, rng: &mut rand_chacha::ChaCha8Rng) -> Task {
    let plane = task.plane().unwrap();
    loop {
        let mut obstacles = plane.world.obstacles().to_vec();
        let which = rng.random_range(0..obstacles.len());
        let Rect { min, max } = obstacles[which].bounding_box();
        let by = [0, 1].map(|_| rng.random_range(-FAR..FAR));
        let shift = |p: [f64; 2]| [p[0] + by[0], p[1] + by[1]];
        obstacles[which] = Obstacle::Rect(Rect::new(shift(min), shift(max)).unwrap());
        let world = World::new(plane.world.bounds(), obstacles, None);
        let certifier = Certifier::new(&world, plane.robot);
        if certifier.point_is_free(plane.start) && certifier.point_is_free(plane.goal) {
            let setting = Setting::Plane { world: Arc::new(world), robot: plane.robot };
            return Task { setting, ..task.clone() };
        }
    }
}
