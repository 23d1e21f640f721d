//! Networks that turn observations into updates: the paper's multi-layer perceptron ([`Mlp`]) and the network
//! with weights shared over waypoints ([`WaypointNet`]).
//!
//! One forward pass serves planning and training; the backward pass stands beside it. Parameters are one
//! flat f32 vector, so that an optimizer, a checkpoint and a policy file need to know nothing about layers.

mod layer;
mod mlp;
mod waypoint_net;

pub use mlp::{MAX_PARAMETERS, Mlp, Scratch};
pub use waypoint_net::{WaypointNet, WaypointScratch, WaypointShape};
