//! Every file of the benchmarks that this project did not write, from the folder that the variable
//! SIDESTEP_DATA names; skipped, and said to be skipped, where it is not set.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
#![allow(clippy::print_stdout, reason = "a skipped test says so")]

use std::fs;
use std::path::PathBuf;

use sidestep::Robot;
use sidestep_io::benchmarks::{barn, mpnet::Simple2d};
use sidestep_io::ros_map::Unknown;
use sidestep_io::{TaskFormat, grid_world, movingai, read_tasks, ros_map, write_tasks};

fn folder(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("SIDESTEP_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("{test}: skipped, SIDESTEP_DATA is not set");
    }
    folder
}

#[test]
fn movingai_maps_and_queries() {
    let Some(folder) = folder("movingai_maps_and_queries") else { return };
    let mut maps = 0;
    for entry in fs::read_dir(folder.join("movingai")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "scen") {
            continue;
        }
        maps += 1;
        let queries = movingai::read_scen(&fs::read_to_string(&path).unwrap()).unwrap();
        let map = path.with_file_name(queries[0].map_file_name());
        let world = grid_world(movingai::read_map(&fs::read(map).unwrap()).unwrap());
        for query in &queries {
            let task = query.task(&world, Robot::Point).unwrap();
            let grid = world.grid().unwrap();
            let task = task.plane().unwrap();
            for p in [task.start, task.goal] {
                let (column, row) = grid.cell_of(p);
                assert!(!grid.is_occupied(column, row), "{path:?} {query:?}");
            }
            let straight = sidestep::plane::geometry::distance(task.start, task.goal);
            // Some of the files round their lengths to five decimals.
            assert!(query.octile_length >= straight - 1e-4, "{query:?}");
            assert_eq!(query.bucket, (query.octile_length / 4.0) as u32, "{query:?}");
        }
    }
    assert!(maps >= 3);
}

#[test]
fn ros_warehouse() {
    let Some(folder) = folder("ros_warehouse") else { return };
    let yaml = fs::read_to_string(folder.join("ros/warehouse.yaml")).unwrap();
    let load = |name: &str| fs::read(folder.join("ros").join(name));
    let grid = ros_map::read(&yaml, Unknown::Occupied, load).unwrap().grid;
    assert_eq!((grid.width(), grid.height(), grid.resolution()), (1006, 1674, 0.03));
    assert_eq!(grid.origin(), [-15.1, -25.0]);
    let occupied = grid.cells().iter().filter(|&&cell| cell).count();
    let share = occupied as f64 / grid.cells().len() as f64;
    assert!((0.02..0.9).contains(&share), "{share}");
}

#[test]
fn barn_worlds() {
    let Some(folder) = folder("barn_worlds") else { return };
    let text = fs::read_to_string(folder.join("barn.json")).unwrap();
    let question = barn::Question { robot_radius: 0.25, ..barn::Question::default() };
    let tasks = barn::read(&text, &question).unwrap();
    assert_eq!(tasks.len(), 150);
    for task in &tasks {
        let task = task.plane().unwrap();
        for p in [task.start, task.goal] {
            let nearest = task.world.obstacles().iter().map(|shape| shape.signed_distance(p));
            assert!(nearest.fold(f64::INFINITY, f64::min) > 0.0, "{}", task.name);
            assert!(task.world.bounds().contains(p));
        }
    }
    let written = write_tasks(&tasks, TaskFormat::JsonLines).unwrap();
    assert_eq!(read_tasks(&written, TaskFormat::JsonLines).unwrap(), tasks);
}

#[test]
fn mpnet_worlds() {
    let Some(folder) = folder("mpnet_worlds") else { return };
    let file = |name: &str| fs::read(folder.join("mpnet2d").join(name)).unwrap();
    let worlds = Simple2d::read(&file("obs.dat"), &file("obs_perm2.dat")).unwrap();
    // Every choice of 7 of the 20 blocks.
    assert_eq!(worlds.len(), 77_520);
    for index in (0..worlds.len()).step_by(997) {
        let task = worlds.task(index, Robot::disc(0.5).unwrap(), 7).unwrap();
        let task = task.plane().unwrap();
        for p in [task.start, task.goal] {
            assert!(task.world.obstacles().iter().all(|block| block.signed_distance(p) > 0.5));
        }
    }
}
