//! One planner on sets of tasks: success, iterations, time and quality.
//!
//! Three passes: the planner as it is used, on all cores, for success and quality; for optimizers, every
//! iterate of every start with both checks, for the paper's any-step and end-state success; and the
//! first tasks of each set once more on one thread, for times of plans and of iterations.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use indicatif::ProgressBar;
use rayon::prelude::*;
use sidestep::objective::{Objective, Scene};
use sidestep::optimizer::{Method, Optimizer};
use sidestep::plan::{Options, Plan, Planner, Status, by_world, plan_in};
use sidestep::rng::{Purpose, stream};
use sidestep::run::{Iteration, Run, Until, run};
use sidestep::{InvalidInput, Task, Trajectory};

use super::report::Row;
use super::statistics::{mean, quantile, student_interval, wilson_interval};
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

/// Measures one planner; steps `bar` twice per task.
pub fn row(
    name: &str,
    planner: &Planner,
    suite: &str,
    sets: &[TaskSet],
    options: &Options,
    timed: usize,
    bar: &ProgressBar,
) -> Result<Row, Failure> {
    let mut outcomes = Vec::new();
    for set in sets {
        outcomes.push(plans(set, planner, options, bar)?);
    }
    let solved = |plans: &[Plan]| plans.iter().filter(|p| p.status == Status::Solved).count();
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
        .filter(|(plan, exact)| {
            plan.status == Status::Solved && matches!(exact, Exact::Solvable { .. })
        })
        .count();
    let contradictions = pairs()
        .filter(|(plan, exact)| plan.status == Status::Solved && matches!(exact, Exact::Unsolvable))
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
        success_of_solvable: solved_solvable as f64 / solvable.max(1) as f64,
        contradictions,
        iterations_mean: every.as_ref().and_then(|every| mean(&every.solved_iterations())),
        iterations_median: every
            .as_ref()
            .and_then(|every| quantile(&mut every.solved_iterations(), 0.5)),
        us_per_iteration,
        us_per_plan_median: quantile(&mut times.plans, 0.5).unwrap_or_default(),
        us_per_plan_p95: quantile(&mut times.plans, 0.95).unwrap_or_default(),
        us_per_world_median: quantile(&mut times.worlds, 0.5),
        length_ratio_median: quantile(&mut ratios, 0.5),
        roughness_median: quantile(&mut roughness, 0.5),
    })
}

/// Plans every task of a set as a user would.
pub fn plans(
    set: &TaskSet,
    planner: &Planner,
    options: &Options,
    bar: &ProgressBar,
) -> Result<Vec<Plan>, Failure> {
    let plan_one = |scene: &Arc<Scene>, index: usize, task: &Task| {
        let outcome = plan_indexed(scene, index, task, planner, options);
        bar.inc(1);
        outcome
    };
    in_scenes(set, options, plan_one)
}

/// Calls `work` with every task, its index and its scene, on all cores.
fn in_scenes<T: Send>(
    set: &TaskSet,
    options: &Options,
    work: impl Fn(&Arc<Scene>, usize, &Task) -> Result<T, InvalidInput> + Sync,
) -> Result<Vec<T>, Failure> {
    let outcomes: Result<Vec<Vec<T>>, _> = by_world(&set.tasks)
        .into_par_iter()
        .map(|(first, tasks)| {
            let scene = Arc::new(Scene::of(&tasks[0], &options.profile));
            let work = |(offset, task)| work(&scene, first + offset, task);
            tasks.par_iter().enumerate().map(work).collect()
        })
        .collect();
    let outcomes = outcomes.map_err(|error| Failure::at(&set.label, error))?;
    Ok(outcomes.into_iter().flatten().collect())
}

/// Plans the task of that index, which is the number of its random stream.
fn plan_indexed(
    scene: &Arc<Scene>,
    index: usize,
    task: &Task,
    planner: &Planner,
    options: &Options,
) -> Result<Plan, InvalidInput> {
    let options = Options { index: index as u64, ..options.clone() };
    plan_in(scene, task, planner, &options, &|_| ControlFlow::Continue(()))
}

/// A figure of each certified plan whose optimal length is known and not 0.
fn quality<'a>(
    pairs: impl Iterator<Item = (&'a Plan, &'a Exact)>,
    figure: impl Fn(&Trajectory, f64) -> f64,
) -> Vec<f64> {
    pairs
        .filter_map(|(plan, exact)| match (&plan.status, &plan.trajectory, exact) {
            (Status::Solved, Some(path), Exact::Solvable { length }) if *length > 0.0 => {
                Some(figure(path, *length))
            }
            _ => None,
        })
        .collect()
}

/// Microseconds on one thread.
#[derive(Default)]
struct Times {
    /// From task to answer, of each task. Where tasks share a world, without what they share.
    plans: Vec<f64>,
    /// What the tasks of a world share: the first answer there less the same answer again.
    worlds: Vec<f64>,
}

