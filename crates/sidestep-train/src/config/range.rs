//! Checks of single values that a range does not describe; a message names the field, the value and
//! what is allowed.

use std::fmt::Display;

use sidestep::InvalidInput;

/// The error for a value.
pub(crate) fn refuse<T>(
    field: &str,
    value: impl Display,
    allowed: &str,
) -> Result<T, InvalidInput> {
    Err(InvalidInput::new(field, value, allowed))
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
