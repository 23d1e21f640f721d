//! Times on one thread, one task after the other.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use sidestep::InvalidInput;
use sidestep::optimizer::Method;
use sidestep::plan::run::{Iteration, Until, run};
use sidestep::plan::{Options, Planner, by_setting};
use sidestep::scene::{Query, Scene};

use super::iterates::Walk;
use super::measure::{TaskSet, plan_indexed};
use crate::failure::Failure;

/// Microseconds on one thread.
#[derive(Default)]
pub(super) struct Times {
    /// From task to answer, of each task. Where tasks share a world, without what they share.
    pub plans: Vec<f64>,
    /// What the tasks of a world share: the first answer there less the same answer again.
    pub worlds: Vec<f64>,
}

/// Times the first `timed` tasks of each set, one after the other.
pub(super) fn times(
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
            for (first, tasks) in by_setting(&set.tasks[..timed.min(set.tasks.len())]) {
                let begin = Instant::now();
                let scene = Arc::new(Scene::of(&tasks[0], &options.profile));
                let query = Query::new(&scene, &tasks[0])?;
                std::hint::black_box(plan_indexed(&query, first, planner, options)?);
                let cold = begin.elapsed().as_secs_f64() * 1e6;
                if tasks.len() == 1 {
                    times.plans.push(cold);
                    continue;
                }
                let before = times.plans.len();
                for (offset, task) in tasks.iter().enumerate() {
                    let begin = Instant::now();
                    let index = first + offset;
                    let query = Query::new(&scene, task)?;
                    std::hint::black_box(plan_indexed(&query, index, planner, options)?);
                    times.plans.push(begin.elapsed().as_secs_f64() * 1e6);
                }
                times.worlds.push((cold - times.plans[before]).max(0.0));
            }
        }
        Ok(times)
    })
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
        for (first, tasks) in by_setting(&set.tasks[..timed.min(set.tasks.len())]) {
            let scene = Arc::new(Scene::of(&tasks[0], &options.profile));
            for (offset, task) in tasks.iter().enumerate() {
                let query = Query::new(&scene, task)?;
                let walk = Walk::new(&query, (first + offset) as u64, method, options)?;
                let (seconds_of_task, steps_of_task) = until_certified(walk)?;
                if steps_of_task > 0 {
                    seconds += seconds_of_task;
                    steps += steps_of_task;
                }
            }
        }
    }
    Ok((steps > 0).then(|| seconds * 1e6 / steps as f64))
}

/// Seconds and steps until the first start is certified.
fn until_certified(mut walk: Walk<'_>) -> Result<(f64, usize), InvalidInput> {
    let (mut seconds, mut steps) = (0.0, 0);
    for start in 0..walk.options.starts {
        let mut optimizer = walk.begin(start)?;
        let (objective, most) = (&mut walk.objective, walk.options.steps);
        optimizer.prepare(objective);
        let begin = Instant::now();
        let go_on = |_: &Iteration<'_>| ControlFlow::Continue(());
        let found = run(objective, &mut optimizer, &mut walk.x, most, Until::Certified, go_on);
        seconds += begin.elapsed().as_secs_f64();
        steps += found.steps;
        if found.first_certified.is_some() {
            break;
        }
    }
    Ok((seconds, steps))
}
