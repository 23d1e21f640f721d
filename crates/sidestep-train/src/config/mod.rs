//! What the configurations of both rooms share: from TOML's text to values, checks of values and of
//! the memory that a training takes, and of what a checkpoint was made with.

pub(crate) mod memory;
pub(crate) mod range;
pub mod reference;
mod same;
mod schema;
pub mod toml_file;

pub(crate) use same::check_same;
pub(crate) use schema::check_ranges;
