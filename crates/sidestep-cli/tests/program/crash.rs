//! The program killed at random moments, on a full disk, with too few files, and with flipped bits.
//!
//! `KILLS` sets how many kills there are in all (12 by default); `scripts/crash 200` asks for more.

use std::fs;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::Duration;

use rand::RngExt;
use sidestep::rng::{Purpose, stream};

use crate::train::SMALL;
use crate::{check, folder, run};

/// A training of the other kind, of a second or so too.
const WAYPOINT: &str = r#"
architecture = "waypoint"
observation = ["waypoints", "probes:4x0.5,1.5"]
network = { width = 16, dilations = [1] }
imitation = { tasks = 4, steps = 3 }
validation = { count = 5, every = 4 }
[[stages]]
kind = "imitation"
updates = 40
learning_rate = 1e-3
"#;

fn kills() -> u64 {
    std::env::var("KILLS").map_or(12, |text| text.parse().unwrap())
}

/// Runs a line of shell, and kills it with everything that it started after so long.
fn killed_after(folder: &Path, line: &str, limit: Duration) -> ExitStatus {
    let path = Path::new(env!("CARGO_BIN_EXE_sidestep")).parent().unwrap();
    let mut shell = Command::new("sh")
        .args(["-c", line])
        .current_dir(folder)
        .env("PATH", format!("{}:{}", path.display(), std::env::var("PATH").unwrap()))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .process_group(0)
        .spawn()
        .unwrap();
    std::thread::sleep(limit);
    let group = format!("kill -KILL -{} 2>/dev/null", shell.id());
    Command::new("sh").args(["-c", &group]).status().unwrap();
    shell.wait().unwrap()
}

/// What killed programs may leave behind only until the next one. The file that a training's folder is
/// locked by stays: the lock is on the file, not its being there.
fn check_nothing_left(folder: &Path) {
    let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let hidden = names.filter(|name| name.to_string_lossy().starts_with('.'));
    let left: Vec<_> = hidden.filter(|name| name != ".lock").collect();
    assert!(left.is_empty(), "{left:?}");
}

#[test]
fn killed_trainings_go_on_to_the_same_bits() {
    for (kind, config) in [("paper", SMALL), ("waypoint", WAYPOINT)] {
        let folder = folder();
        let folder = folder.path();
        fs::write(folder.join("config.toml"), config).unwrap();
        check(folder, "train config.toml --out whole --quiet", 0, &[]);
        let mut rng = stream(0, Purpose::Query, 0, 0);
        let mut left = kills().div_ceil(2);
        for number in 0.. {
            let out = format!("killed-{number}");
            // A training is killed up to five times and then finished.
            for _ in 0..left.min(5) {
                let resume = folder.join(&out).join("checkpoint.safetensors").exists();
                let resume = if resume { "--resume" } else { "" };
                let line = format!(
                    "exec sidestep train config.toml --out {out} {resume} --checkpoint-every 0"
                );
                let limit = Duration::from_millis(rng.random_range(5..600));
                killed_after(folder, &line, limit);
                left -= 1;
            }
            let resume = folder.join(&out).join("checkpoint.safetensors").exists();
            let resume = if resume { "--resume" } else { "" };
            check(folder, &format!("train config.toml --out {out} {resume} --quiet"), 0, &[]);
            let [whole, killed] = ["whole", &out].map(|out| folder.join(out));
            for file in ["policy.safetensors", "metrics.jsonl", "config.toml"] {
                let [whole, killed] = [&whole, &killed].map(|f| fs::read(f.join(file)).unwrap());
                assert!(whole == killed, "{kind}, {out}: another {file}");
            }
            check_nothing_left(&killed);
            if left == 0 {
                break;
            }
        }
    }
}

