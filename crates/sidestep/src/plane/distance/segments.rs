//! Sides and boundary segments in f32: the point of one that is nearest to a point, and the nearest of many.

use super::LANES;

/// A directed side with the shape on its left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    pub from: [f32; 2],
    pub direction: [f32; 2],
    inverse_square: f32,
}

impl Side {
    pub fn new(a: [f32; 2], b: [f32; 2]) -> Self {
        let direction = [b[0] - a[0], b[1] - a[1]];
        let square = direction[0] * direction[0] + direction[1] * direction[1];
        Self { from: a, direction, inverse_square: if square > 0.0 { 1.0 / square } else { 0.0 } }
    }

    /// From the nearest point of the side to `(x, y)`.
    #[inline(always)]
    pub fn offset(&self, x: f32, y: f32) -> [f32; 2] {
        let (rx, ry) = (x - self.from[0], y - self.from[1]);
        let t = (rx * self.direction[0] + ry * self.direction[1]) * self.inverse_square;
        let t = t.clamp(0.0, 1.0);
        [rx - t * self.direction[0], ry - t * self.direction[1]]
    }
}

impl Side {
    /// The distance from `p`, in f64, and whether `p` lies on the right, outside.
    pub fn distance(&self, p: [f64; 2]) -> (f64, bool) {
        let [dx, dy] = self.direction.map(f64::from);
        let (rx, ry) = (p[0] - f64::from(self.from[0]), p[1] - f64::from(self.from[1]));
        let square = dx * dx + dy * dy;
        let t = if square > 0.0 { ((rx * dx + ry * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
        ((rx - t * dx).hypot(ry - t * dy), dx * ry - dy * rx < 0.0)
    }

    /// The largest magnitude of the side's numbers, its length among them.
    pub fn magnitude(&self) -> f64 {
        let numbers = self.from.iter().chain(&self.direction);
        numbers.fold(0.0, |most, &x| most.max(f64::from(x).abs()))
    }
}

/// Segments as arrays, so that one point meets [`LANES`] of them at once.
#[derive(Debug, Clone, Default)]
pub(super) struct SegmentLanes {
    from_x: Vec<f32>,
    from_y: Vec<f32>,
    direction_x: Vec<f32>,
    direction_y: Vec<f32>,
    inverse_square: Vec<f32>,
}

impl SegmentLanes {
    pub fn new(sides: &[Side]) -> Self {
        let mut lanes = Self::default();
        let padded = sides.len().next_multiple_of(LANES);
        for side in sides.iter().cycle().take(if sides.is_empty() { 0 } else { padded }) {
            lanes.from_x.push(side.from[0]);
            lanes.from_y.push(side.from[1]);
            lanes.direction_x.push(side.direction[0]);
            lanes.direction_y.push(side.direction[1]);
            lanes.inverse_square.push(side.inverse_square);
        }
        lanes
    }

    pub fn side(&self, i: usize) -> Side {
        Side {
            from: [self.from_x[i], self.from_y[i]],
            direction: [self.direction_x[i], self.direction_y[i]],
            inverse_square: self.inverse_square[i],
        }
    }

    /// Index of the segment nearest to `(x, y)`.
    #[inline(always)]
    pub fn nearest(&self, x: f32, y: f32) -> Option<usize> {
        let mut best = [f32::INFINITY; LANES];
        let mut index = [0u32; LANES];
        let blocks = self.from_x.len() / LANES;
        for block in 0..blocks {
            let range = block * LANES..(block + 1) * LANES;
            let (from_x, from_y) = (&self.from_x[range.clone()], &self.from_y[range.clone()]);
            let direction_x = &self.direction_x[range.clone()];
            let direction_y = &self.direction_y[range.clone()];
            let inverse_square = &self.inverse_square[range];
            for l in 0..LANES {
                let (rx, ry) = (x - from_x[l], y - from_y[l]);
                let t = (rx * direction_x[l] + ry * direction_y[l]) * inverse_square[l];
                let t = t.clamp(0.0, 1.0);
                let (ox, oy) = (rx - t * direction_x[l], ry - t * direction_y[l]);
                let square = ox * ox + oy * oy;
                let nearer = square < best[l];
                best[l] = if nearer { square } else { best[l] };
                index[l] = if nearer { block as u32 } else { index[l] };
            }
        }
        let least = best.iter().fold(f32::INFINITY, |a, &b| if b < a { b } else { a });
        let lane = best.iter().position(|&square| square == least)?;
        best[lane].is_finite().then(|| index[lane] as usize * LANES + lane)
    }

    /// [`nearest`](Self::nearest) among some of the segments, as if all had been compared.
    #[inline(always)]
    pub fn nearest_among(
        &self,
        segments: impl Iterator<Item = usize>,
        x: f32,
        y: f32,
    ) -> Option<usize> {
        let mut best: Option<(f32, usize)> = None;
        // At a tie the first lane wins, then the first block.
        let order = |i: usize| (i % LANES, i / LANES);
        for i in segments {
            let [ox, oy] = self.side(i).offset(x, y);
            let square = ox * ox + oy * oy;
            let nearer = best.is_none_or(|(least, known)| {
                square < least || square == least && order(i) < order(known)
            });
            if nearer && square < f32::INFINITY {
                best = Some((square, i));
            }
        }
        best.map(|(_, i)| i)
    }
}
