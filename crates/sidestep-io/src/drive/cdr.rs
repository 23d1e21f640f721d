//! Little-endian CDR (OMG DDS-XTypes 1.3, plain CDR version 1), as ROS 2 puts messages on the wire.

/// A message being written.
pub struct Cdr(Vec<u8>);

/// Bytes of the header that says little-endian; alignment counts from behind it.
const HEADER: [u8; 4] = [0, 1, 0, 0];

impl Cdr {
    pub fn new() -> Self {
        Self(HEADER.to_vec())
    }

    pub fn bytes(self) -> Vec<u8> {
        self.0
    }

    fn align(&mut self, to: usize) {
        let written = self.0.len() - HEADER.len();
        self.0.resize(HEADER.len() + written.next_multiple_of(to), 0);
    }

    pub fn u32(&mut self, value: u32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    pub fn i32(&mut self, value: i32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    pub fn f32(&mut self, value: f32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    pub fn f64(&mut self, value: f64) {
        self.align(8);
        self.0.extend(value.to_le_bytes());
    }

    pub fn string(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    pub fn octets(&mut self, bytes: impl ExactSizeIterator<Item = u8>) {
        self.u32(bytes.len() as u32);
        self.0.extend(bytes);
    }
}
