//! BARN and MPNet worlds: values, bad files.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod refusal;

use proptest::prelude::*;
use refusal::check_refused;
use sidestep::Robot;
use sidestep_io::benchmarks::{barn, mpnet::Simple2d};

fn robot(robot_radius: f64) -> barn::Question {
    barn::Question { robot_radius, ..barn::Question::default() }
}

#[test]
fn barn_and_mpnet_files() {
    let text = r#"{"start": [-2, 3], "goal": [-2, 13],
        "worlds": {"10": [[-1, 5, 0.075]], "2": [[-4, 1, 0.5], [0, 1, 0.5]]}}"#;
    let tasks = barn::read(text, &robot(0.2)).unwrap();
    let names: Vec<&str> = tasks.iter().map(|task| task.name.as_str()).collect();
    assert_eq!(names, ["barn/2", "barn/10"]);
    // Past the cylinders twice the radius and 0.5, past the ends once and 0.5.
    assert_eq!(tasks[0].plane().unwrap().world.bounds().min, [-5.4, -0.4]);
    assert_eq!(tasks[0].plane().unwrap().world.bounds().max, [1.4, 13.7]);
    for (from, to, message) in [
        (
            "0.075",
            "-1",
            "BARN worlds, line 2, column 27, worlds.10[0]: found -1; expected a number above 0",
        ),
        ("0.075", "1, 2", "worlds.10[0]: found an array of 4; expected a cylinder [x, y, radius]"),
        ("\"10\"", "\"ten\"", "worlds.ten: found \"ten\"; expected a world's number"),
        ("start", "begin", "found no field \"start\""),
    ] {
        check_refused(barn::read(&text.replace(from, to), &robot(0.2)), message);
    }
    check_refused(
        barn::read(text, &robot(-1.0)),
        "robot.radius: found -1; expected a number of at least 0",
    );

    let obs: Vec<u8> = (0..40).flat_map(|i| f64::to_le_bytes(f64::from(i % 20 - 10))).collect();
    let row = |last: i32| -> Vec<u8> {
        [0, 1, 2, 3, 4, 5, last].into_iter().flat_map(i32::to_le_bytes).collect()
    };
    let worlds = Simple2d::read(&obs, &row(19)).unwrap();
    assert_eq!((worlds.len(), worlds.world(0).unwrap().obstacles().len()), (1, 7));
    let robot = Robot::disc(0.5).unwrap();
    let task = worlds.task(0, robot, 7).unwrap();
    assert_eq!(task, worlds.task(0, robot, 7).unwrap());
    assert_ne!(task, worlds.task(0, robot, 8).unwrap());
    let task = task.plane().unwrap();
    for p in [task.start, task.goal] {
        assert!(task.world.obstacles().iter().all(|block| block.signed_distance(p) > 0.5));
    }
    check_refused(worlds.world(1), "index: found 1; expected 0 to 0");
    check_refused(worlds.task(0, Robot::disc(19.0).unwrap(), 1), "robot.radius: found 19");
    check_refused(
        Simple2d::read(&obs[..100], &row(1)),
        "obs.dat: found 100 bytes; expected at least 320",
    );
    check_refused(
        Simple2d::read(&obs, &row(20)),
        "obs_perm2.dat[0][6]: found 20; expected a block from 0 to 19",
    );
    check_refused(
        Simple2d::read(&obs, &row(1)[1..]),
        "obs_perm2.dat: found 27 bytes; expected a multiple of 28",
    );
}

proptest! {
    #[test]
    fn no_bytes_make_a_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = barn::read(&String::from_utf8_lossy(&bytes), &robot(0.1));
        let _ = Simple2d::read(&bytes, &bytes);
    }
}
