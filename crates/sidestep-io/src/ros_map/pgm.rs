//! PGM images, plain (P2) and raw (P5), of 8 and 16 bits.
//!
//! Source: the Netpbm format description, netpbm.sourceforge.net/doc/pgm.html. Comments (`#` to the
//! line's end) are taken between any two words.

use super::{Image, Shade, check_size, wrong_image};
use crate::error::FormatError;

/// The first image of the file.
pub(super) fn read(bytes: &[u8], occupied: &dyn Fn(Shade) -> bool) -> Result<Image, FormatError> {
    let plain = bytes.starts_with(b"P2");
    let mut words = Words { bytes, at: 2 };
    let width = words.number("the width", u32::MAX)?;
    let height = words.number("the height", u32::MAX)?;
    let white = words.number("the largest value", 65535)? as u16;
    if white == 0 {
        return Err(wrong_image("a largest value of 0", "a largest value from 1 to 65535"));
    }
    // One byte of white space stands between the header and raw samples.
    let samples = bytes.get(words.at + 1..).unwrap_or_default();
    let (width, height) = (u64::from(width), u64::from(height));
    let (most, size) = match (plain, white > 255) {
        (true, _) => (samples.len() as u64 / 2 + 1, "2 bytes a pixel at least"),
        (false, false) => (samples.len() as u64, "1 byte a pixel"),
        (false, true) => (samples.len() as u64 / 2, "2 bytes a pixel"),
    };
    check_size(width, height, most, size, bytes.len())?;
    let (width, count) = (width as usize, (width * height) as usize);
    let mut cells = Vec::with_capacity(count);
    let mut add = |value: u16| {
        if value > white {
            let (x, y) = (cells.len() % width, cells.len() / width);
            return Err(wrong_image(
                format!("the value {value} at column {x}, row {y}"),
                format!("at most the largest value, {white}"),
            ));
        }
        cells.push(occupied(Shade { value, white, opaque: true }));
        Ok(())
    };
    if plain {
        (0..count).try_for_each(|_| add(words.number("a pixel", 65535)? as u16))?;
    } else if white > 255 {
        let pairs = samples.as_chunks::<2>().0;
        pairs[..count].iter().try_for_each(|&pair| add(u16::from_be_bytes(pair)))?;
    } else {
        samples[..count].iter().try_for_each(|&byte| add(u16::from(byte)))?;
    }
    Ok(Image { width, cells })
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
                while self.peek().is_some_and(|byte| byte != b'\n') {
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
