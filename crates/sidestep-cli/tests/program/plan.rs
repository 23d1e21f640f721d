//! `plan`: statuses, the JSON result, pictures, budgets and warm starts.

use std::time::Instant;

use crate::{check, folder};

/// The fields that the result always has.
const FIELDS: [&str; 11] = [
    "status",
    "reason",
    "planner",
    "iterations",
    "time_us",
    "length",
    "optimal_length",
    "clearance",
    "certified",
    "waypoints",
    "task",
];

#[test]
fn ends_that_are_not_free_are_moved_or_have_less_than_the_margin_and_it_is_said() {
    let folder = folder();
    let solved = |line: &str, code: i32| {
        let out = check(folder.path(), &format!("plan block.json {line} --json"), code, &[]);
        let answer = out.json();
        (answer["warnings"].to_string(), answer["waypoints"][0].clone(), answer)
    };
    let (told, start, _) = solved("--start 1,1", 0);
    assert_eq!((told.as_str(), start), ("[]", serde_json::json!([1.0, 1.0])));
    // The robot stands 0.2 from the field's border.
    let (told, start, answer) = solved("--start 0.2,5 --margin 0.5", 0);
    assert!(told.contains("the start (0.2, 5) has a clearance of 0.200 only"), "{told}");
    assert_eq!(start, serde_json::json!([0.2, 5.0]));
    assert!((answer["clearance"].as_f64().unwrap() - 0.2).abs() < 1e-6);
    let (told, start, _) = solved("--start=-0.5,5 --margin 0.5 --snap 2", 0);
    assert!(told.contains("is not free and was moved by 1.000 to (0.500, 5.000)"), "{told}");
    assert!((start[0].as_f64().unwrap() - 0.5).abs() < 1e-3, "{start}");
    let (told, ..) = solved("--start=-0.5,5 --margin 0.5 --snap 0.2", 2);
    assert_eq!(told, "[]");
    check(folder.path(), "plan block.json --snap -1", 2, &["--snap: -1", "from 0 to 10"]);
    check(
        folder.path(),
        "plan block.json --planner gd --steps 0",
        1,
        &["the rectangle [", " at ("],
    );
}

#[test]
fn statuses_and_exit_codes() {
    let folder = folder();
    let rows = [
        ("plan free.json", 0, "solved", ""),
        ("plan block.json", 0, "solved", ""),
        ("plan block.json --planner shortest-path", 0, "solved", ""),
        ("plan block.json --planner rrt-connect", 0, "solved", ""),
        ("plan block.json --planner gd --steps 0", 1, "unsolved", "collides with obstacle 0"),
        ("plan block.json --planner rrt-connect:samples=1", 1, "unsolved", "1 samples spent"),
        ("plan wall.json", 1, "unsolvable", "obstacles separate the start from the goal"),
        ("plan wall.json --planner gd", 1, "unsolvable", "obstacles separate"),
        ("plan wall.json --planner shortest-path", 1, "unsolvable", "obstacles separate"),
        ("plan wall.json --planner rrt-connect", 1, "unsolvable", "obstacles separate"),
        ("plan wall.json --start 4.5,5", 2, "invalid", "the start is in collision with obstacle 0"),
        ("plan wall.json --goal 4.5,5", 2, "invalid", "the goal is in collision with obstacle 0"),
        ("plan free.json --goal 11,5", 2, "invalid", "the goal is out of bounds"),
        ("plan free.json --robot-radius 1.5", 2, "invalid", "the start is out of bounds"),
    ];
    for (line, code, status, reason) in rows {
        let answer = check(folder.path(), &format!("{line} --json"), code, &[]).json();
        for field in FIELDS {
            assert!(answer.get(field).is_some(), "{line}: no {field}");
        }
        assert_eq!(answer["status"], status, "{line}");
        assert_eq!(answer["certified"], status == "solved", "{line}");
        let given = answer["reason"].as_str().unwrap();
        assert!(given.contains(reason), "{line}: {given}");
        if status == "solved" {
            assert_eq!(given, "");
            let length = answer["length"].as_f64().unwrap();
            assert!(length + 1e-6 >= answer["optimal_length"].as_f64().unwrap(), "{line}");
            assert!(answer["clearance"].as_f64().unwrap() >= 0.0, "{line}");
            let points = answer["waypoints"].as_array().unwrap();
            assert_eq!(points[0], serde_json::json!([1.0, 1.0]));
            assert_eq!(points[points.len() - 1], serde_json::json!([9.0, 9.0]));
        }
        // The same in words.
        check(folder.path(), line, code, &[status, reason]);
    }
}

#[test]
fn every_planner_name_plans() {
    let folder = folder();
    for planner in [
        "auto",
        "gd",
        "gd:step=0.5",
        "gd-line-search",
        "momentum",
        "adam",
        "chomp",
        "lbfgs",
        "lm",
        "stomp",
        "rrt-connect",
        "shortest-path",
    ] {
        for profile in ["default", "paper"] {
            let line = format!("plan free.json --planner {planner} --profile {profile} --json");
            let answer = check(folder.path(), &line, 0, &[]).json();
            assert_eq!(answer["planner"], planner);
        }
    }
}

