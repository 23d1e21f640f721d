//! Goals of a robot with joints: configurations, any of which will do, and poses of a link, as configurations that reach them.

use std::time::Instant;

use sidestep::arm::Tool;
use sidestep::plan::Planner;
use sidestep::plan::goals::plan_to_any;
use sidestep::rng::{Purpose, stream};
use sidestep::scene::{Query, Setting};
use sidestep::space::Pose;
use sidestep::{InvalidInput, Task};

use super::{Attempt, PlanArgs, attempt, budget, options};
use crate::failure::Failure;

/// Random configurations from which a pose is sought.
const TRIES: usize = 64;
/// Most goals that are planned to, the nearest ones.
const MOST_GOALS: usize = 32;

/// Where a link is to be.
#[derive(Debug, Clone, PartialEq)]
pub struct GoalPose {
    pose: Pose,
    link: String,
}

/// Parses `X,Y,Z,QX,QY,QZ,QW@LINK`.
pub fn parse_goal_pose(text: &str) -> Result<GoalPose, String> {
    let form = "X,Y,Z,QX,QY,QZ,QW@LINK";
    let (numbers, link) = text.split_once('@').ok_or_else(|| format!("`{text}` is not {form}"))?;
    let numbers: Vec<f64> = numbers
        .split(',')
        .map(|part| part.trim().parse().map_err(|_| format!("`{part}` is not a number")))
        .collect::<Result<_, _>>()?;
    let [x, y, z, qx, qy, qz, qw]: [f64; 7] = numbers
        .try_into()
        .map_err(|found: Vec<f64>| format!("{} numbers are not {form}", found.len()))?;
    let pose = Pose::from_xyzw([qx, qy, qz, qw], [x, y, z]).map_err(|error| error.to_string())?;
    Ok(GoalPose { pose, link: link.into() })
}

/// The task to each goal that the arguments name, or else its file (`more` besides its own), the nearest first; the task alone
/// where there is but one configuration.
pub fn tasks(args: &PlanArgs, task: Task, more: Vec<Vec<f64>>) -> Result<Vec<Task>, Failure> {
    if args.goal.len() <= 1 && args.goal_pose.is_empty() && more.is_empty() {
        return Ok(vec![task]);
    }
    let Setting::Arm { arm, .. } = &task.setting else {
        let flag = if args.goal_pose.is_empty() { "--goal" } else { "--goal-pose" };
        return Err(Failure::at(flag, "several goals, and poses, are for robots with joints"));
    };
    let mut goals: Vec<Vec<f64>> = args.goal.iter().map(|goal| goal.0.clone()).collect();
    if !more.is_empty() {
        goals.push(task.goal.clone());
        goals.extend(more);
    }
    for (index, GoalPose { pose, link }) in args.goal_pose.iter().enumerate() {
        let tool = Tool { link: link.clone(), frame: Pose::IDENTITY };
        let mut rng = stream(args.planning.seed, Purpose::Start, index as u64, 0);
        let found = arm
            .inverse_kinematics(&tool, pose, TRIES, &mut rng)
            .map_err(|error| InvalidInput { field: "--goal-pose".into(), ..error })?;
        let scene = Query::of(&task, &sidestep::Profile::DEFAULT).scene().clone();
        let reached = found.len();
        let free: Vec<_> = found.into_iter().filter(|q| scene.motion_is_free(q, q)).collect();
        if free.is_empty() {
            let why = match reached {
                0 => format!(
                    "no configuration was found that puts {link} there, from {TRIES} starts"
                ),
                some => {
                    format!("each of {some} configurations that put {link} there is in collision")
                }
            };
            return Err(Failure::at("--goal-pose", why));
        }
        goals.extend(free);
    }
    let distance =
        |goal: &[f64]| -> f64 { task.start.iter().zip(goal).map(|(a, b)| (b - a) * (b - a)).sum() };
    goals.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    goals.truncate(MOST_GOALS);
    let task = |goal| Ok(Task::new(&task.name, task.setting.clone(), task.start.clone(), goal)?);
    goals.into_iter().map(task).collect()
}

/// Plans to the goals of the tasks in rounds, each with its share of what is left of the budget. The task whose plan it is, or
/// else the one that came nearest to having one.
pub fn plan(
    args: &PlanArgs,
    mut tasks: Vec<Task>,
    planner: &Planner,
) -> Result<(Task, Attempt), Failure> {
    let Some(first) = tasks.first() else { return Err(Failure::at("--goal", "no goal")) };
    let (options, budget) = (options(args, first, planner)?, budget(args)?);
    let begin = Instant::now();
    let best = plan_to_any(tasks.len(), &options, |goal, left, options| {
        let share = budget.map(|budget| budget.saturating_sub(begin.elapsed()) / left as u32);
        attempt(args, &tasks[goal], &args.planner, planner, options, share)
    })?;
    let Some((goal, attempt)) = best else { return Err(Failure::at("--goal", "no goal")) };
    Ok((tasks.swap_remove(goal), attempt))
}
