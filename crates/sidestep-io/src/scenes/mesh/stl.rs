//! STL: 80 bytes of anything, a count and 50 bytes a triangle (normal, three corners, two bytes),
//! all little-endian; or text of `facet normal`, `outer loop`, three `vertex x y z`, `endloop`,
//! `endfacet`.
//!
//! Many binary files begin with `solid` as texts do, so what decides is whether the length fits the
//! count.

use super::Triangles;
use crate::error::{FormatError, Place, quoted};

const FORMAT: &str = "STL mesh";

pub(super) fn read(bytes: &[u8]) -> Result<Triangles, FormatError> {
    if let Some((head, body)) = bytes.split_at_checked(84) {
        let count = u32::from_le_bytes([head[80], head[81], head[82], head[83]]);
        if body.len() as u64 == 50 * u64::from(count) {
            return Ok(binary(body));
        }
        if !bytes.starts_with(b"solid") || std::str::from_utf8(bytes).is_err() {
            let found = format!("{} bytes for {count} triangles", bytes.len());
            let expected = format!("{} bytes", 84 + 50 * u64::from(count));
            return Err(FormatError::new(FORMAT, Place::default(), found, expected));
        }
    }
    text(super::super::tree::text(FORMAT, bytes)?)
}

fn binary(body: &[u8]) -> Triangles {
    let mut found = Triangles::default();
    for triangle in body.as_chunks::<50>().0 {
        let numbers = triangle[12..48].as_chunks::<4>().0;
        let number = |i: usize| f64::from(f32::from_le_bytes(numbers[i]));
        let first = found.vertices.len() as u32;
        found.vertices.extend([0, 3, 6].map(|i| [number(i), number(i + 1), number(i + 2)]));
        found.triangles.push([first, first + 1, first + 2]);
    }
    found
}

fn text(text: &str) -> Result<Triangles, FormatError> {
    let wrong = |line: usize, found: String, expected: &str| {
        FormatError::new(FORMAT, Place::line(line), found, expected)
    };
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    match lines.next() {
        Some((_, line)) if line.starts_with("solid") => {}
        Some((_, line)) => return Err(wrong(1, quoted(line), "solid, or a binary STL")),
        None => return Err(wrong(1, "nothing".into(), "solid, or a binary STL")),
    }
    let mut found = Triangles::default();
    let mut corners = 0;
    for (number, line) in lines {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vertex") => {
                let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
                let vertex = numbers
                    .and_then(|v| v.try_into().ok())
                    .ok_or_else(|| wrong(number, quoted(line), "vertex and three numbers"))?;
                found.vertices.push(vertex);
                corners += 1;
            }
            Some("endfacet") if corners == 3 => {
                let end = found.vertices.len() as u32;
                found.triangles.push([end - 3, end - 2, end - 1]);
                corners = 0;
            }
            Some("endfacet") => {
                let found = format!("a facet with {corners} corners");
                return Err(wrong(number, found, "three"));
            }
            None | Some("facet" | "outer" | "endloop" | "endsolid" | "solid") => {}
            Some(_) => return Err(wrong(number, quoted(line), "a line of an STL text")),
        }
    }
    if corners > 0 {
        let line = text.lines().count();
        return Err(wrong(line, "the end within a facet".into(), "endfacet"));
    }
    Ok(found)
}