#[test]
fn killed_programs_leave_whole_files_or_none() {
    let folder = folder();
    let folder = folder.path();
    let mut rng = stream(0, Purpose::Query, 1, 0);
    let lines = [
        "exec sidestep generate --suite easy --count 400 --seed 1 --out tasks.jsonl",
        "exec sidestep plan block.json --out plan.json --png plan.png --svg plan.svg",
        "exec sidestep bench --tasks block.json --planner gd --timed 1 --out report.json",
    ];
    for number in 0..kills() {
        let limit = Duration::from_millis(rng.random_range(1..60));
        killed_after(folder, lines[(number % 3) as usize], limit);
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            let bytes = fs::read(&path).unwrap();
            let ends = match name {
                "tasks.jsonl" | "plan.json" | "report.json" => bytes.ends_with(b"\n"),
                "plan.svg" => bytes.ends_with(b"</svg>\n"),
                "plan.png" => bytes.ends_with(b"IEND\xae\x42\x60\x82"),
                _ => true,
            };
            assert!(ends, "{name} is cut at {} bytes", bytes.len());
        }
    }
    check(folder, "plan block.json --out plan.json", 0, &[]);
    check_nothing_left(folder);
}

#[test]
fn a_flipped_bit_is_found() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("config.toml"), SMALL.replace("19_200", "1_200")).unwrap();
    check(folder, "train config.toml --out run --quiet", 0, &[]);
    let mut rng = stream(0, Purpose::Query, 2, 0);
    for name in ["checkpoint", "policy"] {
        let file = format!("run/{name}.safetensors");
        let whole = fs::read(folder.join(&file)).unwrap();
        for _ in 0..kills().clamp(12, 100) {
            let mut bytes = whole.clone();
            let at = rng.random_range(0..bytes.len());
            bytes[at] ^= 1 << rng.random_range(0..8);
            fs::write(folder.join(&file), &bytes).unwrap();
            let line = match name {
                "checkpoint" => "train config.toml --out run --resume --quiet".to_string(),
                _ => format!("plan block.json --planner learned:{file}"),
            };
            let outcome = run(folder, &line);
            assert_eq!(outcome.code, 2, "{file}, byte {at}\n{}", outcome.stderr);
            assert!(outcome.stderr.starts_with("error: "), "{file}: {}", outcome.stderr);
            fs::write(folder.join(&file), &whole).unwrap();
        }
    }
}

#[test]
fn a_full_disk_costs_nothing_that_was_there() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("config.toml"), SMALL).unwrap();
    check(folder, "train config.toml --out whole --quiet", 0, &[]);
    let line = "exec sidestep train config.toml --out full --checkpoint-every 0";
    killed_after(folder, line, Duration::from_millis(400));
    // Files of at most 512 bytes, without the signal that would end the process.
    let full = "trap '' XFSZ; ulimit -f 1; exec sidestep train config.toml --out full --resume";
    killed_after(folder, full, Duration::from_secs(3));
    let resume = folder.join("full/checkpoint.safetensors").exists();
    let resume = if resume { "--resume" } else { "" };
    check(folder, &format!("train config.toml --out full {resume} --quiet"), 0, &[]);
    let [whole, full] = ["whole", "full"].map(|out| folder.join(out).join("policy.safetensors"));
    assert!(fs::read(whole).unwrap() == fs::read(full).unwrap());
    check_nothing_left(&folder.join("full"));
}

#[test]
fn few_files_and_little_memory_are_told() {
    let folder = folder();
    for limit in ["ulimit -n 3", "ulimit -n 4", "ulimit -n 6", "ulimit -v 20000", "ulimit -v 40000"]
    {
        let line = format!("{limit}; exec sidestep plan block.json --out plan.json --png plan.png");
        let path = Path::new(env!("CARGO_BIN_EXE_sidestep")).parent().unwrap();
        let output = Command::new("sh")
            .args(["-c", &line])
            .current_dir(folder.path())
            .env("PATH", format!("{}:{}", path.display(), std::env::var("PATH").unwrap()))
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(!told.contains("panicked"), "{limit}: {told}");
        // Where there is no memory to say so with, the system ends the process.
        if limit.starts_with("ulimit -n") {
            assert!(matches!(output.status.code(), Some(0 | 2 | 127)), "{limit}: {told}");
        }
    }
}
