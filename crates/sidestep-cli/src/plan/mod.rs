//! `sidestep plan`: one task, one certified plan or the reason why not.

use std::path::PathBuf;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use clap::Args;
use sidestep::objective::Objective;
use sidestep::plan::run::Iteration;
use sidestep::plan::{Plan, Planner, Status, Stop, Watch, plan_in};
use sidestep::plane::geometry::Point;
use sidestep::plane::{explain, points};
use sidestep::scene::Query;
use sidestep::{InvalidInput, Obstacle, Task, Trajectory};
use sidestep_io::input::Question;
use sidestep_io::plan_json::{self, PlanDocument, TraceStep};

use crate::Global;
use crate::failure::Failure;
use crate::input::{self, Input, InputArgs, parse_point};
use crate::obstacle::{parse_obstacle, with_obstacles};
use crate::output;
use crate::planning::{PlanningArgs, planner, planner_names};

mod draw;
mod files;

const EXAMPLES: &str = "\
Examples:
  sidestep plan task.json --png picture.png
  sidestep plan map.yaml --start 1.5,1.5 --goal 18,11 --robot-radius 0.2 --margin 0.05
  sidestep plan task.json --planner gd --compare adam,sidestep-1 --trace --svg picture.svg
  sidestep plan task.json --budget-ms 20 --out plan.json";

/// Arguments of `plan`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct PlanArgs {
    /// Task .json or .jsonl, MovingAI .map or .scen, ROS map .yaml, BARN worlds .json, MPNet worlds .dat
    input: PathBuf,
    /// Which task of the file, from 0
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, help_heading = "Task")]
    index: usize,
    /// Start in place of the file's
    #[arg(long, value_parser = parse_point, allow_hyphen_values = true, help_heading = "Task")]
    start: Option<Point>,
    /// Goal in place of the file's
    #[arg(long, value_parser = parse_point, allow_hyphen_values = true, help_heading = "Task")]
    goal: Option<Point>,
    /// An obstacle beside the file's: rect:X0,Y0,X1,Y1, circle:X,Y,RADIUS or polygon:X,Y;X,Y;X,Y; may be
    /// repeated
    #[arg(long, value_parser = parse_obstacle, help_heading = "Task")]
    obstacle: Vec<Obstacle>,
    #[command(flatten, next_help_heading = "Task")]
    from: InputArgs,
    /// Planner, as NAME[:key=value,...]; `sidestep planners` lists them
    #[arg(long, default_value = "auto", help_heading = "Planner")]
    planner: String,
    /// Planners to draw beside the first, each in a panel of its own: NAME,NAME
    #[arg(long, help_heading = "Planner")]
    compare: Vec<String>,
    #[command(flatten, next_help_heading = "Planner")]
    planning: PlanningArgs,
    /// Use the whole budget and keep the best certified plan, instead of the first
    #[arg(long, help_heading = "Planner")]
    best: bool,
    /// Stop after this many milliseconds with the best certified plan so far
    #[arg(long, allow_negative_numbers = true, help_heading = "Planner")]
    budget_ms: Option<f64>,
    /// Distance that the plan keeps from obstacles and walls, certified as if the robot were so much
    /// larger, in task units
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, help_heading = "Task")]
    margin: f64,
    /// Start from the waypoints of this plan (a file that `plan --out` wrote)
    #[arg(long, help_heading = "Planner")]
    warm_start: Option<PathBuf>,
    /// Write the result here: .json, or .csv for the plan's points alone
    #[arg(long, help_heading = "Output")]
    out: Option<PathBuf>,
    /// Draw the task and the plan here, as PNG
    #[arg(long, help_heading = "Output")]
    png: Option<PathBuf>,
    /// Draw the task and the plan here, as SVG
    #[arg(long, help_heading = "Output")]
    svg: Option<PathBuf>,
    /// Keep every iterate, in the JSON result and in pictures
    #[arg(long, help_heading = "Output")]
    trace: bool,
    /// Show the iterates one after the other, over and over: a picture that moves, for --svg
    #[arg(long, requires = "svg", help_heading = "Output")]
    animate: bool,
}

/// Plans, prints and draws.
pub fn run(args: &PlanArgs, global: &Global) -> Result<u8, Failure> {
    let (start, goal, clearance) = (args.start, args.goal, args.margin);
    let seed = args.planning.seed;
    let question = Question { start, goal, clearance, seed, ..Question::default() };
    let Input { mut tasks, warnings } = input::read(&args.input, &args.from, question)?;
    if args.index >= tasks.len() {
        let count = tasks.len();
        return Err(Failure::at("--index", format!("{} of {count} tasks, from 0", args.index)));
    }
    let task = with_obstacles(tasks.swap_remove(args.index), &args.obstacle)?;
    let planner = planner(&args.planner)?;
    let compared = planner_names(&args.compare);
    let others: Vec<Planner> = compared
        .iter()
        .map(|name| self::planner(name))
        .collect::<Result<_, Failure>>()
        .map_err(|error| Failure::at("--compare", error))?;
    files::check(args, &compared)?;
    let attempt = attempt(args, &task, &args.planner, &planner)?;
    if args.png.is_some() || args.svg.is_some() {
        let others: Vec<Attempt> = std::iter::zip(&compared, &others)
            .map(|(name, planner)| self::attempt(args, &task, name, planner))
            .collect::<Result<_, Failure>>()?;
        draw::pictures(args, &task, std::iter::once(&attempt).chain(&others))?;
    }
    let status = attempt.plan.status.clone();
    let answer = PlanDocument { warnings, ..answer(args, &task, attempt) };
    let written = args.out.as_ref().map_or(Ok(()), |path| files::write(path, &answer));
    if global.json {
        output::print(&answer.to_json())?;
    } else {
        output::print(&describe(&answer))?;
    }
    written?;
    Ok(match status {
        Status::Solved(_) => 0,
        Status::Invalid(_) => 2,
        _ => 1,
    })
}

