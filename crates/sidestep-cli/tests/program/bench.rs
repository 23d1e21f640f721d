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
        let outcomes: String = row["outcomes"]
            .as_array()
            .unwrap()
            .iter()
            .map(|group| group.as_str().unwrap())
            .collect();
        let solved = outcomes.matches('1').count();
        assert_eq!((outcomes.len(), solved as f64 / 80.0), (80, number("success")));
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

#[test]
fn figures_of_nothing_are_null() {
    let folder = folder();
    let line = "bench --tasks wall.json --planner gd,auto --timed 0 --out report.json";
    let report = check(folder.path(), &format!("{line} --json"), 0, &[]).json();
    for row in report["rows"].as_array().unwrap() {
        for field in ["success_of_solvable", "us_per_plan_median", "us_per_plan_p95"] {
            assert!(row[field].is_null(), "{field} in {row}");
        }
    }
    let table = check(folder.path(), "table report.json", 0, &[]).stdout;
    // Columns in which no row has anything are left out.
    assert!(!table.contains("of solvable %") && !table.contains("us/plan"), "{table}");
}

#[test]
fn lists_are_written_in_every_way() {
    let folder = folder();
    let planners = |report: &serde_json::Value| -> Vec<String> {
        let rows = report["rows"].as_array().unwrap();
        rows.iter().map(|row| row["planner"].as_str().unwrap().to_string()).collect()
    };
    for list in [
        "--planner gd:step=0.5 --planner stomp:rollouts=4,noise=0.3",
        "--planner gd:step=0.5,stomp:rollouts=4,noise=0.3",
        "--planner gd:step=0.5 stomp:rollouts=4,noise=0.3",
    ] {
        let line = format!("bench --suite easy --count 2 --seeds 2,12 --timed 0 --json {list}");
        let report = check(folder.path(), &line, 0, &[]).json();
        assert_eq!(planners(&report), ["gd:step=0.5", "stomp:rollouts=4,noise=0.3"], "{list}");
    }
    for seeds in ["--seeds 2,12", "--seeds 2 12", "--seeds 2 --seeds 12"] {
        let line = format!("bench --suite easy --count 2 --planner gd --timed 0 --json {seeds}");
        let report = check(folder.path(), &line, 0, &[]).json();
        assert_eq!(report["settings"]["task_seeds"], serde_json::json!([2, 12]), "{seeds}");
    }
    for tasks in [
        "--tasks free.json,block.json",
        "--tasks free.json block.json",
        "--tasks free.json --tasks block.json",
    ] {
        let line = format!("bench {tasks} --planner gd --timed 0 --json");
        let report = check(folder.path(), &line, 0, &[]).json();
        assert_eq!(report["rows"][0]["suite"], "free.json, block.json", "{tasks}");
    }
}

#[test]
fn failed_tasks_can_be_watched() {
    let folder = folder();
    let line = "bench --suite hard --count 4 --seeds 501,502 --planner gd,sidestep-1 --timed 1";
    check(folder.path(), &format!("{line} --html bench.html --quiet"), 0, &["sidestep-1"]);
    let page = std::fs::read_to_string(folder.path().join("bench.html")).unwrap();
    let begin = page.find("id=\"data\">").unwrap() + 10;
    let end = begin + page[begin..].find("</script>").unwrap();
    let data: serde_json::Value = serde_json::from_str(&page[begin..end]).unwrap();
    assert_eq!(data["rows"].as_array().unwrap().len(), 2);
    let tasks = data["tasks"].as_array().unwrap();
    assert!(!tasks.is_empty() && tasks.len() <= 8);
    for task in tasks {
        let solved: Vec<bool> = serde_json::from_value(task["solved"].clone()).unwrap();
        assert!(solved.contains(&false) && solved.len() == 2);
        for (run, solved) in task["replay"]["runs"].as_array().unwrap().iter().zip(solved) {
            assert_eq!(run["frames"].as_array().unwrap().last().unwrap()["free"], solved);
        }
    }
    check(folder.path(), &format!("{line} --html bench.txt"), 2, &["--html", ".html"]);
}
