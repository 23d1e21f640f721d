//! Planning: from a task to a certified trajectory, or the reason why there is none.
//!
//! A plan is [`Status::Solved`] only when the exact certificate passes its trajectory, whatever the
//! profile calls feasible. Optimizers run from several starts, and the best certified plan wins;
//! [`Planner::Auto`] goes on to the exact shortest path where optimizers fail (`auto`), so it
//! answers every task that has an answer.

mod answer;
mod auto;
pub mod planner_name;
pub mod rrt_connect;
pub mod run;
pub mod smooth;
pub mod starts;

pub use answer::{Origin, Plan, Reason, Status};
pub use auto::Auto;

use std::ops::ControlFlow;
use std::sync::Arc;

use rayon::prelude::*;

use crate::error::InvalidInput;
use crate::objective::Objective;
use crate::optimizer::{Method, Optimizer};
use crate::plan::rrt_connect::{RrtConnect, RrtRun};
use crate::plan::run::{Iteration, Run, Until, run};
use crate::plan::starts::StartStrategy;
use crate::plane::shortest_path::{Doubt, Proof, Route};
use crate::profile::{MAX_WAYPOINTS, Profile};
use crate::rng::{Purpose, stream};
use crate::scene::{Query, Refused, Scene, Task};
use crate::trajectory::Trajectory;
use crate::trajectory::waypoints::polyline;

/// How to look for a plan.
#[derive(Debug, Clone)]
pub enum Planner {
    /// An optimizer from one or more starts.
    Optimizer(Method),
    /// RRT-Connect with shortcutting.
    RrtConnect(RrtConnect),
    /// The exact shortest path.
    ShortestPath,
    /// Optimizers; where those fail or find a detour, the exact shortest path made smooth.
    Auto(Auto),
}

/// When planning ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stop {
    /// At the first certified plan.
    #[default]
    First,
    /// When the steps are spent, with the certified plan of least U.
    Best,
}

/// What a planner may use.
#[derive(Debug, Clone)]
pub struct Options {
    /// Constants of the objective.
    pub profile: Profile,
    /// Waypoints between start and goal; the profile's where none.
    pub waypoints: Option<usize>,
    /// Start trajectories of an optimizer, at least 1; the first is the straight line.
    pub starts: usize,
    /// How the others are drawn.
    pub strategy: StartStrategy,
    /// Optimizer steps per start.
    pub steps: usize,
    /// When planning ends.
    pub stop: Stop,
    /// Seed of everything random.
    pub seed: u64,
    /// Number of the random stream, so that the tasks of a batch differ.
    pub index: u64,
    /// A trajectory to start from instead of the straight line.
    pub warm_start: Option<Trajectory>,
    /// Whether a failed search is followed by one for a proof that there is no path.
    pub prove: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            profile: Profile::DEFAULT,
            waypoints: None,
            starts: 1,
            strategy: StartStrategy::default(),
            steps: 200,
            stop: Stop::First,
            seed: 0,
            index: 0,
            warm_start: None,
            prove: false,
        }
    }
}

/// Most start trajectories of one plan.
pub const MAX_STARTS: usize = 1_000_000;
/// Most optimizer steps per start.
pub const MAX_STEPS: usize = 100_000_000;

/// Who watches a planner at work, from any thread.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Sees every iterate of every start.
    pub see: &'a (dyn Fn(&Iteration<'_>) + Sync),
    /// Asked at every iterate and all along the exact search; once it is false, planning ends with the best certified plan so
    /// far. What a world prepares once is not broken off, nor is the sampling planner.
    pub go_on: &'a (dyn Fn() -> bool + Sync),
}

