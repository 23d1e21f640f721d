//! `experiment`: as one run, as cells of which each is a process, and broken off.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::train::SMALL;
use crate::{check, folder};

/// An experiment of seconds that trains a policy of each kind.
const BOTH: &str = r#"
name = "both"
title = "Both kinds"
training_seeds = [0]
[[measure]]
name = "easy"
suite = "easy"
count = 20
seeds = [2]
steps = 10
[[policies]]
row = "paper's"
column = "tiny"
paper = { easy = 50 }
[policies.train]
environment_steps = 400
network.hidden = 8
training.count = 4
cloning.samples_per_task = 4
ppo = { environments = 5, steps = 40 }
validation = { count = 4, steps = 10 }
[[policies]]
row = "waypoint"
column = "tiny"
[policies.train]
architecture = "waypoint"
observation = ["waypoints", "probes:4x1"]
network = { width = 16, dilations = [1] }
imitation = { tasks = 2, steps = 1 }
validation = { count = 3 }
stages = [{ kind = "imitation", updates = 250, learning_rate = 1e-3 }]
[[baselines]]
planner = "gd"
"#;

#[test]
fn an_experiment_trains_and_measures_both_kinds() {
    let folder = folder();
    fs::write(folder.path().join("both.toml"), BOTH).unwrap();
    let line = "experiment both.toml --out both --json";
    let report = check(folder.path(), line, 0, &[]).json();
    let cells = report["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 3);
    for cell in cells {
        assert_eq!(cell["solved"][0].as_str().unwrap().len(), 20, "{cell}");
    }
    assert!(cells[1]["kept_at_steps"][0].as_u64().unwrap() > 0);
    assert!(cells[1]["curves"][0][0][0].as_f64().unwrap() > 0.0);
    // Policies that are there are not trained again.
    let policy = folder.path().join("both/policies/waypoint-tiny-seed-0.safetensors");
    let before = fs::metadata(&policy).unwrap().modified().unwrap();
    check(folder.path(), line, 0, &[]);
    assert_eq!(fs::metadata(&policy).unwrap().modified().unwrap(), before);
    check(folder.path(), "table both/report.json", 0, &["waypoint", "`gd`"]);
}

#[test]
fn an_experiment_is_checked_before_its_first_training() {
    let folder = folder();
    for (from, to, parts) in [
        (
            "\"easy\"\ncount",
            "\"eazy\"\ncount",
            &["both.toml: measure[0].suite: `eazy`", "easy"][..],
        ),
        ("\"gd\"", "\"gdx\"", &["both.toml: baselines[0]", "gdx"]),
        ("count = 20", "count = 9223372036854775807", &["measure[0].count"]),
        ("steps = 10\n[[", "steps = 9223372036854775807\n[[", &["measure[0].steps"]),
        ("steps = 10\n[[", "starts = 0\n[[", &["measure[0].starts: 0"]),
        ("\"both\"", "\"../both\"", &["both.toml: name"]),
        (
            "row = \"waypoint\"",
            "row = \"paper's\"",
            &["policies[1]", "policies/paper's-tiny-seed-0"],
        ),
    ] {
        let text = BOTH.replacen(from, to, 1);
        assert_ne!(text, BOTH, "{from}");
        fs::write(folder.path().join("both.toml"), text).unwrap();
        let outcome = check(folder.path(), "experiment both.toml --out both", 2, parts);
        assert_eq!(outcome.stdout, "", "{to}");
        assert!(!folder.path().join("both").exists(), "{to}");
    }
    fs::write(folder.path().join("both.toml"), BOTH).unwrap();
    check(
        folder.path(),
        "train both.toml --out x",
        2,
        &["is an experiment", "sidestep experiment"],
    );
    fs::write(folder.path().join("config.toml"), SMALL).unwrap();
    check(folder.path(), "experiment config.toml", 2, &["sidestep train"]);
}

/// What a report says, times and the machine aside.
fn without_times(mut report: Value) -> Value {
    report.as_object_mut().unwrap().remove("provenance").unwrap();
    for cell in report["cells"].as_array_mut().unwrap() {
        for time in ["us_per_iteration", "training_seconds"] {
            cell.as_object_mut().unwrap().remove(time).unwrap();
        }
    }
    report
}

fn report(folder: &Path) -> Value {
    without_times(serde_json::from_slice(&fs::read(folder.join("report.json")).unwrap()).unwrap())
}

/// Two trainings of a policy, one of another and a baseline; measurements of which one race serves
/// two, and one by itself.
fn four() -> String {
    let races = |name: &str, starts: u32| {
        format!(
            "[[measure]]\nname = \"{name}\"\nsuite = \"hard\"\ncount = 6\nseeds = [2, 3]\nsteps = 10\n\
             starts = {starts}\nuntil_solved = true\n"
        )
    };
    let measures = races("one", 1) + &races("three", 3) + "[[measure]]\nname = \"easy\"";
    BOTH.replace("[[measure]]\nname = \"easy\"", &measures)
        .replace("column = \"tiny\"\npaper", "column = \"tiny\"\ntraining_seeds = [4, 7]\npaper")
}

#[test]
fn cells_are_merged_into_the_report_of_one_run() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("four.toml"), four()).unwrap();
    check(folder, "experiment four.toml --out whole --quiet", 0, &[]);
    let line = "experiment four.toml --out cells";
    check(
        folder,
        &format!("{line} --list"),
        0,
        &["0  open      paper's tiny, seed 4", "3  open      gd\n"],
    );
    assert!(!folder.join("cells").exists(), "a list writes nothing");
    // Some in turn, the other two at the same time, with other numbers of threads.
    check(folder, &format!("{line} --cell 3 --threads 2"), 0, &[]);
    check(folder, &format!("{line} --cell 1 --quiet"), 0, &[]);
    let parts = ["2 of 4 cells are not finished, the first of them 0", "--cell", "--list"];
    check(folder, &format!("{line} --merge"), 2, &parts);
    assert!(!folder.join("cells/report.json").exists());
    let start = |index: &str| {
        let words =
            ["experiment", "four.toml", "--out", "cells", "--threads", "1", "--cell", index];
        let mut command = Command::new(env!("CARGO_BIN_EXE_sidestep"));
        command.args(words).current_dir(folder).stderr(Stdio::null()).spawn().unwrap()
    };
    let mut beside = [start("0"), start("2")];
    assert!(beside.iter_mut().all(|child| child.wait().unwrap().success()));
    let list = check(folder, &format!("{line} --list --json"), 0, &[]).json();
    let list = list.as_array().unwrap();
    assert!(list.iter().all(|cell| cell["state"] == "finished"), "{list:?}");
    assert_eq!((list[1]["seed"].as_u64(), list[3]["seed"].as_u64()), (Some(7), None));
    let merged = check(folder, &format!("{line} --merge --json"), 0, &[]).json();
    assert_eq!(without_times(merged.clone()), report(&folder.join("cells")));
    assert_eq!(report(&folder.join("cells")), report(&folder.join("whole")));
    assert!(merged["provenance"]["seconds"].as_f64().unwrap() > 0.0);
    let policy = "policies/paper's-tiny-seed-7.safetensors";
    let [a, b] = ["whole", "cells"].map(|out| fs::read(folder.join(out).join(policy)).unwrap());
    assert!(a == b, "another policy");
    // What is finished is not done again, and a run of the whole takes the policies as they are.
    let file = folder.join("cells/cells/0001/cell.json");
    let before = fs::metadata(&file).unwrap().modified().unwrap();
    check(folder, &format!("{line} --cell 1"), 0, &[]);
    assert_eq!(fs::metadata(&file).unwrap().modified().unwrap(), before);
    check(folder, &line.replace("cells", "whole"), 0, &[]);
    // Cells of another experiment count for nothing.
    fs::write(folder.join("four.toml"), four().replace("count = 20", "count = 21")).unwrap();
    check(folder, &format!("{line} --list"), 0, &["1  trained   paper's", "3  open"]);
    check(folder, &format!("{line} --merge"), 2, &["4 of 4 cells are not finished"]);
}