/// What one planner did.
pub struct Attempt {
    planner: String,
    query: Query,
    plan: Plan,
    time: Duration,
    trace: Vec<TraceStep>,
    deadline: Option<Instant>,
}

/// Plans the task with the planner of that name.
fn attempt(
    args: &PlanArgs,
    task: &Task,
    name: &str,
    planner: &Planner,
) -> Result<Attempt, Failure> {
    let mut options = args.planning.options(task.plane()?.world.bounds().extent(), &[planner])?;
    options.prove = true;
    if args.best || args.budget_ms.is_some() {
        options.stop = Stop::Best;
    }
    if let Some(path) = &args.warm_start {
        options.warm_start = Some(read_waypoints(path)?);
    }
    let budget = match args.budget_ms {
        Some(ms) if !(ms > 0.0 && ms <= 1e9) => {
            return Err(Failure(format!("--budget-ms: {ms} is not above 0 and at most 1e9")));
        }
        ms => ms.map(|ms| Duration::from_secs_f64(ms / 1e3)),
    };
    let trace = Mutex::new(Vec::new());
    let asked = task
        .with_margin(args.margin)
        .map_err(|error| InvalidInput { field: "--margin".into(), ..error })?;
    let begin = Instant::now();
    let query = Query::of(&asked, &options.profile);
    let see = |iteration: &Iteration<'_>| {
        if (args.trace || args.animate)
            && let Ok(mut steps) = trace.lock()
        {
            steps.push(step(&query, iteration));
        }
    };
    let deadline = budget.map(|budget| begin + budget);
    let watch = Watch { see: &see, go_on: &|| is_time_left(deadline) };
    let plan = plan_in(&query, planner, &options, watch)?;
    let time = begin.elapsed();
    // What is reported and drawn is the robot itself.
    let query = if args.margin > 0.0 { Query::of(task, &options.profile) } else { query };
    let mut trace = trace.into_inner().unwrap_or_default();
    trace.sort_by_key(|step| (step.start, step.iteration));
    Ok(Attempt { planner: name.into(), query, plan, time, trace, deadline })
}

/// Whether the time budget, if there is one, is not spent.
fn is_time_left(deadline: Option<Instant>) -> bool {
    deadline.is_none_or(|deadline| Instant::now() < deadline)
}

/// An iterate in task units. Methods that do not use U leave it to be computed here.
fn step(query: &Query, iteration: &Iteration<'_>) -> TraceStep {
    let objective = Objective::new(query, iteration.waypoints.len() / query.scene().dof()).ok();
    let cost = iteration.cost.or_else(|| Some(objective.clone()?.cost(iteration.waypoints)));
    let cost = cost.unwrap_or_default();
    let trajectory = objective.map(|objective| objective.trajectory(iteration.waypoints));
    TraceStep {
        start: iteration.start,
        iteration: iteration.index,
        objective: cost.total,
        obstacle_cost: cost.obstacle,
        length_cost: cost.length,
        certified: iteration.solved,
        waypoints: trajectory.map_or_else(Vec::new, |trajectory| points(&trajectory).to_vec()),
    }
}

fn answer(args: &PlanArgs, task: &Task, attempt: Attempt) -> PlanDocument {
    let Attempt { planner, query, plan, time, trace, deadline } = attempt;
    let certified = plan.certified();
    let go_on = || is_time_left(deadline);
    let optimal = || query.scene().exact(query.start(), query.goal(), &go_on)?.length();
    PlanDocument {
        status: plan.status.name(),
        reason: match (&plan.status, task.plane()) {
            (Status::Invalid(violation), Ok(task)) => explain(&task, args.margin, violation),
            (status, _) => status.reason(),
        },
        task: task.name.clone(),
        planner,
        origin: certified.map(|_| plan.origin.to_string()),
        iterations: plan.steps,
        time_us: time.as_secs_f64() * 1e6,
        length: certified.map(Trajectory::length),
        optimal_length: certified.and_then(|_| optimal()),
        clearance: certified.map(|path| query.scene().clearance(path)),
        certified: certified.is_some(),
        warnings: Vec::new(),
        waypoints: plan.trajectory().map_or_else(Vec::new, |path| points(path).to_vec()),
        trace: args.trace.then_some(trace),
    }
}

/// The answer in a few lines.
fn describe(answer: &PlanDocument) -> String {
    let mut text = answer.status.to_string();
    if !answer.reason.is_empty() {
        text += &format!(": {}", answer.reason);
    }
    text += &format!(" ({}, {:.0} us)\n", answer.planner, answer.time_us);
    if let (Some(length), Some(clearance), Some(origin)) =
        (answer.length, answer.clearance, &answer.origin)
    {
        text += &format!("{origin} after {} iterations\n", answer.iterations);
        let over = answer.optimal_length.filter(|&optimal| optimal > 0.0);
        let over = over.map_or(String::new(), |optimal| {
            let more = 100.0 * (length / optimal - 1.0).max(0.0);
            format!(" ({more:.1} % over the shortest, {optimal:.3})")
        });
        text += &format!("length {length:.3}{over}, clearance {clearance:.3}\n");
        text += &format!("{} points, certified free of collision\n", answer.waypoints.len());
    }
    text
}

/// The waypoints of a plan file.
fn read_waypoints(path: &std::path::Path) -> Result<Trajectory, Failure> {
    let points = plan_json::read_waypoints(&input::read_text(path)?)
        .map_err(|error| Failure::file(path, error))?;
    Ok(Trajectory::from_points(&points))
}
