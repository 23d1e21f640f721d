//! Clouds of points: PCD, PLY and XYZ files. Points that are not finite mark what a camera did not
//! see and are left out; units are taken to be metres.

mod lzf;
mod pcd;
mod ply;

use sidestep::space::Vector;

use crate::error::{FormatError, Place, quoted};

pub use pcd::read_pcd;
pub use ply::read_ply;

/// The finite points of a file: PCD, PLY or XYZ by its extension.
///
/// # Errors
/// If the extension is another one, or the file is not what its format allows.
pub fn read(file_name: &str, bytes: &[u8]) -> Result<Vec<Vector>, FormatError> {
    match super::extension(file_name).as_str() {
        "pcd" => read_pcd(bytes),
        "ply" => read_ply(bytes),
        "xyz" | "txt" => read_xyz(bytes),
        _ => {
            let found = quoted(file_name);
            Err(FormatError::new(
                "a point cloud",
                Place::default(),
                found,
                "a PCD, PLY or XYZ file",
            ))
        }
    }
}

/// The finite points of an XYZ text: three numbers a line, by space, comma or semicolon, and
/// perhaps others behind them; `#` begins a comment.
///
/// # Errors
/// A line that does not begin with three numbers.
pub fn read_xyz(bytes: &[u8]) -> Result<Vec<Vector>, FormatError> {
    const FORMAT: &str = "XYZ points";
    let text = super::tree::text(FORMAT, bytes)?;
    let mut points = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let content = line.split('#').next().unwrap_or_default().trim();
        if content.is_empty() {
            continue;
        }
        let words = content.split([' ', '\t', ',', ';']).filter(|word| !word.is_empty());
        let mut numbers = words.map(str::parse::<f64>);
        match (numbers.next(), numbers.next(), numbers.next()) {
            (Some(Ok(x)), Some(Ok(y)), Some(Ok(z))) => points.push([x, y, z]),
            _ => {
                let place = Place::line(i + 1);
                return Err(FormatError::new(FORMAT, place, quoted(content), "three numbers"));
            }
        }
    }
    Ok(finite(points))
}

/// The points that are finite.
fn finite(mut points: Vec<Vector>) -> Vec<Vector> {
    points.retain(|point| point.iter().all(|v| v.is_finite()));
    points
}

/// A binary number of a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Number {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl Number {
    fn size(self) -> usize {
        match self {
            Self::Signed(size) | Self::Unsigned(size) | Self::Float(size) => size,
        }
    }

    /// The number that these bytes are, which are as many as its size, little-endian.
    fn value(self, bytes: &[u8]) -> f64 {
        let mut wide = [0; 8];
        wide[..bytes.len()].copy_from_slice(bytes);
        let unsigned = u64::from_le_bytes(wide);
        match self {
            Self::Float(4) => f64::from(f32::from_bits(unsigned as u32)),
            Self::Float(_) => f64::from_bits(unsigned),
            Self::Unsigned(_) => unsigned as f64,
            Self::Signed(size) => {
                let unused = 64 - 8 * size as u32;
                ((unsigned << unused) as i64 >> unused) as f64
            }
        }
    }
}