#[test]
fn cells_that_cannot_be() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("both.toml"), BOTH).unwrap();
    let line = "experiment both.toml --out both";
    let parts = ["--cell: 3 is not allowed; expected a number from 0 to 2"];
    check(folder, &format!("{line} --cell 3"), 2, &parts);
    check(folder, &format!("{line} --cell=-1"), 2, &["--cell"]);
    check(folder, &format!("{line} --cell 1 --merge"), 2, &["cannot be used with"]);
    check(folder, &format!("{line} --list --merge"), 2, &["cannot be used with"]);
    let parts = ["--checkpoint-every: -1 is not allowed"];
    check(folder, &format!("{line} --cell 1 --checkpoint-every=-1"), 2, &parts);
    assert!(!folder.join("both").exists());
    check(folder, &format!("{line} --merge"), 2, &["both: 3 of 3 cells are not finished"]);
    check(folder, &format!("{line} --cell 2"), 0, &[]);
    let file = folder.join("both/cells/0002/cell.json");
    let whole = fs::read(&file).unwrap();
    for (bytes, parts) in [
        (&whole[..whole.len() / 2], &["0002/cell.json: EOF", "remove it to have it made anew"][..]),
        (b"[]", &["0002/cell.json"]),
        (b"", &["0002/cell.json"]),
    ] {
        fs::write(&file, bytes).unwrap();
        for rest in ["--cell 2", "--list", "--merge"] {
            check(folder, &format!("{line} {rest}"), 2, parts);
        }
    }
    let other = String::from_utf8(whole).unwrap().replace("experiment-cell/1", "experiment-cell/9");
    fs::write(&file, other).unwrap();
    check(folder, &format!("{line} --cell 2"), 2, &["format: \"sidestep.experiment-cell/9\""]);
}

