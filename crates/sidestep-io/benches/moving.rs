//! Ten boxes move on a prepared map, and `auto` plans again after each move: from its last plan, and anew. One thread.
//!
//! `cargo bench -p sidestep-io --bench moving -- 1000 RADIUS MARGIN MAP.. > reports/moving.json`
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a program that measures")]

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sidestep::plan::{Options, Origin, Planner, Watch, plan_in};
use sidestep::plane::geometry::Rect;
use sidestep::profile::Profile;
use sidestep::rng::{Purpose, stream};
use sidestep::scene::{Query, Scene, Setting};
use sidestep::suite::queries::random_queries;
use sidestep::{Certifier, Obstacle, Robot, Task, World};
use sidestep_io::input::{Content, Question, read};

/// Boxes on the map.
const BOXES: usize = 10;
/// Side of a box, and its farthest move along an axis, in robot radii with margin.
const SIDE: f64 = 4.0;
const FAR: f64 = 2.0;
/// Moves after which another question is asked.
const MOVES_A_QUERY: usize = 50;
/// Every so many moves the question is also asked without the last plan.
const ANEW: usize = 5;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let [moves, radius, margin] = [0, 1, 2].map(|i| words[i].parse::<f64>().unwrap());
    let maps: Vec<_> =
        words[3..].iter().map(|map| measured(map, moves as usize, radius, margin)).collect();
    let report = serde_json::json!({
        "what": "boxes move one at a time on a prepared map, and auto plans again, from its last plan and anew",
        "command": format!("cargo bench -p sidestep-io --bench moving -- {moves} {radius} {margin} MAP.."),
        "boxes": BOXES,
        "maps": maps,
    });
    println!("{}", serde_json::to_string_pretty(&report).unwrap());
}

fn measured(map: &str, moves: usize, radius: f64, margin: f64) -> serde_json::Value {
    let path = Path::new(map);
    let bytes = std::fs::read(path).unwrap();
    let mut load = |name: &str| std::fs::read(path.parent().unwrap().join(name));
    let world = match read(map, &bytes, &Question::default(), &mut load).unwrap().content {
        Content::Map(world) => world,
        Content::Tasks(tasks) => tasks[0].plane().unwrap().world.clone(),
        Content::Problems(_) => panic!("{map}: no map"),
    };
    let reach = radius + margin;
    let robot = Robot::disc(reach).unwrap();
    let mut rng = stream(3, Purpose::Query, 0, 0);
    let mut queries = random_queries("", &world, robot, moves.div_ceil(MOVES_A_QUERY), 3).unwrap();
    let begin = Instant::now();
    let setting = Setting::Plane { world: world.clone(), robot };
    let map = Arc::new(Scene::new(&setting, &Profile::DEFAULT));
    map.plane().unwrap().shortest_path().prepare_bounds(&|| true);
    let prepared = 1e3 * begin.elapsed().as_secs_f64();
    let (mut anew, mut times) = (Vec::new(), Vec::new());
    let (mut solved, mut unsolvable, mut kept, mut mended, mut turns) =
        (0, 0, 0, 0, Vec::<f64>::new());
    for task in &mut queries {
        let ends = ends_of(task);
        let mut boxes: Vec<Obstacle> = Vec::new();
        while boxes.len() < BOXES {
            boxes.extend(free_box(&world, reach, &ends, None, &mut rng));
        }
        let mut last = None;
        for moved in 0..=MOVES_A_QUERY {
            let which = rng.random_range(0..BOXES);
            let from = boxes[which].bounding_box();
            if moved > 0
                && let Some(box_moved) = free_box(&world, reach, &ends, Some(from), &mut rng)
            {
                boxes[which] = box_moved;
            }
            let begin = Instant::now();
            let scene = Arc::new(map.with_obstacles(&boxes).unwrap());
            let world = scene.plane().unwrap().world().clone();
            let task = Task::in_plane("", world, robot, ends[0], ends[1]).unwrap();
            let query = Query::new(&scene, &task).unwrap();
            let options = Options { warm_start: last.take(), ..Options::default() };
            let plan = plan_in(&query, &Planner::default(), &options, Watch::NONE).unwrap();
            let time = 1e3 * begin.elapsed().as_secs_f64();
            last = plan.certified().cloned();
            // Nothing has moved yet when a question is asked for the first time, and there was no plan.
            if moved == 0 {
                anew.push(time);
                continue;
            }
            times.push(time);
            if moved % ANEW == 0 {
                let begin = Instant::now();
                let scene = Arc::new(map.with_obstacles(&boxes).unwrap());
                let task = Task { setting: setting_of(&scene), ..task };
                let query = Query::new(&scene, &task).unwrap();
                let again =
                    plan_in(&query, &Planner::default(), &Options::default(), Watch::NONE).unwrap();
                anew.push(1e3 * begin.elapsed().as_secs_f64());
                // From the last plan or without it, the same questions have answers.
                assert_eq!(again.is_solved(), plan.is_solved());
            }
            unsolvable += usize::from(plan.status.name() == "unsolvable");
            if let Some(path) = plan.certified() {
                solved += 1;
                kept += usize::from(plan.origin == Origin::WarmStart);
                mended += usize::from(plan.origin == Origin::MendedWarmStart);
                turns.push(path.sharpest_turn().to_degrees());
            }
        }
    }
    times.sort_by(f64::total_cmp);
    anew.sort_by(f64::total_cmp);
    let of = |times: &[f64], share: f64| times[((times.len() - 1) as f64 * share) as usize];
    let at = |share: f64| of(&times, share);
    serde_json::json!({
        "map": path.file_name().unwrap().to_string_lossy(),
        "moves": times.len(),
        "solved": solved,
        "unsolvable": unsolvable,
        "the_last_plan": kept,
        "the_last_plan_mended": mended,
        "turns_above_20_degrees": turns.iter().filter(|turn| **turn > 20.0).count(),
        "map_prepared_ms": prepared,
        "anew": anew.len(),
        "anew_ms_p50": of(&anew, 0.5),
        "anew_ms_p99": of(&anew, 0.99),
        "anew_ms_most": of(&anew, 1.0),
        "ms_p50": at(0.5),
        "ms_p99": at(0.99),
        "ms_most": at(1.0),
        "share_within_20_ms": times.iter().filter(|time| **time <= 20.0).count() as f64 / times.len() as f64,
    })
}

fn ends_of(task: &Task) -> [[f64; 2]; 2] {
    let plane = task.plane().unwrap();
    [plane.start, plane.goal]
}

fn setting_of(scene: &Scene) -> Setting {
    let plane = scene.plane().unwrap();
    Setting::Plane { world: plane.world().clone(), robot: plane.robot() }
}

/// A box somewhere, or one moved a little, that leaves both ends free.
fn free_box(
    world: &World,
    reach: f64,
    ends: &[[f64; 2]; 2],
    from: Option<Rect>,
    rng: &mut ChaCha8Rng,
) -> Option<Obstacle> {
    let bounds = world.bounds();
    let corner = [0, 1].map(|axis| match from {
        Some(rect) => rect.min[axis] + reach * rng.random_range(-FAR..FAR),
        None => rng.random_range(bounds.min[axis]..bounds.max[axis]),
    });
    let rect = Rect::new(corner, corner.map(|x| x + SIDE * reach)).ok()?;
    let alone = World::new(bounds, vec![Obstacle::Rect(rect)], None);
    let certifier = Certifier::new(&alone, Robot::disc(reach).ok()?);
    ends.iter().all(|&end| certifier.point_is_free(end)).then_some(Obstacle::Rect(rect))
}
