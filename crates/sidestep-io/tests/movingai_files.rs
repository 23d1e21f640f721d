//! MovingAI maps and query lists: values, orientation, bad files.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod refusal;

use proptest::prelude::*;
use proptest::sample::Index;
use refusal::check_refused;
use sidestep::{Grid, Robot};
use sidestep_io::{grid_world, movingai};

const MAP: &[u8] = include_bytes!("fixtures/tiny.map");
const SCEN: &str = include_str!("fixtures/tiny.map.scen");

/// The grid as a person sees it, the top row first.
fn drawn(grid: &Grid) -> Vec<String> {
    let rows = grid.cells().chunks(grid.width()).rev();
    rows.map(|row| row.iter().map(|&cell| if cell { '#' } else { '.' }).collect()).collect()
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
    assert_eq!((&task.start[..], task.name.as_str()), (&[4.5, 1.5][..], "tiny.map"));
    let without_version = SCEN.split_once('\n').unwrap().1.replace('\n', "\r\n");
    assert_eq!(movingai::read_scen(&without_version).unwrap(), queries);
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
        let _ = movingai::read_map(&bytes);
        let _ = movingai::read_scen(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn no_damage_makes_a_reader_panic(
        damage in prop::collection::vec((any::<Index>(), any::<u8>()), 1..4),
        length in any::<Index>(),
    ) {
        let _ = movingai::read_map(&damaged(MAP, &damage, length));
        let scen = damaged(SCEN.as_bytes(), &damage, length);
        let _ = movingai::read_scen(&String::from_utf8_lossy(&scen));
    }
}
