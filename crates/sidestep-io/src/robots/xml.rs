//! XML for readers that must say where a fault lies: elements that know their line, and attributes as numbers.
//!
//! Documents with a DTD are refused, so no entity can grow; elements nest at most [`DEEPEST`] deep.

use roxmltree::{Document, Node, ParsingOptions};

use crate::error::{FormatError, Place, plain_or_quoted, quoted};

/// Most nodes of a document; a robot of 10,000 links has about 300,000.
const MOST_NODES: u32 = 4_000_000;
/// Deepest nesting: a robot's file needs six, and a parser's stack must not overflow.
const DEEPEST: usize = 64;

/// Parses a text whose root element must be `root`.
pub(super) fn parse<'a>(
    format: &'static str,
    text: &'a str,
    root: &str,
) -> Result<Document<'a>, FormatError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    refuse_depth(format, text)?;
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let at = error.pos();
        let place = Place::line(at.row as usize).with_column(at.col as usize);
        // The message repeats the place at its end.
        let message = error.to_string();
        let message = message.rsplit_once(" at ").map_or(message.as_str(), |(before, _)| before);
        FormatError::new(format, place, message, "XML without a DTD")
    })?;
    let element = document.root_element();
    if element.tag_name().name() != root {
        let found = format!("<{}>", plain_or_quoted(element.tag_name().name()));
        let element = Element { format, node: element };
        return Err(element.wrong(found, format!("<{root}> around everything")));
    }
    Ok(document)
}

/// Refuses texts that nest too deep, before anything walks them: counts tags without understanding more.
fn refuse_depth(format: &'static str, text: &str) -> Result<(), FormatError> {
    let bytes = text.as_bytes();
    let (mut depth, mut at) = (0_usize, 0);
    while let Some(next) = bytes[at..].iter().position(|&byte| byte == b'<') {
        at += next + 1;
        let rest = &text[at..];
        let skipped = [("!--", "-->"), ("![CDATA[", "]]>"), ("?", "?>")];
        if let Some((_, end)) = skipped.iter().find(|(start, _)| rest.starts_with(start)) {
            at += rest.find(end).unwrap_or(rest.len());
            continue;
        }
        let Some(end) = rest.find('>') else { break };
        let tag = &rest[..end];
        if tag.starts_with('/') {
            depth = depth.saturating_sub(1);
        } else if !tag.ends_with('/') && !tag.starts_with('!') {
            depth += 1;
        }
        if depth > DEEPEST {
            let line = 1 + text[..at].matches('\n').count();
            let found = format!("more than {DEEPEST} elements inside each other");
            return Err(FormatError::new(format, Place::line(line), found, "fewer"));
        }
        at += end;
    }
    Ok(())
}

/// An element and the format that it is part of.
#[derive(Clone, Copy)]
pub(super) struct Element<'a> {
    pub(super) format: &'static str,
    pub(super) node: Node<'a, 'a>,
}

impl<'a> Element<'a> {
    pub(super) fn root(format: &'static str, document: &'a Document<'a>) -> Self {
        Self { format, node: document.root_element() }
    }

    /// The element's name.
    pub(super) fn name(&self) -> &'a str {
        self.node.tag_name().name()
    }

    /// All children that are elements.
    pub(super) fn children(&self) -> impl Iterator<Item = Self> + use<'a> {
        let format = self.format;
        self.node.children().filter(Node::is_element).map(move |node| Self { format, node })
    }

    /// The children of a name.
    pub(super) fn all(&self, name: &'a str) -> impl Iterator<Item = Self> + use<'a> {
        self.children().filter(move |child| child.name() == name)
    }

    /// The first child of a name.
    pub(super) fn child(&self, name: &'a str) -> Option<Self> {
        self.all(name).next()
    }

    /// The child of a name that must be there.
    pub(super) fn required(&self, name: &'a str) -> Result<Self, FormatError> {
        self.child(name)
            .ok_or_else(|| self.wrong(format!("no <{name}>"), format!("<{name}> in it")))
    }

    /// An attribute's text.
    pub(super) fn text(&self, attribute: &str) -> Option<&'a str> {
        self.node.attribute(attribute).map(str::trim)
    }

    /// The text of an attribute that must be there and not empty.
    pub(super) fn required_text(&self, attribute: &str) -> Result<&'a str, FormatError> {
        match self.text(attribute) {
            Some(text) if !text.is_empty() => Ok(text),
            Some(_) => Err(self.wrong_at(attribute, "nothing", "a text")),
            None => Err(self.wrong(format!("no {attribute}"), format!("{attribute}=\"...\""))),
        }
    }

    /// Numbers separated by spaces; the numbers of `otherwise` if the attribute is not there.
    pub(super) fn numbers<const N: usize>(
        &self,
        attribute: &str,
        otherwise: [f64; N],
    ) -> Result<[f64; N], FormatError> {
        let Some(text) = self.text(attribute) else { return Ok(otherwise) };
        let mut numbers = [0.0; N];
        let mut count = 0;
        for word in text.split_ascii_whitespace() {
            if count < N {
                numbers[count] = word.parse().unwrap_or(f64::NAN);
            }
            count += 1;
        }
        if count == N && numbers.iter().all(|number| number.is_finite()) {
            return Ok(numbers);
        }
        let plural = if N == 1 { "" } else { "s" };
        Err(self.wrong_at(attribute, quoted(text), format!("{N} finite number{plural}")))
    }

    /// One number, if the attribute is there.
    pub(super) fn number(&self, attribute: &str) -> Result<Option<f64>, FormatError> {
        if self.text(attribute).is_none() {
            return Ok(None);
        }
        self.numbers(attribute, [0.0]).map(|[number]| Some(number))
    }

    /// One number of an attribute that must be there.
    pub(super) fn required_number(&self, attribute: &str) -> Result<f64, FormatError> {
        self.required_text(attribute)?;
        self.numbers(attribute, [0.0]).map(|[number]| number)
    }

    /// The line on which the element begins, from 1.
    pub(super) fn line(&self) -> usize {
        self.node.document().text_pos_at(self.node.range().start).row as usize
    }

    /// A fault of the element as a whole.
    pub(super) fn wrong(
        &self,
        found: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> FormatError {
        let place = Place::line(self.line()).with_field(self.path());
        FormatError::new(self.format, place, found, expected)
    }

    /// A fault of one attribute.
    pub(super) fn wrong_at(
        &self,
        attribute: &str,
        found: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> FormatError {
        let place = Place::line(self.line()).with_field(format!("{} {attribute}", self.path()));
        FormatError::new(self.format, place, found, expected)
    }

    /// The elements that lead to this one, named where they have names: `joint "elbow" limit`.
    fn path(&self) -> String {
        let mut words = Vec::new();
        for node in self.node.ancestors().filter(Node::is_element) {
            if node.parent_element().is_none() && !words.is_empty() {
                break;
            }
            let name =
                node.attribute("name").map_or(String::new(), |name| format!(" {}", quoted(name)));
            words.push(format!("{}{name}", plain_or_quoted(node.tag_name().name())));
        }
        words.reverse();
        words.join(" ")
    }
}
