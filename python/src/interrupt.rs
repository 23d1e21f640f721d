//! Ctrl-C while Rust works: whoever plans asks now and then whether to go on.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Milliseconds between two looks at Python's signals.
const PERIOD: u64 = 20;

/// A deadline, and whether Ctrl-C was pressed or a callback raised an error.
pub struct Interrupt {
    begin: Instant,
    deadline: Option<Duration>,
    /// When signals were looked at last, milliseconds from the beginning.
    looked: AtomicU64,
    pressed: AtomicBool,
    /// What a callback raised.
    error: Mutex<Option<PyErr>>,
}

impl Interrupt {
    /// From now on, for so long at most.
    pub fn new(deadline: Option<Duration>) -> Self {
        let (looked, pressed) = (AtomicU64::new(0), AtomicBool::new(false));
        let error = Mutex::new(None);
        Self { begin: Instant::now(), deadline, looked, pressed, error }
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

    /// Ends the work with an error of a callback; the first one is raised.
    pub fn fail(&self, error: PyErr) {
        if let Ok(mut first) = self.error.lock() {
            first.get_or_insert(error);
        }
        self.pressed.store(true, Ordering::Relaxed);
    }

    /// Whether Ctrl-C was pressed or a callback raised an error.
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

    /// As [`Interrupt::check`], after which the next piece of work may begin.
    pub fn check_again(&self) -> PyResult<()> {
        let checked = self.check();
        self.pressed.store(false, Ordering::Relaxed);
        checked
    }

    /// Raises what a callback raised, or KeyboardInterrupt if Ctrl-C was pressed.
    pub fn check(&self) -> PyResult<()> {
        if let Some(error) = self.error.lock().ok().and_then(|mut error| error.take()) {
            return Err(error);
        }
        match self.is_pressed() {
            true => Err(pyo3::exceptions::PyKeyboardInterrupt::new_err(())),
            false => Ok(()),
        }
    }
}
