//! A few rectangles against one segment, four at a time without a branch: the hot path of the
//! certificate.
//!
//! Each rectangle is grown by `margin` and meets the segment unless one of three axes separates
//! them (see `distance.rs`). With a margin that is only the tolerance the grown box's mitred
//! corners are conservative by less than half a tolerance and the answer is final. With a disc robot
//! the third axis is tested against the rounded box and what is left near a corner is decided by
//! the exact distance.

use super::distance::segment_rect_distance;
use crate::plane::geometry::{Point, Rect, norm};

/// Rectangles per block.
const LANES: usize = 4;

/// Centres and grown half sizes of four rectangles; unused lanes have half sizes of minus infinity.
#[derive(Debug, Clone)]
struct Block {
    center_x: [f64; LANES],
    center_y: [f64; LANES],
    half_x: [f64; LANES],
    half_y: [f64; LANES],
}

/// Rectangles prepared for segment tests.
#[derive(Debug, Clone)]
pub(crate) struct Boxes {
    blocks: Vec<Block>,
    rects: Vec<Rect>,
    margin: f64,
    /// Whether corners are round: the margin holds a robot's radius, not only a tolerance.
    rounded: bool,
}

impl Boxes {
    /// Prepares rectangles to be grown by `margin`, with exact round corners where `rounded`.
    pub(crate) fn new(rects: Vec<Rect>, margin: f64, rounded: bool) -> Self {
        let mut blocks = Vec::with_capacity(rects.len().div_ceil(LANES));
        for four in rects.chunks(LANES) {
            let mut block = Block {
                center_x: [0.0; LANES],
                center_y: [0.0; LANES],
                half_x: [f64::NEG_INFINITY; LANES],
                half_y: [f64::NEG_INFINITY; LANES],
            };
            for (lane, rect) in four.iter().enumerate() {
                let [width, height] = rect.size();
                block.center_x[lane] = 0.5 * (rect.min[0] + rect.max[0]);
                block.center_y[lane] = 0.5 * (rect.min[1] + rect.max[1]);
                block.half_x[lane] = 0.5 * width + margin;
                block.half_y[lane] = 0.5 * height + margin;
            }
            blocks.push(block);
        }
        Self { blocks, rects, margin, rounded }
    }

    /// Whether segment `a b` keeps more than the margin from every rectangle.
    #[inline]
    pub(crate) fn segment_is_free(&self, a: Point, b: Point) -> bool {
        let (cx, cy) = (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]));
        let (dx, dy) = (0.5 * (b[0] - a[0]), 0.5 * (b[1] - a[1]));
        let (ax, ay) = (dx.abs(), dy.abs());
        // The grown box reaches margin (|d_x| + |d_y|) along the normal, the rounded one margin |d|.
        let slack = if self.rounded { self.margin * (ax + ay - norm([dx, dy])) } else { 0.0 };
        for (index, block) in self.blocks.iter().enumerate() {
            let mut meets = [false; LANES];
            for lane in 0..LANES {
                let x = cx - block.center_x[lane];
                let y = cy - block.center_y[lane];
                let (hx, hy) = (block.half_x[lane], block.half_y[lane]);
                // Not a number separates nothing, hence `!(.. > ..)`.
                let apart = (x.abs() > hx + ax)
                    | (y.abs() > hy + ay)
                    | ((x * dy - y * dx).abs() + slack > hx * ay + hy * ax);
                meets[lane] = !apart;
            }
            if meets != [false; LANES] && (!self.rounded || self.meets_exactly(index, meets, a, b))
            {
                return false;
            }
        }
        true
    }

    /// Decides the lanes that the three axes left open by the exact distance.
    #[cold]
    fn meets_exactly(&self, index: usize, meets: [bool; LANES], a: Point, b: Point) -> bool {
        self.rects[index * LANES..]
            .iter()
            .zip(meets)
            .any(|(rect, open)| open && segment_rect_distance(a, b, rect) <= self.margin)
    }
}
