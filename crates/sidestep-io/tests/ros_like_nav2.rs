//! ROS maps read as Nav2 reads them: every grey under every mode and threshold against the formula as its
//! server has it, and every way that people's tools write a header.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use proptest::prelude::*;
use sidestep_io::ros_map::{self, RosMap, Unknown};

const YAML: &str = "image: a.pgm\nresolution: 0.5\norigin: [0, 0, 0]\nnegate: 0\n\
    occupied_thresh: 0.65\nfree_thresh: 0.196\n";

fn read(yaml: &str, image: &[u8], unknown: Unknown) -> RosMap {
    ros_map::read(yaml, unknown, |_| Ok(image.to_vec())).unwrap()
}

/// What a map server publishes for a grey: 0 free, 100 occupied, -1 unknown, and in between with `scale`.
fn published(mode: &str, negate: bool, occupied: f32, free: f32, grey: u8) -> i32 {
    if mode == "raw" {
        return if grey <= 100 { i32::from(grey) } else { -1 };
    }
    let shade = f32::from(grey) / 255.0f32;
    let occupancy = if negate { shade } else { 1.0f32 - shade };
    let mut value = -1;
    if occupancy >= occupied {
        value = 100;
    }
    if occupancy <= free {
        value = 0;
    }
    if mode == "scale" && occupancy > free && occupancy < occupied {
        value = (100.0 * (occupancy - free) / (occupied - free)).round() as i32;
    }
    value
}

proptest! {
    #[test]
    fn every_grey_is_what_nav2_publishes(
        mode in prop_oneof![Just("trinary"), Just("scale"), Just("raw")],
        negate in any::<bool>(),
        // Ends, thresholds that a grey meets exactly, and any.
        thresholds in prop_oneof![
            Just((0.0, 1.0)), Just((0.196, 0.65)), Just((0.25, 0.65)), Just((0.01, 0.99)),
            (0u8..=255, 0u8..=255).prop_map(|(a, b)| (f64::from(a.min(b)) / 255.0, f64::from(a.max(b)) / 255.0)),
            (0u8..=20, 0u8..=20).prop_map(|(a, b)| (f64::from(a.min(b)) / 20.0, f64::from(a.max(b)) / 20.0)),
        ],
    ) {
        let (free, occupied) = thresholds;
        let mut image = b"P5\n256 1\n255\n".to_vec();
        image.extend(0..=255u8);
        let yaml = format!(
            "image: a.pgm\nresolution: 1\norigin: [0, 0, 0]\nnegate: {negate}\nmode: {mode}\n\
             occupied_thresh: {occupied}\nfree_thresh: {free}\n"
        );
        let kept_out = read(&yaml, &image, Unknown::Occupied);
        let let_in = read(&yaml, &image, Unknown::Free);
        for grey in 0..=255u8 {
            let is = [&kept_out, &let_in].map(|map| map.grid.cells()[usize::from(grey)]);
            let value = published(mode, negate, occupied as f32, free as f32, grey);
            let expected = match (mode, value) {
                (_, -1) => [true, false],
                // The percentages of a raw map meet the same thresholds, free first.
                ("raw", percent) if percent as f32 / 100.0 <= free as f32 => [false, false],
                ("raw", percent) if percent as f32 / 100.0 >= occupied as f32 => [true, true],
                // Nav2's cost in between is neither free nor occupied.
                ("raw", _) => [true, false],
                (_, _) if !negate && 1.0 - f32::from(grey) / 255.0 <= free as f32 => [false, false],
                (_, _) if negate && f32::from(grey) / 255.0 <= free as f32 => [false, false],
                (_, 100) if !negate && 1.0 - f32::from(grey) / 255.0 >= occupied as f32 => [true, true],
                (_, 100) if negate && f32::from(grey) / 255.0 >= occupied as f32 => [true, true],
                (_, _) => [true, false],
            };
            prop_assert_eq!(is, expected, "{} {} {} {}", mode, negate, grey, value);
        }
    }

    /// Whatever white space and comments stand in the header, and whatever stands after the pixels, the
    /// pixels are those that were written.
    #[test]
    fn no_header_shifts_a_pixel(
        width in 1usize..6,
        height in 1usize..6,
        deep in any::<bool>(),
        pixels in prop::collection::vec(prop_oneof![Just(0u8), Just(205), Just(254), Just(35), Just(13)], 36),
        separators in prop::collection::vec(
            prop_oneof![
                Just(" "), Just("\n"), Just("\r\n"), Just("\n# made by hand\n"), Just("\r\n# x\r\n"), Just("\t "),
            ],
            4
        ),
        after in prop_oneof![Just(""), Just("P5 1 1 255 x")],
    ) {
        let values = &pixels[..width * height];
        let [a, b, c, d] = <[&str; 4]>::try_from(separators).unwrap();
        let white = if deep { "65535" } else { "255" };
        let mut image = format!("P5{a}{width}{b}{height}{c}{white}{d}").into_bytes();
        for &value in values {
            image.extend(std::iter::repeat_n(value, if deep { 2 } else { 1 }));
        }
        image.extend(after.as_bytes());
        match ros_map::read(YAML, Unknown::Occupied, |_| Ok(image.clone())) {
            Ok(map) => {
                let occupied: Vec<bool> = values.iter().map(|&v| v != 254).collect();
                let rows: Vec<&[bool]> = map.grid.cells().chunks(width).rev().collect();
                prop_assert_eq!(rows.concat(), occupied);
                prop_assert_eq!(map.warnings.is_empty(), after.is_empty());
            }
            // Refused where it cannot be told: white space or a comment beyond the one byte, and more after
            // the pixels, or pixels that look like white space.
            Err(error) => {
                let doubtful = d.len() > 1 && d != "\r\n" || values[0] == b'#';
                let more = !after.is_empty() || values.last() == Some(&b'\r');
                prop_assert!(doubtful && more, "{}", error);
            }
        }
    }

    /// Cutting an image short anywhere is an error, whatever its header is like.
    #[test]
    fn a_short_file_is_refused(
        sep in prop_oneof![Just("\n"), Just("\r\n"), Just(" ")],
        plain in any::<bool>(),
        missing in 1usize..12,
    ) {
        let image = if plain {
            format!("P2{sep}4{sep}3{sep}255{sep}0 1 2 3 0 1 2 3 0 1 2 3").into_bytes()
        } else {
            let mut image = format!("P5{sep}4{sep}3{sep}255{sep}").into_bytes();
            image.extend([254; 12]);
            image
        };
        let missing = if plain { 2 * missing } else { missing };
        let cut = image[..image.len() - missing].to_vec();
        prop_assert!(ros_map::read(YAML, Unknown::Free, |_| Ok(cut)).is_err());
    }
}