#[test]
fn maps_take_start_goal_and_radius_from_the_line() {
    let folder = folder();
    let line = "plan EXAMPLES/office.yaml --start 1,1 --goal 18,11 --robot-radius 0.2 --json";
    let answer = check(folder.path(), line, 0, &[]).json();
    assert_eq!(answer["task"], "office");
    let thin = check(folder.path(), &line.replace("0.2", "0"), 0, &[]).json();
    assert!(thin["optimal_length"].as_f64() < answer["optimal_length"].as_f64());
    let line = "plan EXAMPLES/office.yaml --start -1,1 --goal 18,11";
    check(folder.path(), line, 2, &["invalid", "the start is out of bounds"]);
}

#[test]
fn traces_hold_every_iterate() {
    let folder = folder();
    let line = "plan block.json --planner gd --steps 7 --starts 3 --best --trace --json";
    let answer = check(folder.path(), line, 0, &[]).json();
    let trace = answer["trace"].as_array().unwrap();
    // Three starts, seven steps: the start itself and every iterate after it.
    assert_eq!(trace.len(), 3 * 8);
    for field in ["start", "iteration", "objective", "obstacle_cost", "length_cost", "certified"] {
        assert!(trace[0].get(field).is_some(), "{field}");
    }
    assert_eq!(trace[0]["waypoints"].as_array().unwrap().len(), 12);
}

#[test]
fn files_and_pictures() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let line = "plan block.json --out plan.json --png plan.png --svg plan.svg --json";
    let printed = check(folder.path(), line, 0, &[]);
    assert_eq!(std::fs::read_to_string(path("plan.json")).unwrap(), printed.stdout);
    assert!(std::fs::read(path("plan.png")).unwrap().starts_with(b"\x89PNG\r\n\x1a\n"));
    let svg = std::fs::read_to_string(path("plan.svg")).unwrap();
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    // A second run replaces the files; nothing else is left behind.
    check(folder.path(), "plan free.json --out plan.json", 0, &[]);
    assert_ne!(std::fs::read_to_string(path("plan.json")).unwrap(), printed.stdout);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 6);
}

#[test]
#[cfg(unix)]
fn devices_stay_devices() {
    let folder = folder();
    check(folder.path(), "plan free.json --quiet --out /dev/null", 0, &["solved"]);
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn a_diverged_optimizer_leaves_numbers_to_start_from() {
    let folder = folder();
    let line = "plan block.json --planner gd:step=1000 --trace --json --out plan.json";
    let answer = check(folder.path(), line, 1, &["the optimizer diverged after"]);
    assert!(!answer.stdout.contains("[\n      null"), "{}", answer.stdout);
    check(folder.path(), "plan block.json --warm-start plan.json", 0, &["solved"]);
}

#[test]
fn the_time_budget_is_honoured() {
    let folder = folder();
    let line = "plan block.json --planner gd --steps 100000000 --budget-ms 200 --json";
    let begin = Instant::now();
    let answer = check(folder.path(), line, 1, &["the time budget is spent"]).json();
    // Generous: machines that test are busy.
    assert!(begin.elapsed().as_secs() < 20);
    assert!(answer["time_us"].as_f64().unwrap() >= 200e3);
    // With time left over, the best of all steps is kept.
    let line = "plan free.json --planner gd --steps 10 --budget-ms 60000 --json";
    check(folder.path(), line, 0, &[]);
}

#[test]
fn a_plan_can_start_from_another() {
    let folder = folder();
    check(folder.path(), "plan block.json --planner shortest-path --out shortest.json", 0, &[]);
    let line = "plan block.json --planner gd --waypoints 40 --epsilon 0.3";
    check(folder.path(), line, 1, &["unsolved"]);
    check(folder.path(), &format!("{line} --warm-start shortest.json"), 0, &["solved"]);
}

#[test]
fn a_replay_shows_planners_side_by_side() {
    let folder = folder();
    let path = folder.path().join("replay.html");
    let line = "plan block.json --planner gd --compare adam,chomp,sidestep-1 --steps 40";
    check(folder.path(), &format!("{line} --html replay.html"), 1, &["unsolved"]);
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(page.len() < 300_000, "{} bytes", page.len());
    for name in ["gd", "adam", "chomp", "sidestep-1"] {
        assert!(page.contains(&format!("\"name\":\"{name}\"")), "{name}");
    }
    assert!(page.contains("\"label\":\"40\"") && page.contains("\"blocked\":{"));
    assert!(!page.contains("http:") && !page.contains("https:"));
    // A name that would end the element is data all the same.
    let hostile = crate::task("").replace("\"test\"", "\"</script><script>alert(1)</script>\"");
    std::fs::write(folder.path().join("hostile.json"), hostile).unwrap();
    check(folder.path(), "plan hostile.json --html replay.html", 0, &[]);
    let page = std::fs::read_to_string(&path).unwrap();
    assert!(!page.contains("<script>alert") && page.contains("alert(1)"));
}

#[test]
fn pictures_move() {
    let folder = folder();
    let line = "plan block.json --planner gd --compare adam --steps 20 --animate";
    check(folder.path(), &format!("{line} --png moving.png --svg moving.svg"), 1, &["unsolved"]);
    let png = std::fs::read(folder.path().join("moving.png")).unwrap();
    let control = png.windows(4).position(|name| name == b"acTL").unwrap();
    assert_eq!(png[control + 4..control + 8], 21_u32.to_be_bytes(), "the start and 20 iterates");
    let svg = std::fs::read_to_string(folder.path().join("moving.svg")).unwrap();
    assert!(svg.contains("<animate "));
    check(folder.path(), "plan block.json --animate", 2, &["--animate", "--png FILE or --svg"]);
}
