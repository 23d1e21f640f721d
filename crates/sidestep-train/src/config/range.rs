//! Checks of single values; a message names the field, the value and the range.

use std::fmt::Display;
use std::ops::RangeInclusive;

use sidestep::InvalidInput;

/// The error for a value.
pub(crate) fn refuse<T>(
    field: &str,
    value: impl Display,
    allowed: &str,
) -> Result<T, InvalidInput> {
    Err(InvalidInput::new(field, value, allowed))
}

/// A number in `range`.
pub(crate) fn within<T: PartialOrd + Display>(
    field: &str,
    value: T,
    range: RangeInclusive<T>,
) -> Result<(), InvalidInput> {
    if range.contains(&value) {
        return Ok(());
    }
    let allowed = format!("a number from {} to {}", range.start(), range.end());
    Err(InvalidInput::new(field, value, allowed))
}

/// A number in (0, `most`].
pub(crate) fn above_zero<T: Copy + Into<f64> + Display>(
    field: &str,
    value: T,
    most: f64,
) -> Result<(), InvalidInput> {
    if value.into() > 0.0 && value.into() <= most {
        return Ok(());
    }
    Err(InvalidInput::new(field, value, format!("a number above 0 and up to {most}")))
}

/// A seed whose tasks may be trained on.
pub(crate) fn training_seed(field: &str, seed: u64) -> Result<(), InvalidInput> {
    if seed == 0 || seed >= 1000 {
        return Ok(());
    }
    refuse(field, seed, "0, or 1000 and above; the rest are for validation and tests")
}

/// A seed whose tasks may choose between policies.
pub(crate) fn validation_seed(field: &str, seed: u64) -> Result<(), InvalidInput> {
    if [7, 17].contains(&seed) {
        return Ok(());
    }
    refuse(field, seed, "7 or 17; the rest are for training and tests")
}
