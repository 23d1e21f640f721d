//! The threads that batches, trainings and starts are spread over.

use std::error::Error;

use rayon::ThreadPoolBuilder;
use sidestep::InvalidInput;

use crate::failure::Failure;

/// Most threads; beyond it they only wait for each other.
const MAX_THREADS: usize = 512;

/// Starts that many threads, one for each core where 0; in a process that has them already, none.
pub fn start(count: usize) -> Result<(), Failure> {
    if count > MAX_THREADS {
        let allowed = format!("a number from 0 (all cores) to {MAX_THREADS}");
        return Err(InvalidInput::new("--threads", count, allowed).into());
    }
    match ThreadPoolBuilder::new().num_threads(count).build_global() {
        Err(error) if error.source().is_some() => Err(Failure(format!(
            "--threads: {} threads cannot be started ({error}); give a smaller number",
            if count == 0 { "as many as there are cores".into() } else { count.to_string() }
        ))),
        // Without a cause: this process has started its threads before.
        _ => Ok(()),
    }
}
