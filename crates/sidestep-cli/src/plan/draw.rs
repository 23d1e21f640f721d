//! The pictures of `plan`: the task, the plan, the shortest path to compare, and the trace.

use sidestep::objective::Scene;
use sidestep::plan::{Plan, Status};
use sidestep::shortest_path::{Route, ShortestPath};
use sidestep::{Task, Trajectory};
use sidestep_io::picture::{Picture, TaskPanel};

use super::{PlanArgs, Step};
use crate::failure::Failure;
use crate::output;

/// Iterates drawn of a trace; more would only paint over each other.
const MOST_ITERATES: usize = 40;
/// Pixels per unit of a picture.
const PNG_SCALE: f64 = 2.0;

/// Draws what the arguments ask for.
pub fn pictures(
    args: &PlanArgs,
    task: &Task,
    scene: &Scene,
    plan: &Plan,
    steps: &[Step],
) -> Result<(), Failure> {
    if args.png.is_none() && args.svg.is_none() {
        return Ok(());
    }
    let picture = Picture::new().panel(panel(args, task, scene, plan, steps));
    if let Some(path) = &args.svg {
        output::write_file(path, picture.to_svg().as_bytes())?;
    }
    if let Some(path) = &args.png {
        let png = picture.to_png(PNG_SCALE).map_err(|error| Failure::file(path, error))?;
        output::write_file(path, &png)?;
    }
    Ok(())
}

fn panel(args: &PlanArgs, task: &Task, scene: &Scene, plan: &Plan, steps: &[Step]) -> TaskPanel {
    let (frame, field) = (scene.frame(), scene.field());
    let title = if task.name.is_empty() { args.planner.clone() } else { task.name.clone() };
    let mut panel = TaskPanel::new(task)
        .title(format!("{title}: {}", plan.status.name()))
        .shade(|p| f64::from(field.at(frame.to_normalised(p)).0).min(1.0));
    if !steps.is_empty() {
        let first: Vec<&Step> = steps.iter().filter(|step| step.start == steps[0].start).collect();
        let stride = first.len().div_ceil(MOST_ITERATES).max(1);
        let iterates: Vec<Trajectory> = first
            .iter()
            .step_by(stride)
            .map(|step| Trajectory::from_points(&step.waypoints))
            .collect();
        panel = panel.trace("iterates", &iterates);
    }
    if let Some(path) = &plan.trajectory {
        panel = match plan.status {
            Status::Solved => panel.path(args.planner.clone(), path),
            _ => panel.dashed_path(format!("{} (not certified)", args.planner), path),
        };
    }
    let route = ShortestPath::new(&task.world, task.robot).find(task.start, task.goal);
    if let Route::Found { trajectory, .. } = route {
        panel = panel.dashed_path("shortest path", &trajectory);
    }
    panel
}
