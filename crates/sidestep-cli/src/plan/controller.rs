//! What a robot's controller is given: when every joint is where along a certified plan.

use std::path::Path;

use sidestep::InvalidInput;
use sidestep::trajectory::timing::{Limits, Path as TimedBy, time_path};
use sidestep_io::joint_trajectory::{TrajectoryFormat, write_trajectory};

use super::{Attempt, PlanArgs, joint_names};
use crate::failure::Failure;
use crate::output;

/// Seconds between two moments of the file.
const PERIOD: f64 = 0.01;
/// Seconds to top speed where no acceleration is given.
const TO_TOP_SPEED: f64 = 0.5;

/// Times the plan and writes it; the robot stops at the plan's corners, so that it goes where was proved. Nothing is
/// written where there is no plan.
pub fn write(args: &PlanArgs, path: &Path, attempt: &Attempt) -> Result<(), Failure> {
    let Some(scene) = attempt.query.scene().arm() else {
        return Err(Failure::at("--trajectory", "only for a robot with joints"));
    };
    let Some(plan) = attempt.plan.certified() else { return Ok(()) };
    if !(args.speed > 0.0 && args.speed <= 1.0) {
        return Err(InvalidInput::new("--speed", args.speed, "above 0 and up to 1").into());
    }
    let mut velocity = Vec::new();
    for joint in scene.arm().joints() {
        let Some(most) = joint.velocity.filter(|most| *most > 0.0) else {
            let found = format!("the URDF gives the joint {} no top speed", joint.name);
            return Err(Failure::at("--trajectory", format!("{found} (<limit velocity=..>)")));
        };
        velocity.push(args.speed * most);
    }
    let acceleration = match args.acceleration {
        Some(most) if most > 0.0 && most.is_finite() => vec![most; velocity.len()],
        Some(other) => {
            return Err(InvalidInput::new("--acceleration", other, "a number above 0").into());
        }
        None => velocity.iter().map(|most| most / TO_TOP_SPEED).collect(),
    };
    let limits = Limits::new(velocity, acceleration)?;
    let timed = time_path(&TimedBy::polyline(plan.values(), plan.dof())?, &limits)?;
    let name = path.to_string_lossy();
    let format = TrajectoryFormat::from_file_name(&name).unwrap_or(TrajectoryFormat::Yaml);
    let text = write_trajectory(&joint_names(scene.arm()), &timed.sampled(PERIOD)?, format)?;
    output::write_file(path, text.as_bytes())
}
