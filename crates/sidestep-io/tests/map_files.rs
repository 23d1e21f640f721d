//! The map readers on the fixtures of this crate: values, orientation, thresholds, bad files.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::io;

use proptest::prelude::*;
use sidestep::{Grid, Robot};
use sidestep_io::benchmarks::{barn, mpnet::Simple2d};
use sidestep_io::ros_map::Unknown;
use sidestep_io::{FormatError, grid_world, movingai, ros_map};

const MAP: &[u8] = include_bytes!("fixtures/tiny.map");
const SCEN: &str = include_str!("fixtures/tiny.map.scen");
const YAML: &str = include_str!("fixtures/room.yaml");
const PGM: &[u8] = include_bytes!("fixtures/room.pgm");
const PLAIN_PGM: &[u8] = include_bytes!("fixtures/room_plain.pgm");

/// The grid as a person sees it, the top row first.
fn drawn(grid: &Grid) -> Vec<String> {
    let rows = grid.cells().chunks(grid.width()).rev();
    rows.map(|row| row.iter().map(|&cell| if cell { '#' } else { '.' }).collect()).collect()
}

fn ros(yaml: &str, image: &[u8], unknown: Unknown) -> Result<Grid, FormatError> {
    ros_map::read(yaml, unknown, |_| Ok(image.to_vec()))
}

#[track_caller]
fn check_refused<T: std::fmt::Debug>(result: Result<T, FormatError>, message: &str) {
    let error = result.unwrap_err().to_string();
    assert!(error.contains(message), "     got: {error}\nexpected: {message}");
}

