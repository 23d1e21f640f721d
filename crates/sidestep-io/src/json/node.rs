//! A cursor on a JSON tree that knows its path, so that every error names its field.

use sidestep::InvalidInput;
use sidestep::plane::geometry::Point;

use super::{Json, locate};
use crate::error::{FormatError, Place, nearest, plain_or_quoted, quoted};

/// One step down the tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

/// A value and the way to it from the root.
#[derive(Clone, Copy)]
pub(crate) struct Node<'a> {
    value: &'a Json,
    parent: Option<(&'a Node<'a>, Step<'a>)>,
    source: Source<'a>,
}

/// The text that a tree was parsed from.
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    /// The format's name, for errors.
    pub(crate) format: &'static str,
    /// The whole text.
    pub(crate) text: &'a str,
    /// The number of its first line in the file.
    pub(crate) first_line: usize,
}

impl<'a> Node<'a> {
    /// The root of a document.
    pub(crate) fn root(source: Source<'a>, value: &'a Json) -> Self {
        Self { value, parent: None, source }
    }

    fn child(&'a self, step: Step<'a>, value: &'a Json) -> Self {
        Self { value, parent: Some((self, step)), source: self.source }
    }

    /// The value itself.
    pub(crate) fn value(&self) -> &'a Json {
        self.value
    }

    /// The steps from the root to here.
    pub(crate) fn steps(&self) -> Vec<Step<'a>> {
        let mut steps = Vec::new();
        let mut node = *self;
        while let Some((parent, step)) = node.parent {
            steps.push(step);
            node = *parent;
        }
        steps.reverse();
        steps
    }

    /// This value is not what is expected here.
    pub(crate) fn wrong(&self, expected: impl Into<String>) -> FormatError {
        self.found(self.value.describe(), expected)
    }

    /// `found` is not what is expected here.
    pub(crate) fn found(
        &self,
        found: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> FormatError {
        self.found_at(&self.steps(), found, expected)
    }

    fn found_at(
        &self,
        steps: &[Step<'_>],
        found: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> FormatError {
        let Source { format, text, first_line } = self.source;
        let place = match locate(text, steps) {
            Some((line, column)) => Place::line(line + first_line - 1).with_column(column),
            None => Place::default(),
        };
        FormatError::new(format, place.with_field(path_of(steps)), found, expected)
    }

    /// A refusal of the core, whose field `below` this value is given as a path such as `.radius` or
    /// `.goal[1]`; the position is that of the deepest part of it that the text has.
    pub(crate) fn refused(&self, below: &str, invalid: InvalidInput) -> FormatError {
        let mut steps = self.steps();
        let known = steps.len();
        steps.extend(steps_of(below));
        let mut deepest = steps.len();
        while deepest > known && locate(self.source.text, &steps[..deepest]).is_none() {
            deepest -= 1;
        }
        let mut error = self.found_at(&steps[..deepest], invalid.value, invalid.allowed);
        error.place.path = path_of(&steps);
        error
    }

    /// The items of an array.
    pub(crate) fn items(
        &'a self,
        expected: &str,
    ) -> Result<impl ExactSizeIterator<Item = Node<'a>> + 'a, FormatError> {
        match self.value {
            Json::Array(items) => {
                Ok(items.iter().enumerate().map(|(i, item)| self.child(Step::Index(i), item)))
            }
            _ => Err(self.wrong(expected)),
        }
    }

    /// The fields of an object, in the file's order.
    pub(crate) fn fields(
        &'a self,
        expected: &str,
    ) -> Result<impl ExactSizeIterator<Item = (&'a str, Node<'a>)> + 'a, FormatError> {
        match self.value {
            Json::Object(fields) => Ok(fields
                .iter()
                .map(|(key, value)| (key.as_str(), self.child(Step::Key(key), value)))),
            _ => Err(self.wrong(expected)),
        }
    }

    /// Checks that this is an object whose keys are all among `known`.
    pub(crate) fn object(&self, known: &[&str]) -> Result<(), FormatError> {
        let names = known.join(", ");
        let Json::Object(fields) = self.value else {
            return Err(self.wrong(format!("an object with the fields {names}")));
        };
        for (key, value) in fields {
            if !known.contains(&key.as_str()) {
                let found = format!("the unknown field {}", quoted(key));
                let expected = match nearest(key, known) {
                    Some(near) => format!("one of {names} (did you mean {near:?}?)"),
                    None => format!("one of {names}"),
                };
                let field = Node { value, parent: Some((self, Step::Key(key))), ..*self };
                return Err(field.found(found, expected));
            }
        }
        Ok(())
    }

    /// The only field of an object such as `{"circle": ...}`, as its name and value.
    pub(crate) fn only_field(&'a self, known: &[&str]) -> Result<(&'a str, Node<'a>), FormatError> {
        self.object(known)?;
        match self.value {
            Json::Object(fields) if fields.len() == 1 => {
                let (key, value) = &fields[0];
                Ok((key, self.child(Step::Key(key), value)))
            }
            Json::Object(fields) => {
                let found = format!("an object with {} fields", fields.len());
                Err(self.found(found, format!("exactly one of {}", known.join(", "))))
            }
            _ => Err(self.wrong("an object")),
        }
    }

    /// A field that may be missing.
    pub(crate) fn optional(&'a self, key: &'a str) -> Option<Node<'a>> {
        match self.value {
            Json::Object(fields) => fields
                .iter()
                .find(|(name, _)| name == key)
                .map(|(_, value)| self.child(Step::Key(key), value)),
            _ => None,
        }
    }

    /// A field that must be there.
    pub(crate) fn required(&'a self, key: &'a str, what: &str) -> Result<Node<'a>, FormatError> {
        self.optional(key)
            .ok_or_else(|| self.found(format!("no field {key:?}"), format!("{key:?}: {what}")))
    }

    /// A string.
    pub(crate) fn string(&self) -> Result<&'a str, FormatError> {
        match self.value {
            Json::String(text) => Ok(text),
            _ => Err(self.wrong("a string")),
        }
    }

    /// A number.
    pub(crate) fn number(&self) -> Result<f64, FormatError> {
        match self.value {
            Json::Number(value) => Ok(*value),
            _ => Err(self.wrong("a number")),
        }
    }

    /// A point `[x, y]`.
    pub(crate) fn point(&'a self) -> Result<Point, FormatError> {
        let [x, y] = self.pair("a point [x, y]")?;
        Ok([x.number()?, y.number()?])
    }

    /// An array of exactly two values.
    pub(crate) fn pair(&'a self, expected: &str) -> Result<[Node<'a>; 2], FormatError> {
        let mut items = self.items(expected)?;
        match (items.next(), items.next(), items.next()) {
            (Some(first), Some(second), None) => Ok([first, second]),
            _ => Err(self.wrong(expected)),
        }
    }
}

/// The steps of a path such as `.goal[1]`.
fn steps_of(path: &str) -> impl Iterator<Item = Step<'_>> {
    path.split(['.', '[']).filter(|part| !part.is_empty()).map(|part| {
        match part.strip_suffix(']').and_then(|index| index.parse().ok()) {
            Some(index) => Step::Index(index),
            None => Step::Key(part),
        }
    })
}

/// Steps as a person writes them, `obstacles[3].circle`; long or odd keys are quoted and cut.
fn path_of(steps: &[Step<'_>]) -> String {
    let mut path = String::new();
    for step in steps {
        match step {
            Step::Key(key) => {
                if !path.is_empty() {
                    path.push('.');
                }
                path += &plain_or_quoted(key);
            }
            Step::Index(index) => path.push_str(&format!("[{index}]")),
        }
    }
    path
}
