//! The one error of the core: an input value that is not allowed.

/// A value that the caller passed and that is not allowed.
///
/// Not finding a path is never an error: see `plan::Status`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field}: {value} is not allowed; expected {allowed}")]
pub struct InvalidInput {
    /// The field's path, such as `obstacles[3].circle.radius`.
    pub field: String,
    /// The value as it was given.
    pub value: String,
    /// What would have been allowed.
    pub allowed: String,
}

impl InvalidInput {
    /// Names the field, the value given and what is allowed.
    pub fn new(
        field: impl Into<String>,
        value: impl std::fmt::Display,
        allowed: impl Into<String>,
    ) -> Self {
        Self { field: field.into(), value: shortened(value.to_string()), allowed: allowed.into() }
    }

    /// A name that is none of the known ones, with the nearest one where it may be a slip.
    pub fn unknown(field: impl Into<String>, name: &str, known: &[&str]) -> Self {
        let hint = nearest_name(name, known.iter().copied())
            .map_or_else(String::new, |nearest| format!("; did you mean {nearest}?"));
        Self::new(field, format!("`{name}`"), format!("one of {}{hint}", known.join(", ")))
    }

    /// The same error with its field placed inside `parent`: `radius` becomes `parent.radius`.
    pub fn inside(mut self, parent: &str) -> Self {
        self.field = format!("{parent}.{}", self.field);
        self
    }
}

/// Longest name that is compared with others; nobody mistypes a longer one.
const LONGEST_NAME: usize = 64;

/// The name among `known` nearest to `name` by edit distance, if near enough to suggest.
pub fn nearest_name<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.len() > LONGEST_NAME {
        return None;
    }
    known
        .into_iter()
        .map(|candidate| (strsim::damerau_levenshtein(name, candidate), candidate))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, candidate)| *distance <= candidate.len().max(3) / 2)
        .map(|(_, candidate)| candidate)
}

/// Characters of a value that a message repeats: enough to find it, and no more than a line or two.
const LONGEST_VALUE: usize = 160;

/// The value, or its beginning where it is long.
fn shortened(value: String) -> String {
    match value.char_indices().nth(LONGEST_VALUE) {
        Some((end, _)) => format!("{}... ({} characters)", &value[..end], value.chars().count()),
        None => value,
    }
}

/// Largest magnitude of a coordinate, in task units; squares and sums stay finite in f32 beyond it.
pub const MAX_COORDINATE: f64 = 1e9;

/// Checks that a number is finite and of a magnitude that the arithmetic can hold.
pub(crate) fn finite(field: &str, value: f64) -> Result<f64, InvalidInput> {
    if value.is_finite() && value.abs() <= MAX_COORDINATE {
        Ok(value)
    } else {
        Err(InvalidInput::new(field, value, "a finite number of magnitude at most 1e9"))
    }
}

/// Checks both coordinates of a point.
pub(crate) fn finite_point(field: &str, point: [f64; 2]) -> Result<[f64; 2], InvalidInput> {
    finite(&format!("{field}[0]"), point[0])?;
    finite(&format!("{field}[1]"), point[1])?;
    Ok(point)
}
