//! Pictures of a robot with joints.

use std::path::Path;
use std::sync::Arc;

use sidestep::arm::Arm;
use sidestep::space::{Vector, World};
use sidestep_io::picture::{Picture, SpacePanel, View, palette};

use crate::failure::Failure;
use crate::output;

/// Pixels per unit of a picture.
const PNG_SCALE: f64 = 2.0;

/// Draws a robot from three sides, its joints at 0 or the limit nearest to it.
pub fn picture(path: &Path, arm: &Arm) -> Result<(), Failure> {
    let rest: Vec<f64> =
        arm.joints().iter().map(|joint| 0.0_f64.clamp(joint.lower, joint.upper)).collect();
    let world = Arc::new(World::default());
    let figure = spheres(arm, &rest);
    let mut picture = Picture::new().title(format!("{}, {} spheres", arm.name(), arm.ball_count()));
    for view in [View::SIDE, View::FRONT, View::TOP] {
        picture = picture.panel(SpacePanel::new(&world, view).figure(&figure, palette(0)));
    }
    write(path, &picture)
}

/// The spheres of a robot in a configuration: centres and radii in metres.
pub fn spheres(arm: &Arm, configuration: &[f64]) -> Vec<(Vector, f64)> {
    arm.balls_at(configuration).iter().map(|ball| (ball.center, ball.radius)).collect()
}

/// Writes a picture in the format that its name says.
pub fn write(path: &Path, picture: &Picture) -> Result<(), Failure> {
    if path.extension().is_some_and(|suffix| suffix.eq_ignore_ascii_case("svg")) {
        return output::write_file(path, picture.to_svg().as_bytes());
    }
    let png = picture.to_png(PNG_SCALE).map_err(|error| Failure::file(path, error))?;
    output::write_file(path, &png)
}
