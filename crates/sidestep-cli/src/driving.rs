//! Flags for driving a plan, and the files that robots read: each name says its format.

use std::path::Path;

use clap::Args;
use sidestep::error::{InvalidInput, MAX_COORDINATE};
use sidestep::plane::points;
use sidestep::trajectory::driving::{DrivingLimits, Pose, drive, spaced};
use sidestep::{Trajectory, World};
use sidestep_io::drive::{Recording, to_csv, to_geojson, to_mcap, to_nav_path};
use sidestep_io::plan_json::PlanDocument;

use crate::failure::Failure;
use crate::output;

/// Most points of a driven path.
const MOST_POINTS: usize = 1_000_000;
/// Most iterates in a recording.
const MOST_ITERATES: usize = 10_000;
/// Suffixes of the formats of a plan.
pub const FORMATS: [&str; 6] = ["json", "csv", "yaml", "yml", "geojson", "mcap"];

/// How the robot drives.
#[derive(Args, Clone)]
pub struct DriveArgs {
    /// Farthest that two points of the driven path are apart, in task units [default: a quarter of
    /// the way to top speed]
    #[arg(long, allow_negative_numbers = true)]
    spacing: Option<f64>,
    /// Greatest speed, in task units a second
    #[arg(long, default_value_t = DrivingLimits::default().speed, allow_negative_numbers = true)]
    max_speed: f64,
    /// Greatest acceleration along the path
    #[arg(long, value_name = "ACCELERATION", default_value_t = DrivingLimits::default().acceleration, allow_negative_numbers = true)]
    max_accel: f64,
    /// Greatest acceleration across the path
    #[arg(long, value_name = "ACCELERATION", default_value_t = DrivingLimits::default().lateral_acceleration, allow_negative_numbers = true)]
    max_lateral_accel: f64,
    /// Frame of the messages in .yaml and .mcap
    #[arg(long, default_value = "map")]
    frame: String,
}

impl DriveArgs {
    /// Checks the flags.
    pub fn check(&self) -> Result<(), InvalidInput> {
        let flag = |error: InvalidInput| {
            let field = match error.field.as_str() {
                "speed" => "--max-speed",
                "acceleration" => "--max-accel",
                _ => "--max-lateral-accel",
            };
            InvalidInput { field: field.into(), ..error }
        };
        self.limits().check().map_err(flag)?;
        match self.spacing.filter(|spacing| !(*spacing > 0.0 && *spacing <= MAX_COORDINATE)) {
            Some(spacing) => {
                Err(InvalidInput::new("--spacing", spacing, "a number above 0, at most 1e9"))
            }
            None => Ok(()),
        }
    }

    fn limits(&self) -> DrivingLimits {
        DrivingLimits {
            speed: self.max_speed,
            acceleration: self.max_accel,
            lateral_acceleration: self.max_lateral_accel,
        }
    }

    /// The path as it is driven.
    pub fn drive(&self, path: &Trajectory) -> Result<Vec<Pose>, Failure> {
        let limits = self.limits();
        let path = spaced(path, self.spacing.unwrap_or(limits.spacing()), MOST_POINTS);
        Ok(drive(points(&path), &limits)?)
    }

    /// Writes an answer: as JSON where the name says no other format. What is not solved has an empty path in the others, so that no
    /// robot drives it.
    pub fn write(&self, file: &Path, answer: &PlanDocument, world: &World) -> Result<(), Failure> {
        let suffix = file.extension().map(|suffix| suffix.to_string_lossy().to_lowercase());
        let poses = match answer.certified {
            true => self.drive(&Trajectory::new(2, answer.waypoints.concat()))?,
            false => Vec::new(),
        };
        let bytes = match suffix.as_deref() {
            Some("csv") => to_csv(&poses).into_bytes(),
            Some("yaml" | "yml") => to_nav_path(&poses, &self.frame).into_bytes(),
            Some("geojson") => to_geojson(&poses).into_bytes(),
            Some("mcap") => {
                let steps = answer.trace.iter().flatten().take(MOST_ITERATES);
                let iterates = steps
                    .map(|step| {
                        let points: Vec<[f64; 2]> =
                            step.waypoints.iter().filter_map(|p| p[..].try_into().ok()).collect();
                        drive(&points, &self.limits())
                    })
                    .collect::<Result<Vec<_>, _>>()?;
                let frame = &self.frame;
                to_mcap(&Recording { world, poses: &poses, iterates: &iterates, frame })
            }
            _ => answer.to_json().into_bytes(),
        };
        output::write_file(file, &bytes)
    }
}
