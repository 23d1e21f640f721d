//! What an observation holds of the surroundings in the plane: obstacles as numbers, and images.

pub(crate) mod boxes;
pub(crate) mod image;
pub(crate) mod waypoint_image;

use crate::plane::Subject;
use crate::profile::NORMALISED_EXTENT;

/// Half of the field's larger side, in normalised units.
const HALF_EXTENT: f32 = 0.5 * NORMALISED_EXTENT as f32;

/// A place from the field's centre, in half-extents: in [-1, 1].
fn centred(subject: Subject<'_>, p: [f32; 2]) -> [f32; 2] {
    let limits = subject.scene.normalised_limits();
    [0, 1].map(|axis| (p[axis] - 0.5 * limits[axis][1]) / HALF_EXTENT)
}
