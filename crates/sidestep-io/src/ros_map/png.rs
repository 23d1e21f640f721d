//! PNG images through the `png` crate, as one byte of grey a pixel. Colour profiles, gamma and texts are
//! passed over unread.

use std::io::Cursor;

use png::{BitDepth, ColorType, Decoder, DecodingError, Info, Limits, Transformations};

use super::occupancy::{Cells, Occupancy, luma, to_byte};
use super::{check_size, wrong_image};
use crate::error::FormatError;
use crate::most_cells;

/// Deflate packs at most 1032 bytes into one; a file that claims more pixels than that lies.
const MOST_PACKED: u64 = 1032;

/// Most memory that one decoded image may take; a grid of the largest size fits in it as 8-bit grey.
const MOST_MEMORY: usize = 1 << 30;

/// The image, of any colour type and depth that PNG has.
pub(super) fn read(bytes: &[u8], occupancy: &Occupancy) -> Result<Cells, FormatError> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: MOST_MEMORY });
    // Palettes and depths under 8 bits become 8-bit grey or colour, with alpha where there is any.
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_ignore_text_chunk(true);
    let header = decoder.read_header_info().map_err(broken)?;
    let (width, height) = (u64::from(header.width), u64::from(header.height));
    let packed = bytes.len() as u64 * MOST_PACKED * 8;
    let most = packed / header.bits_per_pixel() as u64;
    check_size(width, height, most, "1032 bytes a byte of file at most", bytes.len())?;
    let most = most_cells(bytes.len()) as u64;
    check_size(width, height, most, &format!("at most {most} pixels"), bytes.len())?;

    let mut reader = decoder.read_info().map_err(broken)?;
    check_palette(reader.info())?;
    let mut cells = Cells::with_capacity(width as usize, height as usize);
    let (color, depth) = reader.output_color_type();
    let kind = Kind { channels: color.samples(), deep: depth == BitDepth::Sixteen };
    if reader.info().interlaced {
        let size =
            reader.output_buffer_size().filter(|&size| size <= MOST_MEMORY).ok_or_else(|| {
                let expected = format!("at most {MOST_MEMORY} bytes when unpacked");
                wrong_image(format!("{width} x {height} interlaced pixels"), expected)
            })?;
        let mut samples = vec![0; size];
        reader.next_frame(&mut samples).map_err(broken)?;
        kind.add(&samples, occupancy, &mut cells);
    } else {
        // A row at a time, so that nothing but the cells is as large as the image.
        for _ in 0..height {
            let row = reader.next_row().map_err(broken)?;
            let row =
                row.ok_or_else(|| wrong_image("a PNG that ends early", "a whole PNG image"))?;
            kind.add(row.data(), occupancy, &mut cells);
        }
        reader.finish().map_err(broken)?;
    }
    Ok(cells)
}

/// Refuses a palette of broken colours, or with more opacities than colours: the decoder relies on whole ones.
fn check_palette(info: &Info<'_>) -> Result<(), FormatError> {
    let Some(palette) = &info.palette else { return Ok(()) };
    let opacities = match (info.color_type, &info.trns) {
        (ColorType::Indexed, Some(opacities)) => opacities.len(),
        _ => 0,
    };
    let colours = palette.len() / 3;
    if palette.len() % 3 == 0 && (1..=256).contains(&colours) && opacities <= colours {
        return Ok(());
    }
    let found = format!("a PNG palette of {} bytes with {opacities} opacities", palette.len());
    Err(wrong_image(found, "1 to 256 colours of 3 bytes, and at most one opacity each"))
}

/// How the samples of an image lie.
struct Kind {
    /// Samples a pixel; an even number has alpha for its last.
    channels: usize,
    /// Whether a sample has 16 bits.
    deep: bool,
}

impl Kind {
    /// Adds the pixels of `samples`, which are whole.
    fn add(&self, samples: &[u8], occupancy: &Occupancy, cells: &mut Cells) {
        let alpha = self.channels.is_multiple_of(2);
        let bytes = self.channels * if self.deep { 2 } else { 1 };
        for pixel in samples.chunks_exact(bytes) {
            // A byte v is the 16-bit value 257 v.
            let sample = |i: usize| match self.deep {
                true => u16::from_be_bytes([pixel[2 * i], pixel[2 * i + 1]]),
                false => 257 * u16::from(pixel[i]),
            };
            let opaque = !alpha || to_byte(sample(self.channels - 1), u16::MAX) == 255;
            let grey = if self.channels > 2 {
                let rgb = [sample(0), sample(1), sample(2)];
                cells.coloured += u64::from(opaque && rgb.iter().any(|&v| v != rgb[0]));
                luma(rgb)
            } else {
                to_byte(sample(0), u16::MAX)
            };
            cells.push(occupancy, grey, opaque);
        }
    }
}

fn broken(error: DecodingError) -> FormatError {
    wrong_image(format!("a broken PNG ({error})"), "a whole PNG image")
}
