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

#[test]
fn tables_in_documents_are_written_and_checked() {
    let folder = folder();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let read = || std::fs::read_to_string(folder.path().join("page.md")).unwrap();
    write("report.json", REPORT);
    let end = "<!-- end of table: do not edit; sidestep table --splice FILE -->";
    write(
        "page.md",
        &format!("# Page\n<!-- table: report.json | planner | tasks -->\n{end}\nfoot\n"),
    );
    let checked = "table --splice page.md --check";
    check(folder.path(), checked, 2, &["page.md", "not what their reports say"]);
    check(folder.path(), "table --splice page.md", 0, &[]);
    let page = read();
    assert!(page.starts_with("# Page\n<!-- table: report.json | planner | tasks -->\n\n| planner"));
    assert!(page.ends_with(&format!("|\n\n{end}\nfoot\n")), "{page}");
    check(folder.path(), checked, 0, &[]);
    let rows: [(&str, &[&str]); 3] = [
        (
            "<!-- table: report.json | plan -->\n<!-- end of table -->",
            &["line 1", "no column `plan`"],
        ),
        ("<!-- table: no.json -->\n<!-- end of table -->", &["line 1", "no.json: cannot be read"]),
        ("\n<!-- table: report.json -->\n", &["page.md: line 2", "has no end"]),
    ];
    for (text, parts) in rows {
        write("page.md", text);
        check(folder.path(), "table --splice page.md", 2, parts);
        assert_eq!(read(), text);
    }
}
