//! The pictures of `plan`: the task, the plan, the shortest path to compare, and the trace.

use sidestep::plan::Plan;
use sidestep::plane::ends::Change;
use sidestep::plane::geometry::Point;
use sidestep::plane::points;
use sidestep::plane::shortest_path::{Route, ShortestPath};
use sidestep::scene::Query;
use sidestep::space::Vector;
use sidestep::{PlaneTask, Task, Trajectory};
use sidestep_io::picture::{Color, Picture, SpacePanel, TaskPanel, View, palette, planner_style};
use sidestep_io::plan_json::TraceStep;
use sidestep_io::replay::{Block, blocked};

use super::{Attempt, PlanArgs};
use crate::failure::Failure;
use crate::output;
use crate::robots::draw::spheres;

/// Iterates drawn of a trace; more would only paint over each other.
const MOST_ITERATES: usize = 40;
/// The planner whose path stands beside the others'.
const EXACT: &str = "shortest-path";
/// Pixels per unit of a picture.
const PNG_SCALE: f64 = 2.0;
/// The same of a picture that moves, for slides and pages.
const MOVING_SCALE: f64 = 1.25;

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
    let panels = attempts.map(|attempt| panel(args, task, attempt, &shortest, frames));
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
        let png = match args.animate {
            true => picture.to_moving_png(MOVING_SCALE),
            false => picture.to_png(PNG_SCALE),
        };
        let png = png.map_err(|error| Failure::file(path, error))?;
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
    args: &PlanArgs,
    task: PlaneTask<'_>,
    attempt: &Attempt,
    shortest: &Route,
    frames: Option<usize>,
) -> TaskPanel {
    let Attempt { planner, query, plan, relaxed, .. } = attempt;
    // A policy is named by its file.
    let name = planner.trim_end_matches(".safetensors").rsplit('/').next().unwrap_or(planner);
    let name =
        if planner.starts_with("learned:") { format!("learned: {name}") } else { planner.clone() };
    let style = planner_style(planner);
    let title = format!("{name}: {}", plan.status.name());
    let mut panel = TaskPanel::new(task).title(title).note(note(query, plan)).margin(args.margin);
    for end in relaxed {
        if let Change::Relaxed { radius, .. } = end.change {
            panel = panel.relaxed(end.place, radius);
        }
    }
    // Of what a task may be read from, only ROS maps say what their numbers are.
    let suffix = args.input.as_ref().and_then(|path| path.extension());
    if suffix.is_some_and(|suffix| suffix == "yaml" || suffix == "yml") {
        panel = panel.unit("m");
    }
    if let Some(scene) = query.scene().plane() {
        let (frame, field) = (scene.frame(), scene.field());
        panel = panel.shade(|p| f64::from(field.at(frame.to_normalised(p)).0).min(1.0));
    }
    if let (Route::Found { trajectory, .. }, false) = (shortest, planner == EXACT) {
        panel = panel.path_in("shortest path", trajectory, planner_style(EXACT));
    }
    // A page keeps them too, and asks for none in pictures.
    let shown = args.trace || args.animate;
    let mut iterates = if shown { iterates(attempt) } else { Vec::new() };
    if let (Some(frames), Some(last)) = (frames, iterates.last().cloned()) {
        iterates.resize(frames, last);
        return panel.motion_in(name, &iterates, style);
    }
    if !iterates.is_empty() {
        panel = panel.trace_in("iterates", &iterates, style.color);
    }
    if let Some(path) = plan.certified() {
        panel = panel.path_in(name, path, style);
    } else if let Some(path) = &plan.attempt {
        panel = panel.path_in(format!("{name} (not certified)"), path, style);
        if let Some(Block { segment, place, obstacle }) = blocked(query, plan) {
            let ends = points(path).windows(2).nth(segment).and_then(|ends| ends.try_into().ok());
            let ends: Option<[Point; 2]> = ends;
            panel = ends.into_iter().fold(panel, |p, ends| p.blocked(ends, place, obstacle));
        }
    }
    panel
}

/// What came out, for the line under the title.
fn note(query: &Query, plan: &Plan) -> String {
    let mut parts = Vec::new();
    if let Some(path) = plan.trajectory() {
        parts.push(format!("length {:.3}", path.length()));
        let clearance = query.scene().clearance(path);
        if plan.is_solved() {
            parts.push(format!("clearance {clearance:.3}"));
        }
    }
    if plan.steps > 0 {
        parts.push(format!("{} step{}", plan.steps, if plan.steps == 1 { "" } else { "s" }));
    }
    parts.join(", ")
}
