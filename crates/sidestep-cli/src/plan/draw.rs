//! The pictures of `plan`: the task, the plan, the shortest path to compare, and the trace.

use sidestep::plane::shortest_path::{Route, ShortestPath};
use sidestep::space::Vector;
use sidestep::{PlaneTask, Task, Trajectory};
use sidestep_io::picture::{Color, Picture, SpacePanel, TaskPanel, View, palette};
use sidestep_io::plan_json::TraceStep;

use super::{Attempt, PlanArgs};
use crate::failure::Failure;
use crate::output;
use crate::robots::draw::spheres;

/// Iterates drawn of a trace; more would only paint over each other.
const MOST_ITERATES: usize = 40;
/// Colours of a moving trajectory that ends certified, and of one that does not.
const SOLVED: Color = Color::hex(0x0072b2);
const UNSOLVED: Color = Color::hex(0xd55e00);
/// Pixels per unit of a picture.
const PNG_SCALE: f64 = 2.0;

/// Draws what the arguments ask for, a panel for each attempt.
pub fn pictures<'a>(
    args: &PlanArgs,
    task: &Task,
    attempts: impl Iterator<Item = &'a Attempt> + Clone,
) -> Result<(), Failure> {
    if task.plane().is_err() {
        return views(args, attempts);
    }
    let task = task.plane()?;
    let shortest = ShortestPath::new(task.world, task.robot).find(task.start, task.goal);
    let frames = attempts.clone().map(|attempt| iterates(attempt).len()).max().unwrap_or(0);
    let frames = args.animate.then_some(frames);
    let panels = attempts.map(|attempt| panel(task, attempt, &shortest, frames));
    let picture = panels.fold(Picture::new(), |picture, panel| picture.panel(panel));
    write(args, &picture)
}

/// Bodies along a plan that are drawn of a robot with joints.
const PLACES: usize = 7;

/// A robot with joints from every side along each attempt's plan, or last attempt; two rows for each.
fn views<'a>(args: &PlanArgs, attempts: impl Iterator<Item = &'a Attempt>) -> Result<(), Failure> {
    let mut picture = Picture::new().columns(2);
    for Attempt { planner, query, plan, .. } in attempts {
        let Some(scene) = query.scene().arm() else { continue };
        let arm = scene.arm();
        let ends = Trajectory::new(arm.dof(), [query.start(), query.goal()].concat());
        let path = plan.trajectory().unwrap_or(&ends);
        let places = path.evenly(PLACES);
        let tip: Vec<Vector> = path
            .evenly(20 * PLACES)
            .configurations()
            .filter_map(|place| arm.balls_at(place).last().map(|ball| ball.center))
            .collect();
        let color = |i: usize| palette(0).mix(palette(1), i as f64 / (PLACES - 1) as f64);
        for view in [View::ASLANT, View::SIDE, View::FRONT, View::TOP] {
            let mut panel = SpacePanel::new(scene.world(), view);
            if view == View::ASLANT {
                panel = panel.title(format!("{planner}: {}", plan.status.name()));
            }
            // The ends last, over what lies between them.
            let last = places.len().saturating_sub(1);
            let between = (1..last).map(|i| (i, 0.2));
            for (i, opacity) in between.chain([(0, 0.85), (last, 0.85)]) {
                if let Some(place) = places.configurations().nth(i) {
                    panel = panel.figure(&spheres(arm, place), color(i).with_opacity(opacity));
                }
            }
            panel = panel
                .line(&tip, Color::hex(0x1f2933))
                .label("start", color(0))
                .label("goal", color(PLACES - 1))
                .label("way of the tip", Color::hex(0x1f2933));
            picture = picture.panel(panel);
        }
    }
    write(args, &picture)
}

fn write(args: &PlanArgs, picture: &Picture) -> Result<(), Failure> {
    if let Some(path) = &args.svg {
        output::write_file(path, picture.to_svg().as_bytes())?;
    }
    if let Some(path) = &args.png {
        let png = picture.to_png(PNG_SCALE).map_err(|error| Failure::file(path, error))?;
        output::write_file(path, &png)?;
    }
    Ok(())
}

/// The first start's iterates that are drawn.
fn iterates(attempt: &Attempt) -> Vec<Trajectory> {
    let Some(start) = attempt.trace.first().map(|step| step.start) else { return Vec::new() };
    let first: Vec<&TraceStep> = attempt.trace.iter().filter(|step| step.start == start).collect();
    let stride = first.len().div_ceil(MOST_ITERATES).max(1);
    first.iter().step_by(stride).map(|step| Trajectory::new(2, step.waypoints.concat())).collect()
}

/// One attempt; `frames` is the number of iterates that a moving picture shows of each, the last one for
/// as long as others go on.
fn panel(
    task: PlaneTask<'_>,
    attempt: &Attempt,
    shortest: &Route,
    frames: Option<usize>,
) -> TaskPanel {
    let Attempt { planner, query, plan, .. } = attempt;
    // A policy is named by its file.
    let name = planner.trim_end_matches(".safetensors").rsplit('/').next().unwrap_or(planner);
    let name =
        if planner.starts_with("learned:") { format!("learned: {name}") } else { planner.clone() };
    let mut panel = TaskPanel::new(task).title(format!("{name}: {}", plan.status.name()));
    if let Some(scene) = query.scene().plane() {
        let (frame, field) = (scene.frame(), scene.field());
        panel = panel.shade(|p| f64::from(field.at(frame.to_normalised(p)).0).min(1.0));
    }
    let mut iterates = iterates(attempt);
    if let (Some(frames), Some(last)) = (frames, iterates.last().cloned()) {
        iterates.resize(frames, last);
        let color = if plan.is_solved() { SOLVED } else { UNSOLVED };
        return panel.motion_in(name, &iterates, color);
    }
    if !iterates.is_empty() {
        panel = panel.trace("iterates", &iterates);
    }
    if let Some(path) = plan.certified() {
        panel = panel.path(name, path);
    } else if let Some(path) = &plan.attempt {
        panel = panel.dashed_path(format!("{name} (not certified)"), path);
    }
    if let Route::Found { trajectory, .. } = shortest {
        panel = panel.dashed_path("shortest path", trajectory);
    }
    panel
}
