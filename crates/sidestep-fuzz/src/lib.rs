//! What the fuzzers run, as plain functions of bytes, for libFuzzer (`fuzz/` at the repository's root)
//! and for tests that replay its corpora. A target panics where the program is wrong: on bytes that make
//! a reader panic or read its own writing otherwise, and on answers that contradict each other.
//!
//! Targets start no threads, open no files, and hold no state between calls.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a panic is what a fuzzer looks for")]

pub mod mutation;
mod planning;
mod readers;
mod robots;
mod training;

/// A target: its name, which is its corpus folder's too, and its body.
pub struct Target {
    /// Name.
    pub name: &'static str,
    /// Runs it on one input.
    pub run: fn(&[u8]),
    /// Inputs longer than this, in bytes, show nothing that shorter ones do not.
    pub longest: usize,
}

/// All targets.
pub const TARGETS: [Target; 23] = [
    Target { name: "task_json", run: readers::task_json, longest: 4096 },
    Target { name: "task_lines", run: readers::task_lines, longest: 4096 },
    Target { name: "barn", run: readers::barn, longest: 2048 },
    Target { name: "mpnet", run: readers::mpnet, longest: 2048 },
    Target { name: "movingai_map", run: readers::movingai_map, longest: 1024 },
    Target { name: "movingai_scen", run: readers::movingai_scen, longest: 1024 },
    Target { name: "ros_yaml", run: readers::ros_yaml, longest: 1024 },
    Target { name: "pgm", run: readers::pgm, longest: 1024 },
    Target { name: "png", run: readers::png, longest: 2048 },
    Target { name: "picture", run: readers::picture, longest: 2048 },
    Target { name: "any_file", run: readers::any_file, longest: 2048 },
    Target { name: "policy", run: training::policy, longest: 32_768 },
    Target { name: "checkpoint", run: training::checkpoint, longest: 32_768 },
    Target { name: "recipe", run: training::recipe, longest: 1024 },
    Target { name: "names", run: training::names, longest: 128 },
    Target { name: "urdf", run: robots::urdf, longest: 4096 },
    Target { name: "srdf", run: robots::srdf, longest: 2048 },
    Target { name: "robot_file", run: robots::robot_file, longest: 4096 },
    Target { name: "scene", run: robots::scene, longest: 2048 },
    Target { name: "problems", run: robots::problems, longest: 4096 },
    Target { name: "plan_document", run: robots::plan_document, longest: 2048 },
    Target { name: "path_csv", run: readers::path_csv, longest: 1024 },
    Target { name: "planning", run: planning::planning, longest: 256 },
];

/// The target of a name.
///
/// # Panics
/// If there is none.
pub fn target(name: &str) -> &'static Target {
    TARGETS.iter().find(|target| target.name == name).unwrap()
}
