//! Draws one picture of each kind into a folder: `cargo run -p sidestep-io --example gallery -- FOLDER`.
//!
//! The trajectories and curves are made up; they show what the pictures look like, not what planners do.

use std::error::Error;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;
use std::{env, fs};

use sidestep::plane::geometry::{Circle, ConvexPolygon, Point, Rect};
use sidestep::{Obstacle, Robot, Task, Trajectory, World};
use sidestep_io::picture::{BandPoint, Bar, Chart, Picture, TaskPanel};
use sidestep_io::ros_map::{self, Unknown};
use sidestep_io::{TaskFormat, grid_world, read_tasks};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = env::args().nth(1).ok_or("the folder to draw into is missing")?;
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let pictures = [
        ("comparison", comparison()?),
        ("shapes", shapes()?),
        ("training", training()),
        ("rectangles", rectangles(&fs::read_to_string(examples.join("rectangles.json"))?)?),
        ("office", office(&examples)?),
    ];
    for (name, picture) in pictures {
        let path = Path::new(&folder).join(name);
        fs::write(path.with_extension("svg"), picture.to_svg())?;
        fs::write(path.with_extension("png"), picture.to_png(2.0)?)?;
    }
    Ok(())
}

/// A trajectory from `a` to `b` that swings aside by `swing` of its length.
fn swung(a: Point, b: Point, swing: f64) -> Trajectory {
    let along = [b[0] - a[0], b[1] - a[1]];
    let points: Vec<Point> = (0..=50)
        .map(|i| {
            let t = f64::from(i) / 50.0;
            let aside = swing * (PI * t).sin();
            [a[0] + t * along[0] - aside * along[1], a[1] + t * along[1] + aside * along[0]]
        })
        .collect();
    Trajectory::from_points(&points)
}

/// The distance to the nearest obstacle, negative inside.
fn clearance(world: &World, p: Point) -> f64 {
    world.obstacles().iter().map(|shape| shape.signed_distance(p)).fold(f64::INFINITY, f64::min)
}

fn block_world() -> Result<Task, Box<dyn Error>> {
    let obstacles = vec![
        Obstacle::Rect(Rect::new([24.0, 18.0], [40.0, 46.0])?),
        Obstacle::Rect(Rect::new([6.0, 40.0], [16.0, 50.0])?),
        Obstacle::Rect(Rect::new([48.0, 44.0], [58.0, 60.0])?),
        Obstacle::Rect(Rect::new([44.0, 6.0], [56.0, 14.0])?),
    ];
    let world = World::new(Rect::new([0.0, 0.0], [64.0, 64.0])?, obstacles, None);
    Ok(Task::in_plane("block", Arc::new(world), Robot::disc(1.5)?, [6.0, 34.0], [58.0, 32.0])?)
}

/// Two panels, the optimizers' iterates in each: one stuck, one through.
fn comparison() -> Result<Picture, Box<dyn Error>> {
    let task = block_world()?;
    let task = task.plane()?;
    let iterates = |last: f64| -> Vec<Trajectory> {
        (0..12).map(|i| swung(task.start, task.goal, last * f64::from(i) / 11.0)).collect()
    };
    let panel = |title: &str| {
        let world = Arc::clone(task.world);
        TaskPanel::new(task).title(title).shade(move |p| clearance(&world, p))
    };
    let stuck = panel("gradient descent: stuck").trace("gradient descent", &iterates(0.12));
    let through = panel("learned: through").trace("learned", &iterates(-0.42));
    Ok(Picture::new().title("One task, two optimizers").panel(stuck).panel(through))
}

