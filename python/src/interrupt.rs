//! Ctrl-C while Rust works: whoever plans asks now and then whether to go on.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Milliseconds between two looks at Python's signals.
const PERIOD: u64 = 20;

/// A deadline, and whether Ctrl-C was pressed.
pub struct Interrupt {
    begin: Instant,
    deadline: Option<Duration>,
    /// When signals were looked at last, milliseconds from the beginning.
    looked: AtomicU64,
    pressed: AtomicBool,
}

impl Interrupt {
    /// From now on, for so long at most.
    pub fn new(deadline: Option<Duration>) -> Self {
        let (looked, pressed) = (AtomicU64::new(0), AtomicBool::new(false));
        Self { begin: Instant::now(), deadline, looked, pressed }
    }

    /// Whether to go on. Python's signals are seen by its main thread alone.
    pub fn go_on(&self) -> bool {
        let now = self.begin.elapsed();
        let ms = now.as_millis() as u64;
        if ms >= self.looked.load(Ordering::Relaxed) + PERIOD {
            self.looked.store(ms, Ordering::Relaxed);
            self.look();
        }
        !self.is_pressed() && self.is_time_left()
    }

    /// Whether the budget is not spent.
    pub fn is_time_left(&self) -> bool {
        self.deadline.is_none_or(|deadline| self.begin.elapsed() < deadline)
    }

    fn look(&self) {
        if let Err(error) = Python::attach(|py| py.check_signals()) {
            self.pressed.store(true, Ordering::Relaxed);
            // Raised again by `check`, from where Python can hear it.
            drop(error);
        }
    }

    /// Whether Ctrl-C was pressed.
    pub fn is_pressed(&self) -> bool {
        self.pressed.load(Ordering::Relaxed)
    }

    /// Runs `work` on other threads while this one looks at the signals.
    pub fn beside<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        std::thread::scope(|scope| {
            let worker = scope.spawn(work);
            while !worker.is_finished() {
                std::thread::sleep(Duration::from_millis(1));
                self.go_on();
            }
            match worker.join() {
                Ok(answer) => answer,
                Err(panic) => std::panic::resume_unwind(panic),
            }
        })
    }

    /// Raises KeyboardInterrupt if Ctrl-C was pressed.
    pub fn check(&self) -> PyResult<()> {
        match self.is_pressed() {
            true => Err(pyo3::exceptions::PyKeyboardInterrupt::new_err(())),
            false => Ok(()),
        }
    }
}