#[test]
fn largest_values_other_than_255_are_scaled() {
    for (image, expected) in [
        ("P2 3 1 1 0 1 0", [true, false, true]),
        ("P2 3 1 100 0 100 50", [true, false, true]),
        ("P2 3 1 15 0 15 13", [true, false, false]),
        ("P2 3 1 65535 0 65535 60000", [true, false, false]),
        (
            "P2 # first\n3 1 # size\n255 # white\n0 254 # black, free\n 255 # the last\n",
            [true, false, false],
        ),
    ] {
        let map = read(YAML, image.as_bytes(), Unknown::Occupied);
        assert_eq!(map.grid.cells(), expected, "{image}");
        assert_eq!(map.warnings, [""; 0], "{image}");
    }
}

#[test]
fn what_is_guessed_is_said() {
    let image = b"P2 4 1 255 0 205 205 254";
    let blue = {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Rgb);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&[0, 0, 255, 254, 254, 254]).unwrap();
        writer.finish().unwrap();
        bytes
    };
    for (from, to, image, warning) in [
        ("0.196", "0.196", &image[..], ""),
        ("0.196", "0.25", image, "free_thresh = 0.25 makes 2 pixels of grey 205 free"),
        ("negate: 0", "negate: 1", image, ""),
        ("negate", "mode: scale\nnegate", image, "mode scale: 2 pixels lie between the thresholds"),
        ("0, 0, 0", "0, 0", image, "origin has two numbers"),
        ("0.196", "0.196", b"P2 1 1 255 254\n\n", ""),
        ("0.196", "0.196", b"P5 1 1 255 a\r\n", "2 bytes of white space after the last pixel"),
        ("0.196", "0.196", b"P5 1 1 255 aP5 1 1 255 a", "holds several images"),
        ("0.196", "0.196", &blue, "1 pixels are coloured"),
    ] {
        let warnings = read(&YAML.replace(from, to), image, Unknown::Occupied).warnings;
        match warning {
            "" => assert_eq!(warnings, [""; 0], "{to}"),
            _ => assert!(warnings.len() == 1 && warnings[0].contains(warning), "{warnings:?}"),
        }
    }
}

#[test]
fn turned_maps() {
    let image = b"P2 2 1 255 0 254";
    for (yaw, size, origin, cells) in [
        ("1e-17", (2, 1), [3.0, 4.0], [true, false]),
        ("6.283185307179586", (2, 1), [3.0, 4.0], [true, false]),
        ("-6.2832", (2, 1), [3.0, 4.0], [true, false]),
        ("1.5707963", (1, 2), [2.5, 4.0], [true, false]),
        ("3.14159", (2, 1), [2.0, 3.5], [false, true]),
        ("-1.5708", (1, 2), [3.0, 3.0], [false, true]),
    ] {
        let yaml = YAML.replace("[0, 0, 0]", &format!("[3, 4, {yaw}]"));
        let grid = read(&yaml, image, Unknown::Occupied).grid;
        assert_eq!((grid.width(), grid.height()), size, "{yaw}");
        assert_eq!((grid.origin(), grid.cells()), (origin, &cells[..]), "{yaw}");
    }
    for yaw in ["0.1", "1.5", "-nan", "nan", ".inf", "east"] {
        let yaml = YAML.replace("[0, 0, 0]", &format!("[3, 4, {yaw}]"));
        let error = ros_map::read(&yaml, Unknown::Free, |_| Ok(image.to_vec())).unwrap_err();
        assert!(error.to_string().contains("line 3, column 16, origin[2] (yaw)"), "{error}");
    }
}

#[test]
fn a_colour_profile_is_not_unpacked() {
    // 300 MB of zeros in an iCCP chunk would take a second and the memory.
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header().unwrap();
    // Not even a valid one: nobody looks.
    writer.write_chunk(png::chunk::iCCP, b"name\0\0broken").unwrap();
    writer.write_chunk(png::chunk::zTXt, b"name\0\0broken").unwrap();
    writer.write_image_data(&[254]).unwrap();
    writer.finish().unwrap();
    assert_eq!(read(YAML, &bytes, Unknown::Occupied).grid.cells(), [false]);
}
