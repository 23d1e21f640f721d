//! A grid of heights: each cell is a solid column.

use super::bounds::Bounds;
use super::primitives;
use super::vector::Vector;
use crate::error::{InvalidInput, finite};

/// Columns on a grid. Cell (row, column) stands on `[column, column + 1] x [row, row + 1]` times
/// the resolution and reaches from `base` up to its height; a cell not above the base is empty.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightMap {
    columns: usize,
    resolution: f64,
    base: f64,
    heights: Vec<f64>,
}

impl HeightMap {
    /// `heights` is row-major, the row of the smallest y first; all in metres.
    ///
    /// # Errors
    /// If a number is not finite, the resolution is not positive, or the cells do not fill whole
    /// rows.
    pub fn new(
        columns: usize,
        resolution: f64,
        base: f64,
        heights: Vec<f64>,
    ) -> Result<Self, InvalidInput> {
        finite("resolution", resolution)?;
        finite("base", base)?;
        if resolution <= 0.0 {
            return Err(InvalidInput::new("resolution", resolution, "a number above 0"));
        }
        if columns == 0 || heights.is_empty() || !heights.len().is_multiple_of(columns) {
            let found = format!("{} cells in rows of {columns}", heights.len());
            return Err(InvalidInput::new("heights", found, "one whole row or more"));
        }
        for (i, &height) in heights.iter().enumerate() {
            finite(&format!("heights[{}][{}]", i / columns, i % columns), height)?;
        }
        finite("resolution x cells", resolution * heights.len() as f64)?;
        Ok(Self { columns, resolution, base, heights })
    }

    /// Cells of a row.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Side of a cell, in metres.
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Where the columns stand, in metres.
    pub fn base(&self) -> f64 {
        self.base
    }

    /// All heights, row-major, the row of the smallest y first.
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }

    /// Number of cells, empty ones too; cell i is (i / columns, i % columns).
    pub fn cells(&self) -> usize {
        self.heights.len()
    }

    /// The column of cell `i`, or nothing if it is empty.
    pub fn cell(&self, i: usize) -> Option<Bounds> {
        let (row, column) = ((i / self.columns) as f64, (i % self.columns) as f64);
        let height = self.heights[i];
        (height > self.base).then_some(Bounds {
            min: [column * self.resolution, row * self.resolution, self.base],
            max: [(column + 1.0) * self.resolution, (row + 1.0) * self.resolution, height],
        })
    }

    /// Signed distance and normal to the column of cell `i`; infinite if it is empty.
    pub(super) fn distance(&self, i: usize, p: Vector) -> (f64, Vector) {
        let Some(cell) = self.cell(i) else { return (f64::INFINITY, [0.0, 0.0, 1.0]) };
        let center = cell.center();
        let half_extents = [0, 1, 2].map(|k| 0.5 * (cell.max[k] - cell.min[k]));
        primitives::cuboid([0, 1, 2].map(|k| p[k] - center[k]), half_extents)
    }
}
