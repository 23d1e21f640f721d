//! ROS maps: values, orientation, thresholds, image kinds, bad files.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod refusal;

use std::io;

use proptest::prelude::*;
use proptest::sample::Index;
use refusal::check_refused;
use sidestep::Grid;
use sidestep_io::FormatError;
use sidestep_io::ros_map::{self, Unknown};

const YAML: &str = include_str!("fixtures/room.yaml");
const PGM: &[u8] = include_bytes!("fixtures/room.pgm");
const PLAIN_PGM: &[u8] = include_bytes!("fixtures/room_plain.pgm");

/// The grid as a person sees it, the top row first.
fn drawn(grid: &Grid) -> Vec<String> {
    let rows = grid.cells().chunks(grid.width()).rev();
    rows.map(|row| row.iter().map(|&cell| if cell { '#' } else { '.' }).collect()).collect()
}

fn ros(yaml: &str, image: &[u8], unknown: Unknown) -> Result<Grid, FormatError> {
    ros_map::read(yaml, unknown, |_| Ok(image.to_vec())).map(|map| map.grid)
}

#[test]
fn ros_maps_and_their_modes() {
    let grid = ros(YAML, PGM, Unknown::Occupied).unwrap();
    assert_eq!(drawn(&grid), ["#####", "#..##", "#.#.."]);
    assert_eq!((grid.resolution(), grid.origin()), (0.05, [-1.0, 2.5]));
    assert_eq!(ros(YAML, PLAIN_PGM, Unknown::Occupied).unwrap(), grid);
    // 205 and 100 lie between the thresholds.
    let free = ros(YAML, PGM, Unknown::Free).unwrap();
    assert_eq!(drawn(&free), ["#####", "#...#", "#...."]);
    let negated = YAML.replace("negate: 0", "negate: true");
    let negated = ros(&negated, PGM, Unknown::Occupied).unwrap();
    assert_eq!(drawn(&negated), [".....", ".###.", ".####"]);
    let raw = ros(&format!("{YAML}mode: raw\n"), PGM, Unknown::Free).unwrap();
    assert_eq!(drawn(&raw), [".....", ".....", "..#.."]);
    let mut wide = b"P5 2 1 1000 ".to_vec();
    wide.extend([0, 3, 3, 232]);
    assert_eq!(drawn(&ros(YAML, &wide, Unknown::Occupied).unwrap()), ["#."]);
}

