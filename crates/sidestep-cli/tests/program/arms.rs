//! Robots with joints: plans by files, what controllers get, and every way to get it wrong.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::{check, run};

/// Where the robots' files lie.
const ROBOTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../sidestep-io/tests/robots");

/// A folder with the Panda (`panda_spherized.urdf`, `panda.srdf`), a post that stands in its way (`post.json`) and
/// problems that name the robot (`problems.json`).
fn arms() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in ["panda_spherized.urdf", "panda.srdf"] {
        fs::copy(Path::new(ROBOTS).join(name), folder.path().join(name)).unwrap();
    }
    let objects = r#"[{"name": "post", "shapes": [
        {"cylinder": {"radius": 0.05, "length": 1.5}, "position": [0.45, 0.25, 0.75]}]}]"#;
    let scene = format!(r#"{{"format": "sidestep.scene/1", "objects": {objects}}}"#);
    fs::write(folder.path().join("post.json"), scene).unwrap();
    let joints: Vec<String> = (1..8).map(|i| format!("\"panda_joint{i}\"")).collect();
    let problems = format!(
        r#"{{"format": "sidestep.problems/1", "robot": "panda_spherized.urdf", "joints": [{}],
        "problems": [
            {{"name": "past/0", "start": [{READY}], "goals": [[{BEYOND}]], "objects": {objects}}},
            {{"name": "free/1", "start": [{READY}], "goals": [[{BEYOND}]], "objects": []}}]}}"#,
        joints.join(", ")
    );
    fs::write(folder.path().join("problems.json"), problems).unwrap();
    folder
}

const READY: &str = "0,-0.785,0,-2.356,0,1.571,0.785";
const BEYOND: &str = "1,0.2,0,-1.9,0,2,0.8";

fn line(rest: &str) -> String {
    format!("plan --robot panda_spherized.urdf --start={READY} --goal={BEYOND} {rest}")
}