/// All obstacle shapes, a disc robot's swept area and several paths.
fn shapes() -> Result<Picture, Box<dyn Error>> {
    let obstacles = vec![
        Obstacle::Circle(Circle::new([4.0, 3.0], 1.2)?),
        Obstacle::Circle(Circle::new([4.9, 3.9], 0.8)?),
        Obstacle::Polygon(ConvexPolygon::new(vec![
            [6.5, 0.6],
            [8.6, 1.2],
            [7.8, 2.9],
            [6.4, 2.4],
        ])?),
        Obstacle::Rect(Rect::new([7.0, 4.0], [9.0, 4.8])?),
        Obstacle::Rect(Rect::new([1.0, 4.4], [2.6, 5.4])?),
    ];
    let world = World::new(Rect::new([0.0, 0.0], [10.0, 6.0])?, obstacles, None);
    let task =
        Task::in_plane("shapes", Arc::new(world), Robot::disc(0.25)?, [0.8, 1.2], [9.3, 3.4])?;
    let task = task.plane()?;
    let line = swung(task.start, task.goal, 0.0);
    let panel = TaskPanel::new(task)
        .title("")
        .path("learned", &swung(task.start, task.goal, -0.04))
        .path("CHOMP", &swung(task.start, task.goal, 0.33))
        .dashed_path("straight line", &line);
    Ok(Picture::new().panel(panel))
}

fn training() -> Picture {
    let curve = |rate: f64, top: f64, spread: f64| -> Vec<BandPoint> {
        (0..80)
            .map(|i| {
                let x = f64::from(i) * 25_000.0;
                let mean = top * (1.0 - (-x / rate).exp()) + 0.01 * (f64::from(i) * 0.9).sin();
                let spread = spread * (0.3 + (-x / rate).exp());
                BandPoint { x, mean, low: mean - spread, high: mean + spread }
            })
            .collect()
    };
    let success = Chart::new("Success on held-out tasks", "environment steps", "success rate")
        .y_range(0.0, 1.0)
        .curve("PPO from scratch", &curve(500_000.0, 0.86, 0.09))
        .curve("cloning, then PPO", &curve(150_000.0, 0.95, 0.05))
        .level("the paper", 0.9);
    let times = Chart::new("Time and quality", "time per plan (ms)", "length / optimal length")
        .log_x()
        .points("learned", &[[0.4, 1.04], [0.9, 1.03], [2.1, 1.02]])
        .points("CHOMP", &[[3.0, 1.09], [9.0, 1.06], [31.0, 1.05]])
        .points("RRT-Connect", &[[1.2, 1.32], [4.0, 1.27], [15.0, 1.21]]);
    let bars = |values: &[f64]| -> Vec<Bar> {
        let bar = |&value: &f64| Bar { value, low: value - 0.03, high: (value + 0.02).min(1.0) };
        values.iter().map(bar).collect()
    };
    let suites = Chart::new("Solved tasks by suite", "", "certified")
        .y_range(0.0, 1.0)
        .categories(&["easy", "hard", "mix", "office"])
        .bars("gd", &bars(&[0.61, 0.34, 0.48, 0.22]))
        .bars("CHOMP", &bars(&[0.82, 0.55, 0.67, 0.47]))
        .bars("learned", &bars(&[0.97, 0.83, 0.91, 0.72]));
    let loss: Vec<BandPoint> = (1..60)
        .map(|i| {
            let mean = 2.0 * f64::from(i).powf(-1.4);
            BandPoint { x: f64::from(i), mean, low: 0.7 * mean, high: 1.4 * mean }
        })
        .collect();
    let loss = Chart::new("Cloning loss", "epoch", "loss").log_x().log_y().curve("loss", &loss);
    Picture::new().title("Charts").columns(2).panel(success).panel(times).panel(suites).panel(loss)
}

fn rectangles(text: &str) -> Result<Picture, Box<dyn Error>> {
    let task = read_tasks(text, TaskFormat::Json)?.remove(0);
    let world = Arc::clone(task.plane()?.world);
    Ok(Picture::new().panel(TaskPanel::new(task.plane()?).shade(move |p| clearance(&world, p))))
}

fn office(examples: &Path) -> Result<Picture, Box<dyn Error>> {
    let yaml = fs::read_to_string(examples.join("office.yaml"))?;
    let map = ros_map::read(&yaml, Unknown::Occupied, |name| fs::read(examples.join(name)))?;
    let world = grid_world(map.grid);
    let task = Task::in_plane("office", world, Robot::disc(0.25)?, [2.0, 3.8], [18.3, 8.4])?;
    Ok(Picture::new().panel(TaskPanel::new(task.plane()?)))
}