#[test]
fn movingai_map_and_queries() {
    let grid = movingai::read_map(MAP).unwrap();
    assert_eq!(drawn(&grid), ["######", "#...##", "#..#.#", "######"]);
    assert_eq!((grid.resolution(), grid.origin()), (1.0, [0.0, 0.0]));
    let world = grid_world(grid);
    assert_eq!(world.bounds().max, [6.0, 4.0]);

    let queries = movingai::read_scen(SCEN).unwrap();
    assert_eq!(queries.len(), 2);
    assert_eq!((queries[0].map.as_str(), queries[0].bucket), ("maps/made up/tiny.map", 0));
    assert_eq!(queries[0].map_file_name(), "tiny.map");
    // Row 1 from the top of 4 is row 2 from the bottom.
    assert_eq!((queries[0].start, queries[0].goal), ([1.5, 2.5], [3.5, 2.5]));
    assert_eq!((queries[1].start, queries[1].goal), ([4.5, 1.5], [1.5, 1.5]));
    assert_eq!(queries[1].octile_length, 4.82842712);
    let task = queries[1].task(&world, Robot::Point).unwrap();
    assert_eq!((task.start, task.name.as_str()), ([4.5, 1.5], "tiny.map"));
    let without_version = SCEN.split_once('\n').unwrap().1.replace('\n', "\r\n");
    assert_eq!(movingai::read_scen(&without_version).unwrap(), queries);
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
fn bad_movingai_files() {
    let map = |text: &str| movingai::read_map(text.as_bytes());
    let huge = format!("type octile\nheight 100000\nwidth 100000\nmap\n{}", ".".repeat(1000));
    for (text, message) in [
        (
            huge.as_str(),
            "MovingAI map, width x height: found 100000 x 100000 cells in a file of 1043 bytes",
        ),
        ("", "MovingAI map: found no line \"map\""),
        ("type quad\n", "line 1, type: found \"quad\"; expected octile"),
        (
            "type octile\nheight -3\n",
            "line 2, height: found \"-3\"; expected a whole number from 1 to 268435456",
        ),
        ("type octile\nheight 0\n", "line 2, height: found \"0\""),
        ("type octile\nheight 18446744073709551615\n", "line 2, height"),
        ("type octile\nheight 3\nmap\n", "MovingAI map, width: found no such line"),
        ("P5 whatever", "line 1: found \"P5 whatever\"; expected the lines \"type octile\""),
        (
            "height 2\nwidth 3\nmap\n...\n..\n",
            "line 5: found a row of 2 cells; expected width = 3 cells",
        ),
        (
            "height 2\nwidth 3\nmap\n...\n",
            "line 5: found a row of 0 cells; expected width = 3 cells",
        ),
        ("height 2\nwidth 3\nmap\n...", "map: found 1 rows; expected height = 2 rows"),
        (
            "height 1\nwidth 3\nmap\n.x.",
            "line 4, column 2: found the cell \"x\"; expected one of . G S",
        ),
        (
            "height 1\nwidth 3\nmap\n...\n...",
            "line 5: found another row; expected nothing after height = 1 rows",
        ),
    ] {
        check_refused(map(text), message);
    }
    for (text, message) in [
        ("version 2\n", "MovingAI scen, line 1, version: found \"2\"; expected 1"),
        ("0 a.map 5 5 1 1", "line 1: found 6 fields; expected 9 fields"),
        ("1 2 3 4 5 6 7 8", "line 1: found 8 fields; expected 9 fields"),
        ("version 1\n-1 a.map 5 5 1 1 1 1 0", "line 2, bucket: found \"-1\""),
        ("0 a.map 0 5 1 1 1 1 0", "line 1, width: found 0; expected a whole number of at least 1"),
        (
            "0 a.map 5 5 1 5 1 1 0",
            "line 1, start y: found \"5\"; expected a whole number from 0 to 4",
        ),
        ("0 a.map 5 5 1 1 1.5 1 0", "line 1, goal x: found \"1.5\""),
        (
            "0 a.map 5 5 1 1 1 1 nan",
            "line 1, length: found \"nan\"; expected a finite number of at least 0",
        ),
    ] {
        check_refused(movingai::read_scen(text), message);
    }
    let query = &movingai::read_scen("0 a.map 5 5 1 1 1 1 0").unwrap()[0];
    let world = grid_world(movingai::read_map(MAP).unwrap());
    let message = "found 5 x 5; expected 6 x 4, the size of the map \"a.map\"";
    check_refused(query.task(&world, Robot::Point), message);
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
        ("resolution: 0.05", "resolution: .nan", "resolution: found NaN; expected a finite number"),
        ("resolution: 0.05", "resolution: .inf", "resolution: found inf; expected a finite number"),
        (
            "resolution: 0.05",
            "resolution: fine",
            "ROS map YAML, line 2, column 13: found a fault (invalid floating point); expected the fields image",
        ),
        (
            "[-1.0, 2.5, 0.0]",
            "[-1.0, 2.5, 0.1]",
            "origin[2] (yaw): found 0.1; expected 0: a turned map is not supported",
        ),
        ("[-1.0, 2.5, 0.0]", "[-1.0, 2.5]", "origin: found 2 numbers; expected [x, y, yaw]"),
        ("[-1.0, 2.5, 0.0]", "[.nan, 2.5, 0]", "origin[0]: found NaN; expected a finite number"),
        ("negate: 0", "negate: 2", "negate: found 2; expected 0 or 1"),
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
        ("negate: 0", "negate: [0]", "(negate must be 0, 1, true or false)"),
        (
            "image",
            "negate: 1\nimage",
            "line 5, column 1: found a fault (duplicate mapping key: negate);",
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

#[test]
fn barn_and_mpnet_files() {
    let text = r#"{"start": [-2, 3], "goal": [-2, 13],
        "worlds": {"10": [[-1, 5, 0.075]], "2": [[-4, 1, 0.5], [0, 1, 0.5]]}}"#;
    let tasks = barn::read(text, 0.2).unwrap();
    let names: Vec<&str> = tasks.iter().map(|task| task.name.as_str()).collect();
    assert_eq!(names, ["barn/2", "barn/10"]);
    assert_eq!(tasks[0].world.bounds().min, [-5.0, 0.0]);
    assert_eq!(tasks[0].world.bounds().max, [1.0, 13.7]);
    for (from, to, message) in [
        (
            "0.075",
            "-1",
            "BARN worlds, line 2, column 27, worlds.10[0]: found -1; expected a number above 0",
        ),
        ("0.075", "1, 2", "worlds.10[0]: found an array of 4; expected a cylinder [x, y, radius]"),
        ("\"10\"", "\"ten\"", "worlds.ten: found ten; expected a world's number"),
        ("start", "begin", "found no field \"start\""),
    ] {
        check_refused(barn::read(&text.replace(from, to), 0.2), message);
    }
    check_refused(
        barn::read(text, -1.0),
        "robot.radius: found -1; expected a number of at least 0",
    );

    let obs: Vec<u8> = (0..40).flat_map(|i| f64::to_le_bytes(f64::from(i % 20 - 10))).collect();
    let row = |last: i32| -> Vec<u8> {
        [0, 1, 2, 3, 4, 5, last].into_iter().flat_map(i32::to_le_bytes).collect()
    };
    let worlds = Simple2d::read(&obs, &row(19)).unwrap();
    assert_eq!((worlds.len(), worlds.world(0).unwrap().obstacles().len()), (1, 7));
    let robot = Robot::disc(0.5).unwrap();
    let task = worlds.task(0, robot, 7).unwrap();
    assert_eq!(task, worlds.task(0, robot, 7).unwrap());
    assert_ne!(task, worlds.task(0, robot, 8).unwrap());
    for p in [task.start, task.goal] {
        assert!(task.world.obstacles().iter().all(|block| block.signed_distance(p) > 0.5));
    }
    check_refused(worlds.world(1), "index: found 1; expected 0 to 0");
    check_refused(worlds.task(0, Robot::disc(19.0).unwrap(), 1), "robot.radius: found 19");
    check_refused(
        Simple2d::read(&obs[..100], &row(1)),
        "obs.dat: found 100 bytes; expected at least 320",
    );
    check_refused(
        Simple2d::read(&obs, &row(20)),
        "obs_perm2.dat[0][6]: found 20; expected a block from 0 to 19",
    );
    check_refused(
        Simple2d::read(&obs, &row(1)[1..]),
        "obs_perm2.dat: found 27 bytes; expected a multiple of 28",
    );
}

proptest! {
    #[test]
    fn no_bytes_make_a_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let text = String::from_utf8_lossy(&bytes);
        let _ = movingai::read_map(&bytes);
        let _ = movingai::read_scen(&text);
        let _ = ros(&text, PGM, Unknown::Free);
        let _ = ros(YAML, &bytes, Unknown::Free);
        let _ = barn::read(&text, 0.1);
        let _ = Simple2d::read(&bytes, &bytes);
    }

    #[test]
    fn no_damage_makes_a_reader_panic(
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        length in any::<prop::sample::Index>(),
    ) {
        let png = png_of(png::ColorType::Grayscale, png::BitDepth::Eight, &[0, 9, 200, 255]);
        let damaged = |file: &[u8]| {
            let mut bytes = file.to_vec();
            for (at, byte) in &damage {
                bytes[at.index(file.len())] = *byte;
            }
            bytes.truncate(length.index(file.len() + 1));
            bytes
        };
        let _ = movingai::read_map(&damaged(MAP));
        let _ = movingai::read_scen(&String::from_utf8_lossy(&damaged(SCEN.as_bytes())));
        let _ = ros(&String::from_utf8_lossy(&damaged(YAML.as_bytes())), PGM, Unknown::Free);
        for image in [PGM, PLAIN_PGM, &png] {
            let _ = ros(YAML, &damaged(image), Unknown::Free);
        }
    }
}