#[test]
fn a_plan_of_a_robot_a_scene_and_two_configurations() {
    let folder = arms();
    let files = "--out plan.json --png views.png --svg views.svg --trajectory moves.yaml";
    let words = line(&format!("--scene post.json {files} --json"));
    let answer = check(folder.path(), &words, 0, &[]).json();
    assert_eq!(
        (&answer["status"], answer["joints"][0].as_str()),
        (&"solved".into(), Some("panda_joint1"))
    );
    let waypoints = answer["waypoints"].as_array().unwrap();
    assert_eq!(waypoints[0].as_array().unwrap().len(), 7);
    assert!(waypoints.len() > 2, "the straight line is not free");
    assert!(
        answer["length"].as_f64().unwrap() > 1.0 && answer["clearance"].as_f64().unwrap() > 0.0
    );
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let times: Vec<f64> = read("moves.yaml")
        .lines()
        .filter_map(|line| line.split_once("time_from_start: {sec: "))
        .map(|(_, rest)| {
            let (seconds, rest) = rest.split_once(", nanosec: ").unwrap();
            let nanoseconds: f64 = rest.trim_end_matches('}').parse().unwrap();
            seconds.parse::<f64>().unwrap() + 1e-9 * nanoseconds
        })
        .collect();
    assert!(times.len() > 50 && times.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(read("views.svg").contains("from above"));
    assert!(fs::read(folder.path().join("views.png")).unwrap().starts_with(b"\x89PNG"));
    // What was written is a start for the next plan, and a table has the joints' names.
    let again = line("--scene post.json --warm-start plan.json --out path.csv");
    check(folder.path(), &again, 0, &["solved"]);
    assert!(read("path.csv").starts_with("panda_joint1,panda_joint2,"));
    // Without a scene there is nothing in the way.
    check(folder.path(), &line(""), 0, &["solved", "nothing around"]);
    // A margin that the ends cannot keep.
    let words = line("--scene post.json --margin 0.3");
    check(folder.path(), &words, 2, &["in collision", "only ", " mm from the object \"post\""]);
}

#[test]
fn a_page_shows_the_way_and_corners_are_cut() {
    let folder = arms();
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    check(folder.path(), &line("--scene post.json --html way.html --trajectory cut.csv"), 0, &[]);
    check(folder.path(), &line("--scene post.json --blend 0 --trajectory stops.csv"), 0, &[]);
    // Each row is a hundredth of a second.
    let rows = |name: &str| read(name).lines().count();
    assert!(rows("cut.csv") < rows("stops.csv"), "{} {}", rows("cut.csv"), rows("stops.csv"));
    let page = read("way.html");
    assert!(page.len() < 500_000 && page.contains("the plan"), "{} bytes", page.len());
    assert!(!page.contains("http:") && !page.contains("https:") && page.contains("\"timed\":true"));
    // A failure is shown with the link that hits; iterates have a slider.
    let failed = line("--scene post.json --planner gd --steps 0 --html failed.html");
    check(folder.path(), &failed, 1, &["\"post\""]);
    let page = read("failed.html");
    assert!(page.contains("\"hit\":true") && page.contains("the last attempt"));
    let iterates = line("--scene post.json --planner gd:step=1e-6 --steps 60 --html failed.html");
    check(folder.path(), &iterates, 1, &["unsolved"]);
    let page = read("failed.html");
    assert!(page.contains("\"label\":\"0\"") && page.contains("\"label\":\"60\""));
    assert!(page.len() < 500_000, "{} bytes", page.len());
    check(folder.path(), &line("--html way.txt"), 2, &["--html", ".html"]);
    check(folder.path(), &line("--trajectory a.csv --blend -1"), 2, &["--blend: -1"]);
    let compared = line("--scene post.json --compare chomp --html two.html");
    check(folder.path(), &compared, 2, &["--compare", "--html", "joints", "--png"]);
}

#[test]
fn problems_are_planned_and_measured() {
    let folder = arms();
    let words = "plan problems.json --index 1 --trajectory moves.csv --speed 0.5 --acceleration 3";
    check(folder.path(), words, 0, &["solved"]);
    let table = fs::read_to_string(folder.path().join("moves.csv")).unwrap();
    assert!(table.starts_with("time,panda_joint1"), "{}", &table[..40]);
    let words = "plan problems.json --goal 2.5,0.2,0,-1.9,0,2,0.8 --planner rrt-connect";
    check(folder.path(), words, 0, &["solved"]);
    let words =
        "bench --tasks problems.json --planner auto,rrt-connect --timed 1 --out report.json --json";
    let report = check(folder.path(), words, 0, &[]).json();
    for row in report["rows"].as_array().unwrap() {
        assert_eq!((&row["tasks"], &row["certified"]), (&2.into(), &1.0.into()), "{row}");
    }
    check(folder.path(), "table report.json", 0, &["`auto`", "100.0 [", "length"]);
    // A row for each set; failures are named with their reason.
    let sets = "bench --tasks problems.json --by-file --planner gd --steps 0 --timed 0 --json";
    let report = check(folder.path(), sets, 0, &[]).json();
    let rows = report["rows"].as_array().unwrap();
    let names: Vec<&str> = rows.iter().map(|row| row["suite"].as_str().unwrap()).collect();
    assert_eq!(names, ["problems.json: past", "problems.json: free"]);
    assert_eq!(rows[0]["failures"][0]["task"], "past/0");
    assert!(rows[0]["failures"][0]["reason"].as_str().unwrap().contains("collides"), "{}", rows[0]);
    assert_eq!((&rows[1]["certified"], &rows[1]["invalid"]), (&1.0.into(), &0.into()));
    assert!(rows[1]["length_mean"].as_f64().unwrap() > 1.0);
}

#[test]
fn mistakes_are_told() {
    let folder = arms();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("task.json", &crate::task(""));
    write(
        "loop.urdf",
        r#"<robot name="l"><link name="a"/><link name="b"/>
        <joint name="j" type="fixed"><parent link="a"/><child link="b"/></joint>
        <joint name="k" type="fixed"><parent link="b"/><child link="a"/></joint></robot>"#,
    );
    write("bomb.urdf", r#"<!DOCTYPE r [<!ENTITY a "aaaa">]><robot name="l">&a;</robot>"#);
    write(
        "mesh.urdf",
        r#"<robot name="m"><link name="a"><collision><geometry>
        <mesh filename="package://no/such.stl"/></geometry></collision></link></robot>"#,
    );
    write(
        "limitless.urdf",
        r#"<robot name="m"><link name="a"/><link name="b"><collision><geometry>
        <sphere radius="0.1"/></geometry></collision></link><joint name="j" type="prismatic"><parent link="a"/>
        <child link="b"/><axis xyz="1 0 0"/><limit lower="0" upper="1"/></joint></robot>"#,
    );
    write(
        "nan.json",
        r#"{"format": "sidestep.scene/1", "objects": [{"name": "b", "shapes": [
        {"sphere": {"radius": NaN}}]}]}"#,
    );
    for (words, parts) in [
        (
            line("--scene post.json").replace("2,0.8 ", "2 "),
            vec!["--goal: 6 numbers", "--start has 7"],
        ),
        (
            line("").replace(",0.785 ", " ").replace(",0.8 ", " "),
            vec!["--start: 6 numbers", "panda_joint1", "panda_arm (7)"],
        ),
        (
            line("").replace("--goal=1,", "--goal=3,"),
            vec!["the goal has panda_joint1 at 3", "-2.9671 to 2.9671"],
        ),
        (
            line("--scene post.json").replace("--goal=1,", "--goal=0.6,"),
            vec![
                "the goal is in collision: the link ",
                " mm deep in the object \"post\" at [0.6000",
            ],
        ),
        (line("--scene nothing.yaml"), vec!["nothing.yaml: cannot be read"]),
        (line("--scene nan.json"), vec!["nan.json", "line 2"]),
        (line("--epsilon 0.1"), vec!["--epsilon", "--margin"]),
        (
            line("--overhang 0").replace("panda_spherized.urdf", "mesh.urdf"),
            vec!["overhang", "above 0"],
        ),
        (
            line("").replace("panda_spherized.urdf", "mesh.urdf"),
            vec!["mesh.urdf: link a.collision[0].mesh", "such.stl", "--package no=DIR"],
        ),
        (line("").replace("panda_spherized.urdf", "loop.urdf"), vec!["loop.urdf: URDF"]),
        (line("").replace("panda_spherized.urdf", "bomb.urdf"), vec!["bomb.urdf: URDF", "DTD"]),
        (line("--obstacle circle:1,1,1"), vec!["a robot in the plane"]),
        ("plan".into(), vec!["nothing to plan", "--robot URDF"]),
        ("plan --robot panda_spherized.urdf".into(), vec!["nothing to plan", "--start"]),
        (
            "plan task.json --robot panda_spherized.urdf".into(),
            vec!["task.json: --robot", "in the plane"],
        ),
        ("plan task.json --scene post.json".into(), vec!["--scene"]),
        ("plan task.json --start 1,2,3".into(), vec!["--start", "found 3", "heading"]),
        ("plan problems.json --start 1,2".into(), vec!["start: 2 numbers", "7"]),
        ("plan task.json --trajectory moves.yaml".into(), vec!["--trajectory", "joints"]),
        (line("--trajectory moves.txt"), vec!["--trajectory", "yaml"]),
        (line("--trajectory moves.yaml --speed 2"), vec!["--speed: 2"]),
        (
            "plan --robot limitless.urdf --start=0 --goal=1 --trajectory m.yaml".into(),
            vec!["joint j no top speed"],
        ),
        ("shortest problems.json".into(), vec!["a robot in the plane"]),
        ("bench --tasks problems.json --planner sidestep-1".into(), vec!["problems.json", "dof"]),
    ] {
        let parts: Vec<&str> = parts.to_vec();
        check(folder.path(), &words, 2, &parts);
    }
    assert!(!folder.path().join("moves.txt").exists());
    // A failing optimizer names link, object and depth.
    let outcome = run(folder.path(), &line("--scene post.json --planner gd --steps 0"));
    assert_eq!(outcome.code, 1);
    assert!(
        outcome.stdout.contains("the link panda_") && outcome.stdout.contains("\"post\""),
        "{}",
        outcome.stdout
    );
}