/// Times the first `timed` tasks of each set, one after the other.
fn times(
    sets: &[TaskSet],
    planner: &Planner,
    options: &Options,
    timed: usize,
) -> Result<Times, Failure> {
    // One thread: planning must not spread its starts over the cores.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .map_err(|error| Failure::at("threads", error))?;
    pool.install(|| {
        let mut times = Times::default();
        for set in sets {
            for (first, tasks) in by_world(&set.tasks[..timed.min(set.tasks.len())]) {
                let begin = Instant::now();
                let scene = Arc::new(Scene::of(&tasks[0], &options.profile));
                std::hint::black_box(plan_indexed(&scene, first, &tasks[0], planner, options)?);
                let cold = begin.elapsed().as_secs_f64() * 1e6;
                if tasks.len() == 1 {
                    times.plans.push(cold);
                    continue;
                }
                let before = times.plans.len();
                for (offset, task) in tasks.iter().enumerate() {
                    let begin = Instant::now();
                    let index = first + offset;
                    std::hint::black_box(plan_indexed(&scene, index, task, planner, options)?);
                    times.plans.push(begin.elapsed().as_secs_f64() * 1e6);
                }
                times.worlds.push((cold - times.plans[before]).max(0.0));
            }
        }
        Ok(times)
    })
}

/// Any-step and end-state figures over all tasks of several sets.
pub struct EveryIterate {
    /// Tasks feasible by the profile's check at any iterate of any start.
    pub any: usize,
    /// Tasks feasible by the profile's check at the last iterate of any start.
    pub end: usize,
    /// Tasks certified at any iterate of any start.
    pub certified: usize,
    /// First feasible iterate of each task, the least over its starts.
    pub firsts: Vec<Option<usize>>,
}

impl EveryIterate {
    /// First feasible iterates of the tasks that have one.
    pub fn solved_iterations(&self) -> Vec<f64> {
        self.firsts.iter().flatten().map(|&first| first as f64).collect()
    }
}

/// Runs every start of every task to the end; steps `bar` once per task.
pub fn every_iterate(
    sets: &[TaskSet],
    method: &Method,
    options: &Options,
    bar: &ProgressBar,
) -> Result<EveryIterate, Failure> {
    let runs = all_runs(sets, method, options, false, bar)?;
    Ok(EveryIterate::of(&runs, options.starts))
}

/// The figures that the first 1, 5, .. (`counts`) starts would give alone, each start broken off once it can change none
/// of them; so there is no end state, and `end` counts nothing.
pub fn race(
    sets: &[TaskSet],
    method: &Method,
    options: &Options,
    counts: &[usize],
) -> Result<Vec<EveryIterate>, Failure> {
    let most = counts.iter().copied().max().unwrap_or(1);
    let options = Options { starts: most, ..options.clone() };
    let runs = all_runs(sets, method, &options, true, &ProgressBar::hidden())?;
    let of = |&count: &usize| EveryIterate { end: 0, ..EveryIterate::of(&runs, count) };
    Ok(counts.iter().map(of).collect())
}

impl EveryIterate {
    /// What the first `starts` runs of each task say.
    fn of(runs: &[Vec<Run>], starts: usize) -> Self {
        let mut every = Self { any: 0, end: 0, certified: 0, firsts: Vec::new() };
        for runs in runs {
            let runs = &runs[..starts.min(runs.len())];
            let first = runs.iter().filter_map(|run| run.first_feasible).min();
            every.any += usize::from(first.is_some());
            every.end += usize::from(runs.iter().any(|run| run.feasible_at_end));
            every.certified += usize::from(runs.iter().any(|run| run.first_certified.is_some()));
            every.firsts.push(first);
        }
        every
    }
}

/// The runs of every task.
fn all_runs(
    sets: &[TaskSet],
    method: &Method,
    options: &Options,
    race: bool,
    bar: &ProgressBar,
) -> Result<Vec<Vec<Run>>, Failure> {
    let mut all = Vec::new();
    for set in sets {
        let run_one = |scene: &Arc<Scene>, index: usize, task: &Task| {
            let outcome = all_starts(scene, task, index as u64, method, options, race);
            bar.inc(1);
            outcome
        };
        all.extend(in_scenes(set, options, run_one)?);
    }
    Ok(all)
}

