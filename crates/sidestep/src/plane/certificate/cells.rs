//! The occupied cells of a grid as bits, and exact walks over those near a segment.
//!
//! A row of cells grown by the margin is a horizontal slab. Clipping the segment to the slab and
//! growing what is left by the margin gives one run of columns, so a segment costs a few word
//! operations per row that it passes (the idea of J. Amanatides and A. Woo, A fast voxel traversal
//! algorithm, Eurographics 1987, with closed cells: both neighbours of a touched line are visited).
//! Rows and columns are in cell units; everything outside the grid is free.

use std::sync::Arc;

use super::distance::{segment_polygon_distance, segment_rect_distance};
use crate::plane::bit_grid::BitGrid;
use crate::plane::geometry::{ConvexPolygon, Point, Rect, cross, norm, sub};
use crate::plane::world::Grid;

/// The shape that each occupied cell is grown to.
#[derive(Debug, Clone)]
pub(crate) enum Growth {
    /// A square, by a margin that is only a tolerance.
    Square(f64),
    /// A rounded square, by a margin that holds a robot's radius.
    Round(f64),
    /// A convex polygon round the cell at the origin, which lies between two rounded squares.
    Polygon {
        /// Counter-clockwise.
        polygon: ConvexPolygon,
        /// Distance from the cell within which everything lies in the polygon.
        inner: f64,
        /// Distance from the cell within which all of the polygon lies.
        outer: f64,
    },
}

/// Occupied cells, where they lie and what they are grown to.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    bits: Arc<BitGrid>,
    /// Occupied cells beside a free one, on which the nearest point of all cells lies; empty for
    /// square growth, which does not use it.
    border: Arc<BitGrid>,
    origin: Point,
    resolution: f64,
    growth: Growth,
}

impl Cells {
    /// Packs a grid's occupied cells.
    pub(crate) fn new(grid: &Grid, growth: Growth) -> Self {
        let bits = grid.bits().clone();
        let border = match growth {
            Growth::Square(_) => Arc::new(BitGrid::new(0, 0)),
            _ => grid.border().clone(),
        };
        Self { bits, border, origin: grid.origin(), resolution: grid.resolution(), growth }
    }

    /// The same cells grown otherwise; from one round growth to another.
    pub(crate) fn grown(&self, growth: Growth) -> Self {
        Self { growth, ..self.clone() }
    }

    /// The distance from a cell within which every point is refused.
    pub(crate) fn sure_margin(&self) -> f64 {
        match self.growth {
            Growth::Square(margin) | Growth::Round(margin) => margin,
            Growth::Polygon { inner, .. } => inner,
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

    /// The corner that columns `x - 1`, `x` and rows `y - 1`, `y` share.
    pub(crate) fn lattice_point(&self, x: usize, y: usize) -> Point {
        [self.origin[0] + x as f64 * self.resolution, self.origin[1] + y as f64 * self.resolution]
    }

    /// The square of a cell, in task units.
    fn rect(&self, column: usize, row: usize) -> Rect {
        Rect { min: self.lattice_point(column, row), max: self.lattice_point(column + 1, row + 1) }
    }

    /// Whether the segment touches no grown cell.
    pub(crate) fn segment_is_free(&self, a: Point, b: Point) -> bool {
        match &self.growth {
            Growth::Square(margin) => self
                .near(a, b, *margin, |row, first, last| self.bits.any(row, first, last))
                .is_none(),
            Growth::Round(margin) => {
                self.keeps_clear(a, b, *margin, |_, distance| distance > *margin)
            }
            Growth::Polygon { polygon, inner, outer } => {
                self.keeps_clear(a, b, *outer, |corner, distance| {
                    distance > *outer
                        || distance > *inner && {
                            let (a, b) = (sub(a, corner), sub(b, corner));
                            segment_polygon_distance(a, b, polygon) > 0.0
                        }
                })
            }
        }
    }

    /// Whether `is_clear(lower left corner, distance)` holds for all cells within `reach`; others may
    /// be left out.
    fn keeps_clear(
        &self,
        a: Point,
        b: Point,
        reach: f64,
        is_clear: impl Fn(Point, f64) -> bool,
    ) -> bool {
        // Inside the occupied region the border may be far.
        let start = [0, 1].map(|axis| ((a[axis] - self.origin[axis]) / self.resolution).floor());
        let inside = 0.0 <= start[0]
            && start[0] < self.bits.width() as f64
            && 0.0 <= start[1]
            && start[1] < self.bits.height() as f64;
        if inside && self.bits.get(start[0] as usize, start[1] as usize) {
            return false;
        }
        let direction = sub(b, a);
        let [dx, dy] = direction;
        let half = 0.5 * self.resolution;
        // Cells whose square lies beside the segment's line by more than the reach, and a hair.
        let aside = half * (dx.abs() + dy.abs()) + reach * (1.0 + 1e-12) * norm(direction);
        self.near(a, b, reach, |row, first, last| {
            self.border.ones(row, first, last).any(|column| {
                let rect = self.rect(column, row);
                let center = [rect.min[0] + half, rect.min[1] + half];
                cross(direction, sub(center, a)).abs() <= aside
                    && !is_clear(rect.min, segment_rect_distance(a, b, &rect))
            })
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
