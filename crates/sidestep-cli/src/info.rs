//! `sidestep info`: what a policy file says of itself.

use clap::Args;
use serde_json::{Value, json};
use sidestep::policy::{Policy, PolicyCard, shipped};

use crate::Global;
use crate::failure::Failure;
use crate::output;
use crate::planning::{load_policy, policy_file};

/// Arguments of `info`.
#[derive(Args)]
#[command(after_help = "Examples:\n  sidestep info sidestep-1\n  \
    sidestep info runs/mine/policy.safetensors --json")]
pub struct InfoArgs {
    /// A policy file, the folder of a training, or a shipped policy: sidestep-1, sidestep-1-small
    policy: String,
}

/// Prints the policy's card.
pub fn run(args: &InfoArgs, global: &Global) -> Result<(), Failure> {
    let name = args.policy.as_str();
    let (shipped, loaded);
    let policy: &Policy = match name {
        "sidestep-1" => {
            shipped = shipped::sidestep_1();
            &shipped
        }
        "sidestep-1-small" => {
            shipped = shipped::sidestep_1_small();
            &shipped
        }
        _ => {
            loaded = load_policy(&policy_file(name).unwrap_or_else(|| name.into()))?;
            &loaded
        }
    };
    let parameters = parameters(policy)?;
    if global.json {
        let mut document = json!(policy.card());
        document["parameters"] = json!(parameters);
        return output::print_json(&document);
    }
    output::print(&describe(policy, parameters))
}

/// The numbers that were learned.
fn parameters(policy: &Policy) -> Result<u64, Failure> {
    let bytes = policy.to_safetensors()?;
    let header = bytes.first_chunk().map_or(0, |length| u64::from_le_bytes(*length));
    // Behind the header, every number takes four bytes.
    Ok((bytes.len() as u64).saturating_sub(8 + header) / 4)
}

fn describe(policy: &Policy, parameters: u64) -> String {
    let PolicyCard { format, architecture, sizes, waypoints, observation, .. } = policy.card();
    let PolicyCard { profile, action, training, licence, .. } = policy.card();
    let waypoints = match policy.fixed_waypoints() {
        Some(fixed) => format!("{fixed}"),
        None => format!("any number; trained mostly with {waypoints}"),
    };
    let profile = match policy.fixed_profile() {
        Some(fixed) => fixed.to_string(),
        None => format!("any; trained in {profile}"),
    };
    let inside = if action.keep_inside { ", kept inside the field" } else { "" };
    let rows = [
        ("format", format.clone()),
        ("architecture", format!("{architecture} {sizes:?}")),
        ("parameters", parameters.to_string()),
        ("observation", observation.join(", ")),
        ("waypoints", waypoints),
        ("profile", profile),
        ("action", format!("{} times the output, at most {}{inside}", action.scale, action.limit)),
        ("licence", licence.clone()),
    ];
    let mut text = String::new();
    for (name, value) in rows {
        text += &format!("{name:13} {value}\n");
    }
    // The rest is whatever the training wrote down.
    lines("training", training, &mut text);
    text
}

/// A line for each value, by its place; long lists, such as a curve, by their number.
fn lines(place: &str, value: &Value, text: &mut String) {
    let line = match value {
        Value::Object(fields) => {
            fields.iter().for_each(|(name, value)| lines(&format!("{place}.{name}"), value, text));
            return;
        }
        Value::Array(values) if values.len() > 8 => format!("{} values", values.len()),
        Value::String(line) => line.clone(),
        value => value.to_string(),
    };
    *text += &format!("{place:13} {line}\n");
}
