//! The office of `examples/office.yaml`: its floor plan is drawn here, and the committed image must be
//! this drawing. After a change, run this test with SIDESTEP_DRAW_OFFICE=1 to write the image anew.
//!
//! 20 m x 12.5 m in cells of 5 cm: rooms on both sides of a corridor, doors, desks, chairs and tables.

#![allow(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

use std::path::Path;
use std::{env, fs};

use sidestep::plane::geometry::{Circle, Rect};
use sidestep_io::ros_map::{self, Unknown};

const WIDTH: usize = 400;
const HEIGHT: usize = 250;
const CELL: f64 = 0.05;

/// Values of a ROS map: an obstacle, what the robot has seen to be free, what it has not seen.
const BLACK: u8 = 0;
const FREE: u8 = 254;
const UNKNOWN: u8 = 205;

/// `[x0, y0, x1, y1]` in metres from the lower left corner.
type Box = [f64; 4];

const BUILDING: Box = [0.3, 0.3, 19.7, 12.2];

const WALLS: [Box; 13] = [
    [0.3, 0.3, 19.7, 0.5],
    [0.3, 12.0, 19.7, 12.2],
    [0.3, 0.3, 0.5, 12.2],
    [19.5, 0.3, 19.7, 12.2],
    // Both sides of the corridor.
    [0.3, 5.2, 19.7, 5.35],
    [0.3, 7.1, 19.7, 7.25],
    // Between the rooms below it.
    [4.55, 0.3, 4.7, 5.3],
    [8.6, 0.3, 8.75, 5.3],
    [12.65, 0.3, 12.8, 5.3],
    // Between the rooms above it.
    [5.2, 7.2, 5.35, 12.2],
    [9.8, 7.2, 9.95, 12.2],
    // A store and a lift shaft.
    [16.8, 9.9, 16.95, 12.2],
    [16.8, 9.9, 19.7, 10.05],
];

const DOORS: [Box; 10] = [
    [3.3, 5.1, 4.25, 5.4],
    [5.0, 5.1, 5.95, 5.4],
    [11.4, 5.1, 12.35, 5.4],
    [13.2, 5.1, 14.4, 5.4],
    [18.0, 5.1, 18.95, 5.4],
    [1.2, 7.05, 2.15, 7.3],
    [8.5, 7.05, 9.45, 7.3],
    [11.2, 7.05, 13.2, 7.3],
    [8.55, 1.0, 8.8, 1.95],
    [17.4, 9.85, 18.35, 10.1],
];

const FURNITURE: [Box; 31] = [
    // Single offices: desks, shelves.
    [0.5, 1.4, 1.3, 3.0],
    [2.2, 0.5, 3.8, 0.85],
    [0.5, 4.85, 2.3, 5.2],
    [4.7, 2.2, 5.5, 3.8],
    [6.4, 0.5, 8.0, 0.9],
    [7.4, 3.9, 8.6, 4.7],
    [9.3, 3.4, 10.1, 5.0],
    [10.6, 0.5, 12.2, 1.3],
    [11.9, 2.6, 12.65, 4.2],
    // The meeting room: a long table, a sideboard.
    [14.4, 2.0, 17.8, 3.3],
    [13.6, 0.5, 16.0, 0.85],
    // The kitchen: a counter along two walls, a table.
    [0.5, 11.4, 4.2, 12.0],
    [0.5, 9.2, 1.1, 11.4],
    // The lab: benches.
    [5.9, 9.0, 7.0, 11.2],
    [8.0, 8.9, 9.1, 11.2],
    // The open plan: four islands of desks and a wall of lockers.
    [10.6, 10.2, 12.2, 11.6],
    [13.4, 10.2, 15.0, 11.6],
    [10.8, 8.2, 12.4, 9.0],
    [13.6, 8.0, 15.2, 9.4],
    [16.2, 7.25, 17.4, 7.6],
    [19.05, 7.6, 19.5, 9.3],
    // The corridor: a copier, a bench, plants, a row of bins.
    [6.6, 6.55, 7.4, 7.1],
    [9.6, 5.35, 11.0, 5.75],
    [14.9, 6.6, 15.6, 7.1],
    [0.5, 5.9, 0.85, 6.6],
    [16.2, 5.35, 17.2, 5.65],
    // The store: shelves.
    [16.95, 11.55, 19.5, 12.0],
    [19.1, 10.05, 19.5, 11.2],
    [17.2, 10.6, 17.5, 11.55],
    // Boxes that someone left.
    [12.2, 6.2, 12.75, 6.7],
    [2.9, 5.35, 3.2, 5.65],
];

