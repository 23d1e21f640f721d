//! Changes of an input such as a fuzzer makes, for tests that run everywhere.

use rand::{Rng, RngExt};

/// Bytes that readers decide by.
const TELLING: &[u8] = b"\0\n\r\t \"#,-.0:9@E[]e{}\x7f\x80\xff";

/// `input` with a few changes: bytes replaced, removed, put in, repeated, or the rest of another input.
pub fn mutate(input: &[u8], other: &[u8], longest: usize, rng: &mut impl Rng) -> Vec<u8> {
    let mut bytes = input.to_vec();
    for _ in 0..rng.random_range(1..=4) {
        let at = rng.random_range(0..=bytes.len());
        let end = (at + rng.random_range(1..=16)).min(bytes.len());
        match rng.random_range(0..7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << rng.random_range(0..8),
            1 if at < bytes.len() => bytes[at] = TELLING[rng.random_range(0..TELLING.len())],
            2 => drop(bytes.drain(at..end)),
            3 => bytes.insert(at, TELLING[rng.random_range(0..TELLING.len())]),
            4 => {
                let part = bytes[at..end].to_vec();
                bytes.splice(at..at, part.repeat(rng.random_range(1..=8)));
            }
            5 => bytes.truncate(at),
            _ => {
                let from = rng.random_range(0..=other.len());
                let to = (from + rng.random_range(1..=32)).min(other.len());
                bytes.splice(at..at, other[from..to].iter().copied());
            }
        }
    }
    bytes.truncate(longest);
    bytes
}
