//! Plans as robots read them: every format, and paths of others made smooth.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::{check, folder};

#[test]
fn the_suffix_decides_the_format_and_limits_hold() {
    let folder = folder();
    let text = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let plan = |flags: &str, code: i32, parts: &[&str]| {
        check(folder.path(), &format!("plan block.json {flags}"), code, parts)
    };
    plan("--out p.csv --spacing 0.1 --max-speed 0.8 --max-accel 0.4", 0, &["sharpest corner"]);
    let table = text("p.csv");
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|word| word.parse().unwrap()).collect())
        .collect();
    assert!(table.starts_with("x,y,yaw,t,v,kappa\n1,1,"));
    assert!(rows.len() > 100 && rows.iter().all(|row| row.len() == 6 && row[4] <= 0.8 + 1e-9));
    for pair in rows.windows(2) {
        let ds = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        assert!(ds <= 0.1 + 1e-9 && pair[1][3] > pair[0][3]);
        let acceleration = (pair[1][4].powi(2) - pair[0][4].powi(2)).abs() / (2.0 * ds);
        assert!(acceleration <= 0.4 + 1e-6, "{acceleration}");
    }
    plan("--out p.geojson", 0, &[]);
    let feature: serde_json::Value = serde_json::from_str(&text("p.geojson")).unwrap();
    let line = feature["geometry"]["coordinates"].as_array().unwrap();
    assert_eq!(
        (&line[0], line.len()),
        (&serde_json::json!([1.0, 1.0]), feature["properties"]["t"].as_array().unwrap().len())
    );
    plan("--out p.yaml --frame odom", 0, &[]);
    assert!(text("p.yaml").starts_with(
        "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: \"odom\"\nposes:\n- header:"
    ));
    plan("--out p.txt", 2, &["p.txt: expected a name that ends in .json or .csv"]);
    for (flags, part) in [
        ("--spacing 0", "--spacing: 0 is not allowed"),
        ("--max-speed -1", "--max-speed: -1 is not allowed"),
        ("--max-accel nan", "--max-accel: NaN is not allowed"),
        ("--max-lateral-accel 0", "--max-lateral-accel: 0 is not allowed"),
        ("--max-turn 181", "--max-turn: 181 is not allowed"),
        ("--min-radius -1", "--min-radius: -1 is not allowed"),
    ] {
        plan(flags, 2, &[part]);
    }
    // No robot drives what is not certified.
    plan("--planner gd --steps 0 --out none.csv", 1, &["unsolved"]);
    assert_eq!(text("none.csv"), "x,y,yaw,t,v,kappa\n");
}

#[test]
fn a_recording_is_read_by_the_formats_own_reader() {
    let folder = folder();
    check(folder.path(), "plan block.json --trace --out p.mcap", 0, &[]);
    let bytes = fs::read(folder.path().join("p.mcap")).unwrap();
    let magic = [0x89, b'M', b'C', b'A', b'P', 0x30, b'\r', b'\n'];
    assert!(bytes.starts_with(&magic) && bytes.ends_with(&magic));
    let python = std::env::var("SIDESTEP_PYTHON").unwrap_or_else(|_| "python3".into());
    let has_reader = Command::new(&python).args(["-c", "import mcap, mcap_ros2"]).output();
    if !has_reader.is_ok_and(|found| found.status.success()) {
        return;
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../oracle/read_mcap.py");
    let read =
        Command::new(&python).arg(script).arg(folder.path().join("p.mcap")).output().unwrap();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    let found: serde_json::Value = serde_json::from_slice(&read.stdout).unwrap();
    assert_eq!(found["topics"]["/map"]["type"], "nav_msgs/msg/OccupancyGrid");
    assert!(found["topics"]["/map"]["occupied"].as_u64().unwrap() > 0);
    let poses = found["topics"]["/plan"]["poses"].as_array().unwrap();
    assert_eq!((&poses[0][0], &poses[poses.len() - 1][0]), (&1.0.into(), &9.0.into()));
    assert!(found["topics"]["/iterates"]["count"].as_u64().unwrap() > 0);
}

#[test]
fn paths_of_others_are_made_smooth_or_refused() {
    let folder = folder();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("way.csv", "x,y\n1,1\n1,9\n9,9\n");
    write("through.csv", "x,y\n1,1\n9,9\n");
    let smooth = |line: &str, code: i32, parts: &[&str]| {
        check(folder.path(), &format!("smooth {line}"), code, parts)
    };
    let answer = smooth("way.csv --map block.json --out s.csv --json", 0, &[]).json();
    assert!(answer["sharpest_turn_deg"].as_f64().unwrap() <= 20.0, "{answer}");
    assert_eq!(answer["certified"], true);
    smooth("s.csv --map block.json", 0, &["certified"]);
    smooth("through.csv --map block.json", 1, &["not free: ", "obstacle 0"]);
    smooth("way.csv --map block.json --out way.csv", 2, &["written over way.csv"]);
    smooth("none.csv --map block.json", 2, &["none.csv"]);
    write("bad.csv", "x,y\n1,1\n2,z\n");
    smooth("bad.csv --map block.json", 2, &["bad.csv", "line 3"]);
}
