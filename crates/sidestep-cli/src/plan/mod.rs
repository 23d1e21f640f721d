//! `sidestep plan`: one task, one certified plan or the reason why not.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use sidestep::plan::ends::plan_with_margin;
use sidestep::plan::run::Iteration;
use sidestep::plan::{Options, Plan, Planner, Status, Stop, Watch, Wishes, reason};
use sidestep::plane::ends::EndChange;
use sidestep::scene::Query;
use sidestep::{InvalidInput, Obstacle, PlaneTask, Setting, Task, Trajectory};
use sidestep_io::input::Question;
use sidestep_io::plan_json::{self, PlanDocument, Trace, TraceStep};
use sidestep_io::replay;

use crate::Global;
use crate::bends::{BendArgs, broken};
use crate::driving::DriveArgs;
use crate::failure::Failure;
use crate::input::{self, Configuration, Input, InputArgs, parse_configuration};
use crate::obstacle::{parse_obstacle, with_obstacles};
use crate::output;
use crate::planning::{PlanningArgs, planner, planner_names};
use crate::robots::tasks;
use crate::smooth::read_path;

mod controller;
mod draw;
mod files;
mod goals;
mod page;

const EXAMPLES: &str = "\
Examples:
  sidestep plan task.json --png picture.png
  sidestep plan map.yaml --start 1.5,1.5 --goal 18,11 --robot-radius 0.2 --margin 0.05
  sidestep plan task.json --planner gd --compare adam,sidestep-1 --trace --svg picture.svg
  sidestep plan task.json --planner gd --compare adam,sidestep-1 --html replay.html
  sidestep plan task.json --budget-ms 20 --out plan.json
  sidestep plan --robot panda.urdf --scene shelf.yaml --start 0,-0.8,0,-2.4,0,1.6,0.8 --goal 1,0.2,0,-1.9,0,2,0.8
  sidestep plan problems.json --index 3 --html way.html --trajectory trajectory.yaml";

/// Arguments of `plan`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct PlanArgs {
    /// Task .json or .jsonl, MovingAI .map or .scen, ROS map .yaml, BARN worlds .json, MPNet worlds .dat, problems of a
    /// robot with joints .json; or nothing, and --robot, --start and --goal
    input: Option<PathBuf>,
    /// Which task of the file, from 0
    #[arg(long, default_value_t = 0, allow_negative_numbers = true, help_heading = "Task")]
    index: usize,
    /// Start in place of the file's: X,Y, or a number for each joint (rad or m)
    #[arg(long, value_parser = parse_configuration, allow_hyphen_values = true, help_heading = "Task")]
    start: Option<Configuration>,
    /// Goal in place of the file's; several of a robot with joints, any of which will do
    #[arg(long, value_parser = parse_configuration, allow_hyphen_values = true, help_heading = "Task")]
    goal: Vec<Configuration>,
    /// Where a link is to be, in the frame of the robot's root: X,Y,Z,QX,QY,QZ,QW@LINK in metres and as a quaternion; may be repeated
    #[arg(long, value_name = "POSE", value_parser = goals::parse_goal_pose, allow_hyphen_values = true, help_heading = "Robot with joints")]
    goal_pose: Vec<goals::GoalPose>,
    /// What is around a robot with joints: scene JSON, MoveIt .yaml or .scene, cuRobo .yaml, .pcd, .ply, .xyz, .stl, .obj
    #[arg(long, requires = "robot", conflicts_with = "input", help_heading = "Robot with joints")]
    scene: Option<PathBuf>,
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
    /// larger, in task units; relaxed near a start or goal that is nearer to something, and the answer says so
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, help_heading = "Task")]
    margin: f64,
    /// Move a start or goal where the robot cannot stand to the nearest place where it can, at most so far, in task units; the answer
    /// says so
    #[arg(long, value_name = "DISTANCE", allow_negative_numbers = true, help_heading = "Task")]
    snap: Option<f64>,
    /// Round the plan's corners off, whatever the planner (`auto` does it anyway), certified at every move
    #[arg(long, help_heading = "Planner")]
    polish: bool,
    #[command(flatten, next_help_heading = "Planner")]
    bends: BendArgs,
    /// Start from the waypoints of this plan (a file that `plan --out` wrote)
    #[arg(long, help_heading = "Planner")]
    warm_start: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Output")]
    driving: DriveArgs,
    /// Write the result here: .json, .csv (x,y,yaw,t,v,kappa), .yaml (nav_msgs/Path), .geojson or .mcap (ROS 2
    /// messages, with --trace the iterates too)
    #[arg(long, help_heading = "Output")]
    out: Option<PathBuf>,
    /// Write here when a robot with joints is where along the plan: a ROS JointTrajectory as .yaml or .json, or .csv
    #[arg(long, help_heading = "Output")]
    trajectory: Option<PathBuf>,
    /// Share of the joints' top speeds that --trajectory uses, above 0 and up to 1
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, help_heading = "Output")]
    speed: f64,
    /// Most acceleration of every joint for --trajectory, rad/s² or m/s² [default: top speed within half a second]
    #[arg(long, allow_negative_numbers = true, help_heading = "Output")]
    acceleration: Option<f64>,
    /// How far before and after a corner of the plan --trajectory may leave it, in joint space; as far as that is proved free
    #[arg(long, default_value_t = 0.2, allow_negative_numbers = true, help_heading = "Output")]
    blend: f64,
    /// Show the optimizers at work here: one HTML page with a slider over iterations, the planners of --compare side by side; of a
    /// robot with joints its way in three dimensions
    #[arg(long, help_heading = "Output")]
    html: Option<PathBuf>,
    /// Draw the task and the plan here, as PNG
    #[arg(long, help_heading = "Output")]
    png: Option<PathBuf>,
    /// Draw the task and the plan here, as SVG
    #[arg(long, help_heading = "Output")]
    svg: Option<PathBuf>,
    /// Keep every iterate, in the JSON result and in pictures
    #[arg(long, help_heading = "Output")]
    trace: bool,
    /// Show the iterates one after the other, over and over: pictures that move, as --svg and as an animated --png
    #[arg(long, help_heading = "Output")]
    animate: bool,
}

