//! TensorBoard event files, as far as scalars need them.
//!
//! A file is a sequence of TFRecords (length, masked CRC-32C of the length, data, masked CRC-32C of
//! the data), each an `Event` protocol buffer: wall time (1, double), step (2, varint), file
//! version (3, string) or summary (5), which holds values (1) of a tag (1) and a simple value (2,
//! float). Source: tensorflow/core/util/event.proto and lib/io/record_writer.

/// The bytes of an event file under construction.
#[derive(Default)]
pub struct Events {
    bytes: Vec<u8>,
}

impl Events {
    /// An event file that begins at `wall_time` seconds since 1970.
    pub fn new(wall_time: f64) -> Self {
        let mut events = Self::default();
        let mut event = double(1, wall_time);
        event.extend(field(3, b"brain.Event:2"));
        events.record(&event);
        events
    }

    /// Adds a scalar.
    pub fn scalar(&mut self, wall_time: f64, step: u64, tag: &str, value: f64) {
        let mut scalar = field(1, tag.as_bytes());
        scalar.push(2 << 3 | 5);
        scalar.extend((value as f32).to_le_bytes());
        let mut event = double(1, wall_time);
        event.push(2 << 3);
        event.extend(varint(step));
        event.extend(field(5, &field(1, &scalar)));
        self.record(&event);
    }

    /// The file so far.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn record(&mut self, data: &[u8]) {
        let length = (data.len() as u64).to_le_bytes();
        self.bytes.extend(length);
        self.bytes.extend(masked_crc(&length).to_le_bytes());
        self.bytes.extend(data);
        self.bytes.extend(masked_crc(data).to_le_bytes());
    }
}

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

/// A length-delimited field.
fn field(number: u8, data: &[u8]) -> Vec<u8> {
    let mut bytes = vec![number << 3 | 2];
    bytes.extend(varint(data.len() as u64));
    bytes.extend(data);
    bytes
}

fn double(number: u8, value: f64) -> Vec<u8> {
    let mut bytes = vec![number << 3 | 1];
    bytes.extend(value.to_le_bytes());
    bytes
}

fn masked_crc(data: &[u8]) -> u32 {
    let crc = crc32c(data);
    crc.rotate_right(15).wrapping_add(0xa282_ead8)
}

/// CRC-32C (Castagnoli), bit by bit: event files are small.
fn crc32c(data: &[u8]) -> u32 {
    !data.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            crc >> 1 ^ (0x82f6_3b78 & (crc & 1).wrapping_neg())
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crc_matches_the_published_check_value() {
        // RFC 3720, B.4: CRC-32C of "123456789" and of 32 zeros.
        assert_eq!(crc32c(b"123456789"), 0xe306_9283);
        assert_eq!(crc32c(&[0; 32]), 0x8a91_36aa);
    }

    #[test]
    fn records_are_framed() {
        let mut events = Events::new(1.5);
        events.scalar(2.5, 300, "charts/SPS", 7.0);
        let mut rest = events.bytes();
        let mut records = 0;
        while !rest.is_empty() {
            let length = u64::from_le_bytes(rest[..8].try_into().unwrap()) as usize;
            let data = &rest[12..12 + length];
            let crc = u32::from_le_bytes(rest[12 + length..16 + length].try_into().unwrap());
            assert_eq!(crc, masked_crc(data));
            rest = &rest[16 + length..];
            records += 1;
        }
        assert_eq!(records, 2);
    }
}
