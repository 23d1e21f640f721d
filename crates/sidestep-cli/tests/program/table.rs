//! `table`: rendered tables of a fixed report.

use crate::{check, folder};

const REPORT: &str = include_str!("../fixtures/report.json");

#[test]
fn rendered_reports() {
    let folder = folder();
    std::fs::write(folder.path().join("report.json"), REPORT).unwrap();
    for (format, expected) in [
        ("markdown", include_str!("../fixtures/report.md")),
        ("csv", include_str!("../fixtures/report.csv")),
    ] {
        let line = format!("table report.json --format {format}");
        let outcome = check(folder.path(), &line, 0, &[]);
        assert_eq!(outcome.stdout, expected, "got\n{}", outcome.stdout);
    }
}

#[test]
fn broken_reports() {
    let folder = folder();
    let rows: [(&str, String, &[&str]); 5] = [
        ("version", REPORT.replace("report/1", "report/2"), &["report/2", "sidestep.report/1"]),
        ("missing field", REPORT.replace("\"starts\"", "\"start\""), &["missing field `starts`"]),
        ("wrong type", REPORT.replace("\"tasks\": 1000", "\"tasks\": \"x\""), &["invalid type"]),
        ("cut short", REPORT[..REPORT.len() / 2].into(), &["EOF", "line "]),
        ("no object", "[1, 2]".into(), &["sidestep.report/1"]),
    ];
    for (name, text, parts) in rows {
        std::fs::write(folder.path().join("report.json"), text).unwrap();
        let outcome = check(folder.path(), "table report.json", 2, parts);
        assert!(outcome.stderr.starts_with("error: report.json"), "{name}: {}", outcome.stderr);
        assert_eq!(outcome.stdout, "", "{name}");
    }
}
