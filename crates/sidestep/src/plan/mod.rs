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
use crate::plan::starts::{StartStrategy, polyline};
use crate::plane::certificate::{Certifier, Violation};
use crate::plane::shortest_path::{Proof, Route};
use crate::profile::{MAX_WAYPOINTS, Profile};
use crate::rng::{Purpose, stream};
use crate::scene::Scene;
use crate::task::Task;
use crate::trajectory::Trajectory;

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
    let scene = Arc::new(Scene::of(task, &options.profile));
    plan_in(&scene, task, planner, options, Watch::NONE)
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
    let plans: Result<Vec<Vec<Plan>>, _> = by_world(tasks)
        .into_par_iter()
        .map(|(first, neighbours)| {
            let scene = Arc::new(Scene::of(&neighbours[0], &options.profile));
            let plan_one = |(offset, task)| {
                let options = Options { index: (first + offset) as u64, ..options.clone() };
                plan_in(&scene, task, planner, &options, Watch::NONE)
            };
            neighbours.par_iter().enumerate().map(plan_one).collect()
        })
        .collect();
    Ok(plans?.into_iter().flatten().collect())
}

/// The runs of neighbouring tasks that have a world and a robot in common, and so a [`Scene`], each
/// with the index of its first task.
pub fn by_world(tasks: &[Task]) -> Vec<(usize, &[Task])> {
    let mut first = 0;
    let runs = tasks.chunk_by(|a, b| Arc::ptr_eq(&a.world, &b.world) && a.robot == b.robot);
    runs.map(|run| {
        first += run.len();
        (first - run.len(), run)
    })
    .collect()
}

