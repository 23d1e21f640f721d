//! What the configurations of both trainings share: from TOML's text to values, and checks of single values.

pub(crate) mod range;
pub mod toml_file;
