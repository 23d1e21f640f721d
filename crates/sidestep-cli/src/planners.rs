//! `sidestep planners`: every planner by name, with its settings.

use clap::Args;
use serde_json::{Value, json};
use sidestep::plan::{PLANNERS, PlannerName, PlannerSetting};

use crate::Global;
use crate::failure::Failure;
use crate::output;

/// Arguments of `planners`.
#[derive(Args)]
#[command(after_help = "Example:\n  sidestep planners")]
pub struct PlannersArgs {}

/// Prints the list.
pub fn run(global: &Global) -> Result<(), Failure> {
    if global.json {
        return output::print_json(&PLANNERS.iter().map(document).collect::<Vec<_>>());
    }
    let width = PLANNERS.iter().map(|planner| planner.form().len()).max().unwrap_or(0);
    let mut text = String::new();
    for planner in &PLANNERS {
        text += &format!("{:width$}  {}\n", planner.form(), planner.about);
        for setting in planner.settings {
            let (PlannerSetting { key, about, default, .. }, range) = (setting, setting.range());
            text += &format!("    {key}: {about}; {range} [default: {default}]\n");
        }
    }
    output::print(&text)
}

fn document(planner: &PlannerName) -> Value {
    let setting = |setting: &PlannerSetting| {
        json!({
            "key": setting.key,
            "about": setting.about,
            "least": setting.least,
            "most": setting.most,
            "whole": setting.whole,
            "default": setting.default,
        })
    };
    json!({
        "name": planner.name,
        "form": planner.form(),
        "about": planner.about,
        "settings": planner.settings.iter().map(setting).collect::<Vec<_>>(),
    })
}
