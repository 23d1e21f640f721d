//! What a policy or a baseline comes to in every measurement of an experiment.

use std::sync::Arc;

use indicatif::ProgressBar;
use sidestep::Task;
use sidestep::optimizer::Method;
use sidestep::plan::starts::StartStrategy;
use sidestep::plan::{Options, Planner};
use sidestep::policy::PolicyCard;
use sidestep::profile::Profile;
use sidestep::suite::Suite;

use super::config::{BaselineEntry, Measure, PolicyEntry};
use super::report::{Cell, STEPS};
use super::training::Trained;
use crate::bench::iterates::{EveryIterate, every_iterate, race};
use crate::bench::measure::{Exact, TaskSet, plans};
use crate::bench::timing::us_per_iteration;
use crate::bench::{exact_answers, statistics::mean};
use crate::failure::Failure;
use crate::output;
use crate::planning::planner;

/// Tasks of each set on which iterations are timed.
const TIMED: usize = 50;

/// A measurement with its tasks drawn.
pub struct Prepared<'a> {
    measure: &'a Measure,
    options: Options,
    sets: Arc<Vec<TaskSet>>,
}

/// Draws the tasks of every measurement; those of the same tasks share them.
pub fn prepare(measures: &[Measure], quiet: bool) -> Result<Vec<Prepared<'_>>, Failure> {
    let mut prepared: Vec<Prepared> = Vec::with_capacity(measures.len());
    for measure in measures {
        let tasks = |other: &Measure| (other.suite.clone(), other.count, other.seeds.clone());
        let known = prepared.iter().find(|known| tasks(known.measure) == tasks(measure));
        let sets = match known {
            Some(known) => known.sets.clone(),
            None => Arc::new(draw_sets(measure, quiet)?),
        };
        let options = Options {
            profile: measure.profile.parse::<Profile>()?,
            steps: measure.steps,
            starts: measure.starts,
            strategy: measure.start_strategy.parse::<StartStrategy>()?,
            ..Options::default()
        };
        prepared.push(Prepared { measure, options, sets });
    }
    Ok(prepared)
}

fn draw_sets(measure: &Measure, quiet: bool) -> Result<Vec<TaskSet>, Failure> {
    let suite = measure.suite.parse::<Suite>()?;
    let all = (measure.count * measure.seeds.len()) as u64;
    let bar = output::progress("drawing tasks", all, quiet);
    let draw =
        |&seed: &u64| suite.generate_watched(measure.count, seed, &Profile::PAPER, &|| bar.inc(1));
    let drawn: Vec<Vec<Task>> = measure.seeds.iter().map(draw).collect();
    bar.finish_and_clear();
    let bar = output::progress("exact shortest paths", all, quiet);
    let set = |(tasks, seed): (Vec<Task>, &u64)| {
        let exact = exact_answers(&tasks, &bar);
        TaskSet { label: format!("seed {seed}"), tasks, exact }
    };
    let sets = drawn.into_iter().zip(&measure.seeds).map(set).collect();
    bar.finish_and_clear();
    Ok(sets)
}

/// What one method does in every measurement of a group.
fn measured(
    sets: &[TaskSet],
    method: &Method,
    options: &Options,
    group: &[Prepared],
) -> Result<Vec<EveryIterate>, Failure> {
    if group.iter().any(|prepared| prepared.measure.until_solved) {
        let counts: Vec<usize> = group.iter().map(|prepared| prepared.measure.starts).collect();
        return race(sets, method, options, &counts);
    }
    Ok(vec![every_iterate(sets, method, options, &ProgressBar::hidden())?])
}

fn blank(row: &str, column: &str, measure: &Measure, paper: Option<f64>) -> Cell {
    Cell {
        row: row.into(),
        column: column.into(),
        measure: measure.name.clone(),
        starts: measure.starts,
        until_solved: measure.until_solved,
        paper,
        any: Vec::new(),
        end: Vec::new(),
        certified: Vec::new(),
        certified_of_solvable: Vec::new(),
        iterations: Vec::new(),
        us_per_iteration: Vec::new(),
        training_seconds: Vec::new(),
        kept_at_steps: Vec::new(),
        curves: Vec::new(),
        curves_over: STEPS.into(),
        solved: Vec::new(),
        time: Vec::new(),
    }
}

fn push(cell: &mut Cell, every: &EveryIterate, sets: &[TaskSet]) {
    let tasks: usize = sets.iter().map(|set| set.tasks.len()).sum();
    let is_solvable = |exact: &&Exact| matches!(exact, Exact::Solvable { .. });
    let solvable = sets.iter().flat_map(|set| &set.exact).filter(is_solvable).count();
    cell.any.push(every.any as f64 / tasks as f64);
    if !cell.until_solved {
        cell.end.push(every.end as f64 / tasks as f64);
    }
    cell.certified.push(every.certified as f64 / tasks as f64);
    cell.certified_of_solvable.push(every.certified as f64 / solvable.max(1) as f64);
    cell.iterations.extend(mean(&every.solved_iterations()));
    cell.solved
        .push(every.firsts.iter().map(|first| if first.is_some() { '1' } else { '0' }).collect());
}

