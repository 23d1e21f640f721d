//! PCD, the Point Cloud Library's files, versions 0.6 and 0.7: a header of words, then numbers as
//! text, as bytes point by point, or packed by LZF field by field.
//!
//! Source: the PCL's documentation of the format. Of the fields only x, y and z are read; the
//! viewpoint is passed over, as points stand in the file's own frame.

use sidestep::space::Vector;

use super::{Number, finite, lzf};
use crate::error::{FormatError, Place, quoted};

const FORMAT: &str = "PCD points";

/// How the numbers stand behind the header.
#[derive(Clone, Copy, PartialEq)]
enum Data {
    Text,
    Bytes,
    Packed,
}

/// A field of each point.
struct Field {
    name: String,
    number: Number,
    count: usize,
}

struct Header {
    fields: Vec<Field>,
    points: usize,
    data: Data,
}

/// The finite points of a PCD file.
///
/// # Errors
/// If the header lacks something or says what the data is not; with its line.
pub fn read_pcd(bytes: &[u8]) -> Result<Vec<Vector>, FormatError> {
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let (header, body, line) = read_header(bytes)?;
    let mut axes = [0; 3];
    for (axis, name) in axes.iter_mut().zip(["x", "y", "z"]) {
        let found = header.fields.iter().position(|field| field.name == name && field.count == 1);
        *axis = found.ok_or_else(|| wrong("FIELDS", format!("no {name}"), "x, y and z"))?;
    }
    let points = match header.data {
        Data::Text => read_text(&header, axes, body, line)?,
        Data::Bytes => read_bytes(&header, axes, body)?,
        Data::Packed => read_packed(&header, axes, body)?,
    };
    Ok(finite(points))
}

fn wrong(field: &str, found: impl std::fmt::Display, expected: impl Into<String>) -> FormatError {
    FormatError::new(FORMAT, Place::field(field), found, expected)
}

/// The header, what stands behind it, and the number of that line.
fn read_header(bytes: &[u8]) -> Result<(Header, &[u8], usize), FormatError> {
    let (mut names, mut sizes, mut types, mut counts) = (vec![], vec![], vec![], vec![]);
    let (mut width, mut height, mut points) = (None, 1, None);
    let mut rest = bytes;
    for number in 1.. {
        let end = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        let line = std::str::from_utf8(&rest[..end]).unwrap_or("\u{fffd}").trim();
        let at_end = end == rest.len();
        rest = rest.get(end + 1..).unwrap_or_default();
        let fault =
            |expected: &str| FormatError::new(FORMAT, Place::line(number), quoted(line), expected);
        let mut words = line.split_whitespace();
        let key = words.next().unwrap_or_default();
        let words: Vec<&str> = words.collect();
        let whole = |text: &str| text.parse::<usize>().map_err(|_| fault("whole numbers"));
        let one = || match words[..] {
            [word] => whole(word),
            _ => Err(fault("one whole number")),
        };
        match key {
            "FIELDS" | "COLUMNS" => names = words.iter().map(|&word| word.to_owned()).collect(),
            "SIZE" => sizes = words.iter().map(|word| whole(word)).collect::<Result<_, _>>()?,
            "TYPE" => types = words.iter().map(|&word| word.to_owned()).collect(),
            "COUNT" => counts = words.iter().map(|word| whole(word)).collect::<Result<_, _>>()?,
            "WIDTH" => width = Some(one()?),
            "HEIGHT" => height = one()?,
            "POINTS" => points = Some(one()?),
            "DATA" => {
                let data = match words[..] {
                    ["ascii"] => Data::Text,
                    ["binary"] => Data::Bytes,
                    ["binary_compressed"] => Data::Packed,
                    _ => return Err(fault("DATA ascii, binary or binary_compressed")),
                };
                let fields = fields(names, &sizes, &types, &counts)?;
                let whole = width.and_then(|width: usize| width.checked_mul(height));
                let points = points.or(whole).ok_or_else(|| {
                    wrong("POINTS", "no number of points", "POINTS, or WIDTH and HEIGHT")
                })?;
                return Ok((Header { fields, points, data }, rest, number + 1));
            }
            "" if at_end => break,
            "" | "VERSION" | "VIEWPOINT" => {}
            comment if comment.starts_with('#') => {}
            _ => return Err(fault("a line of a PCD header")),
        }
    }
    Err(wrong("DATA", "the end of the file", "a header that ends with DATA"))
}

