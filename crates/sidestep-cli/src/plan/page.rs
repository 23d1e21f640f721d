//! The plan of a robot with joints as a page.

use std::path::Path;

use sidestep::{Task, Trajectory};
use sidestep_io::arm_page::{ArmPage, Track};

use super::{Attempt, PlanArgs, controller};
use crate::failure::Failure;
use crate::output;

/// Iterates that a page shows; of more, some evenly.
const MOST_ITERATES: usize = 25;
/// Moments of a timed plan that a page shows.
const MOMENTS: usize = 120;

/// Writes the page: the optimizer's iterates, if there are any, and the plan, or the last attempt.
pub fn write(args: &PlanArgs, path: &Path, task: &Task, attempt: &Attempt) -> Result<(), Failure> {
    let Attempt { planner, query, plan, trace, .. } = attempt;
    let Some(scene) = query.scene().arm() else { return Ok(()) };
    let mut tracks = Vec::new();
    let start = trace.first().map(|step| step.start);
    let first: Vec<_> = trace.iter().filter(|step| Some(step.start) == start).collect();
    for step in first.iter().step_by(first.len().div_ceil(MOST_ITERATES).max(1)) {
        let free = if step.certified { ", free" } else { "" };
        let rows: Vec<&[f64]> = step.waypoints.iter().map(Vec::as_slice).collect();
        if !rows.is_empty() {
            tracks.push(Track::along(format!("{}{free}", step.iteration), &rows));
        }
    }
    let ends = Trajectory::new(query.start().len(), [query.start(), query.goal()].concat());
    let shown = plan.trajectory().unwrap_or(&ends);
    // A robot without speed limits is shown without times.
    let timed = controller::timed(args, attempt).ok().flatten();
    tracks.push(match &timed {
        Some(timed) => {
            let at = |i: usize| timed.at(timed.duration() * i as f64 / MOMENTS as f64);
            let moments = (0..=MOMENTS).map(at).map(|moment| (moment.time, moment.position));
            Track { label: "the plan".into(), timed: true, moments: moments.collect() }
        }
        None => {
            let label = if plan.is_solved() { "the plan" } else { "the last attempt" };
            Track::along(label, &shown.configurations().collect::<Vec<_>>())
        }
    });
    let hit = if plan.is_solved() { None } else { scene.hit(shown) };
    let why = sidestep::plan::reason(task, args.margin, query, plan);
    let status = plan.status.name();
    let mut lines = vec![match why.is_empty() {
        true => format!("{status} by {planner}, certified free of collision"),
        false => format!("{status} by {planner}: {why}"),
    }];
    if let (Some(path), Some(timed)) = (plan.certified(), &timed) {
        let (length, seconds) = (path.length(), timed.duration());
        lines.push(format!(
            "length {length:.3} in joint space, {seconds:.2} s, {} points",
            path.len()
        ));
    }
    let title = if task.name.is_empty() { scene.arm().name() } else { &task.name };
    let page = ArmPage {
        title: title.to_owned(),
        lines,
        arm: scene.arm(),
        world: scene.world(),
        tracks,
        hit: hit.into_iter().map(|hit| hit.link).collect(),
    };
    output::write_file(path, page.to_html().as_bytes())
}
