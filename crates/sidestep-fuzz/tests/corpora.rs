//! The fuzzers' corpora on stable Rust: every input, and some thousand changes of them.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use sidestep::rng::{Purpose, stream};
use sidestep_fuzz::mutation::mutate;
use sidestep_fuzz::{TARGETS, Target};

use rand::RngExt;

/// Changed inputs of each target.
const CHANGED: u64 = 1000;
/// Longest that one input may take; debug assertions and a busy machine included.
const LONGEST: Duration = Duration::from_secs(10);

fn corpus(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(name);
    let mut files: Vec<_> = fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert!(!files.is_empty(), "{}: empty", folder.display());
    files.iter().map(|file| fs::read(file).unwrap()).collect()
}

fn check(target: &Target, input: &[u8]) {
    let begin = Instant::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| (target.run)(input)));
    let shown = input.escape_ascii();
    assert!(outcome.is_ok(), "{} fails on b\"{shown}\"", target.name);
    assert!(begin.elapsed() < LONGEST, "{} takes long on b\"{shown}\"", target.name);
}

#[test]
fn every_input_of_every_corpus() {
    for target in &TARGETS {
        corpus(target.name).iter().for_each(|input| check(target, input));
    }
}

#[test]
fn changed_inputs() {
    for (index, target) in TARGETS.iter().enumerate() {
        let inputs = corpus(target.name);
        for number in 0..CHANGED {
            let mut rng = stream(0, Purpose::Query, index as u64, number);
            let [one, other] = [(); 2].map(|()| &inputs[rng.random_range(0..inputs.len())]);
            check(target, &mutate(one, other, target.longest, &mut rng));
        }
    }
}
