//! URDF and SRDF: kinematics against golden values of pinocchio, what is read, and what is refused where.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod refusal;

use std::collections::HashMap;

use refusal::check_refused;
use serde_json::Value;
use sidestep::arm::{Arm, BodyShape, JointKind};
use sidestep_io::robots::{read_srdf, read_urdf};

const PANDA: &str = include_str!("robots/panda_spherized.urdf");
const PANDA_SRDF: &str = include_str!("robots/panda.srdf");
const ALL_KINDS: &str = include_str!("robots/all_kinds.urdf");
const GOLDEN: &str = include_str!("../../../oracle/golden/kinematics.json");

#[test]
fn links_stand_where_pinocchio_puts_them() {
    let golden: Value = serde_json::from_str(GOLDEN).unwrap();
    let mut compared = 0;
    for robot in golden["robots"].as_array().unwrap() {
        let text = if robot["file"] == "all_kinds.urdf" { ALL_KINDS } else { PANDA };
        let model = read_urdf(text).unwrap();
        let names: Vec<&str> =
            robot["joints"].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
        let arm = Arm::new(&model, &names, &HashMap::new()).unwrap();
        for sample in robot["samples"].as_array().unwrap() {
            let numbers = |value: &Value| -> Vec<f64> {
                value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
            };
            let configuration = numbers(&sample["configuration"]);
            for (link, pose) in sample["links"].as_object().unwrap() {
                let (expected, found) =
                    (numbers(pose), arm.link_pose(link, &configuration).unwrap());
                let found = [found.rotation().concat(), found.translation().to_vec()].concat();
                for (a, b) in expected.iter().zip(&found) {
                    assert!((a - b).abs() < 1e-12, "{link}: {expected:?} {found:?}");
                }
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 8 * (13 + 8));
}

#[test]
fn a_panda_is_read_whole() {
    let model = read_urdf(PANDA).unwrap();
    let srdf = read_srdf(PANDA_SRDF).unwrap();
    assert_eq!((model.name(), model.links().len(), model.joints().len()), ("panda", 13, 12));
    let arm_joints = srdf.joints_of("panda_arm", &model).unwrap();
    let expected: Vec<String> = (1..8).map(|i| format!("panda_joint{i}")).collect();
    assert_eq!(arm_joints, expected);
    let both = srdf.joints_of("panda_arm_hand", &model).unwrap();
    assert_eq!(both[..7], expected);
    let names: Vec<&str> = arm_joints.iter().map(String::as_str).collect();
    let arm = Arm::new(&model, &names, &HashMap::new()).unwrap();
    let arm = arm.with_self_collisions(&srdf.disabled_pairs).unwrap();
    assert_eq!((arm.dof(), arm.ball_count()), (7, 59));
    assert!(arm.self_collision_pairs().any(|pair| pair == ("panda_link0", "panda_hand")));
    assert!(!arm.self_collision_pairs().any(|pair| pair == ("panda_link0", "panda_link1")));
    assert_eq!(arm.joints()[3].kind, JointKind::Revolute);
    assert!((arm.joints()[3].upper - 0.0873).abs() < 1e-9, "{:?}", arm.joints()[3]);
    let ready = srdf.states.iter().find(|state| state.name == "ready").unwrap();
    assert_eq!((ready.group.as_str(), ready.values.len()), ("panda_arm", 7));
    assert_eq!(srdf.end_effectors[0].parent_link, "panda_link8");
    assert_eq!(srdf.virtual_joints[0].kind, "floating");
    assert_eq!(
        srdf.joints_of("panda_arn", &model).unwrap_err().allowed,
        "the name of a group (like \"panda_arm\")"
    );
}

#[test]
fn shapes_of_all_kinds_are_read() {
    let shape = |geometry: &str| {
        let text = format!(
            "\u{feff}<robot name='r'><link name='a'><collision><geometry>{geometry}</geometry></collision></link></robot>"
        );
        read_urdf(&text).map(|model| model.links()[0].bodies[0].shape.clone())
    };
    for (geometry, expected) in [
        ("<sphere radius='.5'/>", BodyShape::Sphere { radius: 0.5 }),
        ("<box size='1 2 3'/>", BodyShape::Box { half_extents: [0.5, 1.0, 1.5] }),
        ("<cylinder radius='1' length='2.'/>", BodyShape::Cylinder { radius: 1.0, length: 2.0 }),
        ("<capsule radius='1' length='2'/>", BodyShape::Capsule { radius: 1.0, length: 2.0 }),
        (
            "<mesh filename='package://a/b.stl' scale='1 1 -1'/>",
            BodyShape::Mesh { file: "package://a/b.stl".into(), scale: [1.0, 1.0, -1.0] },
        ),
    ] {
        assert_eq!(shape(geometry).unwrap(), expected);
    }
    for (geometry, found) in [
        ("", "line 1, link \"a\" collision geometry: found nothing"),
        ("<cone/>", "line 1, link \"a\" collision geometry cone: found <cone>"),
        ("<sphere/>", "sphere: found no radius"),
        ("<sphere radius='-1'/>", "sphere radius: found -1"),
        ("<sphere radius='nan'/>", "sphere radius: found \"nan\""),
        ("<box size='1 2'/>", "box size: found \"1 2\"; expected 3 finite numbers"),
        ("<box size='1 2 0'/>", "box size: found 0"),
        ("<mesh/>", "mesh: found no filename"),
    ] {
        check_refused(shape(geometry), found);
    }
}

/// Errors say where: `bad` replaces `good` in the robot of all kinds.
#[test]
fn faults_are_found_at_their_line() {
    for (good, bad, expected) in [
        (
            "<parent link=\"base\"/>",
            "<parent link=\"bas\"/>",
            "URDF, line 8, joint \"mast\" parent link: found \"bas\"; expected the name of a link of this robot (like \"base\")",
        ),
        ("<parent link=\"base\"/>", "", "line 7, joint \"mast\": found no <parent>"),
        (
            "type=\"continuous\"",
            "type=\"floating\"",
            "line 12, joint \"turn\" type: found \"floating\"; expected fixed, revolute",
        ),
        ("type=\"continuous\"", "type=\"hinge\"", "found \"hinge\""),
        ("type=\"continuous\"", "", "found no type"),
        (
            "xyz=\"1 2 -2\"",
            "xyz=\"0 0 0\"",
            "line 12, joint turn.axis: found [0.0, 0.0, 0.0]; expected a vector that is not zero",
        ),
        ("xyz=\"1 2 -2\"", "xyz=\"1 2\"", "axis xyz: found \"1 2\"; expected 3 finite numbers"),
        ("xyz=\"1 2 -2\"", "xyz=\"1 2 inf\"", "found \"1 2 inf\""),
        (
            "lower=\"-2\" upper=\"1.5\"",
            "lower=\"2\" upper=\"1.5\"",
            "joint swing.limit.upper: found 1.5; expected at least the lower limit 2",
        ),
        (
            "<limit lower=\"-2\" upper=\"1.5\" velocity=\"1\" effort=\"10\"/>",
            "",
            "line 30, joint swing.limit: found nothing",
        ),
        ("velocity=\"0.2\"", "velocity=\"-0.2\"", "joint lift.limit.velocity: found -0.2"),
        (
            "<mimic joint=\"left\"",
            "<mimic joint=\"lift2\"",
            "mimic joint: found \"lift2\"; expected the name of a joint of this robot (like \"lift\")",
        ),
        ("<mimic joint=\"left\"", "<mimic joint=\"tip\"", "mimic: found a circle"),
        ("<child link=\"turret\"/>", "<child link=\"mast\"/>", "which joint mast carries"),
        (
            "<child link=\"turret\"/>",
            "<child link=\"base\"/>",
            "found a circle through \"base\"; expected a tree",
        ),
        (
            "<link name=\"mast\"/>",
            "<link name=\"mast\"/><link name=\"alone\"/>",
            "2 roots: \"base\", \"alone\"",
        ),
        (
            "<link name=\"mast\"/>",
            "<link name=\"base\"/>",
            "line 11, link \"base\" name: found \"base\" again",
        ),
        ("<link name=\"mast\"/>", "<link/>", "line 11, link: found no name"),
        ("<link name=\"mast\"/>", "<link name=\"mast\">", "found expected 'link' tag, not 'robot'"),
        ("<robot name=\"all_kinds\">", "<robots>", "expected"),
        (
            "<link name=\"mast\"/>",
            "<x:macro xmlns:x=\"http://www.ros.org/wiki/xacro\"/>",
            "found a xacro macro",
        ),
    ] {
        assert!(ALL_KINDS.contains(good), "{good}");
        check_refused(read_urdf(&ALL_KINDS.replacen(good, bad, 1)), expected);
    }
}

#[test]
fn hostile_files_are_refused_at_once() {
    let entities =
        "<!DOCTYPE r [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;'>]><robot>&b;</robot>";
    let deep = format!("<robot>{}", "<a>".repeat(1_000_000));
    let links: String = (0..1_000_000).map(|i| format!("<link name='{i}'/>")).collect();
    let many = format!("<robot>{links}</robot>");
    let chain: String = (0..20_000)
        .map(|i| {
            format!(
                "<joint name='{i}' type='fixed'><parent link='{i}'/><child link='{}'/></joint>",
                i + 1
            )
        })
        .collect();
    let long = format!(
        "<robot>{}{chain}</robot>",
        (0..20_001).map(|i| format!("<link name='{i}'/>")).collect::<String>()
    );
    for (text, expected) in [
        ("", "line 1"),
        ("{}", "line 1"),
        (entities, "XML without a DTD"),
        (deep.as_str(), "more than 64 elements inside each other"),
        (many.as_str(), "at most 10000 links"),
        (long.as_str(), "at most 10000 links"),
        ("<robot></robot>", "no <link>"),
        ("<mujoco></mujoco>", "found <mujoco>; expected <robot>"),
        ("<robot><link name=\"a\u{0}\"/></robot>", "line 1"),
    ] {
        check_refused(read_urdf(text), expected);
    }
}

#[test]
fn groups_that_lead_nowhere_are_refused() {
    let model = read_urdf(ALL_KINDS).unwrap();
    let joints = |group: &str| {
        let text = format!(
            "<robot name='r'><group name='g'>{group}</group><group name='h'><group name='g'/><joint name='turn'/></group><passive_joint name='lift'/></robot>"
        );
        read_srdf(&text).unwrap().joints_of("h", &model).map_err(|error| error.to_string())
    };
    for (group, expected) in [
        ("<chain base_link='base' tip_link='boom'/>", vec!["turn", "swing"]),
        ("<link name='boom'/><joint name='left'/>", vec!["swing", "left", "turn"]),
        ("<group name='h'/><group name='g'/>", vec!["turn"]),
        ("<link name='base'/><link name='right_tip'/>", vec!["turn"]),
    ] {
        assert_eq!(joints(group).unwrap(), expected, "{group}");
    }
    for (group, expected) in [
        (
            "<chain base_link='boom' tip_link='mast'/>",
            "group g.chain.base_link: \"boom\", which does not carry \"mast\"",
        ),
        (
            "<joint name='turm'/>",
            "group g.joint: \"turm\" is not allowed; expected the name of a joint of the robot (like \"turn\")",
        ),
        ("<link name='bom'/>", "(like \"boom\")"),
        ("<group name='i'/>", "group: \"i\""),
    ] {
        let error = joints(group).unwrap_err();
        assert!(error.contains(expected), "{group}: {error}");
    }
    let error =
        read_srdf("<robot>\n<disable_collisions link1='a'/></robot>").unwrap_err().to_string();
    assert_eq!(error, "SRDF, line 2, disable_collisions: found no link2; expected link2=\"...\"");
}