/// What a trained policy does: one cell a measurement, in their order.
pub fn policy_cells(
    entry: &PolicyEntry,
    trained: &Trained,
    measures: &[Prepared],
) -> Result<Vec<Cell>, Failure> {
    let mut cells = Vec::with_capacity(measures.len());
    for group in measures.chunk_by(|a, b| a.measure.races_with(b.measure)) {
        policy_group(entry, trained, group, &mut cells)?;
    }
    Ok(cells)
}

/// Those of measurements that one race serves.
fn policy_group(
    entry: &PolicyEntry,
    Trained { policy, seconds }: &Trained,
    group: &[Prepared],
    cells: &mut Vec<Cell>,
) -> Result<(), Failure> {
    let card = policy.card();
    let sets = &group[0].sets;
    let options = Options {
        profile: card.profile.parse::<Profile>()?,
        waypoints: Some(card.waypoints),
        ..group[0].options.clone()
    };
    let method = Method::Learned(policy.clone());
    let all = measured(sets, &method, &options, group)?;
    let time = us_per_iteration(sets, &method, &options, TIMED)?;
    for (every, prepared) in all.iter().zip(group) {
        let paper = entry.paper.get(&prepared.measure.name).copied();
        let mut cell = blank(&entry.row, &entry.column, prepared.measure, paper);
        push(&mut cell, every, sets);
        cell.us_per_iteration.extend(time);
        if prepared.measure.suite == "time" {
            cell.time.push(shared_iterations(every, &options, sets)?);
        }
        cell.training_seconds.extend(*seconds);
        let kept = card.training["environment_steps"].as_u64();
        cell.kept_at_steps.push(kept.unwrap_or_default());
        cell.curves.push(curve(card));
        cells.push(cell);
    }
    Ok(())
}

/// The validations of a policy's training.
fn curve(card: &PolicyCard) -> Vec<[f64; 2]> {
    let points = card.training["validation_curve"].as_array().into_iter().flatten();
    let point =
        |p: &serde_json::Value| Some([p["environment_steps"].as_f64()?, p["success"].as_f64()?]);
    points.filter_map(point).collect()
}

/// Iterations on the tasks that the policy and gradient descent (0.1) both solve within 100 steps.
fn shared_iterations(
    policy: &EveryIterate,
    options: &Options,
    sets: &[TaskSet],
) -> Result<[f64; 3], Failure> {
    let descent = |step| {
        let method = Method::GradientDescent { step: Some(step) };
        every_iterate(sets, &method, options, &ProgressBar::hidden())
    };
    let (slow, tuned) = (descent(0.1)?, descent(0.5)?);
    let mut sums = [0.0; 3];
    let mut counts = [0.0f64; 3];
    for ((learned, slow), tuned) in policy.firsts.iter().zip(&slow.firsts).zip(&tuned.firsts) {
        if learned.is_some_and(|k| k <= 100) && slow.is_some_and(|k| k <= 100) {
            for (index, first) in [learned, slow, tuned].into_iter().enumerate() {
                if let Some(first) = first {
                    sums[index] += *first as f64;
                    counts[index] += 1.0;
                }
            }
        }
    }
    Ok([0, 1, 2].map(|index| sums[index] / counts[index].max(1.0)))
}

/// What a baseline does: one cell a measurement, in their order.
pub fn baseline_cells(entry: &BaselineEntry, measures: &[Prepared]) -> Result<Vec<Cell>, Failure> {
    let planner = planner(&entry.planner)?;
    let groups = measures.chunk_by(|a, b| a.measure.races_with(b.measure));
    let cells = groups.map(|group| baseline_group(entry, &planner, group));
    Ok(cells.collect::<Result<Vec<_>, Failure>>()?.concat())
}

/// Those of measurements that one race serves.
fn baseline_group(
    entry: &BaselineEntry,
    planner: &Planner,
    group: &[Prepared],
) -> Result<Vec<Cell>, Failure> {
    let blank_of = |prepared: &Prepared| {
        let paper = entry.paper.get(&prepared.measure.name).copied();
        blank(&entry.planner, "", prepared.measure, paper)
    };
    let mut cells: Vec<Cell> = group.iter().map(blank_of).collect();
    let hidden = ProgressBar::hidden();
    for set in group[0].sets.iter() {
        let set = std::slice::from_ref(set);
        match planner {
            Planner::Optimizer(method) => {
                let all = measured(set, method, &group[0].options, group)?;
                let time = us_per_iteration(set, method, &group[0].options, TIMED)?;
                for (cell, every) in cells.iter_mut().zip(&all) {
                    push(cell, every, set);
                    cell.us_per_iteration.extend(time);
                }
            }
            // Planners of another kind do not know starts.
            _ => {
                let found = plans(&set[0], planner, &group[0].options, &hidden)?;
                let certified = found.iter().filter(|p| p.is_solved()).count();
                let share = certified as f64 / found.len() as f64;
                let is_solvable = |exact: &&Exact| matches!(exact, Exact::Solvable { .. });
                let solvable = set[0].exact.iter().filter(is_solvable).count();
                for cell in &mut cells {
                    cell.any.push(share);
                    cell.end.push(share);
                    cell.certified.push(share);
                    cell.certified_of_solvable.push(certified as f64 / solvable.max(1) as f64);
                }
            }
        }
    }
    Ok(cells)
}
