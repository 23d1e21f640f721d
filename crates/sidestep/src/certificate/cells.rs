//! The occupied cells of a grid as bits, and exact walks over those near a segment.
//!
//! A row of cells grown by the margin is a horizontal slab. Clipping the segment to the slab and
//! growing what is left by the margin gives one run of columns, so a segment costs a few word
//! operations per row that it passes (the idea of J. Amanatides and A. Woo, A fast voxel traversal
//! algorithm, Eurographics 1987, with closed cells: both neighbours of a touched line are visited).
//! Rows and columns are in cell units; everything outside the grid is free.

use super::distance::segment_rect_distance;
use crate::bit_grid::BitGrid;
use crate::geometry::{Point, Rect};
use crate::world::Grid;

/// Occupied cells and where they lie.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    bits: BitGrid,
    origin: Point,
    resolution: f64,
}

impl Cells {
    /// Packs a grid's occupied cells.
    pub(crate) fn new(grid: &Grid) -> Self {
        Self {
            bits: BitGrid::from_bools(grid.width(), grid.height(), grid.cells()),
            origin: grid.origin(),
            resolution: grid.resolution(),
        }
    }

    /// The occupied cells.
    pub(crate) fn bits(&self) -> &BitGrid {
        &self.bits
    }

    /// Lower left corner of the lower left cell.
    pub(crate) fn origin(&self) -> Point {
        self.origin
    }

    /// Side of a cell, in task units.
    pub(crate) fn resolution(&self) -> f64 {
        self.resolution
    }

    /// The square of a cell, in task units.
    fn rect(&self, column: usize, row: usize) -> Rect {
        let corner = |c: usize, r: usize| {
            [
                self.origin[0] + c as f64 * self.resolution,
                self.origin[1] + r as f64 * self.resolution,
            ]
        };
        Rect { min: corner(column, row), max: corner(column + 1, row + 1) }
    }

    /// Whether the segment keeps more than `margin` from every occupied cell. Where not `rounded`,
    /// the cells grow into squares instead of rounded squares.
    pub(crate) fn segment_is_free(&self, a: Point, b: Point, margin: f64, rounded: bool) -> bool {
        self.near(a, b, margin, |row, first, last| {
            if !rounded {
                return self.bits.any(row, first, last);
            }
            self.bits
                .ones(row, first, last)
                .any(|column| segment_rect_distance(a, b, &self.rect(column, row)) <= margin)
        })
        .is_none()
    }

    /// The first cell, from the bottom up, that the segment does not keep clear of.
    pub(crate) fn hit(&self, a: Point, b: Point, margin: f64) -> Option<(usize, usize)> {
        let mut found = None;
        self.near(a, b, margin, |row, first, last| {
            found = self
                .bits
                .ones(row, first, last)
                .find(|&column| segment_rect_distance(a, b, &self.rect(column, row)) <= margin)
                .map(|column| (column, row));
            found.is_some()
        });
        found
    }

    /// The distance from the segment to the nearest occupied cell, or `most` where that is less.
    ///
    /// Looks in neighbourhoods that double until a cell in reach has been found.
    pub(crate) fn distance(&self, a: Point, b: Point, most: f64) -> f64 {
        let mut reach = self.resolution;
        let mut best = most;
        loop {
            let margin = reach.min(best);
            self.near(a, b, margin, |row, first, last| {
                for column in self.bits.ones(row, first, last) {
                    best = best.min(segment_rect_distance(a, b, &self.rect(column, row)));
                }
                false
            });
            if best <= reach {
                return best;
            }
            reach *= 2.0;
        }
    }

    /// Calls `visit(row, first column, last column)` for each row of cells that may lie within
    /// `margin` of the segment, until it answers true; that row is returned.
    fn near(
        &self,
        a: Point,
        b: Point,
        margin: f64,
        mut visit: impl FnMut(usize, usize, usize) -> bool,
    ) -> Option<usize> {
        let local = |p: Point| {
            [(p[0] - self.origin[0]) / self.resolution, (p[1] - self.origin[1]) / self.resolution]
        };
        let (a, b, margin) = (local(a), local(b), margin / self.resolution);
        // Casts of floats saturate, so values far outside the grid end at its border.
        let low = a[1].min(b[1]) - margin;
        let high = a[1].max(b[1]) + margin;
        if high < 0.0 || low > self.bits.height() as f64 {
            return None;
        }
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        for row in low.max(0.0) as usize..=(high as usize).min(self.bits.height() - 1) {
            let (mut left, mut right) = (a[0].min(b[0]), a[0].max(b[0]));
            if dy != 0.0 {
                let t = (row as f64 - margin - a[1]) / dy;
                let u = (row as f64 + 1.0 + margin - a[1]) / dy;
                let x = a[0] + t.min(u).max(0.0) * dx;
                let y = a[0] + t.max(u).min(1.0) * dx;
                (left, right) = (left.max(x.min(y)), right.min(x.max(y)));
            }
            let (left, right) = (left - margin, right + margin);
            if right < 0.0 || left > self.bits.width() as f64 {
                continue;
            }
            let last = (right as usize).min(self.bits.width() - 1);
            if visit(row, (left.max(0.0) as usize).min(last), last) {
                return Some(row);
            }
        }
        None
    }
}
