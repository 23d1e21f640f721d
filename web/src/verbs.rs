//! What a page may ask.
//!
//! | `verb` | takes | gives |
//! | --- | --- | --- |
//! | `read` | `files`: names and sizes, the first the one to read, the others what it may name | `tasks`, JSON each, and `warnings` |
//! | `suite` | `suite`, `seed`, `index` | `tasks`, one |
//! | `plan` | `task`, `planners`, `starts`, `steps`, `seed`, `margin`, perhaps `untraced`; `files`: policies as `learned:NAME` | `replay`, and `plans` as `sidestep plan --out` writes them |
//! | `page` | the same | `html`, a page of its own |
//! | `train` | `seed` | begins a training: `units` |
//! | `train-on` | `units` | `training.rs` |
//!
//! An answer is `{"ok": ..}` or `{"error": "words"}`.

use std::sync::Arc;
use std::time::Duration;

use serde::Deserialize;
use serde_json::{Value, json};
use sidestep::plan::ends::plan_with_margin;
use sidestep::plan::run::Iteration;
use sidestep::plan::{Options, Planner, Watch, parse_planner, reason};
use sidestep::plane::Robot;
use sidestep::policy::Policy;
use sidestep::scene::Query;
use sidestep::suite::Suite;
use sidestep::suite::queries::random_queries;
use sidestep::{InvalidInput, Profile, Task};
use sidestep_io::input::{Content, Question};
use sidestep_io::plan_json::{PlanDocument, Trace};
use sidestep_io::replay::{self, Replay, Run};
use sidestep_io::task_json::{TaskFormat, read_tasks, write_task};

use crate::{now, training};

/// Most tasks of a file that are listed.
const MOST_TASKS: usize = 500;
/// Most obstacles of a task: what is drawn and planned at once in a page.
const MOST_OBSTACLES: usize = 2_000;
/// Most starts and steps, panels, and iterates that are kept of a planner.
const MOST_STARTS: usize = 64;
const MOST_STEPS: usize = 2_000;
const MOST_PLANNERS: usize = 4;
const MOST_ITERATES: usize = 4_000;

#[derive(Deserialize)]
#[serde(tag = "verb", rename_all = "kebab-case", deny_unknown_fields)]
enum Request {
    Read { files: Vec<File> },
    Suite { suite: String, seed: u64, index: usize },
    Plan(Asked),
    Page(Asked),
    Train { seed: u64 },
    TrainOn { units: usize },
}

#[derive(Deserialize)]
struct File {
    name: String,
    bytes: usize,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    task: String,
    planners: Vec<String>,
    starts: usize,
    steps: usize,
    seed: u64,
    margin: f64,
    /// Without iterates: for timing.
    #[serde(default)]
    untraced: bool,
    #[serde(default)]
    files: Vec<File>,
}

/// Answers a request.
pub(crate) fn answer(text: &[u8], files: &[u8]) -> String {
    let answered = serde_json::from_slice(text)
        .map_err(|error| format!("request: {error}"))
        .and_then(|request| answered(request, files));
    match answered {
        Ok(value) => json!({ "ok": value }).to_string(),
        Err(words) => json!({ "error": words }).to_string(),
    }
}

fn answered(request: Request, bytes: &[u8]) -> Result<Value, String> {
    match request {
        Request::Read { files } => read(&split(&files, bytes)?),
        Request::Suite { suite, seed, index } => {
            let suite: Suite = suite.parse().map_err(words)?;
            if index >= MOST_TASKS {
                return Err(format!("index: {index} is not below {MOST_TASKS}"));
            }
            let task = suite.generate(index + 1, seed, &Profile::PAPER).pop();
            let mut task = task.ok_or("the suite has no such task")?;
            task.name = format!("{} {seed}/{index}", suite.name());
            Ok(json!({ "tasks": [write_task(&task).map_err(words)?], "warnings": [] }))
        }
        Request::Plan(asked) => planned(
            &asked,
            bytes,
            |replay, query, plans| json!({ "replay": replay.data(replay::far(query)), "plans": plans }),
        ),
        Request::Page(asked) => planned(
            &asked,
            bytes,
            |replay, query, _| json!({ "html": replay.to_html(replay::far(query)) }),
        ),
        Request::Train { seed } => training::begin(seed),
        Request::TrainOn { units } => training::go_on(units),
    }
}

fn words(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// The files behind a request's text.
fn split<'a>(files: &'a [File], mut bytes: &'a [u8]) -> Result<Vec<(&'a str, &'a [u8])>, String> {
    let mut found = Vec::new();
    for File { name, bytes: count } in files {
        let (own, rest) = bytes.split_at_checked(*count).ok_or("files: fewer bytes than named")?;
        found.push((name.as_str(), own));
        bytes = rest;
    }
    Ok(found)
}

