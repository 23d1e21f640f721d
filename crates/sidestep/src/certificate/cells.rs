//! The occupied cells of a grid as bits, and exact walks over those near a segment.
//!
//! A row of cells grown by the margin is a horizontal slab. Clipping the segment to the slab and
//! growing what is left by the margin gives one run of columns, so a segment costs a few word
//! operations per row that it passes (the idea of J. Amanatides and A. Woo, A fast voxel traversal
//! algorithm, Eurographics 1987, with closed cells: both neighbours of a touched line are visited).
//! Rows and columns are in cell units; everything outside the grid is free.

use super::distance::segment_rect_distance;
use crate::geometry::{Point, Rect};
use crate::world::Grid;

/// Occupied cells, 64 columns to a word.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    width: usize,
    height: usize,
    words_per_row: usize,
    words: Vec<u64>,
    origin: Point,
    resolution: f64,
}

impl Cells {
    /// Packs a grid's occupied cells.
    pub(crate) fn new(grid: &Grid) -> Self {
        let words_per_row = grid.width().div_ceil(64);
        let mut words = Vec::with_capacity(words_per_row * grid.height());
        for row in grid.cells().chunks(grid.width()) {
            for cells in row.chunks(64) {
                let word = cells.iter().rev().fold(0, |word, &cell| word << 1 | u64::from(cell));
                words.push(word);
            }
        }
        Self {
            width: grid.width(),
            height: grid.height(),
            words_per_row,
            words,
            origin: grid.origin(),
            resolution: grid.resolution(),
        }
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
                return self.any(row, first, last);
            }
            self.occupied(row, first, last)
                .any(|column| segment_rect_distance(a, b, &self.rect(column, row)) <= margin)
        })
        .is_none()
    }

    /// The first cell, from the bottom up, that the segment does not keep clear of.
    pub(crate) fn hit(&self, a: Point, b: Point, margin: f64) -> Option<(usize, usize)> {
        let mut found = None;
        self.near(a, b, margin, |row, first, last| {
            found = self
                .occupied(row, first, last)
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
                for column in self.occupied(row, first, last) {
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
        if high < 0.0 || low > self.height as f64 {
            return None;
        }
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        for row in low.max(0.0) as usize..=(high as usize).min(self.height - 1) {
            let (mut left, mut right) = (a[0].min(b[0]), a[0].max(b[0]));
            if dy != 0.0 {
                let t = (row as f64 - margin - a[1]) / dy;
                let u = (row as f64 + 1.0 + margin - a[1]) / dy;
                let x = a[0] + t.min(u).max(0.0) * dx;
                let y = a[0] + t.max(u).min(1.0) * dx;
                (left, right) = (left.max(x.min(y)), right.min(x.max(y)));
            }
            let (left, right) = (left - margin, right + margin);
            if right < 0.0 || left > self.width as f64 {
                continue;
            }
            let last = (right as usize).min(self.width - 1);
            if visit(row, (left.max(0.0) as usize).min(last), last) {
                return Some(row);
            }
        }
        None
    }

    /// The bits of word `index` of the row that lie in columns `first..=last`.
    #[inline]
    fn masked(&self, row: usize, index: usize, first: usize, last: usize) -> u64 {
        let mut word = self.words[row * self.words_per_row + index];
        if index == first / 64 {
            word &= u64::MAX << (first % 64);
        }
        if index == last / 64 {
            word &= u64::MAX >> (63 - last % 64);
        }
        word
    }

    /// Whether a cell of the row in columns `first..=last` is occupied.
    #[inline]
    fn any(&self, row: usize, first: usize, last: usize) -> bool {
        (first / 64..=last / 64).any(|index| self.masked(row, index, first, last) != 0)
    }

    /// The occupied columns of the row in `first..=last`, ascending.
    fn occupied(&self, row: usize, first: usize, last: usize) -> impl Iterator<Item = usize> + '_ {
        (first / 64..=last / 64).flat_map(move |index| {
            let mut word = self.masked(row, index, first, last);
            std::iter::from_fn(move || {
                let bit = (word != 0).then(|| word.trailing_zeros() as usize)?;
                word &= word - 1;
                Some(64 * index + bit)
            })
        })
    }
}
