//! `train` and `experiment`: bad configurations and policies, and trainings that are broken off.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use std::{fs, thread};

use crate::{check, folder, run};

#[test]
fn bad_configurations() {
    let folder = folder();
    for (text, parts) in [
        ("seeed = 1\n", &["seeed", "seed"][..]),
        ("environment_steps = -1\n", &["environment_steps", "-1"]),
        ("seed = \"one\"\n", &["seed"]),
        ("seed = \n", &["line 1"]),
        ("[ppo]\nclipp = 0.2\n", &["ppo.clipp", "clip (the nearest known key)"]),
        ("ppo.steps = -40\n", &["ppo.steps", "-40"]),
        ("network.initialization = \"ortogonal\"\n", &["ortogonal", "orthogonal"]),
    ] {
        fs::write(folder.path().join("config.toml"), text).unwrap();
        let outcome = check(folder.path(), "train config.toml --out trained", 2, parts);
        assert!(outcome.stderr.starts_with("error: config.toml"), "{text}{}", outcome.stderr);
        assert_eq!(outcome.stdout, "", "{text}");
    }
    check(
        folder.path(),
        "train nowhere.toml --out trained",
        2,
        &["nowhere.toml", "cannot be read"],
    );
    check(folder.path(), "experiment nowhere.toml", 2, &["nowhere.toml", "cannot be read"]);
    assert!(!folder.path().join("trained").exists());
}

/// A training of about a second with something of everything: 2 epochs of cloning, 48 updates, validations.
pub const SMALL: &str = r#"
environment_steps = 19_200
network.hidden = 16
training = { suite = "mix", count = 10, seed = 1000 }
environment.episode_limit = 20
cloning = { epochs = 2, samples_per_task = 20 }
ppo = { environments = 10, steps = 40, schedule = "linear" }
validation = { count = 20, every = 5, steps = 30 }
"#;

/// Files that a training has to end with, whatever happened to it on the way.
const RESULTS: [&str; 3] = ["policy.safetensors", "metrics.jsonl", "config.toml"];

/// A folder with the configuration, and `whole`, where it was trained in one go.
fn trained_folder() -> tempfile::TempDir {
    let folder = folder();
    fs::write(folder.path().join("config.toml"), SMALL).unwrap();
    check(folder.path(), "train config.toml --out whole", 0, &["19200 steps"]);
    folder
}

fn check_same(folder: &Path, other: &str) {
    for name in RESULTS {
        let [whole, other] = ["whole", other].map(|out| fs::read(folder.join(out).join(name)));
        assert!(whole.unwrap() == other.unwrap(), "{name} differs");
    }
}

/// The names of a folder's files, sorted.
fn names(folder: &Path) -> Vec<std::ffi::OsString> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    names
}

/// Starts a training that stores its state after every unit, or goes on with it.
fn spawn(folder: &Path, out: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sidestep"));
    command.args(["train", "config.toml", "--checkpoint-every", "0", "--quiet", "--out", out]);
    if folder.join(out).join("checkpoint.safetensors").exists() {
        command.arg("--resume");
    }
    command.current_dir(folder).stderr(Stdio::null()).spawn().unwrap()
}

#[test]
fn a_training_that_is_killed_again_and_again_ends_with_the_same_policy() {
    let folder = trained_folder();
    let mut kills = 0;
    // Moments that fall into reading, training and writing; the last run is left alone.
    for round in 0_u64..12 {
        let mut child = spawn(folder.path(), "killed");
        thread::sleep(Duration::from_millis(20 + 37 * round % 130));
        let running = child.try_wait().unwrap().is_none();
        child.kill().unwrap();
        child.wait().unwrap();
        kills += u32::from(running);
    }
    assert!(kills >= 2, "killed {kills} times only");
    assert!(spawn(folder.path(), "killed").wait().unwrap().success());
    check_same(folder.path(), "killed");
}

