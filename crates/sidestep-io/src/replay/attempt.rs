//! From what planners did in the plane to what a page shows of it.

use std::time::Duration;

use sidestep::objective::Objective;
use sidestep::plan::Plan;
use sidestep::plane::geometry::Point;
use sidestep::plane::points;
use sidestep::plane::shortest_path::{Route, ShortestPath};
use sidestep::scene::Query;
use sidestep::{PlaneTask, Trajectory};

use super::blocked::{blocked, deepest};
use super::{Frame, MOST_FRAMES, Replay, Run};
use crate::plan_json::TraceStep;

/// What is shown of a task in the plane and the planners that were asked.
pub fn replay<'a>(task: PlaneTask<'a>, query: &Query, runs: Vec<Run>) -> Replay<'a> {
    let route = ShortestPath::new(task.world, task.robot).find(task.start, task.goal);
    let mut lines = vec![format!("robot of radius {}", task.robot.radius())];
    let shortest = match route {
        Route::Found { trajectory, .. } => {
            lines.push(format!("shortest path {:.3}, dotted", trajectory.length()));
            Some(trajectory)
        }
        _ => None,
    };
    let scene = query.scene().plane();
    let title = if task.name.is_empty() { "A task" } else { task.name }.to_owned();
    let epsilon = scene.map_or(1.0, |scene| scene.epsilon() * scene.frame().scale);
    Replay { title, lines, task, epsilon, shortest, runs, most_frames: MOST_FRAMES }
}

/// How far a place is from the obstacles, in task units.
pub fn far(query: &Query) -> impl Fn(Point) -> f64 {
    move |p| {
        let scene = query.scene().plane();
        scene.map_or(f64::INFINITY, |scene| {
            let (frame, field) = (scene.frame(), scene.field());
            f64::from(field.at(frame.to_normalised(p)).0) * frame.scale
        })
    }
}

/// What one planner did in some time, with the reason if it has no plan, and its iterates.
pub fn run(
    planner: &str,
    query: &Query,
    plan: &Plan,
    (time, why): (Duration, String),
    trace: &[TraceStep],
) -> Run {
    let several = trace.iter().any(|step| step.start > 0);
    let mut frames: Vec<Frame> = trace
        .iter()
        .filter(|step| !step.waypoints.is_empty())
        .map(|step| {
            let trajectory = Trajectory::new(2, step.waypoints.concat());
            let start = if several { format!("start {}, ", step.start + 1) } else { String::new() };
            Frame {
                label: format!("{start}{}", step.iteration),
                costs: Some([step.objective, step.obstacle_cost].map(f64::from)),
                clearance: clearance(query, &trajectory),
                free: step.certified,
                trajectory,
            }
        })
        .collect();
    let shown = plan.trajectory();
    if let Some(path) =
        shown.filter(|path| frames.last().map(|frame| &frame.trajectory) != Some(path))
    {
        let label = if plan.is_solved() { "the plan" } else { "the last attempt" };
        frames.push(Frame {
            label: label.into(),
            costs: costs(query, path),
            clearance: clearance(query, path),
            free: plan.is_solved(),
            trajectory: path.clone(),
        });
    }
    let took = format!("{} iterations, {:.0} us", plan.steps, time.as_secs_f64() * 1e6);
    let text = match plan.certified() {
        Some(path) => format!(
            "solved: length {:.3}, clearance {:.3}, sharpest corner {:.0} degrees; {took}",
            path.length(),
            query.scene().clearance(path),
            path.sharpest_turn().to_degrees(),
        ),
        None => format!("{}: {why}; {took}", plan.status.name()),
    };
    Run { planner: planner.to_owned(), text, frames, blocked: blocked(query, plan) }
}

/// U of a trajectory that no optimizer made, with as many waypoints as it has.
fn costs(query: &Query, path: &Trajectory) -> Option<[f64; 2]> {
    let inner = path.values().get(2..path.values().len().checked_sub(2)?)?;
    let mut objective = Objective::new(query, inner.len() / 2).ok()?;
    let mut x = vec![0.0; inner.len()];
    query.scene().to_normalised(inner, &mut x);
    let cost = objective.cost(&x);
    Some([cost.total, cost.obstacle].map(f64::from))
}

/// The clearance of a trajectory, or by how much it is too small: how deep the robot is in an obstacle.
fn clearance(query: &Query, path: &Trajectory) -> f64 {
    let clearance = query.scene().clearance(path);
    let radius = query.scene().plane().map_or(0.0, |scene| scene.robot().radius());
    match deepest(query, points(path)) {
        Some((distance, _)) if clearance <= 0.0 => (distance - radius).min(0.0),
        _ => clearance,
    }
}
