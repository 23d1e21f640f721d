//! Parameters of networks: how they begin, and how a gradient changes them.
//!
//! Both rooms of training share these: what is the paper's alone (cloning, PPO) or the waypoint
//! policy's alone (imitation, walks) is in their rooms.

mod clipping;
mod he;
mod initialization;
mod optimizer;
mod schedule;
mod shuffle;

pub use clipping::{clip_factor, finite, norm, told_norm};
pub use he::he;
pub use initialization::{Initialization, Role};
pub use optimizer::{Optimizer, OptimizerKind};
pub use schedule::{Schedule, warm_up_and_cosine};
pub use shuffle::shuffle_in_place;
