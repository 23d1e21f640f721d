//! The robot's body.

use crate::error::{InvalidInput, finite};

/// A robot that translates in the plane.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Robot {
    /// A point.
    #[default]
    Point,
    /// A disc around the configuration.
    Disc {
        /// Radius, in task units; above 0.
        radius: f64,
    },
}

impl Robot {
    /// A disc, or a point where the radius is 0.
    ///
    /// # Errors
    /// If the radius is negative or not finite.
    pub fn disc(radius: f64) -> Result<Self, InvalidInput> {
        finite("robot.radius", radius)?;
        if radius < 0.0 {
            return Err(InvalidInput::new("robot.radius", radius, "a number of at least 0"));
        }
        Ok(if radius == 0.0 { Self::Point } else { Self::Disc { radius } })
    }

    /// The radius of the body around the configuration; 0 for a point.
    pub fn radius(&self) -> f64 {
        match self {
            Self::Point => 0.0,
            Self::Disc { radius } => *radius,
        }
    }
}
