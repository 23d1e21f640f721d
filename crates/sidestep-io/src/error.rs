//! The one error of this crate: a file part that is not what its format allows.

use std::fmt;

/// A file that cannot be read: what it is, where the fault lies, what was found and what is allowed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{format}{place}: found {found}; expected {expected}")]
pub struct FormatError {
    /// The format that was being read, such as `task JSON`.
    pub format: &'static str,
    /// Where in the file.
    pub place: Place,
    /// What the file holds there, or the problem in words.
    pub found: String,
    /// What would have been allowed.
    pub expected: String,
}

/// A place in a file; each part only where it is known.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Place {
    /// The field's path, such as `obstacles[3].circle.radius`; empty for the whole file.
    pub path: String,
    /// Line, from 1.
    pub line: Option<usize>,
    /// Column in characters, from 1.
    pub column: Option<usize>,
}

impl Place {
    /// A field, by its path.
    pub fn field(path: impl Into<String>) -> Self {
        Self { path: path.into(), ..Self::default() }
    }

    /// A line, counted from 1.
    pub fn line(line: usize) -> Self {
        Self { line: Some(line), ..Self::default() }
    }

    /// The same place with the field's path.
    pub fn with_field(self, path: impl Into<String>) -> Self {
        Self { path: path.into(), ..self }
    }

    /// The same place with the column, counted from 1.
    pub fn with_column(self, column: usize) -> Self {
        Self { column: Some(column), ..self }
    }
}

impl fmt::Display for Place {
    /// `, line 3, column 8, goal[1]`: ready to follow the format's name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        if let Some(column) = self.column {
            write!(f, ", column {column}")?;
        }
        if !self.path.is_empty() {
            write!(f, ", {}", self.path)?;
        }
        Ok(())
    }
}

impl FormatError {
    /// An error of `format` at `place`. What was found is cut to a length that a person reads.
    pub fn new(
        format: &'static str,
        place: Place,
        found: impl fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self { format, place, found: cut(found.to_string(), 300), expected: expected.into() }
    }
}

/// The known name nearest to `name` by edit distance, if any is near enough to be a slip.
pub(crate) fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    if name.len() > LONGEST_WORD {
        return None;
    }
    let distance = |k: &str| strsim::damerau_levenshtein(&name.to_lowercase(), k);
    known
        .iter()
        .map(|&k| (distance(k), k))
        .min_by_key(|&(d, _)| d)
        .filter(|&(d, k)| d <= 1 + k.len() / 3)
        .map(|(_, k)| k)
}

/// Characters of a word from a file that a message repeats.
const LONGEST_WORD: usize = 60;

/// A text from a file, quoted for a message and cut to a length that a person reads.
pub(crate) fn quoted(text: &str) -> String {
    match text.char_indices().nth(LONGEST_WORD) {
        Some((cut, _)) => format!("{:?}...", &text[..cut]),
        None => format!("{text:?}"),
    }
}

/// A key from a file: as it is if it is a short word, otherwise quoted and cut.
pub(crate) fn plain_or_quoted(key: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "_-.:/ ".contains(c);
    if !key.is_empty() && key.len() <= LONGEST_WORD && key.chars().all(plain) {
        key.to_owned()
    } else {
        quoted(key)
    }
}

/// A text of at most `longest` characters, its end replaced by dots where it is longer.
fn cut(mut text: String, longest: usize) -> String {
    if let Some((end, _)) = text.char_indices().nth(longest) {
        text.truncate(end);
        text.push_str("...");
    }
    text
}
