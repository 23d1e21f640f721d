//! The one error of the program: a message that says what to mend.

use std::fmt;
use std::path::Path;

/// Bad input or usage; ends the program with exit code 2.
#[derive(Debug)]
pub struct Failure(pub String);

impl Failure {
    /// A failure with `what` it happened to, such as a path, before the reason.
    pub fn at(what: impl fmt::Display, reason: impl fmt::Display) -> Self {
        Self(format!("{what}: {reason}"))
    }

    /// A failure with a file.
    pub fn file(path: &Path, reason: impl fmt::Display) -> Self {
        Self::at(path.display(), reason)
    }
}

/// Characters of a message that are shown; past them somebody's file is being repeated.
const LONGEST: usize = 2000;

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(message) = self;
        let Some((end, _)) = message.char_indices().nth(LONGEST) else {
            return f.write_str(message);
        };
        let left_out = message.chars().count() - LONGEST;
        write!(f, "{}... ({left_out} more characters)", &message[..end])
    }
}

impl From<sidestep::InvalidInput> for Failure {
    fn from(error: sidestep::InvalidInput) -> Self {
        Self(error.to_string())
    }
}
