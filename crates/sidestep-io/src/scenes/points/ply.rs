//! PLY: the corners of its `vertex` element, as text or bytes in either order.
//!
//! Source: G. Turk, "The PLY Polygon File Format", 1994. Elements are read in the header's order up
//! to the vertices, so one with lists that stands before them is refused.

use sidestep::space::Vector;

use super::{Number, finite};
use crate::error::{FormatError, Place, quoted};

const FORMAT: &str = "PLY points";

#[derive(Clone, Copy, PartialEq)]
enum Order {
    Text,
    LittleEndian,
    BigEndian,
}

struct Element {
    name: String,
    count: usize,
    /// Names and numbers; nothing for a list.
    properties: Vec<(String, Option<Number>)>,
}

/// The finite corners of a PLY file.
///
/// # Errors
/// If the header is not one, has no vertices with x, y and z, or there are fewer than it says.
pub fn read_ply(bytes: &[u8]) -> Result<Vec<Vector>, FormatError> {
    let (order, elements, body, first_line) = read_header(bytes)?;
    let mut before = Vec::new();
    for element in elements {
        if element.name != "vertex" {
            before.push(element);
            continue;
        }
        let mut axes = [0; 3];
        for (axis, name) in axes.iter_mut().zip(["x", "y", "z"]) {
            let found = element.properties.iter().position(|(property, _)| property == name);
            *axis = found.ok_or_else(|| wrong(format!("a vertex without {name}"), "x, y, z"))?;
        }
        let points = match order {
            Order::Text => {
                let skipped: usize = before.iter().map(|element| element.count).sum();
                read_text(&element, axes, body, first_line, skipped)?
            }
            _ => {
                let skipped = before.iter().map(size).try_fold(0, |sum: usize, (count, size)| {
                    sum.checked_add(count.checked_mul(size?)?)
                });
                let body = skipped.and_then(|skipped| body.get(skipped..));
                let body =
                    body.ok_or_else(|| wrong("lists before the vertices", "vertices first"))?;
                read_bytes(&element, axes, body, order == Order::BigEndian)?
            }
        };
        return Ok(finite(points));
    }
    Err(wrong("no element vertex", "one"))
}

fn wrong(found: impl std::fmt::Display, expected: &str) -> FormatError {
    FormatError::new(FORMAT, Place::default(), found, expected)
}

/// How many there are, and bytes of one; nothing if it has a list.
fn size(element: &Element) -> (usize, Option<usize>) {
    let sizes = element.properties.iter().map(|(_, number)| number.map(Number::size));
    (element.count, sizes.sum::<Option<usize>>())
}

type Header<'a> = (Order, Vec<Element>, &'a [u8], usize);

fn read_header(bytes: &[u8]) -> Result<Header<'_>, FormatError> {
    let mut order = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut rest = bytes;
    for number in 1.. {
        let Some(end) = rest.iter().position(|&byte| byte == b'\n') else { break };
        let line = std::str::from_utf8(&rest[..end]).unwrap_or("\u{fffd}").trim();
        rest = &rest[end + 1..];
        let words: Vec<&str> = line.split_whitespace().collect();
        let fault =
            |expected: &str| FormatError::new(FORMAT, Place::line(number), quoted(line), expected);
        if number == 1 {
            if line != "ply" {
                return Err(fault("ply"));
            }
            continue;
        }
        match words[..] {
            ["format", "ascii", _] => order = Some(Order::Text),
            ["format", "binary_little_endian", _] => order = Some(Order::LittleEndian),
            ["format", "binary_big_endian", _] => order = Some(Order::BigEndian),
            ["element", name, count] => {
                let count = count.parse().map_err(|_| fault("a whole number"))?;
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", "list", _, _, name] => {
                let element = elements.last_mut().ok_or_else(|| fault("an element before it"))?;
                element.properties.push((name.to_owned(), None));
            }
            ["property", kind, name] => {
                let number = number_of(kind).ok_or_else(|| fault("a type of number"))?;
                let element = elements.last_mut().ok_or_else(|| fault("an element before it"))?;
                element.properties.push((name.to_owned(), Some(number)));
            }
            ["end_header"] => {
                let order = order.ok_or_else(|| fault("a line format before it"))?;
                return Ok((order, elements, rest, number + 1));
            }
            [] | ["comment", ..] | ["obj_info", ..] => {}
            _ => return Err(fault("a line of a PLY header")),
        }
    }
    Err(wrong("a header without its end", "end_header"))
}

fn number_of(kind: &str) -> Option<Number> {
    Some(match kind {
        "char" | "int8" => Number::Signed(1),
        "uchar" | "uint8" => Number::Unsigned(1),
        "short" | "int16" => Number::Signed(2),
        "ushort" | "uint16" => Number::Unsigned(2),
        "int" | "int32" => Number::Signed(4),
        "uint" | "uint32" => Number::Unsigned(4),
        "float" | "float32" => Number::Float(4),
        "double" | "float64" => Number::Float(8),
        _ => return None,
    })
}

fn read_text(
    element: &Element,
    axes: [usize; 3],
    body: &[u8],
    first_line: usize,
    skipped: usize,
) -> Result<Vec<Vector>, FormatError> {
    if element.properties[..axes.into_iter().max().unwrap_or(0)].iter().any(|(_, n)| n.is_none()) {
        return Err(wrong("a list before x, y and z", "x, y and z first"));
    }
    let text = super::super::tree::text(FORMAT, body)?;
    let mut points = Vec::new();
    for (i, line) in text.lines().enumerate().skip(skipped).take(element.count) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |k: usize| words.get(axes[k]).and_then(|word| word.parse().ok());
        match (number(0), number(1), number(2)) {
            (Some(x), Some(y), Some(z)) => points.push([x, y, z]),
            _ => {
                let place = Place::line(first_line + i);
                return Err(FormatError::new(FORMAT, place, quoted(line), "a number a property"));
            }
        }
    }
    too_few(element, points.len())?;
    Ok(points)
}

fn read_bytes(
    element: &Element,
    axes: [usize; 3],
    body: &[u8],
    big_endian: bool,
) -> Result<Vec<Vector>, FormatError> {
    let (count, Some(size)) = size(element) else {
        return Err(wrong("a list within the vertices", "numbers alone"));
    };
    too_few(element, body.len() / size)?;
    let mut points = Vec::with_capacity(count);
    for bytes in body.chunks_exact(size).take(count) {
        points.push(axes.map(|axis| {
            let sizes = element.properties[..axis].iter().filter_map(|(_, number)| *number);
            let at: usize = sizes.map(Number::size).sum();
            let Some(number) = element.properties[axis].1 else { return f64::NAN };
            let mut wide = [0; 8];
            let wide = &mut wide[..number.size()];
            wide.copy_from_slice(&bytes[at..at + number.size()]);
            if big_endian {
                wide.reverse();
            }
            number.value(wide)
        }));
    }
    Ok(points)
}

fn too_few(element: &Element, found: usize) -> Result<(), FormatError> {
    if found < element.count {
        let expected = format!("{}, as the header says", element.count);
        return Err(wrong(format!("{found} vertices"), &expected));
    }
    Ok(())
}
