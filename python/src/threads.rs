//! The threads that work is spread over, also in a process that was forked.

use std::process;
use std::sync::{Arc, Mutex, OnceLock};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The process that loaded the module.
static FIRST: OnceLock<u32> = OnceLock::new();
/// Threads of a forked process: those of its parent are not in it, and whoever waits for them waits for ever.
static FORKED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Remembers which process this is.
pub fn begin() {
    FIRST.get_or_init(process::id);
}

/// Runs `work` with the interpreter free, on threads that are there.
pub fn detach<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    py.detach(|| run(work))
}

/// Runs `work` on threads that are there.
pub fn run<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let here = process::id();
    if FIRST.get().is_none_or(|first| *first == here) {
        return work();
    }
    match forked(here) {
        Some(threads) => threads.install(work),
        None => work(),
    }
}

fn forked(here: u32) -> Option<Arc<ThreadPool>> {
    let mut kept = FORKED.lock().ok()?;
    if let Some((_, threads)) = kept.as_ref().filter(|(of, _)| *of == here) {
        return Some(threads.clone());
    }
    let threads = Arc::new(ThreadPoolBuilder::new().build().ok()?);
    // Another process's are not to be ended from here.
    std::mem::forget(kept.replace((here, threads.clone())));
    Some(threads)
}