#[test]
fn a_disk_that_is_full_ends_the_training_and_loses_no_checkpoint() {
    let folder = trained_folder();
    let out = folder.path().join("full");
    let mut child = spawn(folder.path(), "full");
    while !out.join("checkpoint.safetensors").exists() && child.try_wait().unwrap().is_none() {
        thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = fs::read(out.join("checkpoint.safetensors")).unwrap();
    // The kill may have left a temporary file, which the next run removes; a failed write may not.
    let mut names_before = names(&out);
    names_before.retain(|name| !name.to_string_lossy().starts_with(".sidestep-"));

    // Files may not grow beyond a few kilobytes: the next checkpoint cannot be written.
    let limited = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 16; exec \"$0\" \"$@\""])
        .arg(env!("CARGO_BIN_EXE_sidestep"))
        .args(["train", "config.toml", "--out", "full", "--resume", "--checkpoint-every", "0"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let message = String::from_utf8(limited.stderr).unwrap();
    assert_eq!(limited.status.code(), Some(2), "{message}");
    assert!(message.contains(": cannot be written (file too large)"), "{message}");
    assert!(fs::read(out.join("checkpoint.safetensors")).unwrap() == before);
    assert_eq!(names(&out), names_before);

    // With room again, the training goes on as if nothing had been.
    check(folder.path(), "train config.toml --out full --resume", 0, &[]);
    check_same(folder.path(), "full");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_named() {
    let folder = trained_folder();
    let out = folder.path().join("device");
    fs::create_dir(&out).unwrap();
    std::os::unix::fs::symlink("/dev/full", out.join("metrics.jsonl")).unwrap();
    let line = "train config.toml --out device";
    check(folder.path(), line, 2, &["device/metrics.jsonl", "No space left on device"]);
}

#[test]
fn damaged_checkpoints_and_other_configurations_are_refused() {
    let folder = trained_folder();
    let again = "train config.toml --out whole";
    check(folder.path(), again, 2, &["holds a training already", "--resume"]);
    let other = "train config.toml --out whole --resume --seed 3";
    check(folder.path(), other, 2, &["seed: 3", "expected 0, which the checkpoint was made with"]);
    let path = folder.path().join("whole/checkpoint.safetensors");
    let mut bytes = fs::read(&path).unwrap();
    let resume = "train config.toml --out whole --resume";
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    check(folder.path(), resume, 2, &["checkpoint.safetensors", "complete safetensors file"]);
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(&path, &bytes).unwrap();
    check(folder.path(), resume, 2, &["checkpoint.safetensors", "checksum", "damaged"]);
    let nowhere = "train config.toml --out nowhere --resume";
    check(folder.path(), nowhere, 2, &["nowhere", "no checkpoint", "leave --resume out"]);
}

#[test]
fn settings_are_set_and_a_training_begins_from_a_policy() {
    let folder = trained_folder();
    let set = "train config.toml --out set --set seed=0 --set training.suite=mix";
    check(folder.path(), set, 0, &["19200 steps", "best on validation"]);
    check_same(folder.path(), "set");
    let wrong = "train config.toml --out x --set ppo.stps=3";
    check(folder.path(), wrong, 2, &["config.toml with --set", "ppo.stps", "steps (the nearest"]);
    check(folder.path(), "train config.toml --out x --set seed", 2, &["--set", "KEY=VALUE"]);
    check(folder.path(), "train config.toml --out x --set ppo.clip=9", 2, &["ppo.clip: 9"]);
    let init =
        "train config.toml --out init --init whole/policy.safetensors --set cloning.epochs=0";
    check(folder.path(), &format!("{init} --set environment_steps=800"), 0, &["800 steps"]);
    let other = init.replace("--out init", "--out other") + " --set network.hidden=8";
    check(folder.path(), &other, 2, &["--init: sizes: [20, 16, 16, 20]"]);
    let last = "train config.toml --out last --set validation.count=0";
    check(folder.path(), last, 0, &["nothing was validated"]);
}

#[test]
fn a_folder_is_one_trainings_at_a_time() {
    let folder = folder();
    fs::write(folder.path().join("config.toml"), SMALL).unwrap();
    let mut first = spawn(folder.path(), "both");
    let lock = folder.path().join("both/.lock");
    while fs::read_to_string(&lock).unwrap_or_default().is_empty() {
        thread::sleep(Duration::from_millis(1));
    }
    let second = "train config.toml --out both";
    let process = format!("process {}", first.id());
    check(folder.path(), second, 2, &["both: is being written by another run", &process]);
    // The lock of a dead process is nobody's.
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(spawn(folder.path(), "both").wait().unwrap().success());
}

#[cfg(unix)]
#[test]
fn ctrl_c_stores_the_state_and_says_how_to_go_on() {
    let folder = trained_folder();
    for (round, wait) in [0, 150].into_iter().enumerate() {
        let out = format!("stopped-{round}");
        let child = Command::new(env!("CARGO_BIN_EXE_sidestep"))
            .args(["train", "config.toml", "--out", &out, "--set", "environment_steps=1000000"])
            .current_dir(folder.path())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lock = folder.path().join(&out).join(".lock");
        while !lock.exists() {
            thread::sleep(Duration::from_millis(1));
        }
        thread::sleep(Duration::from_millis(wait));
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        let ended = child.wait_with_output().unwrap();
        let message = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(130), "{message}");
        assert!(message.contains("stopped after unit"), "{message}");
        assert!(message.contains(&format!("--out {out} --resume")), "{message}");
        let resume = format!("train {out}/config.toml --out {out} --resume");
        let fewer = format!("{resume} --set environment_steps=19200");
        check(folder.path(), &fewer, 2, &["environment_steps: 19200", "expected 1000000"]);
    }
}

#[test]
fn divergence_ends_with_a_whole_state_and_resuming_says_so_again() {
    let folder = folder();
    let diverging = SMALL.replace(
        "cloning = { epochs = 2,",
        "cloning = { epochs = 2, optimizer = \"adam\", learning_rate = 1000, prediction = \"sampled\",",
    );
    fs::write(folder.path().join("config.toml"), diverging).unwrap();
    let parts = ["the training diverged: after unit", "not finite; try a", "best on validation"];
    check(folder.path(), "train config.toml --out d", 1, &parts);
    check(folder.path(), "train config.toml --out d --resume", 1, &parts);
    let json = check(folder.path(), "train config.toml --out d --resume --json", 1, &[]).json();
    assert_eq!(json["outcome"], "diverged");
    let checkpoint = fs::read(folder.path().join("d/checkpoint.safetensors")).unwrap();
    let text = String::from_utf8_lossy(&checkpoint);
    assert!(text.contains("sidestep.checkpoint/2") && !text.contains("NaN"));
}

#[test]
fn bad_policy_files() {
    let folder = trained_folder();
    let good = fs::read(folder.path().join("whole/policy.safetensors")).unwrap();
    let replaced = |from: &[u8], to: &[u8]| {
        let at = good.windows(from.len()).position(|window| window == from).unwrap();
        [&good[..at], to, &good[at + from.len()..]].concat()
    };
    let mut not_finite = good.clone();
    let last = good.len() - 4;
    not_finite[last..].copy_from_slice(&f32::NAN.to_le_bytes());
    let rows: [(Vec<u8>, &[&str]); 8] = [
        (Vec::new(), &["0 bytes", "complete safetensors file"]),
        (good[..good.len() - 1].to_vec(), &["complete safetensors file"]),
        (good[..good.len() / 2].to_vec(), &["complete safetensors file"]),
        ([&good[..], &[0; 64]].concat(), &["complete safetensors file"]),
        (vec![0xff; 4096], &["complete safetensors file"]),
        (replaced(b"sidestep.policy/1", b"sidestep.policy/9"), &["sidestep.policy/9", "policy/1"]),
        (replaced(b"[20,16,16,20]", b"[20,16,17,20]"), &["checksum", "it is damaged"]),
        (not_finite, &["checksum", "it is damaged"]),
    ];
    for (bytes, parts) in rows {
        fs::write(folder.path().join("bad.safetensors"), bytes).unwrap();
        let line = "plan free.json --planner learned:bad.safetensors --profile paper";
        let outcome = check(folder.path(), line, 2, parts);
        assert!(outcome.stderr.starts_with("error: bad.safetensors: "), "{}", outcome.stderr);
        assert_eq!(outcome.stdout, "");
    }
    let good = "plan free.json --planner learned:whole/policy.safetensors --profile paper";
    assert!(run(folder.path(), good).code < 2);
    let waypoints = format!("{good} --waypoints 12");
    check(folder.path(), &waypoints, 2, &["waypoints", "10, which the policy was trained for"]);
}
