//! Networks that turn observations into updates: for now the paper's multi-layer perceptron.
//!
//! One forward pass serves planning, cloning and PPO; the backward pass stands beside it. Parameters are one
//! flat f32 vector, so that an optimizer, a checkpoint and a policy file need to know nothing about layers.

mod mlp;

pub use mlp::{MAX_PARAMETERS, Mlp, Scratch};
