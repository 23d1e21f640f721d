//! How time grows with obstacles, waypoints and tasks: a report and a picture.
//!
//! `cargo bench -p sidestep-io --bench growth -- ../../docs/images/growth.png > reports/growth.json`; without a name, no picture.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a program that measures")]

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use rand::RngExt;
use serde_json::{Value, json};
use sidestep::objective::Objective;
use sidestep::optimizer::{Method, Optimizer};
use sidestep::plan::run::{Until, run};
use sidestep::plan::{Auto, Options, Planner, plan, plan_batch};
use sidestep::plane::geometry::Rect;
use sidestep::policy::shipped;
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::scene::Query;
use sidestep::suite::Suite;
use sidestep::{Certifier, Obstacle, Robot, Task, World};
use sidestep_io::picture::{BandPoint, Chart, Picture};

type Curve = (&'static str, Vec<[f64; 2]>);

fn main() {
    let picture = std::env::args().skip(1).find(|word| word != "--bench");
    let parts = [
        ("obstacles", "us per plan (median of 20, scene included)", obstacles()),
        ("waypoints", "us per iteration (median of 200)", waypoints()),
        ("tasks", "plans per second, all cores", tasks()),
    ];
    let mut drawing = Picture::new().columns(3);
    let mut report = serde_json::Map::new();
    for (x, y, curves) in &parts {
        let label = y.split(" (").next().unwrap_or(y);
        let mut chart = Chart::new("", *x, label).log_x().log_y();
        for (name, points) in curves {
            let band = |p: &[f64; 2]| BandPoint { x: p[0], mean: p[1], low: p[1], high: p[1] };
            chart = chart.curve(*name, &points.iter().map(band).collect::<Vec<_>>());
        }
        drawing = drawing.panel(chart);
        let curves: Vec<Value> = curves
            .iter()
            .map(|(name, points)| json!({"planner": name, "points": points}))
            .collect();
        report.insert((*x).to_string(), json!({"measure": y, "curves": curves}));
    }
    if let Some(picture) = picture {
        std::fs::write(picture, drawing.to_png(2.0).unwrap()).unwrap();
    }
    println!("{}", serde_json::to_string_pretty(&report).unwrap());
}

fn learned() -> Method {
    Method::Learned(shipped::sidestep_1())
}

/// A field with `count` squares on about a quarter of it.
fn field(count: usize, index: u64) -> Task {
    let mut rng = stream(2, Purpose::Task, index, count as u64);
    let bounds = Rect::new([0.0; 2], [64.0; 2]).unwrap();
    let side = 64.0 * (0.25 / count as f64).sqrt();
    loop {
        let square = |_| {
            let min = [0, 1].map(|_| rng.random_range(0.0..64.0 - side));
            Obstacle::Rect(Rect::new(min, min.map(|x| x + side)).unwrap())
        };
        let world = World::new(bounds, (0..count).map(square).collect(), None);
        let certifier = Certifier::new(&world, Robot::Point);
        let ends = [[3.0, 3.0], [61.0, 61.0]];
        if ends.iter().all(|&p| certifier.point_is_free(p)) {
            return Task::in_plane("", Arc::new(world), Robot::Point, ends[0], ends[1]).unwrap();
        }
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn obstacles() -> Vec<Curve> {
    let descent = Method::GradientDescent { step: None };
    let planners = [
        ("sidestep-1, 40 steps", Planner::Optimizer(learned()), 40),
        ("gradient descent, 200 steps", Planner::Optimizer(descent), 200),
        ("shortest path", Planner::ShortestPath, 0),
        ("auto", Planner::Auto(Auto::default()), 40),
    ];
    let time = |planner: &Planner, steps: usize, count: usize| {
        let once = |index: u64| {
            let task = field(count, index);
            let options = Options { steps, ..Options::default() };
            let begin = Instant::now();
            plan(&task, planner, &options).unwrap();
            1e6 * begin.elapsed().as_secs_f64()
        };
        median((0..20).map(once).collect())
    };
    let curve = |(name, planner, steps): &(&'static str, Planner, usize)| {
        let counts = [10, 30, 100, 300, 1000, 3000, 10_000];
        (*name, counts.map(|count| [count as f64, time(planner, *steps, count)]).to_vec())
    };
    planners.iter().map(curve).collect()
}

fn waypoints() -> Vec<Curve> {
    let methods = [
        ("sidestep-1", learned()),
        ("sidestep-1-small", Method::Learned(shipped::sidestep_1_small())),
        ("gradient descent", Method::GradientDescent { step: None }),
    ];
    let task = Suite::Easy.generate(1, 2, &Profile::PAPER).remove(0);
    let time = |method: &Method, count: usize| {
        let mut objective = Objective::new(&Query::of(&task, &Profile::DEFAULT), count).unwrap();
        let mut x = vec![0.0; objective.dim()];
        objective.straight_line(&mut x);
        let rng = stream(0, Purpose::Planner, 0, 0);
        let mut optimizer = Optimizer::new(method, &objective, rng).unwrap();
        let mut times = Vec::new();
        let mut last = Instant::now();
        run(&mut objective, &mut optimizer, &mut x, 200, Until::Spent, |_| {
            times.push(1e6 * last.elapsed().as_secs_f64());
            last = Instant::now();
            ControlFlow::Continue(())
        });
        median(times)
    };
    let curve = |(name, method): &(&'static str, Method)| {
        let counts = [10, 30, 100, 300, 1000];
        (*name, counts.map(|count| [count as f64, time(method, count)]).to_vec())
    };
    methods.iter().map(curve).collect()
}

fn tasks() -> Vec<Curve> {
    let planners = [
        ("auto", Planner::Auto(Auto::default())),
        ("sidestep-1", Planner::Optimizer(learned())),
        ("sidestep-1-small", Planner::Optimizer(Method::Learned(shipped::sidestep_1_small()))),
    ];
    let all = Suite::Easy.generate(100_000, 2, &Profile::PAPER);
    let options = Options { steps: 40, ..Options::default() };
    let curve = |(name, planner): &(&'static str, Planner)| {
        let point = |count: usize| {
            let begin = Instant::now();
            plan_batch(&all[..count], planner, &options).unwrap();
            [count as f64, count as f64 / begin.elapsed().as_secs_f64()]
        };
        point(1000);
        (*name, [1, 10, 100, 1000, 10_000, 100_000].map(point).to_vec())
    };
    planners.iter().map(curve).collect()
}
