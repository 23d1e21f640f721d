//! The pictures of `plan`: the task, the plan, the shortest path to compare, and the trace.

use sidestep::plane::shortest_path::{Route, ShortestPath};
use sidestep::{PlaneTask, Task, Trajectory};
use sidestep_io::picture::{Picture, TaskPanel};
use sidestep_io::plan_json::TraceStep;

use super::{Attempt, PlanArgs};
use crate::failure::Failure;
use crate::output;

/// Iterates drawn of a trace; more would only paint over each other.
const MOST_ITERATES: usize = 40;
/// Pixels per unit of a picture.
const PNG_SCALE: f64 = 2.0;

/// Draws what the arguments ask for, a panel for each attempt.
pub fn pictures<'a>(
    args: &PlanArgs,
    task: &Task,
    attempts: impl Iterator<Item = &'a Attempt>,
) -> Result<(), Failure> {
    let task = task.plane()?;
    let shortest = ShortestPath::new(task.world, task.robot).find(task.start, task.goal);
    let panels = attempts.map(|attempt| panel(task, attempt, &shortest));
    let picture = panels.fold(Picture::new(), |picture, panel| picture.panel(panel));
    if let Some(path) = &args.svg {
        output::write_file(path, picture.to_svg().as_bytes())?;
    }
    if let Some(path) = &args.png {
        let png = picture.to_png(PNG_SCALE).map_err(|error| Failure::file(path, error))?;
        output::write_file(path, &png)?;
    }
    Ok(())
}

fn panel(task: PlaneTask<'_>, attempt: &Attempt, shortest: &Route) -> TaskPanel {
    let Attempt { planner, query, plan, trace: steps, .. } = attempt;
    // A policy is named by its file.
    let name = planner.trim_end_matches(".safetensors").rsplit('/').next().unwrap_or(planner);
    let name =
        if planner.starts_with("learned:") { format!("learned: {name}") } else { planner.clone() };
    let mut panel = TaskPanel::new(task).title(format!("{name}: {}", plan.status.name()));
    if let Some(scene) = query.scene().plane() {
        let (frame, field) = (scene.frame(), scene.field());
        panel = panel.shade(|p| f64::from(field.at(frame.to_normalised(p)).0).min(1.0));
    }
    if !steps.is_empty() {
        let first: Vec<&TraceStep> =
            steps.iter().filter(|step| step.start == steps[0].start).collect();
        let stride = first.len().div_ceil(MOST_ITERATES).max(1);
        let iterates: Vec<Trajectory> = first
            .iter()
            .step_by(stride)
            .map(|step| Trajectory::from_points(&step.waypoints))
            .collect();
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
