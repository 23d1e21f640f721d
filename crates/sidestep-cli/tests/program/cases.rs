//! Every case of `tests/cases` against the program: inputs that once broke it, each with what is right.
//!
//! A case is a folder with its inputs and a `case.toml`: what it shows, files too large to keep and
//! therefore made, and runs. A run is a line of shell as a person types it, with limits of processor
//! time and of address space, so that a case that breaks them fails instead of taking the machine along.
//! `CASE=NAME` runs one case alone.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use serde::Deserialize;
use serde_json::Value;

/// Cases that are not answered rightly yet, and who mends them. A case that is mended has to go from here.
const NOT_YET: [(&str, &str); 0] = [];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    /// What it shows, in a sentence.
    about: String,
    #[serde(default)]
    file: Vec<Made>,
    run: Vec<Run>,
}

/// A file of `count` times `each`, in which `{i}` is the number from 0.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Made {
    name: String,
    #[serde(default)]
    before: String,
    each: String,
    #[serde(default)]
    between: String,
    count: usize,
    #[serde(default)]
    after: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Run {
    line: String,
    /// Exit codes that are right.
    #[serde(default = "zero")]
    exit: Vec<i32>,
    /// What standard output and error together hold, and what they do not.
    #[serde(default)]
    has: Vec<String>,
    #[serde(default)]
    lacks: Vec<String>,
    /// Whether standard output is exactly one JSON document; `json` asks for that too.
    #[serde(default)]
    document: bool,
    /// Values by JSON pointer; numbers to six digits, `"null"` for null.
    #[serde(default)]
    json: BTreeMap<String, Value>,
    #[serde(default)]
    differ: Option<Differ>,
    /// Processor time, seconds, of the whole line.
    #[serde(default = "ten")]
    seconds: u32,
    /// Address space of each of its programs, MB.
    #[serde(default = "six_hundred")]
    megabytes: u32,
}

/// Two points of a picture, as shares of width and height from the upper left, that differ in colour.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Differ {
    file: String,
    first: [f64; 2],
    second: [f64; 2],
}

fn zero() -> Vec<i32> {
    vec![0]
}

fn ten() -> u32 {
    10
}

fn six_hundred() -> u32 {
    600
}

/// What is wrong with the answers to a case, one sentence a fault.
fn faults(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join("case.toml")).unwrap();
    let case: Case = toml::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    assert!(!case.about.is_empty() && !case.run.is_empty(), "{}", folder.display());
    let place = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, place.path().join(path.file_name().unwrap())).unwrap();
    }
    for made in &case.file {
        let parts: Vec<_> =
            (0..made.count).map(|i| made.each.replace("{i}", &i.to_string())).collect();
        let text = [&made.before, parts.join(&made.between).as_str(), &made.after].concat();
        fs::write(place.path().join(&made.name), text).unwrap();
    }
    case.run.iter().flat_map(|run| faults_of_run(run, place.path())).collect()
}