/// Plans, prints and draws.
pub fn run(args: &PlanArgs, global: &Global) -> Result<u8, Failure> {
    args.bends.check()?;
    args.driving.check()?;
    let Asked { task, more_goals, mut warnings } = asked(args)?;
    let mut task = with_obstacles(task, &args.obstacle)?;
    if let Some(most) = args.snap {
        let moved = task.snapped(args.margin, most);
        let (ends, changes) = moved.map_err(|error| match error.field.as_str() {
            "snap" => InvalidInput { field: "--snap".into(), ..error },
            _ => error,
        })?;
        task = ends;
        for change in &changes {
            output::tell(&format!("warning: {change}"));
        }
        warnings.extend(changes.iter().map(ToString::to_string));
    }
    if let (Some(out), Err(_)) = (&args.out, task.plane()) {
        output::check_suffix(("--out", out), &["json", "csv"])?;
    }
    if task.plane().is_err() && !args.compare.is_empty() && args.html.is_some() {
        let need = "--html shows one planner of a robot with joints; compare with --png or --svg";
        return Err(Failure::at("--compare", need));
    }
    let planner = planner(&args.planner)?;
    let compared = planner_names(&args.compare);
    let others: Vec<Planner> = compared
        .iter()
        .map(|name| self::planner(name))
        .collect::<Result<_, Failure>>()
        .map_err(|error| Failure::at("--compare", error))?;
    files::check(args, &compared)?;
    let (task, attempt) = goals::plan(args, goals::tasks(args, task, more_goals)?, &planner)?;
    let others: Vec<Attempt> = std::iter::zip(&compared, &others)
        .map(|(name, planner)| {
            let options = options(args, &task, planner)?;
            self::attempt(args, &task, name, planner, &options, budget(args)?)
        })
        .collect::<Result<_, Failure>>()?;
    let attempts = std::iter::once(&attempt).chain(&others);
    if args.png.is_some() || args.svg.is_some() {
        draw::pictures(args, &task, attempts.clone())?;
    }
    let status = attempt.plan.status.clone();
    let trajectory = args.trajectory.as_ref().map(|path| controller::write(args, path, &attempt));
    match (&args.html, task.plane()) {
        (Some(path), Ok(plane)) => replayed(args, path, &task, plane, attempts)?,
        (Some(path), Err(_)) => page::write(args, path, &task, &attempt)?,
        (None, _) => {}
    }
    let mut answer = answer(args, &task, attempt);
    let told = warnings.len();
    answer.warnings.splice(0..0, warnings);
    let written = args.out.as_ref().map_or(Ok(()), |path| match task.plane() {
        Ok(plane) => args.driving.write(path, &answer, plane.world),
        Err(_) => files::write(path, &answer),
    });
    for warning in &answer.warnings[told..] {
        output::tell(&format!("warning: {warning}"));
    }
    if global.json {
        output::print(&answer.to_json())?;
    } else {
        output::print(&describe(&answer))?;
    }
    written?;
    trajectory.transpose()?;
    Ok(match status {
        Status::Solved(_) => 0,
        Status::Invalid(_) => 2,
        _ => 1,
    })
}

