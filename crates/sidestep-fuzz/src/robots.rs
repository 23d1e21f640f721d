//! Readers of robots with joints, of worlds in space, and of plans.

use std::collections::HashMap;
use std::io;

use sidestep::arm::Arm;
use sidestep_io::plan_json::read_waypoints;
use sidestep_io::robots::{read_robot, read_srdf, read_urdf};
use sidestep_io::scenes::{SceneOptions, read_problems, read_request, read_scene, write_problems};

use crate::readers::told;

/// No file lies beside what is read.
fn none(_: &str) -> io::Result<Vec<u8>> {
    Err(io::Error::from(io::ErrorKind::NotFound))
}

/// A robot that was read can be made, or it is said why not; and in the middle of its limits its body is
/// somewhere.
pub fn urdf(bytes: &[u8]) {
    let Some(model) = told(read_urdf(&String::from_utf8_lossy(bytes))) else { return };
    let Some(arm) = told(Arm::new(&model, &[], &HashMap::new())) else { return };
    told(arm.with_self_collisions(&[])).inspect(stands_somewhere);
}

fn stands_somewhere(arm: &Arm) {
    let middle: Vec<f64> =
        arm.joints().iter().map(|joint| joint.lower.midpoint(joint.upper)).collect();
    if told(arm.check("configuration", &middle)).is_some() {
        let balls = arm.balls_at(&middle);
        assert!(balls.iter().all(|ball| ball.center.iter().all(|x| x.is_finite())));
    }
}

/// A robot's own file, written and read again, is the same robot.
pub fn robot_file(bytes: &[u8]) {
    let Some(robot) = told(read_robot(&String::from_utf8_lossy(bytes))) else { return };
    let text = robot.to_json();
    assert_eq!(
        read_robot(&text).unwrap_or_else(|error| panic!("{error}\n{text}")),
        robot,
        "{text}"
    );
    told(robot.arm()).inspect(stands_somewhere);
}

pub fn srdf(bytes: &[u8]) {
    told(read_srdf(&String::from_utf8_lossy(bytes)));
}

/// The first byte says what the file is called.
pub fn scene(bytes: &[u8]) {
    const ENDINGS: [&str; 8] = ["json", "yaml", "scene", "pcd", "ply", "xyz", "stl", "obj"];
    let Some((&first, rest)) = bytes.split_first() else { return };
    let name = format!("file.{}", ENDINGS[usize::from(first) % ENDINGS.len()]);
    let options = SceneOptions { hull: first & 8 != 0, ..Default::default() };
    told(read_scene(&name, rest, options, &mut none));
}

/// Problems that were read and written are read the same, but for the last bits of rotations and the order
/// of a hull's corners.
pub fn problems(bytes: &[u8]) {
    told(read_request(bytes));
    let Some(read) = told(read_problems(bytes, &mut none)) else { return };
    let read = &read[..read.len().min(4)];
    let text = write_problems(read);
    let again = read_problems(text.as_bytes(), &mut none).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(again.len(), read.len(), "{text}");
    for (a, b) in read.iter().zip(&again) {
        assert_eq!((&a.name, &a.robot, &a.joints), (&b.name, &b.robot, &b.joints), "{text}");
        assert_eq!((&a.start, &a.goals), (&b.start, &b.goals), "{text}");
        assert_eq!(a.world.objects().len(), b.world.objects().len(), "{text}");
    }
}

pub fn plan_document(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    told(read_waypoints(&text, 2));
    told(read_waypoints(&text, 7));
}
