//! Other people's worlds on the command line: each kind of file is planned on, and each misuse is
//! refused with exit code 2 and a message that says what to mend.

use std::fs;

use crate::check;

const BARN: &str = r#"{"start": [-2, 3], "goal": [-2, 13],
    "worlds": {"0": [[-2, 6, 0.5], [-4, 1, 0.1], [0, 1, 0.1]], "7": [[-2.5, 8, 0.4]]}}"#;
const MAP: &str = "type octile\nheight 4\nwidth 6\nmap\n......\n..@@..\n..@@..\n......\n";
const ROS: &str = "image: room.pgm\nresolution: 0.5\norigin: [-1, -1, 0]\nnegate: 0\n\
    occupied_thresh: 0.65\nfree_thresh: 0.2\n";

/// A folder with one file of each kind.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    write("barn.json", BARN.as_bytes());
    write("room.map", MAP.as_bytes());
    write("room.yaml", ROS.as_bytes());
    write("room.pgm", b"P2 4 3 255 254 254 254 254 254 0 0 254 254 254 254 205");
    let centres: Vec<u8> =
        (0..40).flat_map(|i| f64::to_le_bytes(f64::from(i) * 0.8 - 16.0)).collect();
    write("obs.dat", &centres);
    let worlds: Vec<u8> =
        (0..3).flat_map(|w| (0..7).map(move |b| 2 * b + w)).flat_map(i32::to_le_bytes).collect();
    write("obs_perm2.dat", &worlds);
    folder
}

#[test]
fn every_kind_of_world_is_planned_on() {
    let folder = folder();
    for (arguments, expected) in [
        ("plan barn.json", "certified"),
        ("plan barn.json --index 1 --robot-radius 0.2", "certified"),
        ("plan obs_perm2.dat --index 2 --seed 5", "certified"),
        ("plan room.map --start 0.5,0.5 --goal 5.5,3.5", "certified"),
        ("plan room.map --random-queries 4 --index 3 --seed 1", "certified"),
        ("plan room.yaml --random-queries 2 --robot-radius 0.1", "certified"),
        ("shortest barn.json", "2 of 2 solvable"),
        ("shortest obs_perm2.dat", "3 of 3 solvable"),
        ("shortest room.yaml --random-queries 9 --seed 2", "9 of 9 solvable"),
    ] {
        check(folder.path(), arguments, 0, &[expected]);
    }
}

#[test]
fn bench_shares_worlds_and_counts_rows() {
    let folder = folder();
    let arguments = "bench --tasks room.map room.yaml --random-queries 12 --limit 5 --spread \
        --by-file --planner shortest-path --planner auto --json";
    let report = check(folder.path(), arguments, 0, &[]).json();
    let rows = report["rows"].as_array().unwrap();
    let suites: Vec<&str> = rows.iter().map(|row| row["suite"].as_str().unwrap()).collect();
    assert_eq!(suites, ["room.map", "room.map", "room.yaml", "room.yaml"]);
    for row in rows {
        assert_eq!(row["tasks"], 5, "{row}");
        assert_eq!(row["success"], 1.0, "{row}");
        assert!(row["us_per_world_median"].is_number(), "{row}");
    }
}

#[test]
fn misuse_is_refused() {
    let folder = folder();
    for (arguments, expected) in [
        ("plan room.map", "within [0.0, 0.0] to [6.0, 4.0], or --random-queries N"),
        ("plan barn.json --random-queries 2", "--random-queries: only a map"),
        ("plan room.map --random-queries 0", "--random-queries: 0 is not a number from 1 to"),
        ("plan room.map --random-queries 2 --robot-radius 9", "leaves the robot a place to stand"),
        ("plan barn.json --robot-radius=-1", "robot.radius: -1"),
        ("plan obs.dat", "expected the worlds' file, obs_perm2.dat"),
        ("plan nowhere.dat", "cannot be read"),
        ("bench --tasks room.yaml --planner gd", "or --random-queries N"),
        ("bench --tasks room.map --spread --planner gd", "--limit"),
        ("bench --suite easy --spread --planner gd", "cannot be used with"),
    ] {
        check(folder.path(), arguments, 2, &[expected]);
    }
}

/// A drawing is a map: what is dark is an obstacle.
#[test]
fn pictures_are_planned() {
    let folder = folder();
    // 40 x 20 pixels with a wall in the middle, open above.
    let row = |y: usize| (0..40).map(move |x| if x == 20 && y > 6 { 30_u8 } else { 250 });
    let pixels: Vec<u8> = (0..20).flat_map(row).collect();
    let picture = [b"P5\n40 20\n255\n".to_vec(), pixels].concat();
    std::fs::write(folder.path().join("wall.pgm"), picture).unwrap();
    let line = "plan wall.pgm --start 5,5 --goal 35,5";
    check(folder.path(), &format!("{line} --robot-radius 1"), 0, &["solved"]);
    check(folder.path(), &format!("{line} --planner gd --steps 0"), 1, &["unsolved"]);
    // Darker than the wall is nothing.
    check(
        folder.path(),
        &format!("{line} --threshold 0.95 --planner gd --steps 0"),
        0,
        &["solved"],
    );
    check(folder.path(), &format!("{line} --light-is-obstacle"), 2, &["the start is in collision"]);
    let small = "plan wall.pgm --scale 0.1 --start 0.5,0.5 --goal 3.5,0.5 --planner shortest-path";
    check(folder.path(), small, 0, &["solved"]);
    check(folder.path(), &format!("{line} --threshold 1.5"), 2, &["threshold: 1.5", "below 1"]);
    check(folder.path(), &format!("{line} --scale -1"), 2, &["scale: -1", "above 0"]);
    std::fs::write(folder.path().join("half.jpg"), b"\xff\xd8\xff\xe0 no more").unwrap();
    check(folder.path(), "plan half.jpg --start 1,1 --goal 2,2", 2, &["half.jpg: picture", "JPEG"]);
}
