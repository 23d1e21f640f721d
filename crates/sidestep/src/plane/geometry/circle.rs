//! A disc-shaped obstacle.

use super::point::{Point, distance};
use crate::error::{InvalidInput, finite, finite_point};

/// A circle with positive radius; its inside is the obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Centre.
    pub center: Point,
    /// Radius, in task units.
    pub radius: f64,
}

impl Circle {
    /// A circle from centre and radius.
    ///
    /// # Errors
    /// If a number is not finite or the radius is not positive.
    pub fn new(center: Point, radius: f64) -> Result<Self, InvalidInput> {
        finite_point("center", center)?;
        finite("radius", radius)?;
        if radius <= 0.0 {
            return Err(InvalidInput::new("radius", radius, "a number above 0"));
        }
        Ok(Self { center, radius })
    }

    /// Signed distance from `p` to the circle, negative inside.
    pub fn signed_distance(&self, p: Point) -> f64 {
        distance(p, self.center) - self.radius
    }
}
