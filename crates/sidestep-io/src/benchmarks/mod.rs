//! Worlds of other groups' benchmarks, as they publish them.

pub mod barn;
pub mod mpnet;
