//! What a robot moves in: bounds, obstacle shapes and at most one occupancy grid.

use std::sync::{Arc, OnceLock};

use crate::error::{InvalidInput, finite, finite_point};
use crate::plane::bit_grid::BitGrid;
use crate::plane::geometry::{Circle, ConvexPolygon, Point, Rect};

/// A solid shape; its inside is forbidden.
#[derive(Debug, Clone, PartialEq)]
pub enum Obstacle {
    /// An axis-aligned rectangle.
    Rect(Rect),
    /// A disc.
    Circle(Circle),
    /// A convex polygon.
    Polygon(ConvexPolygon),
}

impl Obstacle {
    /// Signed distance from `p` to this shape, negative inside.
    pub fn signed_distance(&self, p: Point) -> f64 {
        match self {
            Self::Rect(rect) => rect.signed_distance(p),
            Self::Circle(circle) => circle.signed_distance(p),
            Self::Polygon(polygon) => polygon.signed_distance(p),
        }
    }

    /// Whether `p` lies inside the shape, its border excluded.
    pub fn contains(&self, p: Point) -> bool {
        match self {
            Self::Rect(rect) => (0..2).all(|k| rect.min[k] < p[k] && p[k] < rect.max[k]),
            _ => self.signed_distance(p) < 0.0,
        }
    }

    /// The smallest axis-aligned rectangle around the shape, as `(min, max)`.
    pub fn bounding_box(&self) -> Rect {
        match self {
            Self::Rect(rect) => *rect,
            Self::Circle(Circle { center, radius }) => {
                Rect { min: *center, max: *center }.inflated(*radius)
            }
            Self::Polygon(polygon) => {
                let mut bounds = Rect { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2] };
                for vertex in polygon.vertices() {
                    for axis in 0..2 {
                        bounds.min[axis] = bounds.min[axis].min(vertex[axis]);
                        bounds.max[axis] = bounds.max[axis].max(vertex[axis]);
                    }
                }
                bounds
            }
        }
    }
}

/// An occupancy grid: square cells, row 0 at the bottom, column 0 at the left. Clones share the cells and what was prepared of
/// them.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    width: usize,
    height: usize,
    resolution: f64,
    origin: Point,
    occupied: Arc<Occupied>,
}

/// The cells, and what certificates prepare of them, once for all worlds that share the grid.
#[derive(Debug)]
struct Occupied {
    cells: Vec<bool>,
    bits: OnceLock<Arc<BitGrid>>,
    border: OnceLock<Arc<BitGrid>>,
}

impl PartialEq for Occupied {
    fn eq(&self, other: &Self) -> bool {
        self.cells == other.cells
    }
}

/// The tolerance of fields of 1e4 units and more: some three times the rounding at
/// [`MAX_COORDINATE`](crate::error::MAX_COORDINATE).
const MOST_TOLERANCE: f64 = 1e-5;

/// Most cells that a grid may have (a 16384 x 16384 map).
pub const MAX_GRID_CELLS: usize = 1 << 28;

impl Grid {
    /// A grid of `width x height` cells with side `resolution`, the lower left cell's lower left
    /// corner at `origin`; `occupied` is row-major from the bottom row up.
    ///
    /// # Errors
    /// If a size is zero or too large, the resolution is not positive, or the number of cells differs.
    pub fn new(
        width: usize,
        height: usize,
        resolution: f64,
        origin: Point,
        occupied: Vec<bool>,
    ) -> Result<Self, InvalidInput> {
        let cells = width.checked_mul(height).filter(|&n| n > 0 && n <= MAX_GRID_CELLS);
        let Some(cells) = cells else {
            return Err(InvalidInput::new(
                "grid",
                format!("{width} x {height} cells"),
                format!("between 1 and {MAX_GRID_CELLS} cells"),
            ));
        };
        finite("grid.resolution", resolution)?;
        finite_point("grid.origin", origin)?;
        if resolution <= 0.0 {
            return Err(InvalidInput::new("grid.resolution", resolution, "a number above 0"));
        }
        if occupied.len() != cells {
            return Err(InvalidInput::new(
                "grid.cells",
                format!("{} cells", occupied.len()),
                format!("width x height = {cells}"),
            ));
        }
        let far = [origin[0] + width as f64 * resolution, origin[1] + height as f64 * resolution];
        finite_point("grid.origin + size", far)?;
        let (bits, border) = (OnceLock::new(), OnceLock::new());
        let occupied = Arc::new(Occupied { cells: occupied, bits, border });
        Ok(Self { width, height, resolution, origin, occupied })
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Side of a cell, in task units.
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Lower left corner of the lower left cell.
    pub fn origin(&self) -> Point {
        self.origin
    }

    /// All cells, row-major from the bottom row up; `true` is occupied.
    pub fn cells(&self) -> &[bool] {
        &self.occupied.cells
    }

    /// The cells as bits.
    pub(crate) fn bits(&self) -> &Arc<BitGrid> {
        let pack = || Arc::new(BitGrid::from_bools(self.width, self.height, self.cells()));
        self.occupied.bits.get_or_init(pack)
    }

    /// Occupied cells beside a free one.
    pub(crate) fn border(&self) -> &Arc<BitGrid> {
        self.occupied.border.get_or_init(|| Arc::new(self.bits().border()))
    }

    /// Whether the cell is occupied; cells outside the grid are not.
    pub fn is_occupied(&self, column: i64, row: i64) -> bool {
        let inside =
            (0..self.width as i64).contains(&column) && (0..self.height as i64).contains(&row);
        inside && self.occupied.cells[row as usize * self.width + column as usize]
    }

    /// Column and row of the cell that holds `p`; may lie outside the grid.
    pub fn cell_of(&self, p: Point) -> (i64, i64) {
        let index = |axis: usize| ((p[axis] - self.origin[axis]) / self.resolution).floor() as i64;
        (index(0), index(1))
    }

    /// The square of a cell.
    pub fn cell_rect(&self, column: i64, row: i64) -> Rect {
        let corner = |c: i64, r: i64| {
            [
                self.origin[0] + c as f64 * self.resolution,
                self.origin[1] + r as f64 * self.resolution,
            ]
        };
        Rect { min: corner(column, row), max: corner(column + 1, row + 1) }
    }

    /// The rectangle that the whole grid covers.
    pub fn rect(&self) -> Rect {
        let far = self.cell_rect(self.width as i64 - 1, self.height as i64 - 1);
        Rect { min: self.origin, max: far.max }
    }
}

/// Bounds, obstacles and an optional grid. The robot must stay inside the bounds and outside
/// every obstacle and occupied cell; obstacles may overlap and may cross the bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    bounds: Rect,
    obstacles: Vec<Obstacle>,
    grid: Option<Grid>,
}

impl World {
    /// A world from its parts, each of which is valid by construction.
    pub fn new(bounds: Rect, obstacles: Vec<Obstacle>, grid: Option<Grid>) -> Self {
        Self { bounds, obstacles, grid }
    }

    /// The rectangle that the whole robot must stay in.
    pub fn bounds(&self) -> Rect {
        self.bounds
    }

    /// The obstacle shapes.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// The occupancy grid, if there is one.
    pub fn grid(&self) -> Option<&Grid> {
        self.grid.as_ref()
    }

    /// Lengths below this count as nothing when something is certified: 1e-9 of the field's extent, and not more
    /// than what rounding asks for at the largest coordinates anyway, so that a door stays open however far away
    /// the bounds are.
    pub fn tolerance(&self) -> f64 {
        (1e-9 * self.bounds.extent()).min(MOST_TOLERANCE)
    }
}