impl Watch<'_> {
    /// Nobody.
    pub const NONE: Watch<'static> = Watch { see: &|_| {}, go_on: &|| true };

    /// Shows an iterate and asks whether to go on.
    pub fn look(&self, iteration: &Iteration<'_>) -> ControlFlow<()> {
        (self.see)(iteration);
        if (self.go_on)() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }
}

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
    let plans: Result<Vec<Vec<Plan>>, _> = by_setting(tasks)
        .into_par_iter()
        .map(|(first, neighbours)| {
            let scene = Arc::new(Scene::of(&neighbours[0], &options.profile));
            let plan_one = |(offset, task)| {
                let options = Options { index: (first + offset) as u64, ..options.clone() };
                plan_in(&Query::new(&scene, task)?, planner, &options, Watch::NONE)
            };
            neighbours.par_iter().enumerate().map(plan_one).collect()
        })
        .collect();
    Ok(plans?.into_iter().flatten().collect())
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
    match planner {
        Planner::Optimizer(method) => {
            Ok(or_proof(optimize(query, method, options, watch)?, query, options, watch))
        }
        Planner::RrtConnect(rrt) => Ok(or_proof(tree(query, rrt, options), query, options, watch)),
        Planner::ShortestPath => shortest(query, watch)
            .ok_or_else(|| InvalidInput::new("planner", "shortest-path", "a robot in the plane")),
        Planner::Auto(auto) => auto.plan(query, options, watch),
    }
}

/// The plan; where it is not solved and the options ask for it, with the proof that there is none.
fn or_proof(plan: Plan, query: &Query, options: &Options, watch: Watch<'_>) -> Plan {
    if plan.is_solved() || !options.prove {
        return plan;
    }
    match query.scene().exact(query.start(), query.goal(), watch.go_on) {
        Some(Route::Unsolvable(proof)) => Plan { status: Status::Unsolvable(proof), ..plan },
        _ => plan,
    }
}

impl Options {
    /// Checks every number's range, as planning does before it begins.
    ///
    /// # Errors
    /// If one is out of range.
    pub fn check(&self) -> Result<(), InvalidInput> {
        let range = |field, value: usize, least: usize, most: usize| {
            let allowed = || format!("a number from {least} to {most}");
            let fits = (least..=most).contains(&value);
            fits.then_some(()).ok_or_else(|| InvalidInput::new(field, value, allowed()))
        };
        let waypoints = self.waypoints.unwrap_or(self.profile.waypoints);
        range("waypoints", waypoints, 1, MAX_WAYPOINTS)?;
        range("starts", self.starts, 1, MAX_STARTS)?;
        range("steps", self.steps, 0, MAX_STEPS)
    }
}

/// One start's run: its waypoints end at the last iterate.
struct Attempt {
    start: usize,
    run: Run,
    waypoints: Vec<f32>,
}

