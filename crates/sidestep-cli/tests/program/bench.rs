//! `bench`: the report's fields and what must hold between them.

use crate::{check, folder};

/// The fields of a row.
const FIELDS: [&str; 18] = [
    "planner",
    "suite",
    "starts",
    "tasks",
    "solvable",
    "solved_any",
    "solved_end",
    "certified",
    "success",
    "success_ci95",
    "success_of_solvable",
    "iterations_mean",
    "iterations_median",
    "us_per_iteration",
    "us_per_plan_median",
    "us_per_plan_p95",
    "length_ratio_median",
    "contradictions",
];

#[test]
fn reports() {
    let folder = folder();
    let line = "bench --suite easy --count 40 --seeds 7,17 --timed 2 --planner gd --planner \
                shortest-path --planner auto --planner rrt-connect --out report.json --json";
    let outcome = check(folder.path(), line, 0, &[]);
    let report = outcome.json();
    let saved = std::fs::read_to_string(folder.path().join("report.json")).unwrap();
    assert_eq!(saved, outcome.stdout);
    assert_eq!(report["format"], "sidestep.report/1");
    for field in ["version", "commit", "processor", "cores", "threads", "command", "seconds"] {
        assert!(report["provenance"].get(field).is_some(), "{field}");
    }
    let rows = report["rows"].as_array().unwrap();
    let planners: Vec<_> = rows.iter().map(|row| row["planner"].as_str().unwrap()).collect();
    assert_eq!(planners, ["gd", "shortest-path", "auto", "rrt-connect"]);
    for row in rows {
        for field in FIELDS {
            assert!(row.get(field).is_some(), "{field}");
        }
        let number = |name: &str| row[name].as_f64().unwrap();
        assert_eq!((number("tasks"), number("contradictions")), (80.0, 0.0));
        let [low, high] = [0, 1].map(|end| row["success_ci95"][end].as_f64().unwrap());
        assert!(low <= number("success") && number("success") <= high);
        assert!(number("length_ratio_median") >= 1.0 - 1e-9);
        assert!(number("us_per_plan_median") <= number("us_per_plan_p95"));
    }
    // The exact search and what ends in it solve all that is solvable.
    for row in &rows[1..3] {
        assert_eq!(row["success_of_solvable"], 1.0, "{}", row["planner"]);
    }
    check(folder.path(), "table report.json", 0, &["| `gd`", "task seeds 7, 17", "sidestep bench"]);
}

#[test]
fn task_files_are_groups() {
    let folder = folder();
    let line =
        "bench --tasks free.json block.json --planner auto --timed 1 --json --robot-radius 0.1";
    let report = check(folder.path(), line, 0, &[]).json();
    assert_eq!(report["rows"][0]["suite"], "free.json, block.json");
    assert_eq!(report["rows"][0]["success_by_group"], serde_json::json!([1.0, 1.0]));
    // Without --json: the table.
    check(folder.path(), &line.replace("--json ", ""), 0, &["| `auto`", "of solvable %"]);
}
