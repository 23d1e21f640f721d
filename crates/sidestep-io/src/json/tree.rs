//! A JSON document as a tree, with numbers as f64 and with doubled keys refused.
//!
//! `serde_json` parses (RFC 8259: no NaN, no infinity, and a number beyond f64 is an error); its own
//! `Value` would silently keep the last of two equal keys.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use crate::error::{FormatError, Place, quoted};

/// A JSON value; an object keeps the order of its keys.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Json {
    Null,
    Bool(bool),
    Number(f64),
    String(String),
    Array(Vec<Json>),
    Object(Vec<(String, Json)>),
}

impl Json {
    /// What this is, for a message: small values in full, large ones by kind and size.
    pub(crate) fn describe(&self) -> String {
        match self {
            Self::Null => "null".into(),
            Self::Bool(value) => value.to_string(),
            Self::Number(value) => value.to_string(),
            Self::String(text) => quoted(text),
            Self::Array(items) if items.is_empty() => "an empty array".into(),
            Self::Array(items) => format!("an array of {}", items.len()),
            Self::Object(fields) if fields.is_empty() => "an empty object".into(),
            Self::Object(_) => "an object".into(),
        }
    }
}

/// Parses one document; a syntax error carries its line and column, counted from `first_line`.
pub(crate) fn parse(
    format: &'static str,
    text: &str,
    first_line: usize,
) -> Result<Json, FormatError> {
    serde_json::from_str(text).map_err(|error| {
        let line = first_line + error.line().saturating_sub(1);
        let place = Place::line(line).with_column(error.column().max(1));
        let text = error.to_string();
        // The message ends in " at line L column C", which the place says already.
        let message = text.rsplit_once(" at line ").map_or(text.as_str(), |(head, _)| head);
        let expected = match message {
            "number out of range" => "a number of magnitude at most 1e9",
            doubled if doubled.starts_with("the key ") => "each key once",
            _ => "valid JSON (no NaN, Infinity, comments or trailing commas)",
        };
        let found = match message.strip_prefix("expected ") {
            Some("value") => "what is not a value".into(),
            Some(rest) => format!("something other than {rest}"),
            None => message.to_string(),
        };
        FormatError::new(format, place, found, expected)
    })
}

impl<'de> Deserialize<'de> for Json {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TreeVisitor)
    }
}

struct TreeVisitor;

impl<'de> Visitor<'de> for TreeVisitor {
    type Value = Json;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Json, E> {
        Ok(Json::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Json, E> {
        Ok(Json::Bool(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Json, E> {
        Ok(Json::Number(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Json, E> {
        Ok(Json::Number(value as f64))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Json, E> {
        Ok(Json::Number(value))
    }

    fn visit_str<E>(self, value: &str) -> Result<Json, E> {
        Ok(Json::String(value.to_owned()))
    }

    fn visit_string<E>(self, value: String) -> Result<Json, E> {
        Ok(Json::String(value))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Json, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = access.next_element()? {
            items.push(item);
        }
        Ok(Json::Array(items))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Json, A::Error> {
        let mut fields: Vec<(String, Json)> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        while let Some((key, value)) = access.next_entry::<String, Json>()? {
            if !seen.insert(key.clone()) {
                return Err(A::Error::custom(format!("the key {} twice", quoted(&key))));
            }
            fields.push((key, value));
        }
        Ok(Json::Object(fields))
    }
}
