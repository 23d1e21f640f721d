//! A coarse picture of the free space: square cells, those that no path can enter being blocked.
//!
//! A cell is blocked where every point of it lies within the certificate's margin of one obstacle.
//! A certified path never touches a blocked cell, so what the open cells leave unconnected or out
//! of sight really is so; the converse does not hold.

use crate::plane::bit_grid::BitGrid;
use crate::plane::certificate::Certifier;
use crate::plane::geometry::{Point, Rect};
use crate::plane::world::Obstacle;

/// Most cells; a larger area gets larger cells, then without the occupied cells of a grid.
const MOST_CELLS: f64 = 3e8;
/// Most rows, and most columns: a row takes a word at least, however few columns it has.
const MOST_SIDE: f64 = 1048576.0;

/// Blocked cells over the bounds.
#[derive(Debug, Clone)]
pub(crate) struct Raster {
    pub(crate) blocked: BitGrid,
    /// Lower left corner of the lower left cell.
    pub(crate) origin: Point,
    /// Side of a cell, in task units.
    pub(crate) resolution: f64,
}

impl Raster {
    /// The blocked cells of a certifier's world: those of its grid, or else cells a fraction of
    /// the typical distance between shapes. None once `go_on` is false.
    pub(crate) fn new(certifier: &Certifier, go_on: &dyn Fn() -> bool) -> Option<Self> {
        let bounds = certifier.bounds();
        let [width, height] = bounds.size().map(|side| side.max(0.0));
        let least = (width * height / MOST_CELLS).sqrt().max(width.max(height) / MOST_SIDE);
        let aligned = certifier.cells().filter(|cells| cells.resolution() >= least);
        let resolution = match aligned {
            Some(cells) => cells.resolution(),
            None => {
                let shapes = certifier.obstacles().len() as f64;
                let across = (4.0 * shapes.sqrt()).clamp(64.0, 1024.0);
                (width.max(height) / across).max(least).max(f64::MIN_POSITIVE)
            }
        };
        // The first column and row, counted from the grid's. A sliver that rounding leaves beyond the grid's border belongs to
        // the cells beside it: as a column of its own it would join what the border separates.
        let sliver = 0.25 * certifier.tolerance() / resolution;
        let base = aligned.map_or(bounds.min, |cells| cells.origin());
        let first = [0, 1]
            .map(|axis| ((bounds.min[axis] - base[axis]) / resolution + sliver).floor().max(-1e9));
        let origin = [0, 1].map(|axis| base[axis] + first[axis] * resolution);
        let count = |axis: usize| {
            let cells = ((bounds.max[axis] - origin[axis]) / resolution - sliver).ceil();
            if cells.is_finite() && cells >= 1.0 { cells as usize } else { 1 }
        };
        let mut raster = Self { blocked: BitGrid::new(count(0), count(1)), origin, resolution };
        for obstacle in certifier.obstacles() {
            if !go_on() {
                return None;
            }
            raster.block_near(obstacle, certifier);
        }
        if let Some(cells) = aligned {
            let margin = (cells.sure_margin() - hair(certifier)).max(0.0);
            raster.block_cells(cells.bits(), first.map(|index| index as i64), margin);
        }
        Some(raster)
    }

    /// Blocks the cells that no path can enter because of an obstacle.
    pub(crate) fn block_near(&mut self, obstacle: &Obstacle, certifier: &Certifier) {
        self.block(obstacle, certifier.margin() - hair(certifier));
    }

    /// Number of columns.
    pub(crate) fn width(&self) -> usize {
        self.blocked.width()
    }

    /// Number of rows.
    pub(crate) fn height(&self) -> usize {
        self.blocked.height()
    }

    /// A point in cell units from the origin.
    pub(crate) fn local(&self, p: Point) -> Point {
        [0, 1].map(|axis| (p[axis] - self.origin[axis]) / self.resolution)
    }

    /// The row or column that holds a local coordinate, the nearest one outside the raster.
    pub(crate) fn index(local: f64, count: usize) -> usize {
        (local.max(0.0) as usize).min(count - 1)
    }

    /// Blocks the cells that lie within `margin` of one occupied cell: those whose offset from it
    /// is at most `margin`, since the far corner of one is that far from the near corner of the other.
    fn block_cells(&mut self, occupied: &BitGrid, first: [i64; 2], margin: f64) {
        let reach = margin / self.resolution;
        let (width, height) = (self.width() as i64, self.height() as i64);
        for row in 0..occupied.height() {
            for (begin, end) in runs(occupied.row(row), occupied.width(), u64::MAX) {
                for offset in -(reach as i64)..=reach as i64 {
                    let target = row as i64 - first[1] + offset;
                    let side = (reach * reach - (offset * offset) as f64).max(0.0).sqrt() as i64;
                    let left = (begin as i64 - first[0] - side).max(0);
                    let right = (end as i64 - 1 - first[0] + side).min(width - 1);
                    if (0..height).contains(&target) && left <= right {
                        self.blocked.set(target as usize, left as usize, right as usize);
                    }
                }
            }
        }
    }

