//! stub
#![allow(missing_docs)]
use crate::{Task, Trajectory, certificate::Certifier};
use rand_chacha::ChaCha8Rng;
#[derive(Debug, Clone, Default)]
pub struct RrtConnect {
    pub max_samples: usize,
    pub shortcut_rounds: usize,
}
impl RrtConnect {
    pub fn plan(&self, _: &Task, _: &Certifier, _: &mut ChaCha8Rng) -> Option<Trajectory> {
        None
    }
}
