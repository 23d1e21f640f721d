//! The stages of the paper's training, in the order in which they come.

pub mod cloning;
pub mod dagger;
pub mod ppo;
