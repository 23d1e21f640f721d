//! One planner on sets of tasks: success, iterations, time and quality.
//!
//! Three passes: the planner as it is used, on all cores, for success and quality; for optimizers, every
//! iterate of every start with both checks, for the paper's any-step and end-state success
//! ([`super::iterates`]); and the first tasks of each set once more on one thread, for times of plans and of
//! iterations ([`super::timing`]).

use std::sync::Arc;

use indicatif::ProgressBar;
use rayon::prelude::*;
use sidestep::optimizer::Method;
use sidestep::plan::{Auto, Options, Plan, Planner, Watch, by_setting, plan_in};
use sidestep::scene::{Query, Scene};
use sidestep::{InvalidInput, Status, Task, Trajectory, arm};

use super::iterates::{Walk, every_iterate};
use super::report::{Failed, Row};
use super::statistics::{mean, quantile, student_interval, wilson_interval};
use super::timing::{times, us_per_iteration};
use crate::failure::Failure;

/// What the exact search says of a task.
#[derive(Debug, Clone, Copy)]
pub enum Exact {
    /// There is a path, the shortest of this length.
    Solvable {
        /// In task units.
        length: f64,
    },
    /// Proved: there is none.
    Unsolvable,
    /// Not decided.
    Undecided,
}

/// The tasks of one seed or file with their exact answers.
pub struct TaskSet {
    /// Seed or file.
    pub label: String,
    /// The tasks.
    pub tasks: Vec<Task>,
    /// One answer per task.
    pub exact: Vec<Exact>,
}

/// Measures one planner on tasks that hold the margin already, so many of them timed; steps `bar` twice per task.
pub fn row(
    name: &str,
    planner: &Planner,
    suite: &str,
    sets: &[TaskSet],
    options: &Options,
    (timed, margin): (usize, f64),
    bar: &ProgressBar,
) -> Result<Row, Failure> {
    let mut outcomes = Vec::new();
    for set in sets {
        outcomes.push(plans(set, planner, options, bar)?);
    }
    let solved = |plans: &[Plan]| plans.iter().filter(|p| p.is_solved()).count();
    let shares: Vec<f64> =
        outcomes.iter().map(|plans| solved(plans) as f64 / plans.len() as f64).collect();
    let tasks: usize = sets.iter().map(|set| set.tasks.len()).sum();
    let successes: usize = outcomes.iter().map(|plans| solved(plans)).sum();
    let pairs = || {
        let exact = sets.iter().flat_map(|set| &set.exact);
        outcomes.iter().flatten().zip(exact)
    };
    let count = |keep: fn(&Exact) -> bool| pairs().filter(|(_, exact)| keep(exact)).count();
    let solvable = count(|exact| matches!(exact, Exact::Solvable { .. }));
    let solved_solvable = pairs()
        .filter(|(plan, exact)| plan.is_solved() && matches!(exact, Exact::Solvable { .. }))
        .count();
    let contradictions = pairs()
        .filter(|(plan, exact)| plan.is_solved() && matches!(exact, Exact::Unsolvable))
        .count();
    let mut ratios = quality(pairs(), |path, length| path.length() / length);
    let mut roughness = quality(pairs(), |path, length| path.roughness() / (length * length));
    let every = match planner {
        Planner::Optimizer(method) => Some(every_iterate(sets, method, options, bar)?),
        _ => None,
    };
    let us_per_iteration = match planner {
        Planner::Optimizer(method) => us_per_iteration(sets, method, options, timed)?,
        _ => None,
    };
    let mut times = times(sets, planner, options, timed)?;
    let share = |count: usize| count as f64 / tasks as f64;
    let jointed = sets.iter().flat_map(|set| &set.tasks).all(|task| task.plane().is_err());
    let plans = || outcomes.iter().flatten();
    let invalid = plans().filter(|plan| matches!(plan.status, Status::Invalid(_))).count();
    let lengths: Vec<f64> = plans().filter_map(Plan::certified).map(Trajectory::length).collect();
    let corner = |path: &Trajectory| path.sharpest_turn().to_degrees();
    let mut corners: Vec<f64> = plans().filter_map(Plan::certified).map(corner).collect();
    let corner_median_deg = quantile(&mut corners, 0.5);
    let mut clearances = clearances(sets, &outcomes, options)?;
    let failures = if jointed { failures(sets, &outcomes, options) } else { Vec::new() };
    Ok(Row {
        planner: name.into(),
        suite: suite.into(),
        starts: options.starts,
        tasks,
        solvable,
        undecided: count(|exact| matches!(exact, Exact::Undecided)),
        solved_any: every.as_ref().map(|every| share(every.any)),
        solved_end: every.as_ref().map(|every| share(every.end)),
        certified: every.as_ref().map_or(share(successes), |every| share(every.certified)),
        success: share(successes),
        success_ci95: student_interval(&shares)
            .filter(|_| shares.len() >= 3)
            .unwrap_or_else(|| wilson_interval(successes, tasks)),
        success_by_group: shares,
        outcomes: outcomes.iter().map(|plans| digits(plans)).collect(),
        success_of_solvable: (solvable > 0).then(|| solved_solvable as f64 / solvable as f64),
        contradictions,
        iterations_mean: every.as_ref().and_then(|every| mean(&every.solved_iterations())),
        iterations_median: every
            .as_ref()
            .and_then(|every| quantile(&mut every.solved_iterations(), 0.5)),
        us_per_iteration,
        us_per_plan_median: quantile(&mut times.plans, 0.5),
        us_per_plan_p95: quantile(&mut times.plans, 0.95),
        us_per_world_median: quantile(&mut times.worlds, 0.5),
        invalid: jointed.then_some(invalid),
        length_mean: mean(&lengths).filter(|_| jointed),
        failures,
        length_ratio_median: quantile(&mut ratios, 0.5),
        roughness_median: quantile(&mut roughness, 0.5),
        corner_median_deg,
        corner_most_deg: quantile(&mut corners, 1.0),
        clearance_median: quantile(&mut clearances, 0.5).map(|clearance| clearance + margin),
    })
}

