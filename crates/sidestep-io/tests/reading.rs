//! Any file to tasks: the kind by name or by content, companions, byte order marks, the question's robot
//! and ends, and errors that name the file's part.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::io;

use proptest::prelude::*;
use sidestep::{Robot, Task};
use sidestep_io::input::{Content, Format, Input, InputError, Question, read};

const TASK: &str = r#"{"format": "sidestep.task/1", "bounds": [[0, 0], [9, 9]],
  "obstacles": [{"circle": {"center": [4, 4], "radius": 1}}], "start": [1, 1], "goal": [8, 8]}"#;
const PROBLEMS: &str = r#"{"format": "sidestep.problems/1", "robot": "r.urdf", "joints": ["a"],
  "problems": [{"name": "reach", "start": [0], "goals": [[1]], "objects": []}]}"#;
const BARN: &str = r#"{"start": [0, 0], "goal": [0, 10], "worlds": {"3": [[0, 5, 1]]}}"#;
const MAP: &str = "type octile\nheight 2\nwidth 3\nmap\n...\n.@.\n";
const SCEN: &str = "version 1\n0\tmaps/a.map\t3\t2\t0\t0\t2\t0\t2\n";
const ROS: &str = "image: a.pgm\nresolution: 1\norigin: [0, 0, 0]\nnegate: 0\n\
    occupied_thresh: 0.65\nfree_thresh: 0.25\n";

/// The folder that the files lie in.
fn load(name: &str) -> io::Result<Vec<u8>> {
    match name {
        "a.map" => Ok(MAP.into()),
        "a.pgm" => Ok(b"P2 2 1 255 254 205".to_vec()),
        "obs.dat" => Ok((0..40).flat_map(|i| f64::to_le_bytes(f64::from(i % 20 - 10))).collect()),
        _ => Err(io::ErrorKind::NotFound.into()),
    }
}

fn input(name: &str, bytes: &[u8], question: &Question) -> Result<Input, InputError> {
    read(name, bytes, question, &mut load)
}

fn tasks(input: Input) -> Vec<Task> {
    match input.content {
        Content::Tasks(tasks) => tasks,
        other => panic!("no tasks: {other:?}"),
    }
}

#[test]
fn every_kind_by_name_by_content_and_with_every_mark() {
    let mpnet: Vec<u8> = (0..7).flat_map(i32::to_le_bytes).collect();
    for (name, bytes, format, count) in [
        ("x.json", TASK.as_bytes(), Format::Json, 1),
        ("x.json", BARN.as_bytes(), Format::Barn, 1),
        ("x.json", PROBLEMS.as_bytes(), Format::Problems, 1),
        ("x.map", MAP.as_bytes(), Format::MovingAiMap, 0),
        ("x.scen", SCEN.as_bytes(), Format::MovingAiScen, 1),
        ("x.yaml", ROS.as_bytes(), Format::RosMap, 0),
        ("x.dat", &mpnet, Format::Mpnet, 1),
    ] {
        let by_name = input(name, bytes, &Question::default()).unwrap();
        match &by_name.content {
            Content::Tasks(tasks) => assert_eq!(tasks.len(), count, "{name}"),
            Content::Map(world) => assert!(count == 0 && world.grid().is_some(), "{name}"),
            Content::Problems(problems) => assert_eq!(problems.len(), count, "{name}"),
        }
        let given = Question { format: Some(format), ..Question::default() };
        assert_eq!(input("-", bytes, &given).unwrap(), by_name, "{name}");
        let Ok(text) = std::str::from_utf8(bytes) else { continue };
        if format == Format::Mpnet {
            continue;
        }
        assert_eq!(input("-", bytes, &Question::default()).unwrap(), by_name, "{name}");
        let marked = format!("\u{feff}{text}");
        let wide: Vec<u8> = marked.encode_utf16().flat_map(u16::to_le_bytes).collect();
        for bytes in [marked.as_bytes(), &wide] {
            for name in [name, "-"] {
                assert_eq!(input(name, bytes, &Question::default()).unwrap(), by_name, "{name}");
            }
        }
    }
}

