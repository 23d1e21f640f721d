//! Readers of files: whatever the bytes, an answer; and what was read and written is read the same.

use std::fmt::Display;
use std::io;

use sidestep::{Robot, Task};
use sidestep_io::benchmarks::{barn as barn_file, mpnet::Simple2d};
use sidestep_io::drawing::Drawing;
use sidestep_io::drive::read_csv;
use sidestep_io::input::{Content, Question, read};
use sidestep_io::ros_map::{self, Unknown};
use sidestep_io::{TaskFormat, grid_world, movingai, read_tasks, write_tasks};

/// Tasks that were written are read as they were.
fn same_again(tasks: &[Task]) {
    for format in [TaskFormat::Json, TaskFormat::JsonLines] {
        // Many tasks would only be more of the same.
        let tasks = &tasks[..tasks.len().min(4)];
        let text = write_tasks(tasks, format).unwrap();
        let again = read_tasks(&text, format).unwrap_or_else(|e| panic!("{e}\n{text}"));
        assert_eq!(again.as_slice(), tasks, "{text}");
    }
}

/// What was read, if anything; a refusal says something, and not more than fits a screen.
pub fn told<T>(read: Result<T, impl Display>) -> Option<T> {
    read.inspect_err(|error| {
        let message = error.to_string();
        assert!(!message.is_empty() && message.len() < 4000, "{message}");
    })
    .ok()
}

pub fn task_json(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    told(read_tasks(&text, TaskFormat::Json)).inspect(|tasks| same_again(tasks));
}

pub fn task_lines(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    told(read_tasks(&text, TaskFormat::JsonLines)).inspect(|tasks| same_again(tasks));
}

pub fn barn(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let question = barn_file::Question { robot_radius: 0.333, ..Default::default() };
    told(barn_file::read(&text, &question)).inspect(|tasks| same_again(tasks));
}

/// The first byte says how much of the rest is the blocks' file, in pairs of f64.
pub fn mpnet(bytes: &[u8]) {
    let Some((&first, rest)) = bytes.split_first() else { return };
    let (blocks, worlds) = rest.split_at(rest.len().min(16 * usize::from(first)));
    let Some(worlds) = told(Simple2d::read(blocks, worlds)) else { return };
    for index in 0..worlds.len().min(2) {
        told(worlds.task(index, Robot::Point, 0));
    }
}

pub fn movingai_map(bytes: &[u8]) {
    told(movingai::read_map(bytes));
}

pub fn movingai_scen(bytes: &[u8]) {
    const MAP: &[u8] = b"type octile\nheight 3\nwidth 4\nmap\n....\n.@T.\n....\n";
    let text = String::from_utf8_lossy(bytes);
    let world = grid_world(movingai::read_map(MAP).unwrap());
    for query in told(movingai::read_scen(&text)).unwrap_or_default() {
        assert!(!query.map_file_name().contains(['/', '\\']));
        told(query.task(&world, Robot::Point));
    }
}

pub fn ros_yaml(bytes: &[u8]) {
    let image = b"P5\n3 2\n255\n\x00\x7f\xff\xcd\xfe\x01".to_vec();
    told(ros_map::read(&String::from_utf8_lossy(bytes), Unknown::Free, |_| Ok(image)));
}

const YAML: &str = "image: map\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n\
    free_thresh: 0.196\n";

pub fn pgm(bytes: &[u8]) {
    told(ros_map::read(YAML, Unknown::Occupied, |_| Ok(bytes.to_vec())));
}

pub fn png(bytes: &[u8]) {
    // Begun rightly more often than chance would.
    let begun = match bytes.strip_prefix(b"\x89PNG") {
        Some(_) => bytes.to_vec(),
        None => [b"\x89PNG\r\n\x1a\n", bytes].concat(),
    };
    told(ros_map::read(YAML, Unknown::Occupied, |_| Ok(begun)));
}

/// A picture of any kind; the first byte says how it is read.
pub fn picture(bytes: &[u8]) {
    let Some((&first, rest)) = bytes.split_first() else { return };
    let threshold = 0.2 + 0.6 * f64::from(first % 8) / 7.0;
    let drawing = Drawing { threshold, light: first & 8 != 0, ..Drawing::default() };
    told(drawing.read(rest));
}

/// A file whose kind its bytes must tell; files that it names cannot be read.
pub fn any_file(bytes: &[u8]) {
    let mut load = |_: &str| Err(io::Error::from(io::ErrorKind::NotFound));
    let read = told(read("-", bytes, &Question::default(), &mut load));
    if let Some(Content::Tasks(tasks)) = read.map(|input| input.content) {
        assert!(!tasks.is_empty());
    }
}

/// A path that was read is one: two points at least, all of them places.
pub fn path_csv(bytes: &[u8]) {
    let Some(points) = told(read_csv(&String::from_utf8_lossy(bytes))) else { return };
    assert!(points.len() >= 2 && points.iter().all(|&[x, y]| x.is_finite() && y.is_finite()));
}
