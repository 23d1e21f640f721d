//! Goals of a robot with joints: configurations, any of which will do, and poses of a link, as configurations that reach them.

use sidestep::arm::Tool;
use sidestep::plan::{Planner, Stop};
use sidestep::rng::{Purpose, stream};
use sidestep::scene::{Query, Setting};
use sidestep::space::Pose;
use sidestep::{InvalidInput, Status, Task};

use super::{Attempt, PlanArgs, attempt};
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

/// The task to each goal that the arguments name, the nearest first; the task alone where they name none but one
/// configuration.
pub fn tasks(args: &PlanArgs, task: Task) -> Result<Vec<Task>, Failure> {
    if args.goal.len() <= 1 && args.goal_pose.is_empty() {
        return Ok(vec![task]);
    }
    let Setting::Arm { arm, .. } = &task.setting else {
        let flag = if args.goal_pose.is_empty() { "--goal" } else { "--goal-pose" };
        return Err(Failure::at(flag, "several goals, and poses, are for robots with joints"));
    };
    let mut goals: Vec<Vec<f64>> = args.goal.iter().map(|goal| goal.0.clone()).collect();
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

/// Plans to one goal after another: until there is a plan, or where the best is asked for to all, each with its share of the
/// budget. The task whose plan it is, or else the one that came nearest to having one.
pub fn plan(
    args: &PlanArgs,
    tasks: Vec<Task>,
    planner: &Planner,
) -> Result<(Task, Attempt), Failure> {
    let share = args.budget_ms.map(|budget| budget / tasks.len() as f64);
    let stop = if args.best || share.is_some() { Stop::Best } else { Stop::First };
    let mut best: Option<(Task, Attempt)> = None;
    for task in tasks {
        let next = attempt(args, &task, &args.planner, planner, share)?;
        if best.as_ref().is_none_or(|(_, best)| worth(&next) > worth(best)) {
            best = Some((task, next));
        }
        let is_solved = best.as_ref().is_some_and(|(_, best)| best.plan.is_solved());
        if stop == Stop::First && is_solved {
            break;
        }
    }
    best.ok_or_else(|| Failure::at("--goal", "no goal"))
}

/// Plans before attempts before goals that are in collision, and short plans before long ones.
fn worth(attempt: &Attempt) -> (u8, f64) {
    match (&attempt.plan.status, attempt.plan.certified()) {
        (_, Some(path)) => (2, -path.length()),
        (Status::Invalid(_), _) => (0, 0.0),
        _ => (1, 0.0),
    }
}