fn faults_of_run(run: &Run, place: &Path) -> Vec<String> {
    let program = Path::new(env!("CARGO_BIN_EXE_sidestep")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    // Address space cannot be limited everywhere; where it cannot, the other limits still hold.
    let limits = format!(
        "ulimit -t {} || exit 99; ulimit -v {} 2>/dev/null; {}",
        run.seconds,
        run.megabytes * 1024,
        run.line
    );
    let told = tempfile::tempdir().unwrap();
    let [stdout, stderr] = ["stdout", "stderr"].map(|name| told.path().join(name));
    let mut shell = Command::new("sh")
        .args(["-c", &limits])
        .current_dir(place)
        .env("PATH", path)
        // Arenas for each thread count as address space though nothing lies in them.
        .env("MALLOC_ARENA_MAX", "2")
        .stdin(Stdio::null())
        .stdout(fs::File::create(&stdout).unwrap())
        .stderr(fs::File::create(&stderr).unwrap())
        .process_group(0)
        .spawn()
        .unwrap();
    let status = wait(&mut shell, Duration::from_secs(u64::from(10 + 4 * run.seconds)));
    let [stdout, stderr] = [stdout, stderr].map(|file| fs::read(file).unwrap());
    let stdout = String::from_utf8_lossy(&stdout);
    let told = format!("{stdout}{}", String::from_utf8_lossy(&stderr));
    let shown: String = told.chars().take(1000).collect();
    let mut faults = Vec::new();
    let mut fault = |what: String| faults.push(format!("{}\n    {what}\n    {shown}", run.line));
    match status.map(|status| status.code()) {
        Some(Some(code)) if run.exit.contains(&code) => {}
        Some(Some(code)) => fault(format!("exit code {code}, not of {:?}", run.exit)),
        Some(None) => fault("ended by a signal".into()),
        None => fault("waited for without end".into()),
    }
    if told.contains("panicked") || told.contains("RUST_BACKTRACE") {
        fault("a panic".into());
    }
    for part in run.has.iter().filter(|part| !told.contains(part.as_str())) {
        fault(format!("lacks {part:?}"));
    }
    for part in run.lacks.iter().filter(|part| told.contains(part.as_str())) {
        fault(format!("has {part:?}"));
    }
    if run.document || !run.json.is_empty() {
        match serde_json::from_str::<Value>(&stdout) {
            Err(error) => fault(format!("standard output is not one JSON document: {error}")),
            Ok(document) => {
                for (pointer, right) in &run.json {
                    match document.pointer(pointer) {
                        Some(got) if agrees(got, right) => {}
                        Some(got) => fault(format!("{pointer} is {got}, not {right}")),
                        None => fault(format!("no {pointer}")),
                    }
                }
            }
        }
    }
    if let Some(differ) = &run.differ
        && pixel(&place.join(&differ.file), differ.first)
            == pixel(&place.join(&differ.file), differ.second)
    {
        fault(format!("{:?} and {:?} have one colour", differ.first, differ.second));
    }
    faults
}

/// Waits until the shell ends; past the limit everything that it started is killed, and there is nothing.
fn wait(shell: &mut Child, limit: Duration) -> Option<ExitStatus> {
    let begin = Instant::now();
    while begin.elapsed() < limit {
        if let Some(status) = shell.try_wait().unwrap() {
            return Some(status);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    // The shell is the first of its group, so that the group has its number.
    let group = format!("kill -KILL -{}", shell.id());
    Command::new("sh").args(["-c", &group]).status().unwrap();
    shell.wait().unwrap();
    None
}

fn agrees(got: &Value, right: &Value) -> bool {
    match (got.as_f64(), right.as_f64()) {
        (Some(got), Some(right)) => (got - right).abs() <= 1e-6 * right.abs().max(1.0),
        _ => got == right || got.is_null() && right == "null",
    }
}

/// The colour at a place of a PNG; nothing where there is no such file.
fn pixel(file: &Path, at: [f64; 2]) -> Option<Vec<u8>> {
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(file).ok()?));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let [x, y] =
        [(at[0], info.width), (at[1], info.height)].map(|(s, n)| (s * f64::from(n)) as usize);
    let bytes = info.line_size / info.width as usize;
    let first = y * info.line_size + x * bytes;
    Some(pixels[first..first + bytes].to_vec())
}

fn cases() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let mut cases: Vec<_> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    cases.sort();
    cases
}

#[test]
fn every_case_is_answered_rightly() {
    let one = std::env::var("CASE").ok();
    let cases: Vec<_> = cases()
        .into_iter()
        .filter(|folder| one.as_ref().is_none_or(|one| folder.ends_with(one)))
        .collect();
    assert!(!cases.is_empty(), "no case of that name");
    let next = AtomicUsize::new(0);
    let wrong = Mutex::new(Vec::new());
    let work = || {
        while let Some(folder) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            wrong.lock().unwrap().extend(judge(folder));
        }
    };
    std::thread::scope(|scope| (0..4).for_each(|_| drop(scope.spawn(work))));
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "{} faults\n{}", wrong.len(), wrong.join("\n"));
}

/// What is wrong with a case: its faults, or that it has none though it is on the list.
fn judge(folder: &Path) -> Vec<String> {
    let name = folder.file_name().unwrap().to_str().unwrap();
    let faults = faults(folder);
    match NOT_YET.iter().find(|(case, _)| *case == name) {
        Some((_, owner)) if faults.is_empty() => {
            vec![format!("{name} is right now: take it off the list ({owner})")]
        }
        Some(_) => Vec::new(),
        None => faults.iter().map(|fault| format!("{name}: {fault}")).collect(),
    }
}

#[test]
fn every_case_not_answered_yet_exists() {
    let names: Vec<_> =
        cases().iter().map(|c| c.file_name().unwrap().to_str().unwrap().to_owned()).collect();
    for (name, _) in NOT_YET {
        assert!(names.iter().any(|n| n == name), "no case {name}");
    }
}