fn fields(
    names: Vec<String>,
    sizes: &[usize],
    types: &[String],
    counts: &[usize],
) -> Result<Vec<Field>, FormatError> {
    let n = names.len();
    for (field, length) in [("SIZE", sizes.len()), ("TYPE", types.len())] {
        if length != n {
            return Err(wrong(field, format!("{length} values"), format!("{n}, as FIELDS has")));
        }
    }
    if !counts.is_empty() && counts.len() != n {
        return Err(wrong(
            "COUNT",
            format!("{} values", counts.len()),
            format!("{n}, as FIELDS has"),
        ));
    }
    let mut fields = Vec::with_capacity(n);
    for (i, name) in names.into_iter().enumerate() {
        let number = match (types[i].as_str(), sizes[i]) {
            ("F", size @ (4 | 8)) => Number::Float(size),
            ("I", size @ (1 | 2 | 4 | 8)) => Number::Signed(size),
            ("U", size @ (1 | 2 | 4 | 8)) => Number::Unsigned(size),
            (kind, size) => {
                let expected = "F of 4 or 8, I or U of 1, 2, 4 or 8";
                return Err(wrong("TYPE", format!("{kind} of {size} bytes"), expected));
            }
        };
        fields.push(Field { name, number, count: counts.get(i).copied().unwrap_or(1) });
    }
    Ok(fields)
}

fn read_text(
    header: &Header,
    axes: [usize; 3],
    body: &[u8],
    first_line: usize,
) -> Result<Vec<Vector>, FormatError> {
    let text = super::super::tree::text(FORMAT, body)?;
    // A field of several numbers stands in several columns.
    let column = |i: usize| {
        header.fields[..i].iter().fold(0_usize, |sum, field| sum.saturating_add(field.count))
    };
    let columns = axes.map(column);
    let mut points = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let words: Vec<&str> = line.split_whitespace().collect();
        if words.is_empty() {
            continue;
        }
        let number = |k: usize| words.get(columns[k]).and_then(|word| word.parse().ok());
        match (number(0), number(1), number(2)) {
            (Some(x), Some(y), Some(z)) => points.push([x, y, z]),
            _ => {
                let place = Place::line(first_line + i);
                return Err(FormatError::new(FORMAT, place, quoted(line), "a number a field"));
            }
        }
    }
    if points.len() != header.points {
        let expected = format!("{}, as POINTS says", header.points);
        return Err(wrong("DATA", format!("{} points", points.len()), expected));
    }
    Ok(points)
}

/// Bytes of one point.
fn point_size(header: &Header) -> Result<usize, FormatError> {
    let sizes = header.fields.iter().map(|field| field.number.size().checked_mul(field.count));
    let size = sizes.into_iter().try_fold(0_usize, |sum, size| sum.checked_add(size?));
    size.ok_or_else(|| wrong("COUNT", "more bytes a point than there are", "a smaller number"))
}

/// Checks that there are as many bytes as the header says.
fn body_of<'a>(header: &Header, body: &'a [u8]) -> Result<(usize, &'a [u8]), FormatError> {
    let size = point_size(header)?;
    let body = size.checked_mul(header.points).and_then(|length| body.get(..length));
    let body = body.ok_or_else(|| {
        let found = format!("too few bytes for {} points of {size}", header.points);
        wrong("DATA", found, "as many as POINTS and SIZE say")
    })?;
    Ok((size, body))
}

fn read_bytes(header: &Header, axes: [usize; 3], body: &[u8]) -> Result<Vec<Vector>, FormatError> {
    let (size, body) = body_of(header, body)?;
    let offset = |i: usize| -> usize {
        header.fields[..i].iter().map(|field| field.number.size() * field.count).sum()
    };
    let offsets = axes.map(offset);
    let point = |bytes: &[u8]| {
        [0, 1, 2].map(|k| {
            let number = header.fields[axes[k]].number;
            number.value(&bytes[offsets[k]..offsets[k] + number.size()])
        })
    };
    Ok(body.chunks_exact(size).map(point).collect())
}

fn read_packed(header: &Header, axes: [usize; 3], body: &[u8]) -> Result<Vec<Vector>, FormatError> {
    let expected = "two lengths and as many packed bytes as the first says";
    let lengths = body.as_chunks::<4>().0;
    let (Some(&packed), Some(&length)) = (lengths.first(), lengths.get(1)) else {
        return Err(wrong("DATA", format!("{} bytes", body.len()), expected));
    };
    let (packed, length) = (u32::from_le_bytes(packed) as usize, u32::from_le_bytes(length));
    let bytes = body[8..].get(..packed).and_then(|packed| lzf::unpack(packed, length as usize));
    let bytes = bytes.ok_or_else(|| wrong("DATA", "packed bytes that do not unpack", expected))?;
    let (_, bytes) = body_of(header, &bytes)?;
    // All of the first field, then all of the second.
    let offset = |i: usize| -> usize {
        let sizes = header.fields[..i].iter().map(|field| field.number.size() * field.count);
        sizes.sum::<usize>() * header.points
    };
    let offsets = axes.map(offset);
    let point = |i: usize| {
        [0, 1, 2].map(|k| {
            let number = header.fields[axes[k]].number;
            let at = offsets[k] + i * number.size();
            number.value(&bytes[at..at + number.size()])
        })
    };
    Ok((0..header.points).map(point).collect())
}
