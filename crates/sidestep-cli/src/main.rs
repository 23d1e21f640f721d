//! The `sidestep` program; all of it is in the library of this crate.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(sidestep_cli::main_with(std::env::args_os()))
}
