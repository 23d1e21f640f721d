//! A bench as a page, with the tasks that some planner failed as replays.

use std::path::Path;
use std::time::Instant;

use sidestep::plan::run::Iteration;
use sidestep::plan::{Options, Planner, Watch, plan_in, reason};
use sidestep::scene::Query;
use sidestep::{InvalidInput, Task};
use sidestep_io::plan_json::Trace;
use sidestep_io::replay::{self, BenchPage, BenchRow, FailedTask, Run};

use super::measure::{Exact, TaskSet};
use super::report::{Report, Row};
use crate::failure::Failure;
use crate::output;

/// Most tasks that a page holds.
const MOST_TASKS: usize = 24;
/// Most frames of one task, of all planners together.
const MOST_FRAMES: usize = 120;

/// Writes the page. Of the solvable tasks in the plane that some planner failed, some evenly are planned once more, to be
/// watched.
pub fn write(
    path: &Path,
    report: &Report,
    parts: &[(&str, &[TaskSet])],
    planners: &[(&String, Planner)],
    options: &Options,
    quiet: bool,
) -> Result<(), Failure> {
    let failed = failed(parts, &report.rows);
    let stride = failed.len().div_ceil(MOST_TASKS).max(1);
    let shown: Vec<_> = failed.iter().step_by(stride).collect();
    let settings = &report.settings;
    let made = &report.provenance;
    let about = format!(
        "{} waypoints, up to {} steps a start; commit {}, {}",
        settings.waypoints, settings.steps, made.commit, made.processor
    );
    let which = match failed.len() {
        all if all > shown.len() => format!("{} of {all}, evenly taken", shown.len()),
        all => format!("{all} in all"),
    };
    let mut page = BenchPage::new(about, report.rows.iter().map(row).collect(), which);
    let bar = output::progress("failed tasks", shown.len() as u64, quiet);
    for &&(task, index) in &shown {
        let Ok(plane) = task.plane() else { continue };
        let query = Query::of(task, &options.profile);
        let mut solved = Vec::new();
        let mut runs = Vec::new();
        for (name, planner) in planners {
            let (run, is_solved) = watched(name, planner, task, &query, (index, options))?;
            solved.push(is_solved);
            runs.push(run);
        }
        let mut replay = replay::replay(plane, &query, runs);
        replay.most_frames = MOST_FRAMES;
        page.add(&FailedTask { solved, replay }, replay::far(&query));
        bar.inc(1);
    }
    bar.finish_and_clear();
    output::write_file(path, page.to_html().as_bytes())
}

fn row(row: &Row) -> BenchRow {
    BenchRow {
        planner: row.planner.clone(),
        suite: row.suite.clone(),
        tasks: row.tasks,
        success: row.success,
        interval: row.success_ci95,
        times: [row.us_per_plan_median, row.us_per_plan_p95],
    }
}

/// The tasks in the plane that a planner failed and that are not proved unsolvable, each with its index in its set.
fn failed<'a>(parts: &[(&str, &'a [TaskSet])], rows: &[Row]) -> Vec<(&'a Task, usize)> {
    let planners = rows.len() / parts.len().max(1);
    let mut failed = Vec::new();
    for ((_, sets), rows) in parts.iter().zip(rows.chunks(planners.max(1))) {
        for (at, set) in sets.iter().enumerate() {
            let missed = |index: usize| {
                let mut outcomes = rows.iter().filter_map(|row| row.outcomes.get(at));
                outcomes.any(|digits| digits.as_bytes().get(index) == Some(&b'0'))
            };
            let tasks = set.tasks.iter().zip(&set.exact).enumerate();
            let kept = tasks.filter(|(index, (task, exact))| {
                !matches!(exact, Exact::Unsolvable) && task.plane().is_ok() && missed(*index)
            });
            failed.extend(kept.map(|(index, (task, _))| (task, index)));
        }
    }
    failed
}

/// Plans once more as the measurement did, and keeps every iterate.
fn watched(
    name: &str,
    planner: &Planner,
    task: &Task,
    query: &Query,
    (index, options): (usize, &Options),
) -> Result<(Run, bool), InvalidInput> {
    let options = Options { index: index as u64, ..options.clone() };
    let trace = Trace::new(usize::MAX);
    let see = |iteration: &Iteration<'_>| trace.see(query, iteration);
    let begin = Instant::now();
    let plan = plan_in(query, planner, &options, Watch { see: &see, go_on: &|| true })?;
    let time = begin.elapsed();
    let trace = trace.into_steps();
    let why = reason(task, 0.0, query, &plan);
    Ok((replay::run(name, query, &plan, (time, why), &trace), plan.is_solved()))
}