/// An experiment whose training is long enough to be killed.
fn long() -> String {
    let (head, rest) = BOTH.split_once("[policies.train]\n").unwrap();
    let (_, baselines) = rest.split_once("[[baselines]]").unwrap();
    let train = SMALL.replace("\n[", "\n[policies.train.");
    format!("{head}[policies.train]\n{train}\n[[baselines]]{baselines}")
}

#[test]
fn a_killed_cell_goes_on_to_the_same_bits() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("long.toml"), long()).unwrap();
    check(folder, "experiment long.toml --out whole --quiet", 0, &[]);
    let words = "experiment long.toml --out killed --checkpoint-every 0 --cell 0";
    let mut child = Command::new(env!("CARGO_BIN_EXE_sidestep"))
        .args(words.split(' '))
        .current_dir(folder)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let file = |out: &str, ending: &str| {
        folder.join(out).join("policies").join(format!("paper's-tiny-seed-0.{ending}"))
    };
    let begin = Instant::now();
    while !file("killed", "checkpoint").exists() {
        assert!(begin.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!file("killed", "safetensors").exists(), "the training was over before it was killed");
    check(folder, "experiment long.toml --out killed --list", 0, &["0  begun"]);
    check(folder, words, 0, &["goes on after unit"]);
    for ending in ["safetensors", "metrics.jsonl"] {
        let [a, b] = ["whole", "killed"].map(|out| fs::read(file(out, ending)).unwrap());
        assert!(a == b, "another {ending}");
    }
    assert!(!file("killed", "checkpoint").exists());
    // A whole run goes on from what a killed one left, too.
    check(folder, "experiment long.toml --out killed --cell 1", 0, &[]);
    check(folder, "experiment long.toml --out killed --merge", 0, &["paper's"]);
    assert_eq!(report(&folder.join("killed")), report(&folder.join("whole")));
}