fn read(files: &[(&str, &[u8])]) -> Result<Value, String> {
    let Some((name, bytes)) = files.first() else { return Err("files: none".into()) };
    let mut load = |wanted: &str| {
        let wanted = wanted.rsplit(['/', '\\']).next().unwrap_or(wanted);
        let found = files.iter().find(|(name, _)| *name == wanted);
        let missing = || {
            let text = format!("{wanted} belongs to it: drop both at once");
            std::io::Error::new(std::io::ErrorKind::NotFound, text)
        };
        found.map(|(_, bytes)| bytes.to_vec()).ok_or_else(missing)
    };
    let input = sidestep_io::input::read(name, bytes, &Question::default(), &mut load)
        .map_err(|error| format!("{name}: {error}"))?;
    let mut warnings = input.warnings;
    let mut tasks = match input.content {
        Content::Tasks(tasks) => tasks,
        Content::Map(world) => {
            random_queries(name, &world, Robot::Point, 1, 0).map_err(|e| format!("{name}: {e}"))?
        }
        Content::Problems(_) => {
            return Err(format!("{name}: robots with joints are for the program so far"));
        }
    };
    if tasks.len() > MOST_TASKS {
        warnings.push(format!("the first {MOST_TASKS} of {} tasks", tasks.len()));
        tasks.truncate(MOST_TASKS);
    }
    let tasks: Result<Vec<String>, String> = tasks
        .iter()
        .map(|task| checked(task).and_then(|()| write_task(task).map_err(words)))
        .collect();
    Ok(json!({ "tasks": tasks?, "warnings": warnings }))
}

fn read_task(text: &str) -> Result<Task, String> {
    let task = read_tasks(text, TaskFormat::Json).map_err(words)?.into_iter().next();
    let task = task.ok_or("no task")?;
    checked(&task)?;
    Ok(task)
}

/// A page draws and plans while somebody waits.
fn checked(task: &Task) -> Result<(), String> {
    let count = task.plane().map_err(words)?.world.obstacles().len();
    if count > MOST_OBSTACLES {
        return Err(format!(
            "obstacles: {count} are more than the {MOST_OBSTACLES} that a page plans among; the program takes them"
        ));
    }
    Ok(())
}

/// Plans with every planner and gives what is to be shown.
fn planned(
    asked: &Asked,
    bytes: &[u8],
    show: impl FnOnce(&Replay<'_>, &Query, &[PlanDocument]) -> Value,
) -> Result<Value, String> {
    let within = |field: &str, value: usize, most: usize| match value {
        value if (1..=most).contains(&value) => Ok(()),
        value => Err(format!("{field}: {value} is not from 1 to {most}")),
    };
    within("planners", asked.planners.len(), MOST_PLANNERS)?;
    within("starts", asked.starts, MOST_STARTS)?;
    within("steps", asked.steps, MOST_STEPS)?;
    let task = read_task(&asked.task)?;
    let files = split(&asked.files, bytes)?;
    let mut load = |name: &str| {
        let found = files.iter().find(|(known, _)| *known == name);
        let (_, bytes) = found.ok_or_else(|| {
            InvalidInput::new("planner", format!("`{name}`"), "a policy that was given")
        })?;
        Policy::from_safetensors(bytes)
            .map(Arc::new)
            .map_err(|error| InvalidInput::new("policy", error.to_string(), "a policy file"))
    };
    let mut runs = Vec::new();
    let mut plans = Vec::new();
    let mut first: Option<Query> = None;
    for name in &asked.planners {
        let planner = parse_planner::<InvalidInput>(name, &mut load).map_err(words)?;
        let (query, run, plan) = run(asked, &task, name, &planner)?;
        first.get_or_insert(query);
        runs.push(run);
        plans.push(plan);
    }
    let query = first.ok_or("planners: none")?;
    let mut replay = replay::replay(task.plane().map_err(words)?, &query, runs);
    if asked.margin > 0.0 {
        replay.lines.push(format!("margin {}", asked.margin));
    }
    Ok(show(&replay, &query, &plans))
}

/// What one planner does, as the program's `plan` asks it to.
fn run(
    asked: &Asked,
    task: &Task,
    name: &str,
    planner: &Planner,
) -> Result<(Query, Run, PlanDocument), String> {
    let policy = planner.policy();
    let profile = policy.and_then(|policy| policy.fixed_profile()).unwrap_or("default");
    let options = Options {
        profile: profile.parse::<Profile>().map_err(words)?,
        waypoints: policy.and_then(|policy| policy.fixed_waypoints()),
        starts: asked.starts,
        steps: asked.steps,
        seed: asked.seed,
        prove: true,
        ..Options::default()
    };
    let with_margin = task.with_margin(asked.margin).map_err(words)?;
    let begin = now();
    let wanted = Query::of(&with_margin, &options.profile);
    let trace = Trace::new(if asked.untraced { 0 } else { MOST_ITERATES });
    let see = |iteration: &Iteration<'_>| trace.see(&wanted, iteration);
    let query = if asked.margin > 0.0 { Query::of(task, &options.profile) } else { wanted.clone() };
    let watch = Watch { see: &see, go_on: &|| true };
    let (plan, _) = plan_with_margin(&query, &wanted, planner, &options, watch).map_err(words)?;
    let time = Duration::from_secs_f64(1e-3 * (now() - begin).max(0.0));
    let trace = trace.into_steps();
    let why = reason(task, asked.margin, &query, &plan);
    let document = PlanDocument::of([&task.name, name], &query, &plan, time, why.clone());
    Ok((query.clone(), replay::run(name, &query, &plan, (time, why), &trace), document))
}