/// What the arguments ask for.
struct Asked {
    task: Task,
    /// Goals of its file that will do as well.
    more_goals: Vec<Vec<f64>>,
    /// What to know about how it was read.
    warnings: Vec<String>,
}

fn asked(args: &PlanArgs) -> Result<Asked, Failure> {
    let numbers = |end: &Option<Configuration>| end.as_ref().map(|end| end.0.clone());
    let (start, goal) = (numbers(&args.start), numbers(&args.goal.first().cloned()));
    let Some(path) = &args.input else {
        // A pose becomes a configuration when the robot is known.
        let goal = goal.or_else(|| start.clone().filter(|_| !args.goal_pose.is_empty()));
        let (Some(_), Some(start), Some(goal)) = (&args.from.robot.robot, start, goal) else {
            let need = "give a file of tasks, or --robot URDF, --start and --goal";
            return Err(Failure(format!("nothing to plan: {need}")));
        };
        let scene = args.scene.as_deref();
        let mut asked = tasks::of_scene(&args.from.robot, scene, [start, goal])?;
        asked.files.iter().for_each(|path| args.from.remember(path));
        let task = asked.tasks.pop().ok_or_else(|| Failure("no task".into()))?;
        return Ok(Asked { task, more_goals: Vec::new(), warnings: asked.warnings });
    };
    let question = Question {
        start: args.start.as_ref().and_then(Configuration::point),
        goal: args.goal.first().and_then(Configuration::point),
        clearance: args.margin,
        seed: args.planning.seed,
        ..Question::default()
    };
    let read = input::read(path, &args.from, question);
    let is_arm = |task: &Task| matches!(task.setting, Setting::Arm { .. });
    if !matches!(&read, Ok(Input { tasks, .. }) if tasks.iter().any(is_arm)) {
        for (flag, end) in [("--start", &start), ("--goal", &goal)] {
            if let Some(found) = end.as_ref().map(Vec::len).filter(|found| *found != 2) {
                let why = "a heading means nothing here";
                let found = format!("expected X,Y, two numbers; found {found} ({why})");
                return Err(Failure::at(flag, found));
            }
        }
    }
    let Input { mut tasks, mut more_goals, warnings } = read?;
    if args.index >= tasks.len() {
        let count = tasks.len();
        return Err(Failure::at("--index", format!("{} of {count} tasks, from 0", args.index)));
    }
    let task = tasks.swap_remove(args.index);
    if !is_arm(&task) {
        return Ok(Asked { task, more_goals: Vec::new(), warnings });
    }
    // Goals of the command line stand in place of the file's.
    let own = goal.is_some() || !args.goal_pose.is_empty() || args.index >= more_goals.len();
    let more_goals = if own { Vec::new() } else { more_goals.swap_remove(args.index) };
    let Task { name, setting, start: from, goal: to } = task;
    let task = Task::new(name, setting, start.unwrap_or(from), goal.unwrap_or(to))?;
    Ok(Asked { task, more_goals, warnings })
}

/// Writes a page on which the optimizers are at work.
fn replayed<'a>(
    args: &PlanArgs,
    path: &Path,
    task: &Task,
    plane: PlaneTask<'_>,
    attempts: impl Iterator<Item = &'a Attempt> + Clone,
) -> Result<(), Failure> {
    let Some(attempt) = attempts.clone().next() else { return Ok(()) };
    let runs = attempts.map(|attempt| {
        let Attempt { planner, query, plan, time, trace, .. } = attempt;
        let why = reason(task, args.margin, query, plan);
        replay::run(planner, query, plan, (*time, why), trace)
    });
    let mut page = replay::replay(plane, &attempt.query, runs.collect());
    if args.margin > 0.0 {
        page.lines.push(format!("margin {}", args.margin));
    }
    output::write_file(path, page.to_html(replay::far(&attempt.query)).as_bytes())
}

/// What one planner did.
pub struct Attempt {
    planner: String,
    /// What was asked, with the margin, and the same without.
    asked: Query,
    query: Query,
    plan: Plan,
    /// Ends near which the margin is not kept.
    relaxed: Vec<EndChange>,
    time: Duration,
    trace: Vec<TraceStep>,
    deadline: Option<Instant>,
}

