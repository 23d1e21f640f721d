//! The same answer on any number of threads, on any day.

use serde_json::Value;

use crate::{check, folder};

/// Takes out what may differ between two runs: times, and what a report says of the machine and run.
fn without_times(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.retain(|name, _| {
                name != "time_us" && name != "provenance" && !name.starts_with("us_per_")
            });
            fields.values_mut().for_each(without_times);
        }
        Value::Array(items) => items.iter_mut().for_each(without_times),
        _ => {}
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let folder = folder();
    check(folder.path(), "generate --suite mix --count 12 --seed 7 --out mix.jsonl", 0, &[]);
    for line in [
        "plan EXAMPLES/rectangles.json --planner gd --starts 9 --best --trace",
        "plan EXAMPLES/rectangles.json --planner stomp --starts 4 --seed 5",
        "plan EXAMPLES/rectangles.json --planner rrt-connect --seed 5",
        "plan EXAMPLES/rectangles.json --start-strategy random --starts 8 --profile paper",
        "plan block.json --planner adam --starts 5 --start-strategy sorted --best",
        "bench --tasks mix.jsonl --starts 4 --timed 1 --planner gd --planner adam --planner stomp \
         --planner lbfgs --planner rrt-connect --planner shortest-path --planner auto",
        "bench --suite easy --count 15 --seeds 2,12,22 --profile paper --start-strategy paper \
         --starts 3 --timed 1 --planner gd",
        "shortest mix.jsonl",
    ] {
        let answer = |threads: usize| {
            let line = format!("{line} --json --quiet --threads {threads}");
            let outcome = crate::run(folder.path(), &line);
            assert!((0..2).contains(&outcome.code), "sidestep {line}\n{}", outcome.stderr);
            let mut answer = outcome.json();
            without_times(&mut answer);
            answer
        };
        let one = answer(1);
        assert_eq!(one, answer(2), "sidestep {line}");
        assert_eq!(one, answer(1), "sidestep {line}, again");
    }
}

#[test]
fn suites_do_not_depend_on_threads() {
    let folder = folder();
    for suite in ["easy", "hard", "hard-training", "mix", "time"] {
        let file = |threads: usize| {
            let out = format!("{suite}-{threads}.jsonl");
            let line = format!(
                "generate --suite {suite} --count 9 --seed 7 --threads {threads} --out {out}"
            );
            check(folder.path(), &line, 0, &["9 tasks"]);
            std::fs::read(folder.path().join(out)).unwrap()
        };
        assert_eq!(file(1), file(2), "{suite}");
    }
}

/// Frozen: the first tasks of a suite must never change, or figures of other days mean nothing.
#[test]
fn value_stability() {
    let folder = folder();
    check(folder.path(), "generate --suite easy --count 2 --seed 2 --out easy.jsonl", 0, &[]);
    let tasks = std::fs::read_to_string(folder.path().join("easy.jsonl")).unwrap();
    assert_eq!(tasks, include_str!("../fixtures/easy-seed-2.jsonl"));
}

#[test]
fn kernels_can_be_chosen_and_wide_ones_agree() {
    let folder = folder();
    let line = "generate --suite varied --count 40 --seed 7 --out varied.jsonl";
    check(folder.path(), line, 0, &[]);
    for planner in ["sidestep-1", "sidestep-1-small", "auto", "gd"] {
        let line =
            format!("bench --tasks varied.jsonl --timed 1 --planner {planner} --json --quiet");
        let answer = |kernels: &str| {
            let chosen = [("SIDESTEP_KERNELS", kernels)];
            let outcome = crate::run_with(folder.path(), &line, &chosen);
            assert_eq!(outcome.code, 0, "{kernels}: {}", outcome.stderr);
            let mut answer = outcome.json();
            without_times(&mut answer);
            answer
        };
        let wide = answer("avx2");
        assert_eq!(wide, answer("avx512"), "{planner}");
        // Without a network there is nothing that differs.
        let portable = answer("portable");
        assert!(planner != "gd" || portable == wide, "{planner}");
    }
    let chosen = [("SIDESTEP_KERNELS", "sse9")];
    let outcome = crate::run_with(folder.path(), "plan free.json", &chosen);
    assert_eq!(outcome.code, 2);
    assert!(outcome.stderr.contains("SIDESTEP_KERNELS"), "{}", outcome.stderr);
}
