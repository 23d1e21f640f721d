//! Whether a checkpoint was made with the configuration that is given.

use serde::Serialize;
use serde_json::Value;
use sidestep::InvalidInput;

/// Fails with the first key in which `given` differs from what a checkpoint was made with.
pub(crate) fn check_same<C: Serialize>(stored: &C, given: &C) -> Result<(), InvalidInput> {
    let values = [stored, given].map(|config| serde_json::to_value(config).unwrap_or_default());
    let [stored, given] = &values;
    let Some((key, stored, given)) = difference("", stored, given) else { return Ok(()) };
    let allowed = format!("{stored}, which the checkpoint was made with");
    Err(InvalidInput::new(key, given, allowed))
}

/// The first key whose values differ, with both of them.
fn difference<'a>(
    path: &str,
    stored: &'a Value,
    given: &'a Value,
) -> Option<(String, &'a Value, &'a Value)> {
    match (stored, given) {
        (Value::Object(stored), Value::Object(given)) => stored.iter().find_map(|(key, stored)| {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            difference(&path, stored, given.get(key).unwrap_or(&Value::Null))
        }),
        (Value::Array(stored), Value::Array(given)) if stored.len() == given.len() => {
            let pairs = stored.iter().zip(given).enumerate();
            pairs
                .into_iter()
                .find_map(|(i, (stored, given))| difference(&format!("{path}[{i}]"), stored, given))
        }
        _ => (stored != given).then(|| (path.to_string(), stored, given)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_key_that_differs_is_named() {
        let check = |stored: Value, given: Value, expected: Option<&str>| {
            let message = check_same(&stored, &given).err().map(|error| error.to_string());
            assert_eq!(message.as_deref(), expected);
        };
        check(json!({"a": 1, "b": [1, 2]}), json!({"a": 1, "b": [1, 2]}), None);
        check(
            json!({"a": {"b": 0.5}}),
            json!({"a": {"b": null}}),
            Some("a.b: null is not allowed; expected 0.5, which the checkpoint was made with"),
        );
        check(
            json!({"stages": [{"updates": 5}]}),
            json!({"stages": [{"updates": 4}]}),
            Some(
                "stages[0].updates: 4 is not allowed; expected 5, which the checkpoint was made with",
            ),
        );
        check(
            json!({"a": [1, 2]}),
            json!({"a": [1]}),
            Some("a: [1] is not allowed; expected [1,2], which the checkpoint was made with"),
        );
    }
}