    /// Blocks the cells that lie within `margin` of a shape. The grown shape is convex, so those
    /// of a row lie between its chords along the row's lower and upper line.
    fn block(&mut self, obstacle: &Obstacle, margin: f64) {
        let Rect { min, max } = obstacle.bounding_box().inflated(margin);
        let (low, high) = (self.local(min), self.local(max));
        if high[1] < 0.0 || low[1] > self.height() as f64 {
            return;
        }
        let (first, last) =
            (Self::index(low[1], self.height()), Self::index(high[1], self.height()));
        for row in first..=last {
            let y = |line: usize| self.origin[1] + line as f64 * self.resolution;
            let (Some(lower), Some(upper)) =
                (chord(obstacle, y(row), margin), chord(obstacle, y(row + 1), margin))
            else {
                continue;
            };
            let hair = 1e-9 * self.resolution;
            let column = |x: f64| (x - self.origin[0]) / self.resolution;
            let left = column(lower.0.max(upper.0) + hair).ceil().max(0.0);
            let right = column(lower.1.min(upper.1) - hair).floor().min(self.width() as f64);
            if left < right {
                self.blocked.set(row, left as usize, right as usize - 1);
            }
        }
    }
}

/// Half a tolerance: so much less than what is refused is blocked, for rounding.
fn hair(certifier: &Certifier) -> f64 {
    0.5 * certifier.tolerance()
}

/// The part of the horizontal line at `y` that lies within `margin` of the shape; for polygons, of
/// the shape itself.
fn chord(obstacle: &Obstacle, y: f64, margin: f64) -> Option<(f64, f64)> {
    let half = |radius: f64, dy: f64| {
        let square = radius * radius - dy * dy;
        (square >= 0.0).then(|| square.sqrt())
    };
    match obstacle {
        Obstacle::Rect(rect) => {
            let dy = (rect.min[1] - y).max(y - rect.max[1]).max(0.0);
            half(margin, dy).map(|side| (rect.min[0] - side, rect.max[0] + side))
        }
        Obstacle::Circle(circle) => half(circle.radius + margin, y - circle.center[1])
            .map(|side| (circle.center[0] - side, circle.center[0] + side)),
        Obstacle::Polygon(polygon) => {
            let mut span = (f64::INFINITY, f64::NEG_INFINITY);
            for (p, q) in polygon.edges() {
                if (p[1] - y) * (q[1] - y) <= 0.0 && p[1] != q[1] {
                    let x = p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
                    span = (span.0.min(x), span.1.max(x));
                }
            }
            (span.0 <= span.1).then_some(span)
        }
    }
}

/// The maximal runs `begin..end` of equal bits of a row: of ones with `flip` all ones, of zeros with
/// `flip` 0.
pub(crate) fn runs(
    words: &[u64],
    width: usize,
    flip: u64,
) -> impl Iterator<Item = (usize, usize)> + '_ {
    // The next column from `from` on whose bit, after inverting where asked, is clear.
    let next = move |from: usize, invert: u64| -> usize {
        let mut index = from / 64;
        let mut keep = u64::MAX << (from % 64);
        while index < words.len() {
            let word = !(words[index] ^ invert) & keep;
            if word != 0 {
                return (64 * index + word.trailing_zeros() as usize).min(width);
            }
            keep = u64::MAX;
            index += 1;
        }
        width
    };
    let mut at = 0;
    std::iter::from_fn(move || {
        let begin = if at < width { next(at, flip) } else { width };
        let end = if begin < width { next(begin, !flip) } else { width };
        at = end;
        (begin < end).then_some((begin, end))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Robot;
    use crate::plane::geometry::Circle;
    use crate::plane::world::{Grid, World};

    #[test]
    fn runs_of_ones_and_zeros() {
        let mut bits = BitGrid::new(130, 1);
        bits.set(0, 2, 70);
        bits.set(0, 129, 129);
        assert_eq!(runs(bits.row(0), 130, u64::MAX).collect::<Vec<_>>(), [(2, 71), (129, 130)]);
        assert_eq!(runs(bits.row(0), 130, 0).collect::<Vec<_>>(), [(0, 2), (71, 129)]);
    }

    #[test]
    fn a_blocked_cell_is_blocked_everywhere() {
        let mut occupied = vec![false; 40 * 30];
        for cell in [0, 399, 555, 556, 700, 801] {
            occupied[cell] = true;
        }
        let grid = Grid::new(40, 30, 0.5, [-3.0, 2.0], occupied).unwrap();
        let shapes = vec![
            Obstacle::Circle(Circle::new([5.0, 8.0], 2.3).unwrap()),
            Obstacle::Rect(Rect::new([10.1, 9.2], [14.3, 12.0]).unwrap()),
        ];
        let bounds = Rect::new([-4.0, 1.9], [16.0, 17.5]).unwrap();
        for radius in [0.0, 0.3, 0.7, 2.0] {
            for grid in [None, Some(grid.clone())] {
                let world = World::new(bounds, shapes.clone(), grid);
                let certifier = Certifier::new(&world, Robot::disc(radius).unwrap());
                let raster = Raster::new(&certifier, &|| true).unwrap();
                let mut count = 0;
                for row in 0..raster.height() {
                    for column in 0..raster.width() {
                        if raster.blocked.get(column, row) {
                            count += 1;
                            for (u, v) in
                                [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.4, 0.6)]
                            {
                                let p = [
                                    raster.origin[0] + (column as f64 + u) * raster.resolution,
                                    raster.origin[1] + (row as f64 + v) * raster.resolution,
                                ];
                                assert!(!certifier.point_is_free(p), "{radius} {column} {row}");
                            }
                        }
                    }
                }
                assert!(count > 50, "{count}");
            }
        }
    }
}
