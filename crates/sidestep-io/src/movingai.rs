//! MovingAI benchmark files: `.map` grids and `.scen` query lists.
//!
//! Source: N. Sturtevant, "Benchmarks for Grid-Based Pathfinding", IEEE Transactions on Computational
//! Intelligence and AI in Games, 2012, DOI 10.1109/TCIAIG.2012.2197681; formats as on movingai.com.
//!
//! The files count rows from the top, the core from the bottom: file row `r` of a map of height `h` is
//! our row `h - 1 - r`. A cell is one task unit, the map's lower left corner is the origin, and a query's
//! start and goal are the centres of their cells.
//!
//! `.`, `G` (ground) and `S` (swamp) are free; `@`, `O` (out of bounds), `T` (trees) and `W` (water) are
//! occupied. The benchmark lets water be crossed from water only, which a single robot on land never is.

use std::sync::Arc;

use sidestep::plane::geometry::Point;
use sidestep::plane::world::MAX_GRID_CELLS;
use sidestep::{Grid, Robot, Task, World};

use crate::error::{FormatError, Place, quoted};
use crate::input::{decode, without_mark};

const MAP: &str = "MovingAI map";
const SCEN: &str = "MovingAI scen";

/// One line of a `.scen` file, in our coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Query {
    /// Difficulty class: the octile length divided by 4, rounded down.
    pub bucket: u32,
    /// The map as the file names it, often with folders before it.
    pub map: String,
    /// Number of columns of the map that the query was made for.
    pub width: usize,
    /// Number of rows of that map.
    pub height: usize,
    /// Centre of the start cell.
    pub start: Point,
    /// Centre of the goal cell.
    pub goal: Point,
    /// Length of the shortest path on the 8-connected grid without cut corners.
    pub octile_length: f64,
}

impl Query {
    /// The map's file name without folders: the map lies beside the `.scen` file under this name.
    pub fn map_file_name(&self) -> &str {
        self.map.rsplit(['/', '\\']).next().unwrap_or(&self.map)
    }

    /// The query as a task in the map's world.
    ///
    /// # Errors
    /// If the world's grid has not the size that the query was made for.
    pub fn task(&self, world: &Arc<World>, robot: Robot) -> Result<Task, FormatError> {
        let size = world.grid().map_or((0, 0), |grid| (grid.width(), grid.height()));
        if size != (self.width, self.height) {
            return Err(FormatError::new(
                SCEN,
                Place::field("width x height"),
                format!("{} x {}", self.width, self.height),
                format!("{} x {}, the size of the map {}", size.0, size.1, quoted(&self.map)),
            ));
        }
        Task::in_plane(self.map_file_name(), Arc::clone(world), robot, self.start, self.goal)
            .map_err(|invalid| {
                FormatError::new(SCEN, Place::field(invalid.field), invalid.value, invalid.allowed)
            })
    }
}

/// The grid of a `.map` file.
///
/// # Errors
/// If the header or a row is not what the format allows; a declared size is held against the file's
/// real size before anything is allocated for it.
pub fn read_map(bytes: &[u8]) -> Result<Grid, FormatError> {
    let text = decode(MAP, bytes)?;
    let bytes = text.as_bytes();
    let mut lines = bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii_end).enumerate();
    let (mut width, mut height) = (None, None);
    loop {
        let Some((index, line)) = lines.next() else {
            return Err(FormatError::new(MAP, Place::default(), "no line \"map\"", HEADER));
        };
        let place = Place::line(index + 1);
        let text = String::from_utf8_lossy(line);
        let words: Vec<&str> = text.split_whitespace().collect();
        match words.as_slice() {
            ["map"] => break,
            ["type", "octile"] => {}
            ["type", other] => {
                return Err(FormatError::new(
                    MAP,
                    place.with_field("type"),
                    quoted(other),
                    "octile",
                ));
            }
            ["width", value] => width = Some(size(place, "width", value)?),
            ["height", value] => height = Some(size(place, "height", value)?),
            [] => {}
            _ => return Err(FormatError::new(MAP, place, quoted(&text), HEADER)),
        }
    }
    let missing = |field| FormatError::new(MAP, Place::field(field), "no such line", HEADER);
    let width = width.ok_or_else(|| missing("width"))?;
    let height = height.ok_or_else(|| missing("height"))?;
    // Every cell takes a byte of the file, so this also bounds the allocation.
    if width.checked_mul(height).is_none_or(|cells| cells > bytes.len()) {
        return Err(FormatError::new(
            MAP,
            Place::field("width x height"),
            format!("{width} x {height} cells in a file of {} bytes", bytes.len()),
            "at most as many cells as the file has bytes",
        ));
    }
    let mut occupied = vec![false; width * height];
    for row in (0..height).rev() {
        let Some((index, line)) = lines.next() else {
            return Err(FormatError::new(
                MAP,
                Place::field("map"),
                format!("{} rows", height - 1 - row),
                format!("height = {height} rows"),
            ));
        };
        let place = Place::line(index + 1);
        if line.len() != width {
            let found = format!("a row of {} cells", line.len());
            return Err(FormatError::new(MAP, place, found, format!("width = {width} cells")));
        }
        for (column, &byte) in line.iter().enumerate() {
            occupied[row * width + column] = match byte {
                b'.' | b'G' | b'S' => false,
                b'@' | b'O' | b'T' | b'W' => true,
                _ => {
                    return Err(FormatError::new(
                        MAP,
                        place.with_column(column + 1),
                        format!("the cell {:?}", byte.escape_ascii().to_string()),
                        "one of . G S (free) or @ O T W (occupied)",
                    ));
                }
            };
        }
    }
    if let Some((index, _)) = lines.find(|(_, line)| !line.is_empty()) {
        let expected = format!("nothing after height = {height} rows");
        return Err(FormatError::new(MAP, Place::line(index + 1), "another row", expected));
    }
    Grid::new(width, height, 1.0, [0.0, 0.0], occupied).map_err(|invalid| {
        FormatError::new(MAP, Place::field(invalid.field), invalid.value, invalid.allowed)
    })
}

