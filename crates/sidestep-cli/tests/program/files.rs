//! Files and streams that do not behave: links, permissions, what a kill leaves, full and closed
//! outputs.

#![cfg(unix)]

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::process::Command;

use crate::{check, folder};

/// Runs `sidestep` with the words of `line` under a shell's `redirection`; the exit code and what
/// was said on standard output.
fn redirected(folder: &std::path::Path, line: &str, redirection: &str) -> (i32, String) {
    let program = env!("CARGO_BIN_EXE_sidestep");
    let output = Command::new("sh")
        .args(["-c", &format!("'{program}' {line} {redirection}")])
        .current_dir(folder)
        .output()
        .unwrap();
    (output.status.code().unwrap_or(-1), String::from_utf8(output.stdout).unwrap())
}

#[test]
fn closed_and_full_streams_are_no_panic() {
    let folder = folder();
    let bench = "bench --tasks free.json --planner gd --timed 1";
    for (line, redirection, code) in [
        ("plan free.json", "2>&-", 0),
        ("plan free.json", ">&-", 0),
        ("plan free.json", "2>/dev/full", 0),
        ("plan free.json --json", ">/dev/full 2>/dev/full", 2),
        ("plan wall.json --trace", "2>/dev/full", 1),
        ("plan nowhere.json", "2>/dev/full", 2),
        ("plan nowhere.json", "2>&-", 2),
        ("plan --no-such-flag", "2>/dev/full", 2),
        ("--help", ">/dev/full", 0),
        (bench, ">/dev/full", 2),
        (bench, "2>/dev/full", 0),
        ("generate --suite easy --count 3 --seed 1 --out t.jsonl", "2>/dev/full", 0),
        ("generate --suite easy --count 3 --seed 1 --out t.jsonl", "2>&-", 0),
    ] {
        let (found, _) = redirected(folder.path(), line, redirection);
        assert_eq!(found, code, "sidestep {line} {redirection}");
    }
}

#[test]
fn a_full_disk_after_a_measurement_still_shows_its_table() {
    let folder = folder();
    // Files may not grow at all.
    let line = "bench --tasks free.json --planner gd --timed 1 --out report.json";
    let program = env!("CARGO_BIN_EXE_sidestep");
    let output = Command::new("sh")
        .args(["-c", &format!("trap '' XFSZ; ulimit -f 0; '{program}' {line} | cat")])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let (shown, said) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(shown.contains("| `gd`"), "{shown}{said}");
    assert!(said.contains("report.json: cannot be written"), "{said}");
    assert!(!folder.path().join("report.json").exists());
}

#[test]
fn outputs_go_through_links_and_keep_permissions() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let mode = |name: &str| fs::metadata(path(name)).unwrap().permissions().mode() & 0o777;
    fs::create_dir(path("there")).unwrap();
    symlink("there/plan.json", path("dangling.json")).unwrap();
    symlink("dangling.json", path("twice.json")).unwrap();
    check(folder.path(), "plan free.json --out twice.json", 0, &[]);
    for link in ["dangling.json", "twice.json"] {
        assert!(fs::symlink_metadata(path(link)).unwrap().is_symlink(), "{link}");
    }
    assert!(fs::read_to_string(path("there/plan.json")).unwrap().contains("solved"));
    symlink("free.json", path("to-free.json")).unwrap();
    check(folder.path(), "plan free.json --out to-free.json", 2, &["which is read"]);
    symlink("circle.json", path("circle.json")).unwrap();
    check(folder.path(), "plan free.json --out circle.json", 2, &["circle of links"]);

    for umask in ["022", "077", "002"] {
        let (code, _) = redirected(folder.path(), "plan free.json --out new.json", "");
        assert_eq!(code, 0);
        fs::remove_file(path("new.json")).unwrap();
        let program = env!("CARGO_BIN_EXE_sidestep");
        let line = format!("umask {umask}; '{program}' plan free.json --out new.json");
        Command::new("sh").args(["-c", &line]).current_dir(folder.path()).output().unwrap();
        let expected = 0o666 & !u32::from_str_radix(umask, 8).unwrap();
        assert_eq!(mode("new.json"), expected, "umask {umask}");
    }
    fs::set_permissions(path("new.json"), fs::Permissions::from_mode(0o640)).unwrap();
    check(folder.path(), "plan free.json --out new.json", 0, &[]);
    assert_eq!(mode("new.json"), 0o640);
}

#[test]
fn what_a_killed_process_left_is_removed() {
    let folder = folder();
    let left_over = folder.path().join(".sidestep-AbCdEf");
    fs::write(&left_over, "half of a pl").unwrap();
    let held = folder.path().join(".sidestep-GhIjKl");
    let writing = fs::File::create(&held).unwrap();
    writing.lock().unwrap();
    check(folder.path(), "plan free.json --out plan.json", 0, &[]);
    assert!(!left_over.exists());
    assert!(held.exists(), "another process is still writing it");
}
