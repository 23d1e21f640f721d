//! Text from bytes: UTF-8 with or without a byte order mark, or UTF-16 with one, as some editors and
//! shells write.

use std::borrow::Cow;

use crate::error::{FormatError, Place};

/// The text of a file of the named format, without its byte order mark.
///
/// # Errors
/// If the bytes are not text.
pub fn decode<'a>(format: &'static str, bytes: &'a [u8]) -> Result<Cow<'a, str>, FormatError> {
    let not_text = |what: String| {
        FormatError::new(format, Place::default(), what, "text in UTF-8, or UTF-16 with its mark")
    };
    let utf_16 = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        let (pairs, odd) = bytes.as_chunks::<2>();
        let text: Result<String, _> =
            char::decode_utf16(pairs.iter().map(|&pair| unit(pair))).collect();
        text.ok().filter(|_| odd.is_empty()).map(Cow::Owned)
    };
    let wide = match bytes {
        [0xff, 0xfe, rest @ ..] => utf_16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => utf_16(rest, u16::from_be_bytes),
        _ => {
            let text = std::str::from_utf8(bytes).map_err(|error| {
                not_text(format!("a byte that is not UTF-8 at {}", error.valid_up_to()))
            })?;
            return Ok(Cow::Borrowed(without_mark(text)));
        }
    };
    wide.ok_or_else(|| not_text("broken UTF-16".into()))
}

/// The text without a byte order mark before it.
pub(crate) fn without_mark(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mark_is_taken_off() {
        let text = "type octile\u{1f600}";
        let mut files = vec![text.as_bytes().to_vec(), format!("\u{feff}{text}").into_bytes()];
        let units: Vec<u16> = format!("\u{feff}{text}").encode_utf16().collect();
        files.push(units.iter().flat_map(|unit| unit.to_le_bytes()).collect());
        files.push(units.iter().flat_map(|unit| unit.to_be_bytes()).collect());
        for bytes in files {
            assert_eq!(decode("test", &bytes).unwrap(), text, "{bytes:?}");
        }
        for bytes in [&b"a\xff"[..], b"\xff\xfea", b"\xfe\xff\xd8\x00", b"\xc3"] {
            assert!(decode("test", bytes).is_err(), "{bytes:?}");
        }
    }
}
