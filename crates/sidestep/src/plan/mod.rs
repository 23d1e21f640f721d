//! Planning: from a task to a certified trajectory, or the reason why there is none.
//!
//! A plan is [`Status::Solved`] only when the exact certificate passes its trajectory, whatever the
//! profile calls feasible. Optimizers run from several starts, and the best certified plan wins;
//! [`Planner::Auto`] goes on to the exact shortest path where optimizers fail (`auto`), so it
//! answers every task that has an answer.

mod answer;
mod auto;
pub mod ends;
mod exact;
pub mod fair;
pub mod goals;
mod jointed;
mod mend;
mod optimize;
mod options;
pub(crate) mod parallel;
mod planner;
mod planner_name;
pub mod polish;
mod reason;
pub mod rrt_connect;
pub mod run;
pub mod smooth;
pub mod starts;

pub use answer::{Origin, Plan, Reason, Status};
pub use auto::Auto;
pub use options::{MAX_STARTS, MAX_STEPS, Options, Stop, Watch};
pub use planner::Planner;
pub use planner_name::{PLANNERS, PlannerName, PlannerSetting, parse_planner};
pub use polish::Wishes;
pub use reason::reason;

use std::sync::Arc;

use crate::error::InvalidInput;
use crate::plan::exact::shortest;
use crate::plan::optimize::optimize;
use crate::plan::polish::polish;
use crate::plan::rrt_connect::tree;
use crate::scene::{Query, Scene, Task};

/// Plans one task.
///
/// # Errors
/// If an option is out of range or a learned policy does not fit the task.
pub fn plan(task: &Task, planner: &Planner, options: &Options) -> Result<Plan, InvalidInput> {
    plan_in(&Query::of(task, &options.profile), planner, options, Watch::NONE)
}

/// Plans many tasks on all cores; task i draws from stream i. Results do not depend on the number
/// of threads, nor on whether neighbours share a world.
///
/// # Errors
/// As [`plan()`], for the first task that has one.
pub fn plan_batch(
    tasks: &[Task],
    planner: &Planner,
    options: &Options,
) -> Result<Vec<Plan>, InvalidInput> {
    let runs = by_setting(tasks);
    let plan_run = |run: usize| {
        let (first, neighbours) = runs[run];
        let scene = Arc::new(Scene::of(&neighbours[0], &options.profile));
        parallel::map(neighbours.len(), |offset| {
            let options = Options { index: (first + offset) as u64, ..options.clone() };
            plan_in(&Query::new(&scene, &neighbours[offset])?, planner, &options, Watch::NONE)
        })
    };
    parallel::map(runs.len(), plan_run).into_iter().flatten().collect()
}

/// The runs of neighbouring tasks that have their setting in common, and so a [`Scene`], each
/// with the index of its first task.
pub fn by_setting(tasks: &[Task]) -> Vec<(usize, &[Task])> {
    let mut first = 0;
    let runs = tasks.chunk_by(|a, b| a.setting.is_same(&b.setting));
    runs.map(|run| {
        first += run.len();
        (first - run.len(), run)
    })
    .collect()
}

/// Answers a query; the profile is its scene's, whatever the options say.
///
/// # Errors
/// As [`plan()`].
pub fn plan_in(
    query: &Query,
    planner: &Planner,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Plan, InvalidInput> {
    options.check()?;
    if let Err(violation) = query.check_ends() {
        return Ok(Plan::none(Status::Invalid(violation), Origin::FirstStart));
    }
    let plan = match planner {
        Planner::Optimizer(method) => {
            or_proof(optimize(query, method, options, watch)?, query, options, watch)
        }
        Planner::RrtConnect(rrt) => {
            or_proof(tree(query, rrt, options, watch), query, options, watch)
        }
        Planner::ShortestPath => shortest(query, watch)
            .ok_or_else(|| InvalidInput::new("planner", "shortest-path", "a robot in the plane"))?,
        Planner::Auto(auto) => return auto.plan(query, options, watch),
    };
    Ok(match &options.wishes {
        Some(wishes) => polish(query, plan, wishes, watch),
        None => plan,
    })
}

/// The plan; where it is not solved and the options ask for it, with the proof that there is none.
fn or_proof(plan: Plan, query: &Query, options: &Options, watch: Watch<'_>) -> Plan {
    if plan.is_solved() || !options.prove {
        return plan;
    }
    match query.scene().disproof(query.start(), query.goal(), watch.go_on) {
        Some(proof) => Plan { status: Status::Unsolvable(proof), ..plan },
        None => plan,
    }
}
