//! Prints the reference of all configuration keys: `docs/configuration.md`.
#![allow(clippy::print_stdout, reason = "it is what this program is for")]

fn main() {
    print!("{}", sidestep_train::config::reference::markdown());
}
