//! `generate`, and what other verbs make of its files.

use crate::{check, folder};

#[test]
fn generated_tasks_can_be_planned() {
    let folder = folder();
    let line = "generate --suite easy --count 8 --seed 3 --out tasks";
    check(folder.path(), &format!("{line}.jsonl"), 0, &["8 tasks of easy (seed 3): tasks.jsonl"]);
    check(folder.path(), &format!("{line}.json"), 0, &[]);
    let answers =
        |file: &str| check(folder.path(), &format!("shortest {file} --json"), 0, &[]).json();
    let solvable = answers("tasks.jsonl");
    assert_eq!(solvable, answers("tasks.json"));
    let solvable = solvable.as_array().unwrap();
    assert_eq!(solvable.len(), 8);
    for (index, exact) in solvable.iter().enumerate() {
        let code = i32::from(exact["answer"] != "solvable");
        let line = format!("plan tasks.jsonl --index {index} --json");
        let answer = check(folder.path(), &line, code, &[]).json();
        assert_eq!(answer["optimal_length"], exact["length"], "task {index}");
    }
    check(folder.path(), "plan tasks.jsonl --index 8", 2, &["--index", "8 of 8 tasks"]);
}

#[test]
fn quiet_is_quiet() {
    let folder = folder();
    let line = "generate --suite easy --count 1 --seed 3 --quiet --out tasks.jsonl";
    let outcome = check(folder.path(), line, 0, &[]);
    assert_eq!((outcome.stdout.as_str(), outcome.stderr.as_str()), ("", ""));
}
