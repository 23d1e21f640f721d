//! JSON and YAML as one kind of tree, and the values that scenes are made of: vectors and poses.

use sidestep::InvalidInput;
use sidestep::space::{Pose, Vector};

use crate::error::{FormatError, Place, quoted};
use crate::json::{Json, Node, Source};

/// The text of a file, without the mark that some editors put before it.
pub(super) fn text<'a>(format: &'static str, bytes: &'a [u8]) -> Result<&'a str, FormatError> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let before = &bytes[..error.valid_up_to()];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        FormatError::new(format, Place::line(line), "bytes that are no text", "UTF-8")
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// A YAML text as a tree. Aliases are expanded within the parser's budget, so that a short text
/// cannot become a large tree.
pub(super) fn yaml(format: &'static str, text: &str) -> Result<Json, FormatError> {
    let options = serde_saphyr::options! { with_snippet: false };
    serde_saphyr::from_str_with_options(text, options).map_err(|error| {
        let place = match error.location() {
            Some(at) => Place::line(at.line() as usize).with_column(at.column() as usize),
            None => Place::default(),
        };
        let message = error.to_string();
        let message = message.split(" at line ").next().unwrap_or(&message);
        let message = message.split(", set ").next().unwrap_or(message);
        FormatError::new(format, place, format!("a fault ({message})"), "YAML")
    })
}

/// The root of a tree; of YAML, errors name the field but not the line.
pub(super) fn root<'a>(format: &'static str, text: &'a str, json: &'a Json) -> Node<'a> {
    Node::root(Source { format, text, first_line: 1 }, json)
}

/// Exactly `N` numbers.
pub(super) fn numbers<const N: usize>(
    node: &Node<'_>,
    expected: &str,
) -> Result<[f64; N], FormatError> {
    let items: Vec<f64> = all_numbers(node, expected)?;
    items
        .try_into()
        .map_err(|items: Vec<f64>| node.found(format!("{} numbers", items.len()), expected))
}

/// Any number of numbers.
pub(super) fn all_numbers(node: &Node<'_>, expected: &str) -> Result<Vec<f64>, FormatError> {
    node.items(expected)?.map(|item| item.number()).collect()
}

/// Three numbers as a list, or as `{x: , y: , z: }`.
pub(super) fn vector(node: &Node<'_>) -> Result<Vector, FormatError> {
    const EXPECTED: &str = "three numbers [x, y, z]";
    if !matches!(node.value(), Json::Object(_)) {
        return numbers(node, EXPECTED);
    }
    node.object(&["x", "y", "z"])?;
    let mut v = [0.0; 3];
    for (v, key) in v.iter_mut().zip(["x", "y", "z"]) {
        *v = node.required(key, "a number")?.number()?;
    }
    Ok(v)
}

/// Four numbers as a list in the order x, y, z, w, or as `{x: , y: , z: , w: }`.
pub(super) fn xyzw(node: &Node<'_>) -> Result<[f64; 4], FormatError> {
    if !matches!(node.value(), Json::Object(_)) {
        return numbers(node, "a unit quaternion [x, y, z, w]");
    }
    node.object(&["x", "y", "z", "w"])?;
    let mut q = [0.0; 4];
    for (q, key) in q.iter_mut().zip(["x", "y", "z", "w"]) {
        *q = node.required(key, "a number")?.number()?;
    }
    Ok(q)
}

/// ROS's pose: `{position: , orientation: }`, the orientation as xyzw and the identity if it is
/// missing.
pub(super) fn ros_pose(node: &Node<'_>) -> Result<Pose, FormatError> {
    node.object(&["position", "orientation"])?;
    let position = match node.optional("position") {
        Some(position) => vector(&position)?,
        None => [0.0; 3],
    };
    let orientation = match node.optional("orientation") {
        Some(orientation) => xyzw(&orientation)?,
        None => [0.0, 0.0, 0.0, 1.0],
    };
    Pose::from_xyzw(orientation, position).map_err(|invalid| {
        let invalid = renamed(invalid, "quaternion", "orientation");
        below(node, invalid)
    })
}

/// cuRobo's pose: `[x, y, z, qw, qx, qy, qz]`.
pub(super) fn flat_pose(node: &Node<'_>) -> Result<Pose, FormatError> {
    let [x, y, z, w, a, b, c] = numbers(node, "seven numbers [x, y, z, qw, qx, qy, qz]")?;
    Pose::from_wxyz([w, a, b, c], [x, y, z]).map_err(|invalid| node.refused("", invalid))
}

/// A text, or a number that somebody uses as a name.
pub(super) fn name(node: &Node<'_>) -> Result<String, FormatError> {
    match node.value() {
        Json::String(text) => Ok(text.clone()),
        Json::Number(number) => Ok(number.to_string()),
        _ => Err(node.wrong("a name")),
    }
}

/// The fields of an object whose keys are names.
pub(super) fn fields<'a>(node: &'a Node<'a>) -> Result<Vec<(&'a str, Node<'a>)>, FormatError> {
    match node.value() {
        Json::Object(fields) => Ok(fields
            .iter()
            .filter_map(|(key, _)| node.optional(key).map(|value| (key.as_str(), value)))
            .collect()),
        _ => Err(node.wrong("an object of names")),
    }
}

/// A refusal of the core about a field of this object.
pub(super) fn below(node: &Node<'_>, invalid: InvalidInput) -> FormatError {
    let field = format!(".{}", invalid.field);
    node.refused(&field, invalid)
}

/// The same refusal, with the field called as this format calls it.
pub(super) fn renamed(mut invalid: InvalidInput, from: &str, to: &str) -> InvalidInput {
    invalid.field = invalid.field.replacen(from, to, 1);
    invalid
}

/// The bytes of a file that this field names.
pub(super) fn load(node: &Node<'_>, load: super::Load<'_>) -> Result<Vec<u8>, FormatError> {
    let name = node.string()?;
    load(name).map_err(|error| {
        node.found(format!("{}, which cannot be read ({error})", quoted(name)), "a readable file")
    })
}
