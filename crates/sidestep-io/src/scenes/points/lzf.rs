//! LZF, the packing of `binary_compressed` PCD files (M. Lehmann, liblzf).
//!
//! A control byte below 32 is followed by that many bytes and one more, as they are. Any other has
//! in its upper three bits the length less two of a repetition (7: the next byte says how much
//! more), in its lower five and the next byte how far back that begins, less one.

/// The unpacked bytes, exactly `length`; nothing if the packed ones are damaged.
pub(super) fn unpack(packed: &[u8], length: usize) -> Option<Vec<u8>> {
    // A repetition of three bytes gives at most 264: more cannot come out, whatever a file says.
    if length > packed.len().saturating_mul(88) {
        return None;
    }
    let mut unpacked = Vec::with_capacity(length);
    let mut bytes = packed.iter();
    while let Some(&control) = bytes.next() {
        if control < 32 {
            let rest = bytes.as_slice();
            let (plain, rest) = rest.split_at_checked(usize::from(control) + 1)?;
            unpacked.extend_from_slice(plain);
            bytes = rest.iter();
        } else {
            let mut count = usize::from(control >> 5);
            if count == 7 {
                count += usize::from(*bytes.next()?);
            }
            let back = (usize::from(control & 31) << 8) + usize::from(*bytes.next()?) + 1;
            let start = unpacked.len().checked_sub(back)?;
            // What is copied may be what this very copy writes.
            for i in start..start + count + 2 {
                unpacked.push(unpacked[i]);
            }
        }
        if unpacked.len() > length {
            return None;
        }
    }
    (unpacked.len() == length).then_some(unpacked)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unpacks() {
        for (packed, expected) in [
            (&[2, b'a', b'b', b'c'][..], Some("abc")),
            (&[2, b'a', b'b', b'c', 0x80, 2], Some("abcabcabc")),
            (&[0, b'a', 0xe0, 1, 0], Some("aaaaaaaaaaa")),
            (&[0, b'a', 0x20, 1], None),
            (&[5, b'a'], None),
            (&[0, b'a', 0xe0], None),
        ] {
            let length = expected.map_or(11, str::len);
            let found = unpack(packed, length);
            assert_eq!(found.as_deref(), expected.map(str::as_bytes), "{packed:?}");
        }
        assert_eq!(unpack(&[2, b'a', b'b', b'c'], 4), None);
        assert_eq!(unpack(&[2, b'a', b'b', b'c'], usize::MAX), None);
    }
}