impl AsRef<Plan> for Attempt {
    fn as_ref(&self) -> &Plan {
        &self.plan
    }
}

/// What the arguments let a planner use.
fn options(args: &PlanArgs, task: &Task, planner: &Planner) -> Result<Options, Failure> {
    let extent = task.plane().ok().map(|task| task.world.bounds().extent());
    let mut options = args.planning.options(extent, &[planner])?;
    options.prove = true;
    options.wishes = args.bends.wishes().or_else(|| args.polish.then(Wishes::default));
    if args.best || args.budget_ms.is_some() {
        options.stop = Stop::Best;
    }
    if let Some(path) = &args.warm_start {
        options.warm_start = Some(read_waypoints(path, task.start.len())?);
    }
    Ok(options)
}

/// The time that the arguments allow.
fn budget(args: &PlanArgs) -> Result<Option<Duration>, Failure> {
    match args.budget_ms {
        Some(ms) if !(ms > 0.0 && ms <= 1e9) => {
            Err(Failure(format!("--budget-ms: {ms} is not above 0 and at most 1e9")))
        }
        ms => Ok(ms.map(|ms| Duration::from_secs_f64(ms / 1e3))),
    }
}

/// Plans the task with the planner of that name, within the time.
fn attempt(
    args: &PlanArgs,
    task: &Task,
    name: &str,
    planner: &Planner,
    options: &Options,
    budget: Option<Duration>,
) -> Result<Attempt, Failure> {
    let trace = Trace::new(usize::MAX);
    let asked = task
        .with_margin(args.margin)
        .map_err(|error| InvalidInput { field: "--margin".into(), ..error })?;
    let begin = Instant::now();
    let asked = Query::of(&asked, &options.profile);
    let see = |iteration: &Iteration<'_>| {
        if args.trace || args.animate || args.html.is_some() {
            trace.see(&asked, iteration);
        }
    };
    let deadline = budget.map(|budget| begin + budget);
    let watch = Watch { see: &see, go_on: &|| is_time_left(deadline) };
    // What is reported and drawn is the robot itself.
    let query = if args.margin > 0.0 { Query::of(task, &options.profile) } else { asked.clone() };
    let (plan, relaxed) = plan_with_margin(&query, &asked, planner, options, watch)?;
    let time = begin.elapsed();
    let trace = trace.into_steps();
    Ok(Attempt { planner: name.into(), asked, query, plan, relaxed, time, trace, deadline })
}

/// Whether the time budget, if there is one, is not spent.
fn is_time_left(deadline: Option<Instant>) -> bool {
    deadline.is_none_or(|deadline| Instant::now() < deadline)
}

fn answer(args: &PlanArgs, task: &Task, attempt: Attempt) -> PlanDocument {
    let Attempt { planner, query, plan, relaxed, time, trace, deadline, .. } = attempt;
    let certified = plan.certified();
    let go_on = || is_time_left(deadline);
    let optimal = || query.scene().exact(query.start(), query.goal(), &go_on)?.length();
    let why = reason(task, args.margin, &query, &plan);
    let made = PlanDocument::of([&task.name, &planner], &query, &plan, time, why);
    let unkept = args.bends.wishes().and_then(|wishes| broken(&wishes, certified?));
    PlanDocument {
        optimal_length: certified.and_then(|_| optimal()),
        warnings: relaxed.iter().map(ToString::to_string).chain(unkept).collect(),
        trace: args.trace.then_some(trace),
        ..made
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
        let clearance = match clearance.is_finite() {
            true => format!("clearance {clearance:.3}"),
            false => "nothing around".into(),
        };
        text += &format!("length {length:.3}{over}, {clearance}");
        let turn = answer.sharpest_turn_deg.unwrap_or(0.0);
        text += &match answer.turning_radius.filter(|radius| radius.is_finite()) {
            Some(_) if answer.joints.is_some() => "\n".into(),
            Some(radius) => format!(", sharpest corner {turn:.0} degrees, radius {radius:.3}\n"),
            None => ", straight\n".into(),
        };
        text += &format!("{} points, certified free of collision\n", answer.waypoints.len());
    }
    text
}

/// The waypoints of a plan file.
fn read_waypoints(path: &std::path::Path, dof: usize) -> Result<Trajectory, Failure> {
    let is_table = path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("csv"));
    if is_table && dof == 2 {
        return Ok(Trajectory::from_points(&read_path(path)?));
    }
    plan_json::read_waypoints(&input::read_text(path)?, dof)
        .map_err(|error| Failure::file(path, error))
}
