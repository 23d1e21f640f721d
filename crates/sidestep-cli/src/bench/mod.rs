//! `sidestep bench`: planners on suites and task files, as a report.
//!
//! Measuring ([`measure`]) never formats and rendering ([`crate::table`]) never measures.

pub mod iterates;
pub mod measure;
mod page;
pub mod report;
pub mod statistics;
pub mod timing;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;
use sidestep::plan::{Options, by_setting};
use sidestep::plane::shortest_path::{Route, ShortestPath};
use sidestep::profile::Profile;
use sidestep::suite::Suite;
use sidestep::{InvalidInput, Task};
use sidestep_io::input::Question;

use crate::Global;
use crate::bends::BendArgs;
use crate::failure::Failure;
use crate::generate::{MAX_COUNT, draw};
use crate::input::{self, InputArgs};
use crate::machine::Provenance;
use crate::output;
use crate::planning::{PlanningArgs, planner, planner_names, policy_file};
use crate::table;
use measure::{Exact, TaskSet};
use report::Report;

/// Flags that say something of task files, and so nothing beside a suite.
const TASK_FLAGS: [&str; 7] =
    ["tasks", "limit", "spread", "by_file", "robot_radius", "unknown_is_free", "random_queries"];

const EXAMPLES: &str = "\
Examples:
  sidestep bench --suite easy --planner gd,adam,sidestep-1 --out report.json
  sidestep bench --suite hard --count 300 --seeds 2,12 --planner gd:step=0.5 --starts 5
  sidestep bench --suite hard --count 100 --planner gd,adam,sidestep-1 --html bench.html
  sidestep bench --tasks maps/*.map --random-queries 50 --by-file --planner auto";

/// Arguments of `bench`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct BenchArgs {
    /// Suite: easy, hard, hard-training, mix, time, varied, rooms, blobs or scans
    #[arg(long, conflicts_with_all = TASK_FLAGS, help_heading = "Tasks")]
    suite: Option<String>,
    /// Tasks per seed
    #[arg(long, default_value_t = 1000, allow_negative_numbers = true, help_heading = "Tasks")]
    count: usize,
    /// Task seeds of the suite
    #[arg(long, num_args = 1.., value_delimiter = ',', default_values_t = [2, 12, 22, 32, 42], help_heading = "Tasks")]
    seeds: Vec<u64>,
    /// Files in place of a suite: tasks, maps and worlds as `plan` reads them
    #[arg(long, num_args = 1.., help_heading = "Tasks")]
    tasks: Vec<PathBuf>,
    /// Use at most this many tasks of each file, the first ones
    #[arg(long, help_heading = "Tasks")]
    limit: Option<usize>,
    /// Take the tasks of --limit evenly from the whole file
    #[arg(long, requires = "limit", help_heading = "Tasks")]
    spread: bool,
    /// A row for each file, or of problems for each set (`cage` of `cage/12`), instead of one over all
    #[arg(long, requires = "tasks", help_heading = "Tasks")]
    by_file: bool,
    #[command(flatten, next_help_heading = "Tasks")]
    from: InputArgs,
    /// Planners, as NAME[:key=value,...]; `sidestep planners` lists them
    #[arg(long, num_args = 1.., required = true, help_heading = "Planner")]
    planner: Vec<String>,
    #[command(flatten, next_help_heading = "Planner")]
    planning: PlanningArgs,
    #[command(flatten, next_help_heading = "Planner")]
    bends: BendArgs,
    /// Distance that plans keep from obstacles and walls, and the shortest paths that lengths are compared with too, in task units;
    /// not with a suite
    #[arg(
        long,
        default_value_t = 0.0,
        allow_negative_numbers = true,
        conflicts_with = "suite",
        help_heading = "Tasks"
    )]
    margin: f64,
    /// Tasks per seed or file that are timed, one after the other on one thread
    #[arg(long, default_value_t = 200, allow_negative_numbers = true, help_heading = "Output")]
    timed: usize,
    /// Write the report here
    #[arg(long, help_heading = "Output")]
    out: Option<PathBuf>,
    /// Show the figures here, as one HTML page in which tasks that some planner failed can be watched
    #[arg(long, help_heading = "Output")]
    html: Option<PathBuf>,
}

/// Measures and prints.
pub fn run(args: &BenchArgs, global: &Global) -> Result<(), Failure> {
    let begin = Instant::now();
    let names = planner_names(&args.planner);
    let planners: Vec<_> =
        names.iter().map(|name| Ok((name, planner(name)?))).collect::<Result<_, Failure>>()?;
    let every: Vec<_> = planners.iter().map(|(_, planner)| planner).collect();
    let policies: Vec<PathBuf> = names.iter().filter_map(|name| policy_file(name)).collect();
    check_output(args, &policies)?;
    // All but what depends on the field is known before tasks are drawn or read.
    args.planning.options(Some(f64::INFINITY), &every)?;
    args.bends.check()?;
    let groups = task_groups(args, global)?;
    check_output(args, &args.from.files())?;
    let extent = groups[0].1[0].plane().ok().map(|task| task.world.bounds().extent());
    let mut options = args.planning.options(extent, &every)?;
    options.wishes = args.bends.wishes();
    let total = groups.iter().map(|(_, tasks)| tasks.len() as u64).sum::<u64>();
    let bar = output::progress("exact shortest paths", total, global.quiet);
    let sets: Vec<TaskSet> = groups
        .into_iter()
        .map(|(label, tasks)| {
            let exact = exact_answers(&tasks, &bar);
            TaskSet { label, tasks, exact }
        })
        .collect();
    bar.finish_and_clear();
    for planner in every {
        measure::check_fit(&sets, planner, &options)?;
    }
    let labels: Vec<String> = sets.iter().map(|set| set.label.clone()).collect();
    let all = labels.join(", ");
    let parts: Vec<(&str, &[TaskSet])> = match &args.suite {
        _ if args.by_file => labels.iter().map(String::as_str).zip(sets.chunks(1)).collect(),
        Some(suite) => vec![(suite, &sets)],
        None => vec![(&all, &sets)],
    };
    let mut rows = Vec::new();
    for &(name, sets) in &parts {
        for (planner_name, planner) in &planners {
            let total = sets.iter().map(|set| set.tasks.len() as u64).sum::<u64>();
            let bar = output::progress(planner_name, 2 * total, global.quiet);
            rows.push(measure::row(
                planner_name,
                planner,
                name,
                sets,
                &options,
                (args.timed, args.margin),
                &bar,
            )?);
            bar.finish_and_clear();
        }
    }
    let report = Report {
        format: report::FORMAT.into(),
        kind: "bench".into(),
        provenance: Provenance::here(begin.elapsed().as_secs_f64()),
        settings: settings(args, &options),
        rows,
    };
    // A report that cannot be written is shown all the same: the measurement may have taken hours.
    let written = args.out.as_ref().map_or(Ok(()), |path| output::write_json(path, &report));
    let shown = args.html.as_ref().map_or(Ok(()), |path| {
        page::write(path, &report, &parts, &planners, &options, global.quiet)
    });
    if global.json {
        output::print_json(&report)?;
    } else {
        output::print(&table::markdown(&report))?;
    }
    written?;
    shown
}

/// Fails if the report could not be written or would replace one of these.
fn check_output(args: &BenchArgs, inputs: &[PathBuf]) -> Result<(), Failure> {
    let named = [("--out", &args.out, ["json"]), ("--html", &args.html, ["html"])];
    let mut outputs = Vec::new();
    for (flag, path, suffixes) in &named {
        if let Some(path) = path {
            output::check_suffix((flag, path), suffixes)?;
            outputs.push((*flag, path.as_path()));
        }
    }
    output::check_outputs(&outputs, inputs)
}

fn settings(args: &BenchArgs, options: &Options) -> report::Settings {
    report::Settings {
        profile: options.profile.name.into(),
        steps: options.steps,
        waypoints: options.waypoints.unwrap_or(options.profile.waypoints),
        start_strategy: options.strategy.name().into(),
        task_seeds: if args.suite.is_some() { args.seeds.clone() } else { Vec::new() },
        planning_seed: options.seed,
        margin: args.margin,
    }
}

type Groups = Vec<(String, Vec<Task>)>;

/// One group per seed or file.
fn task_groups(args: &BenchArgs, global: &Global) -> Result<Groups, Failure> {
    let groups: Groups = match &args.suite {
        Some(suite) => {
            let suite = suite.parse::<Suite>()?;
            check_count(args)?;
            let draw = |&seed: &u64| {
                let tasks = draw(&suite, args.count, seed, &Profile::PAPER, global.quiet);
                (format!("seed {seed}"), tasks)
            };
            args.seeds.iter().map(draw).collect()
        }
        None if args.tasks.is_empty() => {
            let need = "no tasks: give --suite NAME (easy, hard, hard-training, mix, time, \
                        varied, rooms, blobs or scans) or --tasks FILE...";
            return Err(Failure(need.into()));
        }
        None => {
            let read = |path: PathBuf| {
                let (seed, clearance) = (args.planning.seed, args.margin);
                let question = Question { seed, clearance, ..Question::default() };
                let mut tasks = input::read(&path, &args.from, question)?.tasks;
                if args.margin != 0.0 {
                    let wide = |task: &Task| task.with_margin(args.margin);
                    let wide: Result<_, InvalidInput> = tasks.iter().map(wide).collect();
                    let named = |error| InvalidInput { field: "--margin".into(), ..error };
                    tasks = wide.map_err(named)?;
                }
                let label =
                    path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into());
                let tasks = selection(tasks, args);
                Ok(if args.by_file { by_set(label, tasks) } else { vec![(label, tasks)] })
            };
            files(&args.tasks)
                .into_iter()
                .map(read)
                .collect::<Result<Vec<Groups>, Failure>>()?
                .concat()
        }
    };
    if groups.is_empty() || groups.iter().any(|(_, tasks)| tasks.is_empty()) {
        return Err(Failure(
            "no tasks: --count, --seeds and --limit must leave at least one".into(),
        ));
    }
    Ok(groups)
}

/// The tasks of a file by the set that their names begin with, if they are of robots with joints and of several.
fn by_set(label: String, tasks: Vec<Task>) -> Groups {
    let set = |task: &Task| task.name.split_once('/').map(|(set, _)| set.to_owned());
    let mut sets: Groups = Vec::new();
    for task in &tasks {
        let Some(name) = set(task).filter(|_| task.plane().is_err()) else {
            return vec![(label, tasks)];
        };
        let name = format!("{label}: {name}");
        match sets.iter_mut().find(|(known, _)| *known == name) {
            Some((_, of_set)) => of_set.push(task.clone()),
            None => sets.push((name, vec![task.clone()])),
        }
    }
    if sets.len() > 1 { sets } else { vec![(label, tasks)] }
}

/// Checks the number of tasks of a suite, over all seeds.
fn check_count(args: &BenchArgs) -> Result<(), Failure> {
    let (count, seeds) = (args.count, args.seeds.len());
    if count.checked_mul(seeds).is_some_and(|total| (1..=MAX_COUNT).contains(&total)) {
        return Ok(());
    }
    let allowed = format!("at least 1 and, times {seeds} seed(s), at most {MAX_COUNT} tasks");
    Err(InvalidInput::new("--count", count, allowed).into())
}

/// Files as they are named, or several in one word, with commas between them.
fn files(words: &[PathBuf]) -> Vec<PathBuf> {
    let several = |word: &PathBuf| match word.to_str().filter(|_| !word.exists()) {
        Some(text) => text.split(',').map(PathBuf::from).collect(),
        None => vec![word.clone()],
    };
    words.iter().flat_map(several).collect()
}

/// The tasks of a file that `--limit` and `--spread` leave.
fn selection(mut tasks: Vec<Task>, args: &BenchArgs) -> Vec<Task> {
    let count = tasks.len();
    let limit = args.limit.unwrap_or(count).min(count);
    if args.spread {
        return (0..limit).map(|i| tasks[i * count / limit].clone()).collect();
    }
    tasks.truncate(limit);
    tasks
}

/// The exact search's answer to each task; steps `bar` once per task.
pub fn exact_answers(tasks: &[Task], bar: &indicatif::ProgressBar) -> Vec<Exact> {
    let answer = |exact: &mut Option<ShortestPath>, task: &Task| {
        let plane = task.plane().ok();
        let route =
            exact.as_mut().zip(plane).map(|(exact, task)| exact.find(task.start, task.goal));
        bar.inc(1);
        match route {
            Some(Route::Found { length, .. }) => Exact::Solvable { length },
            Some(Route::Unsolvable(_)) => Exact::Unsolvable,
            Some(Route::Undecided(_)) | None => Exact::Undecided,
        }
    };
    by_setting(tasks)
        .into_par_iter()
        .flat_map(|(_, tasks)| {
            let plane = tasks[0].plane().ok();
            let exact = plane.map(|task| ShortestPath::new(task.world, task.robot));
            tasks.par_iter().map_with(exact, answer)
        })
        .collect()
}
