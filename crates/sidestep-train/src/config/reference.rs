//! The reference of all keys of both rooms' configurations, as Markdown: `docs/configuration.md`.

use serde::Serialize;
use serde_json::Value;

use super::schema::{Range, schema, shown};
use crate::paper::TrainConfig;
use crate::waypoint::{StageConfig, StageKind, WaypointConfig};

/// The paper's values, where it has some (sections II and III, and its published code).
const PAPER: [(&str, &str); 27] = [
    ("environment_steps", "10,000 to 80,000"),
    ("observation", "gradient; others in section III"),
    ("training.suite", "easy, hard or mix"),
    ("training.count", "100"),
    ("network.hidden", "64, 128, 256"),
    ("network.initialization", "identity in its text, orthogonal in its code"),
    ("environment.mu", "0.1 and 1"),
    ("environment.feasible_bonus", "0"),
    ("environment.episode_limit", "none"),
    ("cloning.epochs", "1"),
    ("cloning.samples_per_task", "100"),
    ("cloning.step", "0.1"),
    ("cloning.starts", "random"),
    ("cloning.minibatch", "64"),
    ("cloning.optimizer", "adadelta"),
    ("cloning.prediction", "mean in its text, sampled in its code"),
    ("dagger.rounds", "0; named as a cure in section IV"),
    ("ppo.environments", "100"),
    ("ppo.steps", "40"),
    ("ppo.gamma", "1"),
    ("ppo.lambda", "0.95"),
    ("ppo.learning_rate", "3e-4"),
    ("ppo.minibatch", "64"),
    ("ppo.epochs", "10"),
    ("ppo.value", "0.5"),
    ("ppo.max_gradient_norm", "0.5"),
    ("ppo.clip", "0.2"),
];

/// The whole document.
pub fn markdown() -> String {
    let mut text = String::from(
        "# Configuration of trainings\n\n\
         Made from the code by `cargo run -p sidestep-train --example configuration > docs/configuration.md`; do not edit.\n\n\
         A file names only what differs from the defaults. `sidestep train FILE --set KEY=VALUE` puts a value in place of the file's.\n\
         What `experiment` trains is written the same way, under `[train]` for all policies and `[policies.train]` for one.\n\n\
         The key `architecture` says which of the two rooms a file is for.\n\n\
         ## The paper's system\n\n\
         Without the key `architecture`: cloning of gradient descent, DAgger if there are rounds, then PPO.\n\n",
    );
    text += HEAD_WITH_PAPER;
    rows(&mut text, "", &schema::<TrainConfig>(), &defaults(&TrainConfig::default()), true);
    text += "\n## The waypoint policy\n\n\
             With `architecture = \"waypoint\"`: the stages that `stages` lists, in order. What is shipped is made by\n\
             `experiments/sidestep-1.toml`.\n\n";
    text += HEAD;
    rows(&mut text, "", &schema::<WaypointConfig>(), &defaults(&WaypointConfig::default()), false);
    text += "\nA stage, `[[stages]]`, names all of its keys:\n\n";
    text += HEAD;
    let stage = StageConfig { kind: StageKind::Imitation, updates: 0, learning_rate: 0.0 };
    let keys = defaults(&stage);
    let none: Value =
        keys.as_object().into_iter().flatten().map(|(k, _)| (k.clone(), Value::Null)).collect();
    rows(&mut text, "", &schema::<StageConfig>(), &none, false);
    text
}

const HEAD_WITH_PAPER: &str = "| key | kind | default | allowed | the paper | meaning |\n| --- | --- | --- | --- | --- | --- |\n";
const HEAD: &str =
    "| key | kind | default | allowed | meaning |\n| --- | --- | --- | --- | --- |\n";

fn defaults<C: Serialize>(config: &C) -> Value {
    serde_json::to_value(config).unwrap_or_default()
}

/// One line for each key under `prefix`.
fn rows(text: &mut String, prefix: &str, schema: &Value, defaults: &Value, with_paper: bool) {
    for (name, own) in schema["properties"].as_object().into_iter().flatten() {
        let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        let default = &defaults[name];
        if own["properties"].is_object() {
            rows(text, &key, own, default, with_paper);
            continue;
        }
        let paper = PAPER.iter().find(|(known, _)| *known == key).map_or("", |(_, value)| value);
        let paper = if with_paper { format!(" {paper} |") } else { String::new() };
        let meaning = own["description"].as_str().unwrap_or_default().replace('\n', " ");
        let (kind, allowed, default) = (kind(own), allowed(own), written(default));
        *text += &format!("| `{key}` | {kind} | {default} | {allowed} |{paper} {meaning} |\n");
    }
}

fn kind(schema: &Value) -> &'static str {
    if !choices(schema).is_empty() {
        return "choice";
    }
    let name = match &schema["type"] {
        Value::Array(names) => names.first().and_then(Value::as_str),
        name => name.as_str(),
    };
    match name {
        Some("integer") => "whole number",
        Some("number") => "number",
        Some("boolean") => "true or false",
        Some("array") => "list",
        _ => "text",
    }
}

/// The range or the choices.
fn allowed(schema: &Value) -> String {
    let choices = choices(schema);
    if !choices.is_empty() {
        return choices.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    }
    match kind(schema) {
        "whole number" | "number" => {
            let words = Range::of(schema).words();
            let words = words.strip_prefix("a number ").unwrap_or_default().to_string();
            let optional = schema["type"].is_array();
            if optional { format!("{words}, or left out") } else { words }
        }
        _ => String::new(),
    }
}

fn choices(schema: &Value) -> Vec<&str> {
    let listed = schema["enum"].as_array().into_iter().flatten();
    let described = schema["oneOf"].as_array().into_iter().flatten().map(|one| &one["const"]);
    listed.chain(described).filter_map(Value::as_str).collect()
}

/// A default as TOML writes it.
fn written(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::Number(number) if number.is_f64() => {
            format!("`{}`", shown(number.as_f64().unwrap_or_default()))
        }
        Value::Array(items) if items.iter().any(Value::is_object) => "two stages".into(),
        other => format!("`{other}`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_document_is_what_the_code_says() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/configuration.md");
        let found = std::fs::read_to_string(path).unwrap();
        assert!(found == markdown(), "docs/configuration.md is old; its head names the command");
    }

    #[test]
    fn every_key_has_a_line_with_a_meaning_and_every_value_of_the_papers_a_key() {
        let text = markdown();
        for line in text.lines().filter(|line| line.starts_with("| `")) {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            assert!(cells[cells.len() - 2].len() > 5, "{line}");
        }
        for (key, _) in PAPER {
            assert!(text.contains(&format!("| `{key}` |")), "{key}");
        }
        assert!(text.matches("| `").count() > 70, "{text}");
    }
}
