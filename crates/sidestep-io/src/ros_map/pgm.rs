//! PGM images, plain (P2) and raw (P5), of 8 and 16 bits.
//!
//! Source: the Netpbm format description, netpbm.sourceforge.net/doc/pgm.html. Comments (`#` to the
//! line's end) are taken between any two words.
//!
//! One byte of white space should stand between the header and raw pixels. Files that went through other
//! hands have CR LF there, or a comment; a reader that takes these for pixels shifts the map. The size of
//! the file says which it is: `raster` begins where the pixels end with the file, if only white space and
//! comments lie before. What is left over behind the last pixel is told, or refused if it cannot be told
//! from pixels.

use super::occupancy::{Cells, Occupancy, to_byte};
use super::{check_size, wrong_image};
use crate::error::FormatError;

/// The first image of the file.
pub(super) fn read(bytes: &[u8], occupancy: &Occupancy) -> Result<Cells, FormatError> {
    let plain = bytes.starts_with(b"P2");
    let mut words = Words { bytes, at: 2 };
    let width = words.number("the width", u32::MAX)?;
    let height = words.number("the height", u32::MAX)?;
    let white = words.number("the largest value", 65535)? as u16;
    if white == 0 {
        return Err(wrong_image("a largest value of 0", "a largest value from 1 to 65535"));
    }
    let rest = bytes.len().saturating_sub(words.at + 1) as u64;
    let (width, height) = (u64::from(width), u64::from(height));
    let (most, size) = match (plain, white > 255) {
        (true, _) => (rest / 2 + 1, "2 bytes a pixel at least"),
        (false, false) => (rest, "1 byte a pixel"),
        (false, true) => (rest / 2, "2 bytes a pixel"),
    };
    check_size(width, height, most, size, bytes.len())?;
    let (width, count) = (width as usize, (width * height) as usize);
    let mut cells = Cells::with_capacity(width, height as usize);
    let mut add = |value: u16| {
        if value > white {
            let (x, y) = (cells.len() % width, cells.len() / width);
            return Err(wrong_image(
                format!("the value {value} at column {x}, row {y}"),
                format!("at most the largest value, {white}"),
            ));
        }
        cells.push(occupancy, to_byte(value, white), true);
        Ok(())
    };
    let end = if plain {
        (0..count).try_for_each(|_| add(words.number("a pixel", 65535)? as u16))?;
        words.skip_space_and_comments();
        words.at
    } else {
        let length = if white > 255 { 2 * count } else { count };
        let begin = raster(bytes, words.at, length)?;
        let samples = &bytes[begin..begin + length];
        if white > 255 {
            let mut pairs = samples.as_chunks::<2>().0.iter();
            pairs.try_for_each(|&pair| add(u16::from_be_bytes(pair)))?;
        } else {
            samples.iter().try_for_each(|&byte| add(u16::from(byte)))?;
        }
        begin + length
    };
    cells.notes.extend(left_over(&bytes[end..])?);
    Ok(cells)
}

/// Where the pixels of a raw file begin, `length` bytes that are all there; the header's last word ends
/// at `header`.
fn raster(bytes: &[u8], header: usize, length: usize) -> Result<usize, FormatError> {
    let after = &bytes[header..];
    let carriage_returns =
        after.starts_with(b"\r\n") && !has_lone_carriage_return(&bytes[..header]);
    let first = header + if carriage_returns { 2 } else { 1 };
    let surplus = (bytes.len() as i64) - (first + length) as i64;
    if surplus < 0 {
        let found = format!("{} bytes after a header that ends in CR LF", bytes.len() - first);
        let expected = format!("{length} bytes of pixels; the file may be cut short");
        return Err(wrong_image(found, expected));
    }
    let last = bytes.len() - length;
    let could_end = matches!(left_over(&bytes[first + length..]), Ok(Some(_)));
    match is_space_and_comments(&bytes[header..last]) {
        true if surplus == 0 || !could_end => Ok(last),
        false if after.get(first - header) != Some(&b'#') && !after.starts_with(b"#") => Ok(first),
        _ => Err(wrong_image(
            format!("{surplus} bytes too many, before or after the pixels"),
            "one byte of white space after the largest value, then the pixels and nothing else",
        )),
    }
}

/// Whether lines end in CR alone, so that a LF behind one may be a pixel.
fn has_lone_carriage_return(header: &[u8]) -> bool {
    header.windows(2).any(|pair| pair[0] == b'\r' && pair[1] != b'\n')
}

fn is_space_and_comments(bytes: &[u8]) -> bool {
    let mut words = Words { bytes, at: 0 };
    words.skip_space_and_comments();
    let printable = |&byte: &u8| byte.is_ascii_whitespace() || byte.is_ascii_graphic();
    // A comment has to end before the pixels begin.
    let last_comment = bytes.rsplit(|&byte| byte == b'#').next().unwrap_or_default();
    let ended = last_comment.len() == bytes.len() || last_comment.contains(&b'\n');
    let space = bytes.last().is_some_and(u8::is_ascii_whitespace);
    words.at == bytes.len() && space && ended && bytes.iter().all(printable)
}

/// What to say of bytes after the last pixel; an error if they may be pixels.
fn left_over(bytes: &[u8]) -> Result<Option<String>, FormatError> {
    match bytes {
        [] => Ok(None),
        [b'P', b'1'..=b'7', c, ..] if c.is_ascii_whitespace() => {
            Ok(Some("the image file holds several images; the first is read".into()))
        }
        _ if bytes.iter().all(u8::is_ascii_whitespace) => {
            Ok(Some(format!("{} bytes of white space after the last pixel", bytes.len())))
        }
        _ => Err(wrong_image(
            format!("{} bytes after the last pixel", bytes.len()),
            "as many pixels as the header says, width x height, and nothing else",
        )),
    }
}

/// The words of a Netpbm file from a position on.
struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Words<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn skip_space_and_comments(&mut self) {
        while let Some(byte) = self.peek() {
            if byte == b'#' {
                while self.peek().is_some_and(|byte| byte != b'\n' && byte != b'\r') {
                    self.at += 1;
                }
            } else if byte.is_ascii_whitespace() {
                self.at += 1;
            } else {
                return;
            }
        }
    }

    /// The next word as a whole number of at most `most`.
    fn number(&mut self, what: &str, most: u32) -> Result<u32, FormatError> {
        self.skip_space_and_comments();
        let start = self.at;
        while self.peek().is_some_and(|byte| !byte.is_ascii_whitespace() && byte != b'#') {
            self.at += 1;
        }
        let word = &self.bytes[start..self.at];
        let expected = || format!("{what}: a whole number from 0 to {most}");
        if word.is_empty() {
            return Err(wrong_image("the end of the file", expected()));
        }
        let number = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        number.filter(|&number| number <= most).ok_or_else(|| {
            let shown = word[..word.len().min(20)].escape_ascii();
            wrong_image(format!("\"{shown}\" at byte {start}"), expected())
        })
    }
}
