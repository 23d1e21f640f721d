//! How much memory a training takes, estimated from its configuration before anything is made.
//!
//! Counts and sizes are each within a range, and their products could still ask for more than a
//! machine has. Every part that grows with the configuration is estimated; together they may take
//! [`LIMIT`], and the error names the largest.

use sidestep::InvalidInput;

/// Most bytes that a training may take.
pub(crate) const LIMIT: f64 = 2.0 * GIB;
const GIB: f64 = (1u64 << 30) as f64;
/// Bytes of a task made ready, with its distance field and its certificate: 73 kB as measured.
pub(crate) const TASK: f64 = 80e3;
/// Bytes of a number.
pub(crate) const NUMBER: f64 = 4.0;

/// A part of the memory: the key that decides it, its value, and bytes.
pub(crate) struct Part {
    pub key: &'static str,
    pub value: usize,
    pub bytes: f64,
}

/// Fails if the parts together take too much.
pub(crate) fn check(parts: &[Part]) -> Result<(), InvalidInput> {
    let all: f64 = parts.iter().map(|part| part.bytes).sum();
    let Some(largest) = parts.iter().max_by(|a, b| a.bytes.total_cmp(&b.bytes)) else {
        return Ok(());
    };
    if all <= LIMIT {
        return Ok(());
    }
    let allowed = format!(
        "less: it takes about {:.1} GB of {:.1} GB in all, and a training may take {:.1} GB",
        largest.bytes / 1e9,
        all / 1e9,
        LIMIT / 1e9
    );
    Err(InvalidInput::new(largest.key, largest.value, allowed))
}