#[test]
fn any_of_several_goals_will_do_and_poses_are_reached() {
    let folder = arms();
    let base =
        format!("plan --robot panda_spherized.urdf --start={READY} --scene post.json --json");
    // In the post, and behind it: the second will do.
    let goals = format!("{base} --goal=0.6,0.2,0,-1.9,0,2,0.8 --goal={BEYOND}");
    let answer = check(folder.path(), &goals, 0, &[]).json();
    let last = |answer: &serde_json::Value| -> Vec<f64> {
        let points = answer["waypoints"].as_array().unwrap();
        serde_json::from_value(points.last().unwrap().clone()).unwrap()
    };
    let beyond: Vec<f64> = BEYOND.split(',').map(|number| number.parse().unwrap()).collect();
    assert_eq!(last(&answer), beyond);
    // The nearest is taken first, and the best is no longer than what is first.
    let near = "0.1,-0.785,0,-2.356,0,1.571,0.785";
    let answer = check(folder.path(), &format!("{base} --goal={BEYOND} --goal={near}"), 0, &[]);
    assert_eq!(last(&answer.json())[0], 0.1);
    let pose = "--goal-pose=0.4,-0.3,0.5,1,0,0,0@panda_hand";
    let first = check(folder.path(), &format!("{base} {pose}"), 0, &[]).json();
    let best = check(folder.path(), &format!("{base} {pose} --best"), 0, &[]).json();
    let length = |answer: &serde_json::Value| answer["length"].as_f64().unwrap();
    assert!(length(&best) <= length(&first) + 1e-9, "{} {}", length(&best), length(&first));
    for (words, parts) in [
        ("--goal-pose=9,0,0,1,0,0,0@panda_hand", vec!["--goal-pose", "no configuration", "64"]),
        ("--goal-pose=0.4,0.3,0.5,1,0,0,0@hand", vec!["--goal-pose", "\"hand\"", "a link"]),
        ("--goal-pose=0.4,0.3,0.5,1,0,0@panda_hand", vec!["--goal-pose", "6 numbers"]),
        ("--goal-pose=0.4,0.3,0.5,1,1,0,0@panda_hand", vec!["--goal-pose", "quaternion"]),
        ("--goal-pose=0.4,0.3,0.5,1,0,0,0", vec!["--goal-pose", "@LINK"]),
    ] {
        check(folder.path(), &format!("{base} {words}"), 2, &parts);
    }
    fs::write(folder.path().join("task.json"), crate::task("")).unwrap();
    check(folder.path(), "plan task.json --goal 8,8 --goal 9,9", 2, &["--goal", "joints"]);
}

