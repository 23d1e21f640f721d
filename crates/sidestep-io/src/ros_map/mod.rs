//! ROS `map_server` maps: a YAML file and the PGM or PNG image it names, as an occupancy grid.
//!
//! Source: the `map_server` packages of ROS 1 (wiki.ros.org/map_server) and Nav2 (`nav2_map_server`,
//! `map_io.cpp`). The image's top row is the field's top. `origin` is the pose of the lower left corner of
//! the lower left cell: the map is turned about it by the yaw. Quarter turns are exact; the core's grids
//! lie along the axes, so a map turned by anything else is refused.
//!
//! `occupancy.rs` says which pixels are occupied.

mod occupancy;
mod pgm;
mod png;
mod yaml;

use sidestep::Grid;
use sidestep::plane::world::MAX_GRID_CELLS;

use crate::error::{FormatError, Place, quoted};
use occupancy::{Cells, Occupancy};
use yaml::Header;

/// The format's name in errors.
const IMAGE: &str = "ROS map image";

/// What a cell counts as that the map calls neither occupied nor free.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unknown {
    /// The robot must keep out.
    #[default]
    Occupied,
    /// The robot may go there.
    Free,
}

/// A map as it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct RosMap {
    /// Its cells.
    pub grid: Grid,
    /// What a person should know about how it was read, a sentence each.
    pub warnings: Vec<String>,
}

/// Most that a map may be turned off a quarter turn, in cells at its far end: what rounding of the yaw
/// leaves.
const MOST_TURN: f64 = 0.01;

/// The map of a YAML text; `load` gives the bytes of the image by the name that the YAML says, a path
/// relative to the YAML file unless it is absolute.
///
/// # Errors
/// If the YAML or the image is not what the formats allow, or `load` fails.
pub fn read(
    yaml: &str,
    unknown: Unknown,
    load: impl FnOnce(&str) -> std::io::Result<Vec<u8>>,
) -> Result<RosMap, FormatError> {
    let header = Header::read(yaml)?;
    let bytes = load(&header.image).map_err(|error| {
        let found = format!("{}, which cannot be read ({error})", quoted(&header.image));
        FormatError::new(yaml::FORMAT, Place::field("image"), found, "a PGM or PNG file")
    })?;
    let occupancy = Occupancy::new(&header, unknown);
    let image = read_image(&bytes, &occupancy)?;
    let mut warnings = header.warnings.clone();
    warnings.extend(image.warnings(&header, unknown));
    let (width, height) = (image.width, image.height());
    let turns = quarter_turns(&header, width.max(height))?;
    let (width, cells) = turned(width, image.bottom_row_first(), turns);
    let origin = lower_left(&header, [width, cells.len() / width], turns);
    let height = cells.len() / width;
    let grid = Grid::new(width, height, header.resolution, origin, cells).map_err(|invalid| {
        let field = invalid.field.trim_start_matches("grid.").to_owned();
        FormatError::new(yaml::FORMAT, Place::field(field), invalid.value, invalid.allowed)
    })?;
    Ok(RosMap { grid, warnings })
}

fn read_image(bytes: &[u8], occupancy: &Occupancy) -> Result<Cells, FormatError> {
    match bytes {
        [b'P', b'2' | b'5', ..] => pgm::read(bytes, occupancy),
        [0x89, b'P', b'N', b'G', ..] => png::read(bytes, occupancy),
        _ => {
            let start = bytes[..bytes.len().min(4)].escape_ascii();
            let found = format!("a file that starts with \"{start}\"");
            Err(wrong_image(found, "a PGM (P2 or P5) or PNG image"))
        }
    }
}

/// How many quarters, counter-clockwise, a map of so many cells is turned.
fn quarter_turns(header: &Header, cells: usize) -> Result<u8, FormatError> {
    let yaw = header.yaw;
    let quarters = yaw / std::f64::consts::FRAC_PI_2;
    let off = (quarters - quarters.round()).abs() * std::f64::consts::FRAC_PI_2;
    if off * cells as f64 > MOST_TURN {
        let expected = "a multiple of a quarter turn (0, pi/2, ..): other turned maps are not \
                        supported; turn the image, or plan in the map's own frame with yaw 0";
        return Err(FormatError::new(yaml::FORMAT, header.yaw_place.clone(), yaw, expected));
    }
    Ok(quarters.round().rem_euclid(4.0) as u8)
}

/// The width and cells, the bottom row first, of a grid after so many quarter turns counter-clockwise.
fn turned(width: usize, cells: Vec<bool>, turns: u8) -> (usize, Vec<bool>) {
    let height = cells.len() / width;
    match turns {
        1 => (
            height,
            (0..cells.len())
                .map(|i| cells[(height - 1 - i % height) * width + i / height])
                .collect(),
        ),
        2 => (width, cells.into_iter().rev().collect()),
        3 => (
            height,
            (0..cells.len()).map(|i| cells[i % height * width + width - 1 - i / height]).collect(),
        ),
        _ => (width, cells),
    }
}

/// The lower left corner of a turned map of this size: `origin` is its corner on another side.
fn lower_left(header: &Header, size: [usize; 2], turns: u8) -> [f64; 2] {
    let [x, y] = header.origin;
    let [width, height] = size.map(|cells| cells as f64 * header.resolution);
    match turns {
        1 => [x - width, y],
        2 => [x - width, y - height],
        3 => [x, y - height],
        _ => [x, y],
    }
}

/// Checks a declared size against the cells that a grid may have and those that the file can hold.
fn check_size(
    width: u64,
    height: u64,
    most: u64,
    expected: &str,
    file_length: usize,
) -> Result<(), FormatError> {
    let cells = width.saturating_mul(height);
    let found = format!("{width} x {height} pixels");
    if cells == 0 || cells > MAX_GRID_CELLS as u64 {
        return Err(wrong_image(found, format!("between 1 and {MAX_GRID_CELLS} pixels")));
    }
    if cells > most {
        return Err(wrong_image(
            format!("{found} in a file of {file_length} bytes"),
            format!("{expected}; the file may be cut short"),
        ));
    }
    Ok(())
}

fn wrong_image(found: impl std::fmt::Display, expected: impl Into<String>) -> FormatError {
    FormatError::new(IMAGE, Place::default(), found, expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every quarter turn against a turn of the cells' centres about the origin.
    #[test]
    fn quarter_turns_move_every_cell_where_a_rotation_does() {
        let (width, height) = (5, 3);
        let cells: Vec<bool> = (0..15).map(|i| i % 4 == 0 || i == 7).collect();
        let header = Header { resolution: 0.5, origin: [-2.0, 7.0], ..Header::default() };
        for turns in 0..4u8 {
            let (new_width, new) = turned(width, cells.clone(), turns);
            let size = [new_width, new.len() / new_width];
            let [left, bottom] = lower_left(&header, size, turns);
            for (i, &cell) in cells.iter().enumerate() {
                let (u, v) = ((i % width) as f64 * 0.5 + 0.25, (i / width) as f64 * 0.5 + 0.25);
                let (x, y) = [(u, v), (-v, u), (-u, -v), (v, -u)][usize::from(turns)];
                let column = ((x - 2.0 - left) / 0.5) as usize;
                let row = ((y + 7.0 - bottom) / 0.5) as usize;
                assert!(column < size[0] && row < size[1], "{turns} {i}");
                assert_eq!(new[row * new_width + column], cell, "{turns} {i}");
            }
        }
        assert_eq!(height, 3);
    }
}
