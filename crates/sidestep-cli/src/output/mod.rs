//! Results to files and standard output, messages and progress to standard error.

mod files;

use std::io::{self, Write};
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::failure::Failure;
pub use files::{Output, check_outputs, check_suffix, write_file};

/// Writes a value as JSON with a final newline.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    write_file(path, to_json(value)?.as_bytes())
}

/// Prints a value as JSON on standard output.
pub fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    print(&to_json(value)?)
}

/// Prints text on standard output; a closed pipe is not an error.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::at("standard output", format!("cannot be written ({error})")))
        }
        _ => Ok(()),
    }
}

/// Says a line on standard error; where nobody can hear it, it is lost.
pub fn tell(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

fn to_json(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|error| Failure::at("result", error))
}

/// A progress bar on standard error; silent where that is no terminal or `quiet` is set.
pub fn progress(label: &str, total: u64, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(total);
    if let Ok(style) = ProgressStyle::with_template(
        "{prefix:24!} {bar:32} {pos}/{len} {elapsed} (left {eta}) {msg}",
    ) {
        bar.set_style(style);
    }
    bar.set_prefix(label.to_string());
    bar
}

/// Something that turns on standard error while work of unknown length is done; silent as
/// [`progress`] is.
pub fn spinner(label: &str, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner().with_message(label.to_string());
    bar.enable_steady_tick(std::time::Duration::from_millis(200));
    bar
}