#[test]
fn what_has_no_way_is_said_and_any_goal_of_a_problem_will_do() {
    let folder = arms();
    let path = |name: &str| folder.path().join(name);
    let draw = "generate --suite planar-arm --dof 2 --count 2 --seed 77 --out p.json";
    check(folder.path(), draw, 0, &[]);
    // Boxes hold the second arm; cells of its configurations prove it.
    let none = check(folder.path(), "plan p.json --index 1 --json", 1, &[]).json();
    assert_eq!(none["status"], "unsolvable", "{none}");
    let few = check(folder.path(), "plan p.json --index 1 --max-samples 7 --json", 1, &[]).json();
    assert_eq!(few["status"], "unsolvable", "{few}");
    let trees = "plan p.json --index 1 --max-samples 7 --planner rrt-connect";
    check(folder.path(), trees, 1, &["separate"]);
    check(folder.path(), "plan p.json --max-samples 0", 2, &["max_samples", "0", "1 to"]);
    // A goal that cannot be, and one that can.
    let text = fs::read_to_string(path("p.json")).unwrap();
    let mut problems: serde_json::Value = serde_json::from_str(&text).unwrap();
    let near = |k: usize| problems["problems"][1]["start"][k].as_f64().unwrap();
    let near = serde_json::json!([near(0) + 1e-4, near(1)]);
    problems["problems"][1]["goals"].as_array_mut().unwrap().push(near.clone());
    fs::write(path("two.json"), problems.to_string()).unwrap();
    let answer = check(folder.path(), "plan two.json --index 1 --json", 0, &[]).json();
    let last = answer["waypoints"].as_array().unwrap().last().unwrap();
    assert_eq!(last, &near);
}
