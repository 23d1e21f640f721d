//! The threads that batches, trainings and starts are spread over.

use std::error::Error;
use std::thread::available_parallelism;

use rayon::ThreadPoolBuilder;
use sidestep::InvalidInput;

use crate::failure::Failure;

/// Most threads; beyond it they only wait for each other.
const MAX_THREADS: usize = 512;
/// Address space that a thread needs, at most: its stack, and what the system's allocator sets aside for it.
const ROOM: usize = 8 << 20;

/// Starts that many threads, one for each core where 0; in a process that has them already, none.
pub fn start(count: usize) -> Result<(), Failure> {
    if count > MAX_THREADS {
        let allowed = format!("a number from 0 (all cores) to {MAX_THREADS}");
        return Err(InvalidInput::new("--threads", count, allowed).into());
    }
    let cores = available_parallelism().map_or(1, usize::from);
    let threads = if count == 0 { cores } else { count };
    let refused = |why: String| {
        let hint = "give a smaller number";
        Err(Failure(format!("--threads: {threads} threads cannot be started ({why}); {hint}")))
    };
    if !is_room_for(threads) {
        return refused("there is not enough memory".into());
    }
    match ThreadPoolBuilder::new().num_threads(count).build_global() {
        Err(error) if error.source().is_some() => refused(error.to_string()),
        // Without a cause: this process has started its threads before.
        _ => Ok(()),
    }
}

/// Whether so many threads find room: one that starts and finds none aborts the process, and nobody can catch it.
fn is_room_for(threads: usize) -> bool {
    let mut room: Vec<u8> = Vec::new();
    let found = room.try_reserve_exact(threads * ROOM).is_ok();
    // Else the compiler may leave out what is given back at once.
    std::hint::black_box(&room);
    found
}
