//! Lines of bounded length.

use std::io::{self, BufRead};

/// Most bytes of a request.
pub const MOST_BYTES: usize = 1 << 20;

/// One line, or that it was too long.
#[derive(Debug, PartialEq, Eq)]
pub enum Line {
    /// Without its newline.
    Text(Vec<u8>),
    /// Longer than [`MOST_BYTES`]; it was read to its end and dropped.
    TooLong,
}

/// The next line; none at the end.
pub fn next(reader: &mut impl BufRead) -> io::Result<Option<Line>> {
    let (mut line, mut too_long, mut any) = (Vec::new(), false, false);
    loop {
        let buffer = match reader.fill_buf() {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            buffer => buffer?,
        };
        if buffer.is_empty() {
            break;
        }
        any = true;
        let end = buffer.iter().position(|&byte| byte == b'\n');
        let part = &buffer[..end.unwrap_or(buffer.len())];
        too_long |= line.len() + part.len() > MOST_BYTES;
        if !too_long {
            line.extend_from_slice(part);
        }
        let used = end.map_or(buffer.len(), |end| end + 1);
        reader.consume(used);
        if end.is_some() {
            break;
        }
    }
    Ok(any.then_some(if too_long { Line::TooLong } else { Line::Text(line) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_bounded() {
        let long = vec![b'x'; MOST_BYTES + 1];
        let text = [b"one\n", &long[..], b"\n\nlast"].concat();
        let mut reader = io::BufReader::with_capacity(1000, &text[..]);
        let line = |text: &str| Some(Line::Text(text.into()));
        for expected in [line("one"), Some(Line::TooLong), line(""), line("last"), None] {
            assert_eq!(next(&mut reader).unwrap(), expected);
        }
    }
}
