//! The policies that come with the program, as trained by `experiments/sidestep-1.toml` and
//! `experiments/sidestep-1-small.toml`.

use std::sync::{Arc, LazyLock};

use crate::policy::Policy;

/// Names of the shipped policies, which are planner names too.
pub const NAMES: [&str; 2] = ["sidestep-1", "sidestep-1-small"];

static SIDESTEP_1: LazyLock<Arc<Policy>> =
    LazyLock::new(|| read(include_bytes!("../../weights/sidestep-1.safetensors")));
static SIDESTEP_1_SMALL: LazyLock<Arc<Policy>> =
    LazyLock::new(|| read(include_bytes!("../../weights/sidestep-1-small.safetensors")));

/// The default optimizer of `auto`: [`NAMES`]`[0]`.
pub fn sidestep_1() -> Arc<Policy> {
    SIDESTEP_1.clone()
}

/// A smaller and faster policy: [`NAMES`]`[1]`.
pub fn sidestep_1_small() -> Arc<Policy> {
    SIDESTEP_1_SMALL.clone()
}

#[allow(clippy::expect_used, reason = "the bytes are part of the program, and a test reads them")]
fn read(bytes: &[u8]) -> Arc<Policy> {
    Arc::new(Policy::from_safetensors(bytes).expect("a shipped policy is a policy"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shipped_policies_are_whole() {
        for policy in [sidestep_1(), sidestep_1_small()] {
            assert_eq!(policy.fixed_waypoints(), None);
            assert_eq!(policy.fixed_profile(), None);
            assert!(policy.card().training["config"]["seed"].is_u64());
        }
    }
}
