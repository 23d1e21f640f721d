//! An axis-aligned rectangle.

use super::point::Point;
use crate::error::{InvalidInput, finite_point};

/// An axis-aligned rectangle with positive width and height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Lower left corner.
    pub min: Point,
    /// Upper right corner.
    pub max: Point,
}

impl Rect {
    /// A rectangle from its lower left and upper right corners.
    ///
    /// # Errors
    /// If a coordinate is not finite or `max` is not above `min` on both axes.
    pub fn new(min: Point, max: Point) -> Result<Self, InvalidInput> {
        finite_point("min", min)?;
        finite_point("max", max)?;
        for axis in 0..2 {
            if max[axis] <= min[axis] {
                return Err(InvalidInput::new(
                    format!("max[{axis}]"),
                    max[axis],
                    format!("more than min[{axis}] = {}", min[axis]),
                ));
            }
        }
        Ok(Self { min, max })
    }

    /// Width and height.
    pub fn size(&self) -> Point {
        [self.max[0] - self.min[0], self.max[1] - self.min[1]]
    }

    /// The larger of width and height.
    pub fn extent(&self) -> f64 {
        let [width, height] = self.size();
        width.max(height)
    }

    /// The rectangle grown by `margin` on every side (shrunk where negative).
    pub fn inflated(&self, margin: f64) -> Self {
        Self {
            min: [self.min[0] - margin, self.min[1] - margin],
            max: [self.max[0] + margin, self.max[1] + margin],
        }
    }

    /// Whether `p` lies inside or on the border.
    pub fn contains(&self, p: Point) -> bool {
        (0..2).all(|axis| self.min[axis] <= p[axis] && p[axis] <= self.max[axis])
    }

    /// Signed distance from `p` to the border, negative inside.
    pub fn signed_distance(&self, p: Point) -> f64 {
        let outside = |axis: usize| (self.min[axis] - p[axis]).max(p[axis] - self.max[axis]);
        let (dx, dy) = (outside(0), outside(1));
        if dx <= 0.0 && dy <= 0.0 { dx.max(dy) } else { dx.max(0.0).hypot(dy.max(0.0)) }
    }

    /// The corners, counter-clockwise from the lower left.
    pub fn corners(&self) -> [Point; 4] {
        let (min, max) = (self.min, self.max);
        [min, [max[0], min[1]], max, [min[0], max[1]]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signed_distance_rows() {
        let rect = Rect::new([0.0, 0.0], [4.0, 2.0]).unwrap();
        for (p, expected) in [
            ([2.0, 1.0], -1.0),
            ([0.5, 1.0], -0.5),
            ([4.0, 1.0], 0.0),
            ([7.0, 6.0], 5.0),
            ([-3.0, 1.0], 3.0),
        ] {
            assert!((rect.signed_distance(p) - expected).abs() < 1e-12, "{p:?}");
        }
    }

    #[test]
    fn refuses_empty_and_non_finite() {
        assert!(Rect::new([0.0, 0.0], [0.0, 1.0]).is_err());
        assert!(Rect::new([0.0, f64::NAN], [1.0, 1.0]).is_err());
        let message = Rect::new([0.0, 2.0], [1.0, 1.0]).unwrap_err().to_string();
        assert_eq!(message, "max[1]: 1 is not allowed; expected more than min[1] = 2");
    }
}