/// Plans one task in a scene that was prepared for its world and robot and the options' profile.
///
/// # Errors
/// As [`plan()`].
pub fn plan_in(
    scene: &Arc<Scene>,
    task: &Task,
    planner: &Planner,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Plan, InvalidInput> {
    options.check()?;
    if let Err(violation) = check_ends(scene.certifier(), task) {
        return Ok(Plan::invalid(violation));
    }
    match planner {
        Planner::Optimizer(method) => Ok(or_proof(
            optimize(scene, task, method, options, watch)?,
            scene,
            task,
            options,
            watch,
        )),
        Planner::RrtConnect(rrt) => {
            Ok(or_proof(tree(scene.certifier(), task, rrt, options), scene, task, options, watch))
        }
        Planner::ShortestPath => Ok(shortest(scene, task, watch)),
        Planner::Auto(auto) => auto.plan(scene, task, options, watch),
    }
}

/// The plan; where it is not solved and the options ask for it, with the proof that there is none.
fn or_proof(plan: Plan, scene: &Scene, task: &Task, options: &Options, watch: Watch<'_>) -> Plan {
    if plan.status == Status::Solved || !options.prove {
        return plan;
    }
    match scene.shortest_path().find_while(task.start, task.goal, watch.go_on) {
        Route::Unsolvable(proof) => Plan { status: Status::Unsolvable(proof), ..plan },
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
        range("waypoints", self.waypoints(), 1, MAX_WAYPOINTS)?;
        range("starts", self.starts, 1, MAX_STARTS)?;
        range("steps", self.steps, 0, MAX_STEPS)
    }

    fn waypoints(&self) -> usize {
        self.waypoints.unwrap_or(self.profile.waypoints)
    }
}

/// Whether start and goal are themselves free.
fn check_ends(certifier: &Certifier, task: &Task) -> Result<(), Violation> {
    if certifier.point_is_free(task.start) && certifier.point_is_free(task.goal) {
        return Ok(());
    }
    certifier.check(&Trajectory::from_points(&[task.start, task.goal]))
}

/// One start's run: its waypoints end at the last iterate.
struct Attempt {
    start: usize,
    run: Run,
    waypoints: Vec<f32>,
}

fn optimize(
    scene: &Arc<Scene>,
    task: &Task,
    method: &Method,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Plan, InvalidInput> {
    let objective = Objective::new(task, scene.clone(), options.waypoints())?;
    let attempt = |start: usize| {
        let mut objective = objective.clone();
        let mut x = vec![0.0; objective.dim()];
        let mut rng = stream(options.seed, Purpose::Start, options.index, start as u64);
        match (&options.warm_start, start) {
            (Some(warm), 0) => resample(&objective, warm, &mut x),
            (None, 0) => objective.straight_line(&mut x),
            _ => options.strategy.draw(&objective, &mut rng, &mut x),
        }
        attempt(&mut objective, task, method, options, start, x, watch)
    };
    let first = attempt(0)?;
    if options.stop == Stop::First && first.run.best.is_some() || options.starts == 1 {
        return Ok(chosen(&objective, options, vec![first]));
    }
    let others: Result<Vec<_>, _> = (1..options.starts).into_par_iter().map(attempt).collect();
    let attempts = std::iter::once(first).chain(others?).collect();
    Ok(chosen(&objective, options, attempts))
}

/// Runs the method from the waypoints `x`.
fn attempt(
    objective: &mut Objective,
    task: &Task,
    method: &Method,
    options: &Options,
    start: usize,
    mut x: Vec<f32>,
    watch: Watch<'_>,
) -> Result<Attempt, InvalidInput> {
    let rng = stream(options.seed, Purpose::Planner, options.index, start as u64);
    let mut optimizer = Optimizer::new(method, task, objective, rng)?;
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
    if let Some((attempt, best)) = best {
        return Plan {
            status: Status::Solved,
            trajectory: Some(objective.trajectory(&best.waypoints)),
            steps: attempt.run.first_certified.unwrap_or(attempt.run.steps),
            origin: match attempt.start {
                0 => Origin::FirstStart,
                start => Origin::RandomStart(start),
            },
        };
    }
    let first = &attempts[0];
    let trajectory = objective.trajectory(&first.waypoints);
    let steps = first.run.steps;
    let status = match objective.scene().certifier().check(&trajectory) {
        // The paper's check can refuse a point on a wall that the exact one passes.
        Ok(()) => Status::Solved,
        Err(violation) if steps < options.steps => {
            Status::Unsolved(Reason::BrokenOff { steps, violation })
        }
        Err(violation) => Status::Unsolved(Reason::StepsSpent { steps, starts, violation }),
    };
    Plan { status, trajectory: Some(trajectory), steps, origin: Origin::FirstStart }
}

/// Spreads the objective's waypoints evenly along a trajectory's interior points.
fn resample(objective: &Objective, trajectory: &Trajectory, x: &mut [f32]) {
    let frame = objective.scene().frame();
    let inner = trajectory.points().get(1..trajectory.points().len().max(2) - 1).unwrap_or(&[]);
    let corners: Vec<[f32; 2]> = std::iter::once(objective.start())
        .chain(inner.iter().map(|&p| frame.to_normalised(p)))
        .chain([objective.goal()])
        .collect();
    polyline(&corners, x.as_chunks_mut::<2>().0);
}

fn shortest(scene: &Scene, task: &Task, watch: Watch<'_>) -> Plan {
    let route = scene.shortest_path().find_while(task.start, task.goal, watch.go_on);
    let (status, trajectory) = match route {
        Route::Found { trajectory, .. } => (Status::Solved, Some(trajectory)),
        Route::Unsolvable(Proof::End(violation)) => (Status::Invalid(violation), None),
        Route::Unsolvable(proof) => (Status::Unsolvable(proof), None),
        Route::Undecided(doubt) => (Status::Unsolved(Reason::Undecided(doubt)), None),
    };
    Plan { status, trajectory, steps: 0, origin: Origin::ShortestPath }
}

fn tree(certifier: &Certifier, task: &Task, rrt: &RrtConnect, options: &Options) -> Plan {
    if let Err(violation) = check_ends(certifier, task) {
        return Plan::invalid(violation);
    }
    let mut rng = stream(options.seed, Purpose::Planner, options.index, 0);
    let RrtRun { trajectory, samples, .. } = rrt.plan(task, certifier, &mut rng);
    let status = match trajectory {
        Some(_) => Status::Solved,
        None => Status::Unsolved(Reason::SamplesSpent { samples }),
    };
    Plan { status, trajectory, steps: 0, origin: Origin::Tree }
}