fn optimize(
    query: &Query,
    method: &Method,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Plan, InvalidInput> {
    let waypoints = options.waypoints.unwrap_or(query.scene().profile().waypoints);
    let mut objective = Objective::new(query, waypoints)?;
    let attempt = |objective: &mut Objective, start: usize| {
        let mut x = vec![0.0; objective.dim()];
        let mut rng = stream(options.seed, Purpose::Start, options.index, start as u64);
        match (&options.warm_start, start) {
            (Some(warm), 0) => resample(objective, warm, &mut x)?,
            (None, 0) => objective.straight_line(&mut x),
            _ => options.strategy.draw(objective, &mut rng, &mut x),
        }
        attempt(objective, method, options, start, x, watch)
    };
    let first = attempt(&mut objective, 0)?;
    if options.stop == Stop::First && first.run.best.is_some() || options.starts == 1 {
        return Ok(chosen(&objective, options, vec![first]));
    }
    let other = |start: usize| attempt(&mut objective.clone(), start);
    let others: Result<Vec<_>, _> = (1..options.starts).into_par_iter().map(other).collect();
    let attempts = std::iter::once(first).chain(others?).collect();
    Ok(chosen(&objective, options, attempts))
}

/// Runs the method from the waypoints `x`.
fn attempt(
    objective: &mut Objective,
    method: &Method,
    options: &Options,
    start: usize,
    mut x: Vec<f32>,
    watch: Watch<'_>,
) -> Result<Attempt, InvalidInput> {
    let rng = stream(options.seed, Purpose::Planner, options.index, start as u64);
    let mut optimizer = Optimizer::new(method, objective, rng)?;
    let until = match options.stop {
        Stop::First => Until::Certified,
        Stop::Best => Until::Spent,
    };
    let run = run(objective, &mut optimizer, &mut x, options.steps, until, |iteration| {
        watch.look(&Iteration { start, ..*iteration })
    });
    Ok(Attempt { start, run, waypoints: x })
}

/// The certified attempt of least U, the earliest at a tie; else the first start's failure.
fn chosen(objective: &Objective, options: &Options, attempts: Vec<Attempt>) -> Plan {
    let starts = attempts.len();
    let solved = attempts.iter().filter_map(|a| a.run.best.as_ref().map(|best| (a, best)));
    let best = solved.min_by(|(_, p), (_, q)| p.cost.total_cmp(&q.cost));
    // The certificate has passed the best iterate: so it does the trajectory that is made of it.
    let first = &attempts[0];
    let (attempt, waypoints, steps) = match best {
        Some((attempt, best)) => {
            let steps = attempt.run.first_certified.unwrap_or(attempt.run.steps);
            (attempt, &best.waypoints, steps)
        }
        None => (first, &first.waypoints, first.run.steps),
    };
    let origin = match attempt.start {
        0 => Origin::FirstStart,
        start => Origin::RandomStart(start),
    };
    match objective.query().certify(objective.trajectory(waypoints)) {
        // Also where the paper's check refuses a point on a wall that the exact one passes.
        Ok(certified) => Plan { status: Status::Solved(certified), attempt: None, steps, origin },
        Err(Refused { violation, trajectory }) => {
            let reason = if steps < options.steps {
                Reason::BrokenOff { steps, violation }
            } else {
                Reason::StepsSpent { steps, starts, violation }
            };
            Plan { status: Status::Unsolved(reason), attempt: Some(trajectory), steps, origin }
        }
    }
}

/// Spreads the objective's waypoints evenly along a trajectory's interior points.
fn resample(
    objective: &Objective,
    trajectory: &Trajectory,
    x: &mut [f32],
) -> Result<(), InvalidInput> {
    let dof = objective.dof();
    if trajectory.dof() != dof {
        let found = format!("configurations of {} numbers", trajectory.dof());
        let allowed = format!("configurations of {dof} numbers, as the task's robot has");
        return Err(InvalidInput::new("warm_start", found, allowed));
    }
    let inner = 1..trajectory.len().max(2) - 1;
    let inner = trajectory.values().get(inner.start * dof..inner.end * dof).unwrap_or(&[]);
    let mut corners = vec![0.0; inner.len() + 2 * dof];
    corners[..dof].copy_from_slice(objective.start());
    objective.scene().to_normalised(inner, &mut corners[dof..dof + inner.len()]);
    corners[dof + inner.len()..].copy_from_slice(objective.goal());
    polyline(dof, &corners, x);
    Ok(())
}

/// The exact answer, where there is a search for it.
fn shortest(query: &Query, watch: Watch<'_>) -> Option<Plan> {
    let origin = Origin::ShortestPath;
    Some(match query.scene().exact(query.start(), query.goal(), watch.go_on)? {
        Route::Found { trajectory, .. } => Plan::of(query, trajectory, 0, origin),
        Route::Unsolvable(Proof::End(violation)) => Plan::none(Status::Invalid(violation), origin),
        Route::Unsolvable(proof) => Plan::none(Status::Unsolvable(proof), origin),
        Route::Undecided(doubt) => Plan::none(undecided(doubt), origin),
    })
}

fn undecided(doubt: Doubt) -> Status {
    Status::Unsolved(Reason::Undecided(doubt))
}

fn tree(query: &Query, rrt: &RrtConnect, options: &Options) -> Plan {
    let mut rng = stream(options.seed, Purpose::Planner, options.index, 0);
    let RrtRun { trajectory, samples, .. } = rrt.plan(query, &mut rng);
    match trajectory {
        Some(trajectory) => Plan::of(query, trajectory, 0, Origin::Tree),
        None => Plan::none(Status::Unsolved(Reason::SamplesSpent { samples }), Origin::Tree),
    }
}
