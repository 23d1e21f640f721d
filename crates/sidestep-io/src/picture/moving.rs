//! A PNG that moves (APNG): of each frame, only the part that differs from the one before.

use std::borrow::Cow;

/// Milliseconds that a frame is shown, and that the last one is.
const SHOWN: u16 = 120;
const HELD: u16 = 2_500;

/// The PNG of `count` frames of opaque pixels, the top row first, over and over; `None` if the sizes disagree.
pub(super) fn encode(
    [width, height]: [u32; 2],
    count: usize,
    frames: impl Iterator<Item = Vec<u8>>,
) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    encoder.set_animated(u32::try_from(count).ok()?, 0).ok()?;
    let mut writer = encoder.write_header().ok()?;
    let mut before: Option<Vec<u8>> = None;
    for (i, frame) in frames.enumerate() {
        let shown = if i + 1 == count { HELD } else { SHOWN };
        writer.set_frame_delay(shown, 1_000).ok()?;
        let [left, top, wide, tall] = match &before {
            Some(before) => changed(width as usize, before, &frame),
            None => [0, 0, width, height],
        };
        writer.reset_frame_position().ok()?;
        writer.set_frame_dimension(wide, tall).ok()?;
        writer.set_frame_position(left, top).ok()?;
        writer.write_image_data(&part(width as usize, &frame, [left, top, wide, tall])).ok()?;
        before = Some(frame);
    }
    writer.finish().ok()?;
    Some(bytes)
}

/// The least rectangle that holds every pixel in which two frames differ: left, top, width, height; a pixel if
/// none does.
fn changed(width: usize, before: &[u8], after: &[u8]) -> [u32; 4] {
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    let pixels = before.chunks_exact(3).zip(after.chunks_exact(3));
    for (i, _) in pixels.enumerate().filter(|(_, (a, b))| a != b) {
        let at = [i % width, i / width];
        for axis in 0..2 {
            low[axis] = low[axis].min(at[axis]);
            high[axis] = high[axis].max(at[axis]);
        }
    }
    if low[0] > high[0] {
        return [0, 0, 1, 1];
    }
    [low[0], low[1], high[0] - low[0] + 1, high[1] - low[1] + 1].map(|side| side as u32)
}

/// The pixels of a rectangle.
fn part(width: usize, frame: &[u8], [left, top, wide, tall]: [u32; 4]) -> Cow<'_, [u8]> {
    if wide as usize == width {
        let from = 3 * width * top as usize;
        return Cow::Borrowed(&frame[from..from + 3 * width * tall as usize]);
    }
    let rows = (top as usize..(top + tall) as usize).map(|row| 3 * (row * width + left as usize));
    Cow::Owned(rows.flat_map(|from| &frame[from..from + 3 * wide as usize]).copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_back_as_they_went_in() {
        let frame = |lit: &[usize]| -> Vec<u8> {
            (0..12).flat_map(|i| [if lit.contains(&i) { 200 } else { 7 }; 3]).collect()
        };
        // Four wide, three high; nothing changes from the third to the fourth.
        let frames = [frame(&[]), frame(&[1, 6]), frame(&[10]), frame(&[10])];
        let bytes = encode([4, 3], 4, frames.iter().cloned()).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 4);
        let mut sheet = frames[0].clone();
        for (i, expected) in frames.iter().enumerate() {
            let mut buffer = vec![0; 36];
            reader.next_frame(&mut buffer).unwrap();
            let control = *reader.info().frame_control().unwrap();
            assert_eq!(control.delay_num, if i == 3 { HELD } else { SHOWN });
            for row in 0..control.height {
                let to = 3 * ((control.y_offset + row) * 4 + control.x_offset) as usize;
                let from = (3 * row * control.width) as usize;
                let long = 3 * control.width as usize;
                sheet[to..to + long].copy_from_slice(&buffer[from..from + long]);
            }
            assert_eq!(&sheet, expected, "frame {i}");
        }
    }
}
