//! A configuration's schema: every key with its kind, range and meaning, as the types state them.
//! It checks values, and it is what the reference of keys is made from ([`super::reference`]).

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde_json::Value;
use sidestep::InvalidInput;

/// The schema of a configuration, without references.
pub(super) fn schema<C: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
    settings.into_generator().into_root_schema_for::<C>().to_value()
}

/// Checks every number of a configuration against the range that its type states.
///
/// # Errors
/// If one is out of its range, or not finite; the message names the key, the value and the range.
pub(crate) fn check_ranges<C: Serialize + JsonSchema>(config: &C) -> Result<(), InvalidInput> {
    let value = serde_json::to_value(config)
        .map_err(|error| InvalidInput::new("config", error, "a configuration"))?;
    check("", &value, &schema::<C>())
}

fn check(key: &str, value: &Value, schema: &Value) -> Result<(), InvalidInput> {
    match value {
        Value::Object(fields) => fields.iter().try_for_each(|(name, value)| {
            let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
            check(&key, value, &schema["properties"][name])
        }),
        Value::Array(items) => items
            .iter()
            .enumerate()
            .try_for_each(|(i, item)| check(&format!("{key}[{i}]"), item, &schema["items"])),
        Value::Number(number) => {
            let number = number.as_f64().unwrap_or(f64::NAN);
            let range = Range::of(schema);
            if range.holds(number) {
                return Ok(());
            }
            Err(InvalidInput::new(key, shown(number), range.words()))
        }
        // JSON has no other numbers than finite ones; where a key may be left out, this is that.
        Value::Null if schema["type"].is_string() => {
            Err(InvalidInput::new(key, "NaN or infinity", Range::of(schema).words()))
        }
        _ => Ok(()),
    }
}

/// What a number may be.
pub(super) struct Range {
    least: Option<f64>,
    /// The number has to be above this.
    above: Option<f64>,
    most: Option<f64>,
}

impl Range {
    /// As a key's schema states it.
    pub fn of(schema: &Value) -> Self {
        let above = schema["exclusiveMinimum"].as_f64();
        let least = schema["minimum"].as_f64().filter(|_| above.is_none());
        Self { least, above, most: schema["maximum"].as_f64() }
    }

    fn holds(&self, number: f64) -> bool {
        self.least.is_none_or(|least| number >= least)
            && self.above.is_none_or(|above| number > above)
            && self.most.is_none_or(|most| number <= most)
    }

    /// Such as `a number from 1 to 4096`.
    pub fn words(&self) -> String {
        match (self.least, self.above, self.most) {
            (Some(least), _, Some(most)) => format!("a number from {least} to {most}"),
            (_, Some(above), Some(most)) => format!("a number above {above} and up to {most}"),
            (Some(least), _, None) => format!("a number of at least {least}"),
            _ => "a number".into(),
        }
    }
}

/// A number as it was written: in single precision where that is what it is.
pub(super) fn shown(number: f64) -> String {
    let single = number as f32;
    if f64::from(single) == number { single.to_string() } else { number.to_string() }
}
