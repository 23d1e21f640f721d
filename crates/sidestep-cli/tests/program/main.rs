//! The program from outside: exit codes, output and messages, as a person or a script meets them.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod arms;
mod bad_input;
mod bench;
#[cfg(unix)]
mod cases;
#[cfg(unix)]
mod crash;
mod determinism;
mod drive;
mod experiment;
mod files;
mod generate;
mod generate_arms;
mod mistakes;
mod plan;
mod robot;
mod serve;
mod table;
mod train;
mod worlds;

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

/// What a run of the program gave.
struct Outcome {
    code: i32,
    stdout: String,
    stderr: String,
}

impl Outcome {
    /// Standard output, which must be exactly one JSON document.
    fn json(&self) -> Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|error| panic!("{error} in {:?}\n{}", self.stdout, self.stderr))
    }
}

/// Runs `sidestep` on the words of `line` in `folder`. `EXAMPLES` stands for the repository's examples.
fn run(folder: &Path, line: &str) -> Outcome {
    run_with(folder, line, &[])
}

/// The same with these variables in the environment.
fn run_with(folder: &Path, line: &str, environment: &[(&str, &str)]) -> Outcome {
    let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
    let output = Command::new(env!("CARGO_BIN_EXE_sidestep"))
        .args(line.split_whitespace().map(|word| word.replace("EXAMPLES", examples)))
        .current_dir(folder)
        .envs(environment.iter().copied())
        .output()
        .unwrap();
    Outcome {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Runs `sidestep` and checks the exit code, and that its whole output holds every one of `parts`.
fn check(folder: &Path, line: &str, code: i32, parts: &[&str]) -> Outcome {
    let outcome = run(folder, line);
    let told = format!("{}{}", outcome.stdout, outcome.stderr);
    assert_eq!(outcome.code, code, "sidestep {line}\n{told}");
    for part in parts {
        assert!(told.contains(part), "sidestep {line}\nlacks {part:?} in\n{told}");
    }
    outcome
}

/// A task document on a field of 10 x 10, from (1, 1) to (9, 9), with these obstacles.
fn task(obstacles: &str) -> String {
    format!(
        r#"{{"format": "sidestep.task/1", "name": "test", "bounds": [[0, 0], [10, 10]],
        "obstacles": [{obstacles}], "robot": "point", "start": [1, 1], "goal": [9, 9]}}"#
    )
}

/// A folder with a few tasks: `free.json`, `block.json` (a way around), `wall.json` (no way).
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, obstacles: &str| {
        std::fs::write(folder.path().join(name), task(obstacles)).unwrap();
    };
    write("free.json", "");
    write("block.json", r#"{"rect": [[3, 2], [7, 7]]}"#);
    write("wall.json", r#"{"rect": [[4, -1], [5, 11]]}"#);
    folder
}

#[test]
fn help_and_version() {
    let folder = folder();
    let verbs = [
        "plan",
        "generate",
        "bench",
        "table",
        "robot",
        "shortest",
        "train",
        "experiment",
        "robot",
        "planners",
        "info",
        "completions",
    ];
    check(folder.path(), "--help", 0, &verbs);
    check(folder.path(), "--version", 0, &["sidestep ", env!("CARGO_PKG_VERSION")]);
    check(folder.path(), "", 2, &["Usage"]);
    for verb in verbs {
        let parts = ["--threads", "--json", "--quiet", "Every verb:"];
        check(folder.path(), &format!("{verb} --help"), 0, &parts);
    }
}

#[test]
fn every_verb_prints_one_document_with_json() {
    let folder = folder();
    for line in [
        "plan block.json --png plan.png",
        "generate --suite easy --count 3 --seed 1 --out tasks.jsonl",
        "shortest tasks.jsonl",
        "bench --tasks tasks.jsonl --planner gd,stomp:rollouts=4,noise=0.3 --timed 0 --out report.json",
        "table report.json",
        "table report.json --format csv",
        "planners",
        "plan --planner help",
        "info sidestep-1",
        "completions zsh",
        "man --out pages",
    ] {
        check(folder.path(), &format!("{line} --json"), 0, &[]).json();
    }
}

#[test]
fn old_names_go_on_working_and_say_what_to_write() {
    let folder = folder();
    let line = "plan block.json --planner gd --waypoints 40 --clearance 0.3";
    let old = check(folder.path(), line, 1, &["note: --clearance is called --epsilon now"]);
    let new = check(folder.path(), &line.replace("clearance", "epsilon"), 1, &[]);
    let until_time = |text: &str| text.split(" (gd, ").next().map(str::to_string);
    assert_eq!(until_time(&old.stdout), until_time(&new.stdout));
    check(folder.path(), "oracle free.json", 0, &["note: the verb `oracle`", "1 of 1 solvable"]);
    let quiet = check(folder.path(), "oracle free.json --quiet", 0, &["1 of 1 solvable"]);
    assert_eq!(quiet.stderr, "");
}

#[test]
fn policies_say_what_they_are() {
    let folder = folder();
    let policies = concat!(env!("CARGO_MANIFEST_DIR"), "/../../policies");
    let parts = ["parameters    6804", "profile       paper", "training.config.seed 0"];
    check(folder.path(), &format!("info {policies}/gradient-4m.safetensors"), 0, &parts);
    let card = check(folder.path(), "info sidestep-1-small --json", 0, &[]).json();
    assert_eq!(card["format"], "sidestep.policy/1");
    assert!(card["parameters"].as_u64().unwrap() > 1000);
}
