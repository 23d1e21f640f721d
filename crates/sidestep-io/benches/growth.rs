//! How time grows with obstacles, sides of maps, waypoints and tasks: a report, a picture and, by `scripts/growth_table`, a table.
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
use sidestep::plan::{Auto, Options, Planner, Watch, plan, plan_batch, plan_in};
use sidestep::plane::geometry::Rect;
use sidestep::policy::shipped;
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::scene::{Query, Scene, Setting};
use sidestep::suite::Suite;
use sidestep::{Certifier, Grid, Obstacle, Robot, Task, Trajectory, World};
use sidestep_io::picture::{BandPoint, Chart, Picture};

type Curve = (&'static str, Vec<[f64; 2]>);

fn main() {
    let picture = std::env::args().skip(1).find(|word| word != "--bench");
    let parts = [
        ("obstacles", "us per plan (median of 20, scene included)", obstacles()),
        ("obstacles, prepared", "us per iteration (median of 200)", iterations()),
        (
            "side of a map, cells",
            "us (median of 20, the map prepared but where it says so)",
            maps(),
        ),
        ("waypoints", "us per iteration (median of 200)", waypoints()),
        ("tasks", "plans per second, all cores", tasks()),
    ];
    let pictured = |x: &str| !x.contains(',');
    let mut drawing = Picture::new().columns(3);
    let mut report = serde_json::Map::new();
    for (x, y, curves) in &parts {
        let label = y.split(" (").next().unwrap_or(y);
        let mut chart = Chart::new("", *x, label).log_x().log_y();
        for (name, points) in curves {
            let band = |p: &[f64; 2]| BandPoint { x: p[0], mean: p[1], low: p[1], high: p[1] };
            chart = chart.curve(*name, &points.iter().map(band).collect::<Vec<_>>());
        }
        if pictured(x) {
            drawing = drawing.panel(chart);
        }
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

/// Iterations of optimizers among many obstacles, of which few are near.
fn iterations() -> Vec<Curve> {
    let methods =
        [("sidestep-1", learned()), ("gradient descent", Method::GradientDescent { step: None })];
    let curve = |(name, method): &(&'static str, Method)| {
        let point = |count: usize| [count as f64, iteration(&field(count, 0), method, 10)];
        (*name, [10, 30, 100, 300, 1000, 3000, 10_000].map(point).to_vec())
    };
    methods.iter().map(curve).collect()
}

/// Rooms of 32 x 32 cells with a door in each wall, `side` cells in all directions.
fn rooms(side: usize) -> Arc<World> {
    let is_wall = |i: usize| {
        let (x, y) = (i % side, i / side);
        let door = |along: usize, room: usize| (along % 32).abs_diff(8 + 7 * (room % 3)) <= 3;
        x % 32 == 0 && !door(y, x / 32 + y / 32) || y % 32 == 0 && !door(x, x / 32 + 2 * (y / 32))
    };
    let grid = Grid::new(side, side, 0.05, [0.0; 2], (0..side * side).map(is_wall).collect());
    let grid = grid.unwrap();
    Arc::new(World::new(grid.rect(), Vec::new(), Some(grid)))
}

/// Maps of growing sides, and a question between neighbouring rooms in their middle: what is far away should cost nothing.
fn maps() -> Vec<Curve> {
    let robot = Robot::disc(0.1).unwrap();
    let names = ["the map prepared", "auto", "auto with a box added", "auto after a box has moved"];
    let mut curves = names.map(|name| (name, Vec::new()));
    for side in [64, 128, 256, 512, 1024, 2048, 4096] {
        let world = rooms(side);
        let setting = Setting::Plane { world, robot };
        let timed = |work: &mut dyn FnMut()| {
            let begin = Instant::now();
            work();
            1e6 * begin.elapsed().as_secs_f64()
        };
        let mut scene = Arc::new(Scene::new(&setting, &Profile::DEFAULT));
        let prepare = || {
            scene = Arc::new(Scene::new(&setting, &Profile::DEFAULT));
            scene.plane().unwrap().shortest_path().prepare_bounds(&|| true);
        };
        let mut prepare = prepare;
        let prepared = median((0..3).map(|_| timed(&mut prepare)).collect());
        // From the middle of one room to the middle of the next but one, or of the next on the smallest.
        let room = 32.0 * 0.05;
        let first = (side / 64).saturating_sub(1) as f64 * room;
        let [start, goal] = [first + 0.4 * room, first + 1.6 * room].map(|at| [at, at + 0.1]);
        let shape = |by: f64| {
            let low = [0, 1].map(|axis| 0.5 * (start[axis] + goal[axis]) - 0.3 + by);
            Obstacle::Rect(Rect::new(low, low.map(|x| x + 0.15)).unwrap())
        };
        let ask = |scene: &Arc<Scene>, warm_start: Option<Trajectory>| {
            let world = scene.plane().unwrap().world().clone();
            let task = Task::in_plane("", world, robot, start, goal).unwrap();
            let query = Query::new(scene, &task).unwrap();
            let options = Options { warm_start, ..Options::default() };
            let plan = plan_in(&query, &Planner::default(), &options, Watch::NONE).unwrap();
            plan.certified().unwrap().clone()
        };
        let first = ask(&scene, None);
        let with_box = |by: f64| Arc::new(scene.with_obstacles(&[shape(by)]).unwrap());
        let many = |work: &mut dyn FnMut(f64)| {
            median((0..20).map(|i| timed(&mut || work(0.005 * f64::from(i)))).collect())
        };
        let times = [
            prepared,
            many(&mut |_| drop(ask(&scene, None))),
            many(&mut |by| drop(ask(&with_box(by), None))),
            many(&mut |by| drop(ask(&with_box(by), Some(first.clone())))),
        ];
        for (curve, time) in curves.iter_mut().zip(times) {
            curve.1.push([side as f64, time]);
        }
    }
    curves.to_vec()
}

/// Microseconds of an iteration with so many waypoints.
fn iteration(task: &Task, method: &Method, count: usize) -> f64 {
    let mut objective = Objective::new(&Query::of(task, &Profile::DEFAULT), count).unwrap();
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
}

fn waypoints() -> Vec<Curve> {
    let methods = [
        ("sidestep-1", learned()),
        ("sidestep-1-small", Method::Learned(shipped::sidestep_1_small())),
        ("gradient descent", Method::GradientDescent { step: None }),
    ];
    let task = Suite::Easy.generate(1, 2, &Profile::PAPER).remove(0);
    let time = |method: &Method, count: usize| iteration(&task, method, count);
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
