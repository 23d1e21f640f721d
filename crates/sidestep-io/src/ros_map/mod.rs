//! ROS `map_server` maps: a YAML file and the PGM or PNG image it names, as an occupancy grid.
//!
//! Source: the `map_server` packages of ROS 1 (wiki.ros.org/map_server) and Nav2 (`nav2_map_server`,
//! `map_io.cpp`). With `v` a pixel's brightness in `[0, 1]`, its occupancy is `p = 1 - v`, or `p = v`
//! with `negate`. A cell is occupied if `p > occupied_thresh`, free if `p < free_thresh`, and otherwise
//! unknown. `trinary` and `scale` maps differ only in the grey values in between, which are unknown here.
//! In a `raw` map a pixel of value 0 to 100 is an occupancy in percent, to which the same thresholds
//! apply, and a larger one is unknown; `negate` has no say there, as in Nav2. A pixel of an image with
//! transparency is unknown unless it is opaque; a coloured one counts by the mean of its channels.
//!
//! The image's top row is the field's top. `origin` is the pose of the lower left corner of the lower
//! left cell; a turned map (yaw not 0) is refused, since the core's grids lie along the axes.

mod pgm;
mod png;
mod yaml;

use sidestep::Grid;
use sidestep::plane::world::MAX_GRID_CELLS;

use crate::error::{FormatError, Place};
use yaml::{Header, Mode};

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

/// The grid of a map, from its YAML text; `load` gives the bytes of the image by the name that the YAML
/// says, a path relative to the YAML file unless it is absolute.
///
/// # Errors
/// If the YAML or the image is not what the formats allow, or `load` fails.
pub fn read(
    yaml: &str,
    unknown: Unknown,
    load: impl FnOnce(&str) -> std::io::Result<Vec<u8>>,
) -> Result<Grid, FormatError> {
    let header = Header::read(yaml)?;
    let bytes = load(&header.image).map_err(|error| {
        let found = format!("{:?}, which cannot be read ({error})", header.image);
        FormatError::new(yaml::FORMAT, Place::field("image"), found, "a PGM or PNG file")
    })?;
    let Image { width, cells } = read_image(&bytes, &|shade| match header.occupancy(shade) {
        Some(p) if p > header.occupied_thresh => true,
        Some(p) if p < header.free_thresh => false,
        _ => unknown == Unknown::Occupied,
    })?;
    let height = cells.len() / width;
    // The image's top row first becomes the grid's bottom row first.
    let cells = cells.chunks(width).rev().flatten().copied().collect();
    Grid::new(width, height, header.resolution, header.origin, cells).map_err(|invalid| {
        let field = invalid.field.trim_start_matches("grid.").to_owned();
        FormatError::new(yaml::FORMAT, Place::field(field), invalid.value, invalid.allowed)
    })
}

/// A pixel: its value and the value of white.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shade {
    value: u16,
    white: u16,
    opaque: bool,
}

/// Which pixels are occupied, the top row first. Pixels become cells as they are read, since a map may
/// have hundreds of millions.
struct Image {
    width: usize,
    cells: Vec<bool>,
}

fn read_image(bytes: &[u8], occupied: &dyn Fn(Shade) -> bool) -> Result<Image, FormatError> {
    match bytes {
        [b'P', b'2' | b'5', ..] => pgm::read(bytes, occupied),
        [0x89, b'P', b'N', b'G', ..] => png::read(bytes, occupied),
        _ => {
            let start = bytes[..bytes.len().min(4)].escape_ascii();
            let found = format!("a file that starts with \"{start}\"");
            Err(wrong_image(found, "a PGM (P2 or P5) or PNG image"))
        }
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

impl Header {
    /// The occupancy that a pixel stands for, in `[0, 1]`; `None` if the pixel says unknown.
    fn occupancy(&self, shade: Shade) -> Option<f64> {
        let Shade { value, white, opaque } = shade;
        let brightness = f64::from(value) / f64::from(white);
        match self.mode {
            _ if !opaque => None,
            Mode::Raw => {
                let percent = (brightness * 255.0).round();
                (percent <= 100.0).then_some(percent / 100.0)
            }
            // As whole numbers first, so that the borders are those of the formula (255 - v) / 255.
            _ if self.negate => Some(brightness),
            _ => Some(f64::from(white - value) / f64::from(white)),
        }
    }
}
