//! Task units and normalised units of the plane.

use crate::plane::geometry::{Point, Rect};
use crate::profile::{DistanceKind, NORMALISED_EXTENT, Profile};

/// The similarity between task units and normalised units: `normalised = (task - origin) / scale`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The task-unit point at the normalised origin.
    pub origin: Point,
    /// Task units per normalised unit.
    pub scale: f64,
}

impl Frame {
    /// The frame of a profile for a field with these bounds.
    pub fn new(profile: &Profile, bounds: Rect) -> Self {
        let scale = bounds.extent() / NORMALISED_EXTENT;
        // The paper's x = 0.1 (u + 0.5): its pixel image is read half a pixel off.
        let shift = if profile.distance == DistanceKind::PaperImage { scale * 0.05 } else { 0.0 };
        Self { origin: [bounds.min[0] - shift, bounds.min[1] - shift], scale }
    }

    /// Task units to normalised units.
    #[inline]
    pub fn to_normalised(&self, p: Point) -> [f32; 2] {
        [
            ((p[0] - self.origin[0]) / self.scale) as f32,
            ((p[1] - self.origin[1]) / self.scale) as f32,
        ]
    }

    /// Normalised units to task units.
    #[inline]
    pub fn to_task(&self, p: [f32; 2]) -> Point {
        [
            f64::from(p[0]) * self.scale + self.origin[0],
            f64::from(p[1]) * self.scale + self.origin[1],
        ]
    }

    /// Points `[N x 2]` from task units to normalised units.
    pub fn block_to_normalised(&self, from: &[f64], to: &mut [f32]) {
        let from = from.as_chunks::<2>().0.iter();
        for (to, &p) in to.as_chunks_mut::<2>().0.iter_mut().zip(from) {
            *to = self.to_normalised(p);
        }
    }

    /// Points `[N x 2]` from normalised units to task units.
    pub fn block_to_task(&self, from: &[f32], to: &mut [f64]) {
        let from = from.as_chunks::<2>().0.iter();
        for (to, &p) in to.as_chunks_mut::<2>().0.iter_mut().zip(from) {
            *to = self.to_task(p);
        }
    }
}