/// Microseconds per iteration as planning makes them, until a start is certified: those of the first `timed` tasks of each
/// set that take a step, one after the other on this thread, over all of their steps. `None` if none does.
pub fn us_per_iteration(
    sets: &[TaskSet],
    method: &Method,
    options: &Options,
    timed: usize,
) -> Result<Option<f64>, Failure> {
    let (mut seconds, mut steps) = (0.0, 0);
    for set in sets {
        for (first, tasks) in by_world(&set.tasks[..timed.min(set.tasks.len())]) {
            let scene = Arc::new(Scene::of(&tasks[0], &options.profile));
            for (offset, task) in tasks.iter().enumerate() {
                let walk = Walk::new(&scene, task, (first + offset) as u64, method, options)?;
                let (seconds_of_task, steps_of_task) = walk.until_certified()?;
                if steps_of_task > 0 {
                    seconds += seconds_of_task;
                    steps += steps_of_task;
                }
            }
        }
    }
    Ok((steps > 0).then(|| seconds * 1e6 / steps as f64))
}

/// The starts of one task.
struct Walk<'a> {
    task: &'a Task,
    index: u64,
    method: &'a Method,
    options: &'a Options,
    objective: Objective,
    x: Vec<f32>,
}

impl<'a> Walk<'a> {
    fn new(
        scene: &Arc<Scene>,
        task: &'a Task,
        index: u64,
        method: &'a Method,
        options: &'a Options,
    ) -> Result<Self, InvalidInput> {
        let waypoints = options.waypoints.unwrap_or(options.profile.waypoints);
        let objective = Objective::new(task, scene.clone(), waypoints)?;
        let x = vec![0.0; objective.dim()];
        Ok(Self { task, index, method, options, objective, x })
    }

    /// Puts x at a start, and begins the method there.
    fn begin(&mut self, start: usize) -> Result<Optimizer, InvalidInput> {
        let Self { task, index, method, options, objective, x } = self;
        if start == 0 {
            objective.straight_line(x);
        } else {
            let mut rng = stream(options.seed, Purpose::Start, *index, start as u64);
            options.strategy.draw(objective, &mut rng, x);
        }
        let rng = stream(options.seed, Purpose::Planner, *index, start as u64);
        Optimizer::new(method, task, objective, rng)
    }

    /// Seconds and steps until the first start is certified.
    fn until_certified(mut self) -> Result<(f64, usize), InvalidInput> {
        let (mut seconds, mut steps) = (0.0, 0);
        for start in 0..self.options.starts {
            let mut optimizer = self.begin(start)?;
            let (objective, most) = (&mut self.objective, self.options.steps);
            optimizer.prepare(objective);
            let begin = Instant::now();
            let go_on = |_: &Iteration<'_>| ControlFlow::Continue(());
            let found = run(objective, &mut optimizer, &mut self.x, most, Until::Certified, go_on);
            seconds += begin.elapsed().as_secs_f64();
            steps += found.steps;
            if found.first_certified.is_some() {
                break;
            }
        }
        Ok((seconds, steps))
    }
}

/// Runs every start. In a race a run ends where it is certified, or where no later iterate could be the first of all starts.
fn all_starts(
    scene: &Arc<Scene>,
    task: &Task,
    index: u64,
    method: &Method,
    options: &Options,
    race: bool,
) -> Result<Vec<Run>, InvalidInput> {
    let mut walk = Walk::new(scene, task, index, method, options)?;
    let mut runs = Vec::with_capacity(options.starts);
    for start in 0..options.starts {
        let mut optimizer = walk.begin(start)?;
        let first = |pick: fn(&Run) -> Option<usize>| runs.iter().filter_map(pick).min();
        let steps = match (first(|run| run.first_feasible), first(|run| run.first_certified)) {
            (Some(feasible), Some(_)) if race => options.steps.min(feasible),
            _ => options.steps,
        };
        let (objective, x) = (&mut walk.objective, &mut walk.x);
        let found = run(objective, &mut optimizer, x, steps, Until::Spent, |seen| {
            if race && seen.solved { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        runs.push(found);
    }
    Ok(runs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use sidestep::profile::Profile;
    use sidestep::suite::Suite;

    #[test]
    fn a_race_finds_what_running_every_start_to_the_end_finds() {
        let tasks = Suite::Mix.generate(40, 7, &Profile::PAPER);
        let exact = vec![Exact::Undecided; tasks.len()];
        let sets = [TaskSet { label: "seed 7".into(), tasks, exact }];
        let method = Method::GradientDescent { step: Some(0.5) };
        let options = Options { profile: Profile::PAPER, steps: 60, ..Options::default() };
        let counts = [1, 3, 6];
        let raced = race(&sets, &method, &options, &counts).unwrap();
        for (starts, raced) in counts.into_iter().zip(raced) {
            let options = Options { starts, ..options.clone() };
            let every = every_iterate(&sets, &method, &options, &ProgressBar::hidden()).unwrap();
            assert_eq!((raced.any, raced.certified), (every.any, every.certified));
            assert_eq!(raced.firsts, every.firsts);
            assert_eq!(raced.end, 0);
        }
    }
}
