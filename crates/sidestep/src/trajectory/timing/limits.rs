//! How fast joints may move and speed up.

use crate::error::{InvalidInput, MAX_COORDINATE};

/// Limits of velocity and acceleration, one each for every joint; the same in both directions.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
}

impl Limits {
    /// Velocities in rad/s and accelerations in rad/s^2 (m for joints that slide), both above 0.
    ///
    /// # Errors
    /// If a limit is not a finite number above 0, there is none, or the two are not equally many.
    pub fn new(velocity: Vec<f64>, acceleration: Vec<f64>) -> Result<Self, InvalidInput> {
        for (field, limits) in [("velocity", &velocity), ("acceleration", &acceleration)] {
            for (j, &limit) in limits.iter().enumerate() {
                if !(limit > 0.0 && limit <= MAX_COORDINATE) {
                    let allowed = "a number above 0, at most 1e9";
                    return Err(InvalidInput::new(format!("{field}[{j}]"), limit, allowed));
                }
            }
        }
        if velocity.is_empty() || velocity.len() != acceleration.len() {
            let found = format!("{} and {} limits", velocity.len(), acceleration.len());
            let allowed = "one velocity and one acceleration for each joint";
            return Err(InvalidInput::new("limits", found, allowed));
        }
        Ok(Self { velocity, acceleration })
    }

    /// Largest speed of each joint.
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// Largest acceleration of each joint.
    pub fn acceleration(&self) -> &[f64] {
        &self.acceleration
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.velocity.len()
    }
}