/// A PNG of the same five shades in one colour type and depth.
fn png_of(color: png::ColorType, depth: png::BitDepth, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_color(color);
    encoder.set_depth(depth);
    if color == png::ColorType::Indexed {
        encoder.set_palette(vec![0, 0, 0, 255, 255, 255]);
    }
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(samples).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn png_colour_types() {
    use png::BitDepth::{Eight, One, Sixteen};
    use png::ColorType::{Grayscale, GrayscaleAlpha, Indexed, Rgb, Rgba};
    let two = |black: &[u8], white: &[u8]| [black, white, white, black].concat();
    for (color, depth, samples) in [
        (Grayscale, Eight, two(&[0], &[254])),
        (Grayscale, One, vec![0b0100_0000, 0b1000_0000]),
        (Grayscale, Sixteen, two(&[0, 9], &[255, 0])),
        (GrayscaleAlpha, Eight, two(&[0, 255], &[255, 255])),
        (Indexed, One, vec![0b0100_0000, 0b1000_0000]),
        (Rgb, Eight, two(&[0, 9, 0], &[255, 250, 255])),
        (Rgba, Eight, two(&[0, 0, 0, 255], &[255, 255, 255, 255])),
        (Rgba, Sixteen, two(&[0, 0, 0, 0, 0, 0, 255, 255], &[255; 8])),
    ] {
        let bytes = png_of(color, depth, &samples);
        let grid = ros(YAML, &bytes, Unknown::Free).unwrap();
        assert_eq!(drawn(&grid), ["#.", ".#"], "{color:?} {depth:?}");
        for cut in [bytes.len() / 2, bytes.len() - 20] {
            check_refused(
                ros(YAML, &bytes[..cut], Unknown::Free),
                "ROS map image: found a broken PNG",
            );
        }
    }
    // Black but see-through: unknown.
    let glass = png_of(GrayscaleAlpha, Eight, &[0, 254, 0, 255, 255, 255, 255, 0]);
    assert_eq!(drawn(&ros(YAML, &glass, Unknown::Free).unwrap()), [".#", ".."]);
    assert_eq!(drawn(&ros(YAML, &glass, Unknown::Occupied).unwrap()), ["##", ".#"]);
}

#[test]
fn bad_ros_yaml() {
    for (from, to, message) in [
        (
            "resolution: 0.05",
            "",
            "ROS map YAML, resolution: found no such field; expected the fields image",
        ),
        ("resolution: 0.05", "resolution: 0", "resolution: found 0; expected a number above 0"),
        ("resolution: 0.05", "resolution: -1", "resolution: found -1; expected a number above 0"),
        (
            "resolution: 0.05",
            "resolution: .nan",
            "resolution: found \".nan\"; expected a finite number",
        ),
        (
            "resolution: 0.05",
            "resolution: .inf",
            "resolution: found \".inf\"; expected a finite number",
        ),
        (
            "resolution: 0.05",
            "resolution: fine",
            "ROS map YAML, line 2, column 13, resolution: found \"fine\"; expected a finite number",
        ),
        (
            "[-1.0, 2.5, 0.0]",
            "[-1.0, 2.5, 0.1]",
            "origin[2] (yaw): found 0.1; expected a multiple of a quarter turn",
        ),
        (
            "[-1.0, 2.5, 0.0]",
            "[-1.0]",
            "line 3, column 9, origin: found 1 numbers; expected [x, y, yaw]",
        ),
        (
            "[-1.0, 2.5, 0.0]",
            "[.nan, 2.5, 0]",
            "origin[0]: found \".nan\"; expected a finite number",
        ),
        ("negate: 0", "negate: 2", "negate: found 2; expected 0, 1, true or false"),
        (
            "occupied_thresh: 0.65",
            "occupied_thresh: 65",
            "occupied_thresh: found 65; expected a number from 0 to 1",
        ),
        (
            "free_thresh: 0.196",
            "free_thresh: -0.1",
            "free_thresh: found -0.1; expected a number from 0 to 1",
        ),
        (
            "free_thresh: 0.196",
            "free_thresh: 0.7",
            "free_thresh: found 0.7; expected at most occupied_thresh = 0.65",
        ),
        (
            "negate",
            "mode: trinar\nnegate",
            "mode: found \"trinar\"; expected trinary, scale, raw (did you mean trinary?)",
        ),
        ("image", "- image", "ROS map YAML, line 1, column 1: found a fault ("),
        ("negate: 0", "negate: [0]", "negate: found a fault ("),
        (
            "image",
            "negate: 1\nimage",
            "line 5, column 1, negate: found a fault (duplicate mapping key: negate);",
        ),
    ] {
        assert!(YAML.contains(from), "{from}");
        check_refused(ros(&YAML.replace(from, to), PGM, Unknown::Occupied), message);
    }
    check_refused(ros("", PGM, Unknown::Free), "ROS map YAML");
    let missing = ros_map::read(YAML, Unknown::Free, |name| {
        assert_eq!(name, "room.pgm");
        Err(io::Error::from(io::ErrorKind::NotFound))
    });
    check_refused(missing, "image: found \"room.pgm\", which cannot be read (entity not found)");
}

#[test]
fn bad_images() {
    let huge_png = {
        let mut bytes = png_of(png::ColorType::Grayscale, png::BitDepth::Eight, &[0; 4]);
        bytes[16..24].copy_from_slice(&[0, 0, 0x3f, 0xff, 0, 0, 0x3f, 0xff]);
        let checksum = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
        bytes
    };
    let cut = &PGM[..PGM.len() - 1];
    for (image, message) in [
        (
            &b""[..],
            "ROS map image: found a file that starts with \"\"; expected a PGM (P2 or P5) or PNG image",
        ),
        (b"GIF89a", "found a file that starts with \"GIF8\""),
        (
            cut,
            "found 5 x 3 pixels in a file of 41 bytes; expected 1 byte a pixel; the file may be cut short",
        ),
        (b"P5 5", "found the end of the file; expected the height"),
        (b"P5 0 5 255 ", "found 0 x 5 pixels; expected between 1 and 268435456 pixels"),
        (b"P5 -5 5 255 ", "found \"-5\" at byte 3; expected the width: a whole number"),
        (b"P5 5 5 70000 ", "found \"70000\" at byte 7; expected the largest value"),
        (b"P5 5 5 0 ", "found a largest value of 0"),
        (b"P5 100000 100000 255 abc", "found 100000 x 100000 pixels; expected between 1 and"),
        (b"P5 10000 10000 255 abc", "found 10000 x 10000 pixels in a file of 22 bytes"),
        (
            b"P2 10000 10000 255 1 2 3",
            "found 10000 x 10000 pixels in a file of 24 bytes; expected 2 bytes a pixel at least",
        ),
        (b"P2 2 2 255 1 2 3     ", "found the end of the file; expected a pixel"),
        (
            b"P2 2 1 255 1 300",
            "found the value 300 at column 1, row 0; expected at most the largest value, 255",
        ),
        (b"P2 2 1 255 1 2 3", "found 1 bytes after the last pixel"),
        (
            b"P5 2 1 255 abc",
            "found 1 bytes after the last pixel; expected as many pixels as the header",
        ),
        (
            b"P5\r\n2 1\r\n255\r\na",
            "found 1 bytes after a header that ends in CR LF; expected 2 bytes",
        ),
        // Where the pixels begin cannot be told.
        (b"P5 2 1 255 # of\nabc", "found 6 bytes too many, before or after the pixels"),
        (b"P5 2 1 255\n\na\n", "found 1 bytes too many, before or after the pixels"),
        (b"P2 2 1 255 1 x", "found \"x\" at byte 13; expected a pixel"),
        (&huge_png, "found 16383 x 16383 pixels in a file of"),
    ] {
        check_refused(ros(YAML, image, Unknown::Free), message);
    }
}

/// The checksum of PNG chunks, bit by bit (PNG specification, annex D).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 * (crc & 1)))
    })
}

/// `file` with some bytes replaced and its end cut off.
fn damaged(file: &[u8], damage: &[(Index, u8)], length: Index) -> Vec<u8> {
    let mut bytes = file.to_vec();
    for (at, byte) in damage {
        bytes[at.index(file.len())] = *byte;
    }
    bytes.truncate(length.index(file.len() + 1));
    bytes
}

proptest! {
    #[test]
    fn no_bytes_make_a_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = ros(&String::from_utf8_lossy(&bytes), PGM, Unknown::Free);
        let _ = ros(YAML, &bytes, Unknown::Free);
    }

    #[test]
    fn no_damage_makes_a_reader_panic(
        damage in prop::collection::vec((any::<Index>(), any::<u8>()), 1..4),
        length in any::<Index>(),
    ) {
        let yaml = damaged(YAML.as_bytes(), &damage, length);
        let _ = ros(&String::from_utf8_lossy(&yaml), PGM, Unknown::Free);
        let png = png_of(png::ColorType::Grayscale, png::BitDepth::Eight, &[0, 9, 200, 255]);
        for image in [PGM, PLAIN_PGM, &png] {
            let _ = ros(YAML, &damaged(image, &damage, length), Unknown::Free);
        }
    }
}
