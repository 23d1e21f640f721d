//! From TOML text to a configuration, with errors in the user's own words.
//!
//! Serde's messages name neither the section nor the nearest key, so keys and kinds of values are
//! first compared with the defaults, which know every key; what is left (names of choices, syntax)
//! keeps the parser's message and line.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value as Known;
use sidestep::InvalidInput;
use toml::{Table, Value};

/// Farthest that a key may be from a known one (Jaro-Winkler similarity) to be suggested.
const SIMILAR: f64 = 0.7;

/// The text as a table.
///
/// # Errors
/// If it is no TOML; the message names the line.
pub fn table(text: &str) -> Result<Table, InvalidInput> {
    toml::from_str(text).map_err(|error| plain(text, &error))
}

/// Reads a configuration; what is left out keeps its default. `text` is what the table was read
/// from, or empty.
///
/// # Errors
/// If there is an unknown key or a value of the wrong kind; the message names key, value and kind.
pub fn parse<C: Default + Serialize + DeserializeOwned>(
    table: &Table,
    text: &str,
) -> Result<C, InvalidInput> {
    let known = serde_json::to_value(C::default())
        .map_err(|error| InvalidInput::new("config", error, "the defaults as JSON"))?;
    check_table("", table, &known)?;
    match text {
        "" => table.clone().try_into(),
        text => toml::from_str(text),
    }
    .map_err(|error| plain(text, &error))
}

/// Puts `over` into `base`, table by table; lists and values replace what was there.
pub fn merge(base: &mut Table, over: &Table) {
    for (key, value) in over {
        match (base.get_mut(key), value) {
            (Some(Value::Table(base)), Value::Table(over)) => merge(base, over),
            _ => {
                base.insert(key.clone(), value.clone());
            }
        }
    }
}

/// The table of one setting `KEY=VALUE`, where the key may have dots and the value is TOML; a value
/// that is none counts as a text.
///
/// # Errors
/// If there is no `=`, or the key is none of TOML.
pub fn setting(text: &str) -> Result<Table, InvalidInput> {
    let refused = || InvalidInput::new("--set", text, "KEY=VALUE, such as ppo.learning_rate=1e-3");
    let (key, value) = text.split_once('=').ok_or_else(refused)?;
    let quoted = Value::String(value.trim().into());
    toml::from_str(&format!("{key} = {value}"))
        .or_else(|_| toml::from_str(&format!("{key} = {quoted}")))
        .map_err(|_| refused())
}

/// The parser's own error, with its line.
fn plain(text: &str, error: &toml::de::Error) -> InvalidInput {
    let field = match error.span() {
        Some(span) => {
            let before = text.get(..span.start).unwrap_or(text);
            format!("config, line {}", before.matches('\n').count() + 1)
        }
        None => "config".into(),
    };
    let message = error.message();
    let (value, allowed) =
        message.split_once(", expected ").unwrap_or((message, "the syntax of TOML"));
    InvalidInput::new(field, value, allowed)
}

fn check_table(path: &str, table: &Table, known: &Known) -> Result<(), InvalidInput> {
    for (key, value) in table {
        let field = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        let Some(default) = known.get(key) else {
            return Err(InvalidInput::new(field, "an unknown key", suggestion(path, key, known)));
        };
        check_kind(&field, value, default)?;
    }
    Ok(())
}

fn suggestion(path: &str, key: &str, known: &Known) -> String {
    let keys: Vec<&String> = known.as_object().into_iter().flat_map(|map| map.keys()).collect();
    let similarity = |name: &String| strsim::jaro_winkler(name, key);
    let nearest = keys.iter().max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
    match nearest.filter(|name| similarity(name) > SIMILAR) {
        Some(name) => format!("{name} (the nearest known key)"),
        None => {
            let place = if path.is_empty() { String::new() } else { format!("[{path}] knows ") };
            let names: Vec<&str> = keys.iter().map(|name| name.as_str()).collect();
            format!("{place}{}", names.join(", "))
        }
    }
}

fn check_kind(field: &str, value: &Value, default: &Known) -> Result<(), InvalidInput> {
    let (fits, kind) = match default {
        Known::Object(_) => match value {
            Value::Table(table) => return check_table(field, table, default),
            _ => (false, "a table"),
        },
        Known::Number(number) if number.is_u64() => {
            (value.as_integer().is_some_and(|n| n >= 0), "a whole number of at least 0")
        }
        Known::Number(_) => (value.is_float() || value.is_integer(), "a number"),
        Known::Bool(_) => (value.is_bool(), "true or false"),
        Known::String(_) => (value.is_str(), "a text in quotes"),
        Known::Array(known) => match (value.as_array(), known.first()) {
            (Some(items), Some(first)) => {
                let kind = if first.is_string() { "a list of texts in quotes" } else { "" };
                for item in items {
                    check_kind(field, item, first).map_err(|error| match kind {
                        "" => error,
                        kind => InvalidInput::new(field, item, kind),
                    })?;
                }
                return Ok(());
            }
            (items, _) => (items.is_some(), "a list"),
        },
        // Optional values have no default to compare with: all of them are numbers above 0.
        Known::Null => (
            value.as_float().is_some_and(|x| x > 0.0) || value.as_integer().is_some_and(|n| n > 0),
            "a number above 0, or leave the key out",
        ),
    };
    if fits { Ok(()) } else { Err(InvalidInput::new(field, value, kind)) }
}
