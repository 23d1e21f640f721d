//! The instruction set that policies compute with.

use std::env::VarError;

use sidestep::kernels::Kernels;

use crate::failure::Failure;

/// Names the widest kernels that may be used, so that a machine can answer with the bits of another.
const VARIABLE: &str = "SIDESTEP_KERNELS";

/// Keeps to what the environment allows.
pub fn limit() -> Result<(), Failure> {
    match std::env::var(VARIABLE) {
        Ok(name) => Kernels::named(&name)
            .map(Kernels::limit)
            .map_err(|error| Failure(error.inside(VARIABLE).to_string())),
        Err(VarError::NotPresent) => Ok(()),
        Err(error) => Err(Failure(format!("{VARIABLE}: {error}"))),
    }
}
