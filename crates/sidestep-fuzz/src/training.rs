//! Readers of what training writes and reads, and of the names and settings of the command line.

use std::sync::LazyLock;

use sidestep::InvalidInput;
use sidestep::plan::parse_planner;
use sidestep::plan::starts::StartStrategy;
use sidestep::policy::Policy;
use sidestep::profile::Profile;
use sidestep_train::Recipe;

use crate::readers::told;

/// A file from before there were checksums is read too, so a changed file gets past that one.
pub fn policy(bytes: &[u8]) {
    told(Policy::from_safetensors(bytes));
}

/// The first byte says of which kind of training it is.
pub fn checkpoint(bytes: &[u8]) {
    static RECIPES: LazyLock<[Recipe; 2]> = LazyLock::new(|| {
        ["environment_steps = 4", "architecture = \"waypoint\""]
            .map(|text| Recipe::from_toml(text).unwrap())
    });
    let Some((&first, rest)) = bytes.split_first() else { return };
    told(RECIPES[usize::from(first % 2)].resume(rest));
}

/// A configuration of either kind; what was read and written is read the same.
pub fn recipe(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Some(recipe) = told(Recipe::from_toml(&text)) {
        let written = recipe.to_toml().unwrap();
        let again = Recipe::from_toml(&written).unwrap_or_else(|e| panic!("{e}\n{written}"));
        assert_eq!(again.to_toml().unwrap(), written);
    }
}

/// Planners with their settings, profiles and start strategies by name.
pub fn names(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let none = |_: &str| Err(InvalidInput::new("policy", "none", "a file"));
    told(parse_planner(&text, &mut { none }));
    told(text.parse::<Profile>());
    told(text.parse::<StartStrategy>());
}