/// Chairs, round tables, pillars and plants: `[x, y, radius]`.
const ROUND: [[f64; 3]; 30] = [
    [1.75, 2.2, 0.27],
    [3.0, 1.3, 0.25],
    [5.95, 3.0, 0.27],
    [7.0, 4.3, 0.26],
    [10.5, 4.2, 0.26],
    [11.4, 1.75, 0.26],
    [14.9, 1.65, 0.24],
    [15.7, 1.6, 0.24],
    [16.5, 1.65, 0.24],
    [17.3, 1.6, 0.24],
    [14.9, 3.65, 0.24],
    [15.7, 3.7, 0.24],
    [16.6, 3.65, 0.24],
    [17.3, 3.75, 0.24],
    [14.0, 2.65, 0.24],
    [18.2, 2.6, 0.24],
    [2.9, 9.3, 0.6],
    [2.0, 9.4, 0.23],
    [3.8, 9.2, 0.23],
    [2.9, 10.2, 0.23],
    [4.85, 7.6, 0.25],
    [7.4, 10.0, 0.22],
    [11.4, 9.75, 0.26],
    [14.2, 9.8, 0.26],
    [11.6, 7.8, 0.25],
    [15.6, 8.7, 0.26],
    [10.3, 11.0, 0.24],
    [15.5, 10.9, 0.26],
    [19.2, 5.65, 0.28],
    [8.3, 6.0, 0.3],
];

fn draw() -> Vec<u8> {
    let rect = |b: &Box| Rect::new([b[0], b[1]], [b[2], b[3]]).unwrap();
    let [walls, doors, furniture] =
        [&WALLS[..], &DOORS, &FURNITURE].map(|list| list.iter().map(rect).collect::<Vec<_>>());
    let building = rect(&BUILDING);
    let round = ROUND.map(|c| Circle::new([c[0], c[1]], c[2]).unwrap());
    let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
    for row in (0..HEIGHT).rev() {
        for column in 0..WIDTH {
            let p = [(column as f64 + 0.5) * CELL, (row as f64 + 0.5) * CELL];
            let within = |rects: &[Rect]| rects.iter().any(|rect| rect.contains(p));
            let solid = within(&furniture) || round.iter().any(|c| c.signed_distance(p) < 0.0);
            let wall = within(&walls) && !within(&doors);
            pixels.push(match () {
                () if !building.contains(p) => UNKNOWN,
                () if wall || solid => BLACK,
                () => FREE,
            });
        }
    }
    pixels
}

fn encode(pixels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, WIDTH as u32, HEIGHT as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(pixels).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn the_committed_map_is_this_drawing() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let pixels = draw();
    if env::var_os("SIDESTEP_DRAW_OFFICE").is_some() {
        fs::write(examples.join("office.png"), encode(&pixels)).unwrap();
    }
    let yaml = fs::read_to_string(examples.join("office.yaml")).unwrap();
    for (unknown, free) in [(Unknown::Occupied, &[FREE][..]), (Unknown::Free, &[FREE, UNKNOWN])] {
        let grid =
            ros_map::read(&yaml, unknown, |name| fs::read(examples.join(name))).unwrap().grid;
        assert_eq!((grid.width(), grid.height(), grid.resolution()), (WIDTH, HEIGHT, CELL));
        let rows = pixels.chunks(WIDTH).rev().flatten();
        let drawn: Vec<bool> = rows.map(|pixel| !free.contains(pixel)).collect();
        assert!(grid.cells() == drawn, "the image differs from the drawing ({unknown:?})");
    }
}

/// One place in every room, and both ends of the corridor.
const PLACES: [[f64; 2]; 9] = [
    [2.0, 3.8],
    [6.5, 2.0],
    [10.9, 2.7],
    [13.5, 1.5],
    [1.8, 8.2],
    [7.5, 8.0],
    [12.8, 9.5],
    [18.5, 11.2],
    [18.6, 6.2],
];

/// Floods the cells where a disc of 0.3 m fits (by the centres of the cells around it).
#[test]
fn a_robot_fits_through_every_door() {
    let pixels = draw();
    let free = |column: usize, row: usize| pixels[(HEIGHT - 1 - row) * WIDTH + column] == FREE;
    let fits = |column: usize, row: usize| {
        let reach = (0.3 / CELL) as usize;
        (row - reach..=row + reach).all(|r| {
            (column - reach..=column + reach).all(|c| {
                let far = c.abs_diff(column).pow(2) + r.abs_diff(row).pow(2) > reach * reach;
                far || free(c, r)
            })
        })
    };
    let cell = |p: [f64; 2]| ((p[0] / CELL) as usize, (p[1] / CELL) as usize);
    let mut reached = vec![false; WIDTH * HEIGHT];
    let mut open = vec![cell(PLACES[0])];
    while let Some((column, row)) = open.pop() {
        // The building's margin is wider than the disc, so no neighbour leaves the image.
        if !reached[row * WIDTH + column] && fits(column, row) {
            reached[row * WIDTH + column] = true;
            open.extend([
                (column + 1, row),
                (column - 1, row),
                (column, row + 1),
                (column, row - 1),
            ]);
        }
    }
    for place in PLACES {
        let (column, row) = cell(place);
        assert!(reached[row * WIDTH + column], "{place:?}");
    }
}
