//! Python bindings: thin, NumPy arrays in and out, the interpreter free while Rust works. What is computed,
//! read or checked lives in the libraries.

#![allow(clippy::needless_pass_by_value, reason = "arguments come from Python by value")]
// The macros of pyo3 make the functions that Python calls.
#![allow(unsafe_code, reason = "pyo3's macros")]

mod batch;
mod distances;
mod interrupt;
mod objective;
mod own;
mod planning;
mod policy;
mod robots;
mod tasks;
mod threads;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// An error of the libraries as Python's: the message names field, value and what is allowed.
fn invalid(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The compiled part of the package `sidestep`.
#[pymodule]
mod _sidestep {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::batch::Batch;
    #[pymodule_export]
    use super::distances::distances;
    #[pymodule_export]
    use super::objective::Objective;
    #[pymodule_export]
    use super::planning::{Plan, certify, plan, plan_batch, planners, shortest_path};
    #[pymodule_export]
    use super::policy::Policy;
    #[pymodule_export]
    use super::robots::{Robot, Scene};
    #[pymodule_export]
    use super::tasks::{Task, read, read_problems, suite, write};

    #[pymodule_init]
    fn init(_module: &Bound<'_, PyModule>) -> PyResult<()> {
        super::threads::begin();
        Ok(())
    }

    /// Version of the libraries.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");

    /// Runs the program `sidestep` with these arguments (the first is its name); its exit code.
    #[pyfunction]
    fn main(py: Python<'_>, arguments: Vec<String>) -> u8 {
        crate::threads::detach(py, || sidestep_cli::main_with(arguments))
    }
}
