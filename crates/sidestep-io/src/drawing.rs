//! A picture as a map: a PNG, PGM or JPEG of a workspace, where what is dark is an obstacle.
//!
//! A pixel is a cell. The picture's lower left corner is the origin, x goes to the right and y upwards, and a side of
//! a pixel is [`Drawing::scale`] task units long. Colours count by their lightness; what is transparent lies on white.

use sidestep::plane::world::MAX_GRID_CELLS;
use sidestep::{Grid, InvalidInput};
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

use crate::error::{FormatError, Place};
use crate::most_cells;
use crate::ros_map::{self, Unknown};

const FORMAT: &str = "picture";

/// How pixels become obstacles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawing {
    /// Side of a pixel in task units; above 0.
    pub scale: f64,
    /// How dark a pixel must be, from 0 (white) to 1 (black), to be an obstacle; above 0 and below 1.
    pub threshold: f64,
    /// Whether what is light is an obstacle, and what is dark is free.
    pub light: bool,
}

impl Default for Drawing {
    /// One unit a pixel; darker than a middle grey.
    fn default() -> Self {
        Self { scale: 1.0, threshold: 0.5, light: false }
    }
}

impl Drawing {
    /// The map of a picture, of the kind that its first bytes say.
    ///
    /// # Errors
    /// If a setting is out of its range, the bytes are no such picture, or it has too many pixels for its bytes.
    pub fn read(&self, bytes: &[u8]) -> Result<Grid, DrawingError> {
        if !(self.scale > 0.0 && self.scale <= 1e6) {
            return Err(
                InvalidInput::new("scale", self.scale, "a number above 0 and up to 1e6").into()
            );
        }
        if !(self.threshold > 0.0 && self.threshold < 1.0) {
            let allowed = "a number above 0 (white) and below 1 (black)";
            return Err(InvalidInput::new("threshold", self.threshold, allowed).into());
        }
        let pixels = match bytes {
            [0xff, 0xd8, ..] => jpeg(bytes)?,
            _ => bytes.to_vec(),
        };
        // What Nav2 calls a map: darkness over one threshold is occupied, under the other free.
        let yaml = format!(
            "image: picture\nresolution: {:e}\norigin: [0, 0, 0]\nnegate: {}\n\
             occupied_thresh: {threshold}\nfree_thresh: {threshold}\n",
            self.scale,
            u8::from(self.light),
            threshold = self.threshold,
        );
        let map = ros_map::read(&yaml, Unknown::Occupied, |_| Ok(pixels));
        Ok(map.map_err(|error| FormatError { format: FORMAT, ..error })?.grid)
    }
}

/// Why a picture is no map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DrawingError {
    /// It is not what its format allows.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A setting is out of its range.
    #[error(transparent)]
    Setting(#[from] InvalidInput),
}

/// A JPEG's lightness as the bytes of a PGM.
fn jpeg(bytes: &[u8]) -> Result<Vec<u8>, FormatError> {
    let broken = |error: &dyn std::fmt::Display| {
        let found = format!("a JPEG that cannot be read ({error})");
        FormatError::new(FORMAT, Place::default(), found, "a whole baseline or progressive JPEG")
    };
    let options = DecoderOptions::default()
        .set_max_width(MAX_GRID_CELLS)
        .set_max_height(MAX_GRID_CELLS)
        .jpeg_set_out_colorspace(ColorSpace::Luma);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| broken(&error))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| broken(&"it has no size"))?;
    // A block of 64 pixels takes a bit at least.
    let most = most_cells(bytes.len()).min(bytes.len().saturating_mul(8 * 64));
    if width.saturating_mul(height) > most {
        let found = format!("{width} x {height} pixels in {} bytes", bytes.len());
        return Err(FormatError::new(
            FORMAT,
            Place::default(),
            found,
            format!("at most {most} pixels"),
        ));
    }
    let grey = decoder.decode().map_err(|error| broken(&error))?;
    if grey.len() != width * height {
        return Err(broken(&format!("{} samples for {width} x {height} pixels", grey.len())));
    }
    let mut pgm = format!("P5\n{width} {height}\n255\n").into_bytes();
    pgm.extend(grey);
    Ok(pgm)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 16 x 8 pixels of grey, the left half black: a baseline JPEG made by libjpeg (quality 90).
    const JPEG: &[u8] = include_bytes!("../tests/fixtures/half.jpg");

    #[test]
    fn dark_pixels_are_obstacles_in_every_format() {
        let pgm = [b"P5\n16 8\n255\n".to_vec(), [[0_u8; 8], [255; 8]].concat().repeat(8)].concat();
        for bytes in [JPEG, &pgm] {
            let grid = Drawing { scale: 0.5, ..Drawing::default() }.read(bytes).unwrap();
            assert_eq!((grid.width(), grid.height(), grid.resolution()), (16, 8, 0.5));
            assert!((0..8).all(|row| grid.is_occupied(2, row) && !grid.is_occupied(12, row)));
            let light = Drawing { light: true, ..Drawing::default() }.read(bytes).unwrap();
            assert!(!light.is_occupied(2, 3) && light.is_occupied(12, 3));
        }
    }

    #[test]
    fn faults_are_told() {
        let read = |drawing: Drawing, bytes: &[u8]| drawing.read(bytes).unwrap_err().to_string();
        let plain = Drawing::default();
        assert!(read(Drawing { scale: 0.0, ..plain }, JPEG).starts_with("scale: 0"));
        assert!(read(Drawing { threshold: 1.0, ..plain }, JPEG).starts_with("threshold: 1"));
        assert!(read(plain, &JPEG[..JPEG.len() / 2]).starts_with("picture"));
        assert!(read(plain, b"GIF89a").starts_with("picture"));
        assert!(read(plain, b"").starts_with("picture"));
        // A size that its bytes cannot fill.
        let mut huge = JPEG.to_vec();
        let at = huge.windows(2).position(|pair| pair == [0xff, 0xc0]).unwrap();
        huge[at + 5..at + 9].copy_from_slice(&[0xff, 0xff, 0xff, 0xff]);
        assert!(read(plain, &huge).contains("65535 x 65535 pixels"));
    }
}
