//! The stages of a waypoint policy's training.

pub(super) mod gradient;
pub(super) mod imitation;
mod loss;
pub(super) mod walks;
