//! PNG images through the `png` crate, as one brightness a pixel.

use std::io::Cursor;

use png::{BitDepth, Decoder, DecodingError, Limits, Transformations};

use super::{Image, Shade, check_size, wrong_image};
use crate::error::FormatError;

/// Deflate packs at most 1032 bytes into one; a file that claims more pixels than that lies.
const MOST_PACKED: u64 = 1032;

/// Most memory that one decoded image may take; a grid of the largest size fits in it as 8-bit grey.
const MOST_MEMORY: usize = 1 << 30;

/// The image, of any colour type and depth that PNG has.
pub(super) fn read(bytes: &[u8], occupied: &dyn Fn(Shade) -> bool) -> Result<Image, FormatError> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: MOST_MEMORY });
    // Palettes and depths under 8 bits become 8-bit grey or colour, with alpha where there is any.
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(broken)?;
    let (width, height) = (u64::from(header.width), u64::from(header.height));
    let packed = bytes.len() as u64 * MOST_PACKED * 8;
    let most = packed / header.bits_per_pixel() as u64;
    check_size(width, height, most, "1032 bytes a byte of file at most", bytes.len())?;

    let mut reader = decoder.read_info().map_err(broken)?;
    let size =
        reader.output_buffer_size().filter(|&size| size <= MOST_MEMORY).ok_or_else(|| {
            let expected = format!("at most {MOST_MEMORY} bytes when unpacked");
            wrong_image(format!("{width} x {height} pixels"), expected)
        })?;
    let mut samples = vec![0; size];
    let info = reader.next_frame(&mut samples).map_err(broken)?;
    let channels = info.color_type.samples();
    // Grey and RGB with alpha have an even number of channels, the last of them alpha.
    let has_alpha = channels % 2 == 0;
    let cells = if info.bit_depth == BitDepth::Sixteen {
        let sample = |pair: &[u8]| u16::from_be_bytes([pair[0], pair[1]]);
        let pixel = |bytes: &[u8]| shade(bytes.chunks_exact(2).map(sample), has_alpha, u16::MAX);
        samples.chunks_exact(2 * channels).map(|bytes| occupied(pixel(bytes))).collect()
    } else {
        let pixel = |bytes: &[u8]| shade(bytes.iter().map(|&b| u16::from(b)), has_alpha, 255);
        samples.chunks_exact(channels).map(|bytes| occupied(pixel(bytes))).collect()
    };
    Ok(Image { width: width as usize, cells })
}

/// The mean of the colour channels, rounded.
fn shade(channels: impl ExactSizeIterator<Item = u16>, has_alpha: bool, white: u16) -> Shade {
    let colours = channels.len() - usize::from(has_alpha);
    let (mut sum, mut opaque) = (0, true);
    for (i, value) in channels.enumerate() {
        if i < colours {
            sum += u32::from(value);
        } else {
            opaque = value == white;
        }
    }
    let count = colours.max(1) as u32;
    Shade { value: ((sum + count / 2) / count) as u16, white, opaque }
}

fn broken(error: DecodingError) -> FormatError {
    wrong_image(format!("a broken PNG ({error})"), "a whole PNG image")
}