const HEADER: &str = "the lines \"type octile\", \"height H\", \"width W\" and \"map\"";

fn size(place: Place, field: &str, value: &str) -> Result<usize, FormatError> {
    match value.parse() {
        Ok(size) if (1..=MAX_GRID_CELLS).contains(&size) => Ok(size),
        _ => Err(FormatError::new(
            MAP,
            place.with_field(field),
            quoted(value),
            format!("a whole number from 1 to {MAX_GRID_CELLS}"),
        )),
    }
}

/// The queries of a `.scen` file of version 1, in the file's order; the line `version 1` may be missing.
///
/// # Errors
/// If a line is not `bucket map width height start-x start-y goal-x goal-y length`, separated by tabs or
/// spaces, or a cell lies outside the declared size.
pub fn read_scen(text: &str) -> Result<Vec<Query>, FormatError> {
    let mut queries = Vec::new();
    for (index, line) in without_mark(text).lines().enumerate() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            [] => {}
            ["version", "1" | "1.0"] => {}
            ["version", version @ ..] => {
                let place = Place::line(index + 1).with_field("version");
                return Err(FormatError::new(SCEN, place, quoted(&version.join(" ")), "1"));
            }
            _ => queries.push(query(index + 1, &words)?),
        }
    }
    Ok(queries)
}

fn query(line: usize, words: &[&str]) -> Result<Query, FormatError> {
    // Nine fields; only the map's name may hold spaces, so the last seven count from the end.
    let [bucket, name @ .., width, height, start_x, start_y, goal_x, goal_y, length] = words else {
        return Err(wrong_fields(line, words));
    };
    if name.is_empty() {
        return Err(wrong_fields(line, words));
    }
    let at = |field: &str| Place::line(line).with_field(field);
    let whole = |field: &str, word: &str, below: usize| match word.parse::<usize>() {
        Ok(value) if value < below => Ok(value),
        _ => Err(FormatError::new(
            SCEN,
            at(field),
            quoted(word),
            format!("a whole number from 0 to {}", below - 1),
        )),
    };
    let bucket = whole("bucket", bucket, u32::MAX as usize)? as u32;
    let side = |field: &str, word: &str| match whole(field, word, MAX_GRID_CELLS + 1)? {
        0 => Err(FormatError::new(SCEN, at(field), "0", "a whole number of at least 1")),
        side => Ok(side),
    };
    let (width, height) = (side("width", width)?, side("height", height)?);
    let centre = |names: [&str; 2], x: &str, y: &str| -> Result<Point, FormatError> {
        let (column, row) = (whole(names[0], x, width)?, whole(names[1], y, height)?);
        Ok([column as f64 + 0.5, (height - 1 - row) as f64 + 0.5])
    };
    let octile_length = match length.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => value,
        _ => {
            let expected = "a finite number of at least 0";
            return Err(FormatError::new(SCEN, at("length"), quoted(length), expected));
        }
    };
    Ok(Query {
        bucket,
        map: name.join(" "),
        width,
        height,
        start: centre(["start x", "start y"], start_x, start_y)?,
        goal: centre(["goal x", "goal y"], goal_x, goal_y)?,
        octile_length,
    })
}

fn wrong_fields(line: usize, words: &[&str]) -> FormatError {
    FormatError::new(
        SCEN,
        Place::line(line),
        format!("{} fields", words.len()),
        "9 fields: bucket, map, width, height, start x, start y, goal x, goal y, length",
    )
}
