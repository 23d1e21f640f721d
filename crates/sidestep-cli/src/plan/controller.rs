//! What a robot's controller is given: when every joint is where along a certified plan.

use std::path::Path;

use sidestep::InvalidInput;
use sidestep::trajectory::timing::{Limits, TimedPath, time_path};
use sidestep_io::joint_trajectory::{TrajectoryFormat, write_trajectory};

use super::{Attempt, PlanArgs};
use crate::failure::Failure;
use crate::output;

/// Seconds between two moments of the file.
const PERIOD: f64 = 0.01;
/// Seconds to top speed where no acceleration is given.
const TO_TOP_SPEED: f64 = 0.5;

/// Times the plan and writes it. Nothing is written where there is no plan.
pub fn write(args: &PlanArgs, path: &Path, attempt: &Attempt) -> Result<(), Failure> {
    let Some(scene) = attempt.query.scene().arm() else {
        return Err(Failure::at("--trajectory", "only for a robot with joints"));
    };
    let Some(timed) = timed(args, attempt)? else { return Ok(()) };
    let name = path.to_string_lossy();
    let format = TrajectoryFormat::from_file_name(&name).unwrap_or(TrajectoryFormat::Yaml);
    let text = write_trajectory(&scene.arm().joint_names(), &timed.sampled(PERIOD)?, format)?;
    output::write_file(path, text.as_bytes())
}

/// When the robot is where along the plan, if there is one. Corners are cut as far as that is proved free, with the margin;
/// elsewhere the robot stops, so that it goes where was proved.
pub fn timed(args: &PlanArgs, attempt: &Attempt) -> Result<Option<TimedPath>, Failure> {
    let (Some(scene), Some(plan)) = (attempt.asked.scene().arm(), attempt.plan.certified()) else {
        return Ok(None);
    };
    if !(args.speed > 0.0 && args.speed <= 1.0) {
        return Err(InvalidInput::new("--speed", args.speed, "above 0 and up to 1").into());
    }
    if !(0.0..=10.0).contains(&args.blend) {
        let allowed = "a number from 0 to 10, in rad or m of joint space";
        return Err(InvalidInput::new("--blend", args.blend, allowed).into());
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
    Ok(Some(time_path(&scene.with_corners_cut(plan, args.blend)?, &limits)?))
}
