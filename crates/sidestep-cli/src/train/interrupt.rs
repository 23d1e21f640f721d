//! Ctrl-C (and a polite request to end) during a training: the unit that is being made is finished
//! and stored.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::iterator::{Handle, Signals};

use crate::failure::Failure;
use crate::output;

/// Exit code of a run that was broken off, as a shell gives it.
pub const EXIT: u8 = 130;

/// Listens from its making to its end.
pub struct Interrupt {
    wanted: Arc<AtomicBool>,
    handle: Handle,
}

impl Interrupt {
    /// Begins to listen.
    pub fn listen() -> Result<Self, Failure> {
        let failed = |error| Failure::at("Ctrl-C", format!("cannot be listened to ({error})"));
        let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(failed)?;
        let (wanted, handle) = (Arc::new(AtomicBool::new(false)), signals.handle());
        let seen = wanted.clone();
        thread::Builder::new()
            .spawn(move || {
                for _ in signals.forever() {
                    if seen.swap(true, Ordering::SeqCst) {
                        // The second time: what is stored already has to do.
                        std::process::exit(i32::from(EXIT));
                    }
                    output::tell("stopping after this unit; once more, and it stops at once");
                }
            })
            .map_err(failed)?;
        Ok(Self { wanted, handle })
    }

    /// Whether the training is to stop.
    pub fn is_wanted(&self) -> bool {
        self.wanted.load(Ordering::SeqCst)
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        self.handle.close();
    }
}
