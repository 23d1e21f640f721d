//! Readers of what training writes, and of the names and settings of the command line.

use sidestep::InvalidInput;
use sidestep::plan::parse_planner;
use sidestep::plan::starts::StartStrategy;
use sidestep::policy::Policy;
use sidestep::profile::Profile;

use crate::readers::told;

/// A file from before there were checksums is read too, so a changed file gets past that one.
pub fn policy(bytes: &[u8]) {
    told(Policy::from_safetensors(bytes));
}

/// Planners with their settings, profiles and start strategies by name.
pub fn names(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let none = |_: &str| Err(InvalidInput::new("policy", "none", "a file"));
    told(parse_planner(&text, &mut { none }));
    told(text.parse::<Profile>());
    told(text.parse::<StartStrategy>());
}
