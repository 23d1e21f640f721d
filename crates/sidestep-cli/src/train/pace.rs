//! How a training goes, for people: a bar on a terminal, elsewhere a line now and then.

use std::io::{IsTerminal, stderr};
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use sidestep_train::Training;

use crate::output;

/// Time between two lines where there is no terminal.
const INTERVAL: Duration = Duration::from_secs(10);

/// Shows how a training goes.
pub struct Pace {
    bar: ProgressBar,
    tells: bool,
    begin: Instant,
    last_line: Instant,
    steps_before: u64,
    units_before: u64,
    validation: Option<String>,
}

impl Pace {
    /// Begins to show a training; `quiet` shows nothing.
    pub fn of(training: &dyn Training, quiet: bool) -> Self {
        let units = training.units();
        let bar = output::progress("training", units.all, quiet);
        bar.set_position(units.done);
        let now = Instant::now();
        Self {
            bar,
            tells: !quiet && !stderr().is_terminal(),
            begin: now,
            last_line: now,
            steps_before: training.environment_steps(),
            units_before: units.done,
            validation: None,
        }
    }

    /// After a unit, with what its validation found in words.
    pub fn step(&mut self, training: &dyn Training, validation: Option<String>) {
        self.bar.inc(1);
        if let Some(words) = validation {
            self.bar.set_message(words.clone());
            self.validation = Some(words);
        }
        if self.tells && self.last_line.elapsed() >= INTERVAL {
            output::tell(&self.line(training));
            self.last_line = Instant::now();
        }
    }

    /// Such as `unit 12 of 49, 4800 steps, 51300 a second, validation 81.5 %, 70 s left`.
    fn line(&self, training: &dyn Training) -> String {
        let (units, steps) = (training.units(), training.environment_steps());
        let seconds = self.begin.elapsed().as_secs_f64();
        let rate = (steps - self.steps_before) as f64 / seconds;
        let made = units.done - self.units_before;
        let left = seconds / made.max(1) as f64 * (units.all - units.done) as f64;
        let validation = self.validation.as_ref().map_or(String::new(), |v| format!(", {v}"));
        format!(
            "unit {} of {}, {steps} steps, {rate:.0} a second{validation}, {left:.0} s left",
            units.done, units.all
        )
    }

    /// Ends the bar.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }
}