#[test]
fn the_question_comes_first() {
    let question = Question {
        robot_radius: Some(0.5),
        start: Some([2.0, 1.0]),
        goal: Some([60.0, 1.0]),
        ..Question::default()
    };
    let read = |text: &str, question: &Question| {
        tasks(input("a.json", text.as_bytes(), question).unwrap()).swap_remove(0)
    };
    let task = read(TASK, &question);
    let plane = task.plane().unwrap();
    assert_eq!(plane.robot, Robot::Disc { radius: 0.5 });
    assert_eq!((plane.start, plane.goal), ([2.0, 1.0], [60.0, 1.0]));
    // Worlds without bounds reach as far as the question.
    let task = read(BARN, &question);
    let bounds = task.plane().unwrap().world.bounds();
    assert!(bounds.inflated(-0.5).contains([60.0, 1.0]), "{bounds:?}");
    let wide = read(BARN, &Question { clearance: 7.0, ..question });
    // Round the cylinder with 0.5 + 7 on both sides, and a space of 0.5.
    assert_eq!(wide.plane().unwrap().world.bounds().min[1], 4.0 - 15.0 - 0.5);
    let bad = Question { robot_radius: Some(-1.0), ..Question::default() };
    assert!(matches!(input("a.json", TASK.as_bytes(), &bad), Err(InputError::Question(_))));
}

#[test]
fn what_is_said_of_other_files() {
    let warnings = input("a.yaml", ROS.as_bytes(), &Question::default()).unwrap().warnings;
    assert!(warnings.len() == 1 && warnings[0].contains("free_thresh"), "{warnings:?}");
    for (name, text, message) in [
        ("a.txt", "hello", "input: found an unknown kind of file that begins with \"hello\""),
        ("-", "", "input: found an empty file"),
        (
            "a.scen",
            "0 b.map 3 2 0 0 2 0 2",
            "MovingAI scen, map: found \"b.map\", which cannot be read",
        ),
        ("a.scen", "0 a.map 4 2 0 0 2 0 2", "width x height: found 4 x 2; expected 3 x 2"),
        ("a.scen", "\n", "MovingAI scen: found no task"),
        ("a.yaml", &ROS.replace("a.pgm", "b.pgm"), "image: found \"b.pgm\", which cannot be read"),
        ("some/obs.dat", "", "found MPNet's blocks only; expected the worlds' file"),
        (
            "a.json",
            &TASK.replace("[8, 8]", "\n [8, 2e9]"),
            "line 3, column 6, goal[1]: found 2000000000",
        ),
    ] {
        let error = input(name, text.as_bytes(), &Question::default()).unwrap_err().to_string();
        assert!(error.contains(message), "     got: {error}\nexpected: {message}");
    }
}

proptest! {
    /// Names of megabytes, whatever they hold, make no message of megabytes.
    #[test]
    fn no_message_repeats_what_is_long(
        unit in prop_oneof![Just("a"), Just("\u{1f600}"), Just("\\u0007"), Just("x.y[0]")],
        count in 1usize..20_000,
        template in prop_oneof![
            Just("{\"K\": 1}"), Just("{\"K\": 1, \"K\": 2}"), Just("{\"format\": \"K\"}"), Just("[K"),
            Just("{\"start\": [0, 0], \"goal\": [1, 1], \"worlds\": {\"K\": []}}"),
            Just("type K"), Just("map K"), Just("image: K\nresolution: 1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 1\nfree_thresh: 0"),
            Just("image: a\nresolution: K"), Just("K: ["), Just("0 K 1 1 0 0 0 0 0"), Just("K"),
        ],
        name in prop_oneof![Just("a.json"), Just("a.map"), Just("a.scen"), Just("a.yaml"), Just("-")],
    ) {
        let text = template.replace('K', &unit.repeat(count));
        if let Err(error) = input(name, text.as_bytes(), &Question::default()) {
            let error = error.to_string();
            prop_assert!(error.len() < 2000, "{} bytes: {}", error.len(), &error[..200]);
        }
    }

    #[test]
    fn no_bytes_make_a_reader_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..200),
        name in prop_oneof![Just("a.json"), Just("a.map"), Just("a.scen"), Just("a.yaml"), Just("a.dat"), Just("-")],
    ) {
        let _ = input(name, &bytes, &Question::default());
    }
}
