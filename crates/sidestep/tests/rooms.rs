//! The house has rooms, and imports run down: see ARCHITECTURE.md, code map.
#![allow(clippy::unwrap_used, reason = "a test")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// From the ground up: a room imports only what stands before it.
const ROOMS: [&str; 15] = [
    "error",
    "rng",
    "kernels",
    "profile",
    "trajectory",
    "network",
    "plane",
    "space",
    "arm",
    "scene",
    "objective",
    "policy",
    "optimizer",
    "plan",
    "suite",
];

/// What only `plane/` may say, for it alone knows that a configuration has two numbers.
const PLANAR: [&str; 3] = ["as_chunks::<2>", "as_chunks_mut::<2>", "geometry::"];

/// The generator draws the paper's fields, and `PlaneTask` hands out what a task in the plane is made of.
const MAY_SAY_IT: [&str; 4] =
    ["suite/mod.rs", "suite/pictured.rs", "suite/queries.rs", "scene/task.rs"];

fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, out);
        } else if path.extension().is_some_and(|e| e == "rs") {
            out.push(path);
        }
    }
    out.sort();
}

/// The code of a file without its tests and comments.
fn code(path: &Path) -> String {
    let text = fs::read_to_string(path).unwrap();
    let own = text.split("\n#[cfg(test)]\nmod ").next().unwrap();
    let lines = own.lines().map(|line| line.split("//").next().unwrap());
    lines.collect::<Vec<_>>().join("\n")
}

/// Each file that is no test, by its path below `src`, with its code.
fn sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut paths = Vec::new();
    files(&root, &mut paths);
    let name = |path: &Path| {
        let parts: Vec<_> = path.strip_prefix(&root).unwrap().iter().collect();
        parts.iter().map(|part| part.to_str().unwrap()).collect::<Vec<_>>().join("/")
    };
    let named = paths.iter().map(|path| (name(path), code(path)));
    named.filter(|(name, _)| !name.ends_with("tests.rs") && name != "lib.rs").collect()
}

fn room(file: &str) -> &str {
    file.split('/').next().unwrap().trim_end_matches(".rs")
}

/// What follows `crate::` in a file, first names only.
fn imports(code: &str) -> BTreeSet<String> {
    let names = code.split("crate::").skip(1).filter(|rest| !rest.starts_with("kernels::AVX"));
    let word = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    names.map(word).collect()
}

#[test]
fn every_file_has_its_room() {
    let found: BTreeSet<String> = sources().iter().map(|(file, _)| room(file).into()).collect();
    let listed = ROOMS.iter().map(|room| (*room).to_owned()).collect();
    assert_eq!(found, listed, "rooms of src, and rooms in this list");
}

#[test]
fn imports_run_down() {
    let floor = |room: &str| ROOMS.iter().position(|known| *known == room);
    let mut faults = Vec::new();
    for (file, code) in sources() {
        for import in imports(&code) {
            // A name without a room would be one that the root hands on.
            let is_below = floor(&import).is_some_and(|to| Some(to) <= floor(room(&file)));
            if !is_below {
                faults.push(format!("{file} imports crate::{import}"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn only_the_plane_knows_points() {
    let mut faults = Vec::new();
    for (file, code) in sources() {
        if room(&file) != "plane" && !MAY_SAY_IT.contains(&file.as_str()) {
            let said = PLANAR.iter().filter(|word| code.contains(*word));
            faults.extend(said.map(|word| format!("{file} says {word}")));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn files_are_small() {
    let long = sources().into_iter().filter(|(_, code)| code.lines().count() > 400);
    let long: Vec<String> = long.map(|(file, _)| file).collect();
    assert!(long.is_empty(), "more than one idea: {long:?}");
}
