//! One check for every table of bad input: the reader refuses it, in these words.

use sidestep_io::FormatError;

/// Panics unless `result` is an error whose message holds `message`.
#[track_caller]
pub fn check_refused<T: std::fmt::Debug>(result: Result<T, FormatError>, message: &str) {
    let error = result.unwrap_err().to_string();
    assert!(error.contains(message), "     got: {error}\nexpected: {message}");
}
