//! Every start of every task, iterate by iterate.

use std::ops::ControlFlow;

use indicatif::ProgressBar;
use sidestep::InvalidInput;
use sidestep::objective::Objective;
use sidestep::optimizer::{Method, Optimizer};
use sidestep::plan::Options;
use sidestep::plan::run::{Run, Until, run};
use sidestep::rng::{Purpose, stream};
use sidestep::scene::Query;

use super::measure::{TaskSet, in_scenes};
use crate::failure::Failure;

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
        let run_one = |query: &Query, index: usize| {
            let outcome = all_starts(query, index as u64, method, options, race);
            bar.inc(1);
            outcome
        };
        all.extend(in_scenes(set, options, run_one)?);
    }
    Ok(all)
}

/// The starts of one task.
pub(super) struct Walk<'a> {
    index: u64,
    method: &'a Method,
    pub options: &'a Options,
    pub objective: Objective,
    pub x: Vec<f32>,
}

impl<'a> Walk<'a> {
    pub fn new(
        query: &Query,
        index: u64,
        method: &'a Method,
        options: &'a Options,
    ) -> Result<Self, InvalidInput> {
        let waypoints = options.waypoints.unwrap_or(options.profile.waypoints);
        let objective = Objective::new(query, waypoints)?;
        let x = vec![0.0; objective.dim()];
        Ok(Self { index, method, options, objective, x })
    }

    /// Puts x at a start, and begins the method there.
    pub fn begin(&mut self, start: usize) -> Result<Optimizer, InvalidInput> {
        let Self { index, method, options, objective, x } = self;
        if start == 0 {
            objective.straight_line(x);
        } else {
            let mut rng = stream(options.seed, Purpose::Start, *index, start as u64);
            options.strategy.draw(objective, &mut rng, x);
        }
        let rng = stream(options.seed, Purpose::Planner, *index, start as u64);
        Optimizer::new(method, objective, rng)
    }
}

/// Runs every start. In a race a run ends where it is certified, or where no later iterate could be the first of all starts.
fn all_starts(
    query: &Query,
    index: u64,
    method: &Method,
    options: &Options,
    race: bool,
) -> Result<Vec<Run>, InvalidInput> {
    let mut walk = Walk::new(query, index, method, options)?;
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
    use crate::bench::measure::Exact;
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
