//! Why there is no plan, in words of the task: places of its file, names of its links and objects.

use crate::arm;
use crate::plan::answer::{Plan, Status};
use crate::plane::{explain, explain_path};
use crate::scene::{Query, Task};

/// Why there is no plan, with a margin (task units) that was asked for; empty where there is one.
pub fn reason(task: &Task, margin: f64, query: &Query, plan: &Plan) -> String {
    // What was asked of a robot with joints, and not what is reported: with the margin.
    let asked = (margin > 0.0).then(|| task.with_margin(margin).ok()).flatten();
    let asked = asked.map(|asked| Query::of(&asked, query.scene().profile()));
    let query = asked.as_ref().unwrap_or(query);
    match (&plan.status, task.plane(), query.scene().arm()) {
        (Status::Invalid(violation), Ok(task), _) => explain(&task, margin, violation),
        (Status::Invalid(violation), _, Some(scene)) => {
            arm::explain_ends(scene, [query.start(), query.goal()], violation)
        }
        (Status::Unsolved(reason), plane, scene) => match (reason.violation(), &plan.attempt) {
            (Some(violation), Some(path)) => {
                let words = match (plane, scene) {
                    (Ok(task), _) => explain_path(&task, margin, path, violation),
                    (_, Some(scene)) => arm::explain(scene, path, violation),
                    _ => violation.to_string(),
                };
                reason.to_string().replace(&violation.to_string(), &words)
            }
            _ => reason.to_string(),
        },
        (status, ..) => status.reason(),
    }
}
