//! A uniform grid of buckets over the bounds: which of many shapes can be near a segment.
//!
//! Used above a few dozen shapes. A bucket lists every shape whose grown bounding box overlaps it;
//! a shape in several buckets is met several times, which only costs time.

use crate::plane::geometry::{Point, Rect};

/// Most buckets along one axis.
const MOST_PER_AXIS: usize = 256;
/// Most entries over all buckets, per shape; larger shapes make the buckets coarser.
const MOST_ENTRIES_PER_SHAPE: usize = 16;

/// Indices of shapes by square bucket, in compressed rows.
#[derive(Debug, Clone)]
pub(crate) struct Buckets {
    per_axis: usize,
    origin: Point,
    /// Width and height of one bucket.
    size: Point,
    /// Where each bucket's entries begin; one more than there are buckets.
    begin: Vec<u32>,
    entries: Vec<u32>,
}

impl Buckets {
    /// Sorts shapes, given by their grown bounding boxes, into buckets that cover `bounds`; their indices count from `first`.
    pub(crate) fn new(bounds: Rect, boxes: &[Rect], first: usize) -> Self {
        let mut per_axis = (boxes.len() as f64).sqrt().ceil().clamp(1.0, 256.0) as usize;
        per_axis = per_axis.min(MOST_PER_AXIS);
        loop {
            let [width, height] = bounds.size();
            let mut buckets = Self {
                per_axis,
                origin: bounds.min,
                size: [width / per_axis as f64, height / per_axis as f64],
                begin: vec![0; per_axis * per_axis + 1],
                entries: Vec::new(),
            };
            let total = buckets.count(boxes);
            if per_axis == 1 || total <= MOST_ENTRIES_PER_SHAPE * boxes.len() {
                buckets.fill(boxes, first as u32);
                return buckets;
            }
            per_axis = per_axis.div_ceil(2);
        }
    }

    /// The bucket column (axis 0) or row (axis 1) of a coordinate, clamped to the bounds.
    fn index(&self, axis: usize, value: f64) -> usize {
        // Bounds shrunk by a robot that does not fit are inside out: all is in the first bucket.
        let index = (value - self.origin[axis]) / self.size[axis].max(f64::MIN_POSITIVE);
        (index.max(0.0) as usize).min(self.per_axis - 1)
    }

    /// Bucket columns and rows that a box overlaps, both ends included.
    fn span(&self, rect: &Rect) -> [(usize, usize); 2] {
        [0, 1].map(|axis| (self.index(axis, rect.min[axis]), self.index(axis, rect.max[axis])))
    }

    fn count(&self, boxes: &[Rect]) -> usize {
        boxes
            .iter()
            .map(|rect| self.span(rect).iter().map(|(i, j)| j - i + 1).product::<usize>())
            .sum()
    }

    fn fill(&mut self, boxes: &[Rect], first: u32) {
        let mut lists = vec![Vec::new(); self.per_axis * self.per_axis];
        for (shape, rect) in (first..).zip(boxes) {
            let [columns, rows] = self.span(rect);
            for row in rows.0..=rows.1 {
                for column in columns.0..=columns.1 {
                    lists[row * self.per_axis + column].push(shape);
                }
            }
        }
        for (bucket, list) in lists.iter().enumerate() {
            self.entries.extend(list);
            self.begin[bucket + 1] = self.entries.len() as u32;
        }
    }

    /// Calls `visit` for each shape in a bucket that segment `a b` passes, until it answers true;
    /// returns whether it did.
    pub(crate) fn any_near(
        &self,
        a: Point,
        b: Point,
        mut visit: impl FnMut(usize) -> bool,
    ) -> bool {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let rows = self.index(1, a[1].min(b[1]))..=self.index(1, a[1].max(b[1]));
        for row in rows {
            let (mut left, mut right) = (a[0].min(b[0]), a[0].max(b[0]));
            if dy != 0.0 {
                let at = |row: usize| (self.origin[1] + row as f64 * self.size[1] - a[1]) / dy;
                let (t, u) = (at(row), at(row + 1));
                let x = a[0] + t.min(u).max(0.0) * dx;
                let y = a[0] + t.max(u).min(1.0) * dx;
                (left, right) = (left.max(x.min(y)), right.min(x.max(y)));
            }
            // One part in a million of a bucket covers the rounding of the clipped ends.
            let slop = 1e-6 * self.size[0];
            for column in self.index(0, left - slop)..=self.index(0, right + slop) {
                let bucket = row * self.per_axis + column;
                let list = self.begin[bucket] as usize..self.begin[bucket + 1] as usize;
                if self.entries[list].iter().any(|&shape| visit(shape as usize)) {
                    return true;
                }
            }
        }
        false
    }
}