/// Clearances of the certified plans in the plane.
fn clearances(
    sets: &[TaskSet],
    outcomes: &[Vec<Plan>],
    options: &Options,
) -> Result<Vec<f64>, Failure> {
    let mut all = Vec::new();
    for (set, plans) in sets.iter().zip(outcomes) {
        all.extend(in_scenes(set, options, |query, index| {
            let path = plans[index].certified().filter(|_| query.scene().plane().is_some());
            Ok(path.map(|path| query.scene().clearance(path)))
        })?);
    }
    Ok(all.into_iter().flatten().filter(|clearance| clearance.is_finite()).collect())
}

/// The tasks without a certified plan, and why.
fn failures(sets: &[TaskSet], outcomes: &[Vec<Plan>], options: &Options) -> Vec<Failed> {
    let tasks = sets.iter().flat_map(|set| &set.tasks);
    let failed = tasks.zip(outcomes.iter().flatten()).filter(|(_, plan)| !plan.is_solved());
    failed
        .map(|(task, plan)| {
            let query = Query::of(task, &options.profile);
            let reason = match (&plan.status, query.scene().arm()) {
                (Status::Invalid(violation), Some(scene)) => {
                    arm::explain_ends(scene, [query.start(), query.goal()], violation)
                }
                (status, _) => status.reason(),
            };
            Failed { task: task.name.clone(), status: plan.status.name().into(), reason }
        })
        .collect()
}

/// A digit for each plan: whether it is solved.
fn digits(plans: &[Plan]) -> String {
    plans.iter().map(|plan| if plan.is_solved() { '1' } else { '0' }).collect()
}

/// Fails if a learned planner does not fit a task: better before hours of measuring than after.
pub fn check_fit(sets: &[TaskSet], planner: &Planner, options: &Options) -> Result<(), Failure> {
    let method = match planner {
        Planner::Optimizer(method @ Method::Learned(_))
        | Planner::Auto(Auto { quick: method @ Method::Learned(_), .. }) => method,
        _ => return Ok(()),
    };
    // For robots with joints `auto` has another way, without a policy.
    let has_other_way = |set: &TaskSet| {
        matches!(planner, Planner::Auto(_)) && set.tasks.iter().all(|task| task.plane().is_err())
    };
    for set in sets.iter().filter(|set| !has_other_way(set)) {
        in_scenes(set, options, |query, index| {
            Walk::new(query, index as u64, method, options)?.begin(0).map(drop)
        })?;
    }
    Ok(())
}

/// Plans every task of a set as a user would.
pub fn plans(
    set: &TaskSet,
    planner: &Planner,
    options: &Options,
    bar: &ProgressBar,
) -> Result<Vec<Plan>, Failure> {
    let plan_one = |query: &Query, index: usize| {
        let outcome = plan_indexed(query, index, planner, options);
        bar.inc(1);
        outcome
    };
    in_scenes(set, options, plan_one)
}

/// Calls `work` with every task's query and its index, on all cores.
pub(super) fn in_scenes<T: Send>(
    set: &TaskSet,
    options: &Options,
    work: impl Fn(&Query, usize) -> Result<T, InvalidInput> + Sync,
) -> Result<Vec<T>, Failure> {
    let outcomes: Result<Vec<Vec<T>>, _> = by_setting(&set.tasks)
        .into_par_iter()
        .map(|(first, tasks)| {
            let scene = Arc::new(Scene::of(&tasks[0], &options.profile));
            let work = |(offset, task)| work(&Query::new(&scene, task)?, first + offset);
            tasks.par_iter().enumerate().map(work).collect()
        })
        .collect();
    let outcomes = outcomes.map_err(|error| Failure::at(&set.label, error))?;
    Ok(outcomes.into_iter().flatten().collect())
}

/// Plans the task of that index, which is the number of its random stream.
pub(super) fn plan_indexed(
    query: &Query,
    index: usize,
    planner: &Planner,
    options: &Options,
) -> Result<Plan, InvalidInput> {
    let options = Options { index: index as u64, ..options.clone() };
    plan_in(query, planner, &options, Watch::NONE)
}

/// A figure of each certified plan whose optimal length is known and not 0.
fn quality<'a>(
    pairs: impl Iterator<Item = (&'a Plan, &'a Exact)>,
    figure: impl Fn(&Trajectory, f64) -> f64,
) -> Vec<f64> {
    pairs
        .filter_map(|(plan, exact)| match (plan.certified(), exact) {
            (Some(path), Exact::Solvable { length }) if *length > 0.0 => {
                Some(figure(path, *length))
            }
            _ => None,
        })
        .collect()
}
