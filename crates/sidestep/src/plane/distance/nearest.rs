//! A block of points against one shape after another: the nearest so far, or the distance alone.

use super::LANES;
use super::segments::Side;
use crate::kernels::{least, most};

/// What is known of a block of points after some shapes; starts as [`Default`], with none met.
pub(super) trait Compared: Default {
    /// Meets a rectangle `[min_x, min_y, max_x, max_y]`.
    fn rect(&mut self, rect: &[f32; 4], x: &[f32; LANES], y: &[f32; LANES]);
    /// Meets a circle `[center_x, center_y, radius]`.
    fn circle(&mut self, circle: &[f32; 3], x: &[f32; LANES], y: &[f32; LANES]);
    /// Meets a polygon.
    fn polygon(&mut self, sides: &[Side], x: &[f32; LANES], y: &[f32; LANES]);
    /// Takes the marked lanes of another.
    fn take(&mut self, other: &Self, lanes: &[bool; LANES]);
}

/// The nearest of the shapes met so far, for each lane.
pub(super) struct Nearest {
    pub square: [f32; LANES],
    pub offset_x: [f32; LANES],
    pub offset_y: [f32; LANES],
}

impl Default for Nearest {
    #[inline(always)]
    fn default() -> Self {
        Self { square: [f32::INFINITY; LANES], offset_x: [0.0; LANES], offset_y: [0.0; LANES] }
    }
}

impl Nearest {
    #[inline(always)]
    fn keep(&mut self, l: usize, square: f32, offset_x: f32, offset_y: f32) {
        let nearer = square < self.square[l];
        self.square[l] = if nearer { square } else { self.square[l] };
        self.offset_x[l] = if nearer { offset_x } else { self.offset_x[l] };
        self.offset_y[l] = if nearer { offset_y } else { self.offset_y[l] };
    }
}

impl Compared for Nearest {
    #[inline(always)]
    fn rect(
        &mut self,
        &[min_x, min_y, max_x, max_y]: &[f32; 4],
        x: &[f32; LANES],
        y: &[f32; LANES],
    ) {
        let (known, known_x, known_y) = (self.square, self.offset_x, self.offset_y);
        for l in 0..LANES {
            let dx = x[l] - least(most(x[l], min_x), max_x);
            let dy = y[l] - least(most(y[l], min_y), max_y);
            let square = dx * dx + dy * dy;
            let nearer = square < known[l];
            self.square[l] = if nearer { square } else { known[l] };
            self.offset_x[l] = if nearer { dx } else { known_x[l] };
            self.offset_y[l] = if nearer { dy } else { known_y[l] };
        }
    }

    #[inline(always)]
    fn circle(
        &mut self,
        &[center_x, center_y, radius]: &[f32; 3],
        x: &[f32; LANES],
        y: &[f32; LANES],
    ) {
        for l in 0..LANES {
            let (dx, dy) = (x[l] - center_x, y[l] - center_y);
            let to_center = (dx * dx + dy * dy).sqrt();
            let outside = (to_center - radius).max(0.0);
            let factor = outside / to_center.max(f32::MIN_POSITIVE);
            self.keep(l, outside * outside, dx * factor, dy * factor);
        }
    }

    #[inline(always)]
    fn polygon(&mut self, sides: &[Side], x: &[f32; LANES], y: &[f32; LANES]) {
        for l in 0..LANES {
            let mut outside = false;
            let mut nearest = [f32::INFINITY, 0.0, 0.0];
            for side in sides {
                let (rx, ry) = (x[l] - side.from[0], y[l] - side.from[1]);
                outside |= side.direction[0] * ry - side.direction[1] * rx < 0.0;
                let [ox, oy] = side.offset(x[l], y[l]);
                let square = ox * ox + oy * oy;
                nearest = if square < nearest[0] { [square, ox, oy] } else { nearest };
            }
            self.keep(l, if outside { nearest[0] } else { 0.0 }, nearest[1], nearest[2]);
        }
    }

    #[inline(always)]
    fn take(&mut self, other: &Self, lanes: &[bool; LANES]) {
        for l in 0..LANES {
            let take = |new: f32, old: f32| if lanes[l] { new } else { old };
            self.square[l] = take(other.square[l], self.square[l]);
            self.offset_x[l] = take(other.offset_x[l], self.offset_x[l]);
            self.offset_y[l] = take(other.offset_y[l], self.offset_y[l]);
        }
    }
}

/// The least square outside and the least depth inside of the shapes met so far, for each lane. Outside, no depth
/// is below 0.
pub(super) struct Probe {
    pub square: [f32; LANES],
    pub depth: [f32; LANES],
}

impl Default for Probe {
    #[inline(always)]
    fn default() -> Self {
        Self { square: [f32::INFINITY; LANES], depth: [0.0; LANES] }
    }
}

impl Compared for Probe {
    #[inline(always)]
    fn rect(
        &mut self,
        &[min_x, min_y, max_x, max_y]: &[f32; 4],
        x: &[f32; LANES],
        y: &[f32; LANES],
    ) {
        for l in 0..LANES {
            let dx = most(min_x - x[l], x[l] - max_x);
            let dy = most(min_y - y[l], y[l] - max_y);
            let (ox, oy) = (most(dx, 0.0), most(dy, 0.0));
            self.square[l] = least(self.square[l], ox * ox + oy * oy);
            self.depth[l] = least(self.depth[l], most(dx, dy));
        }
    }

    #[inline(always)]
    fn circle(
        &mut self,
        &[center_x, center_y, radius]: &[f32; 3],
        x: &[f32; LANES],
        y: &[f32; LANES],
    ) {
        for l in 0..LANES {
            let (dx, dy) = (x[l] - center_x, y[l] - center_y);
            let distance = (dx * dx + dy * dy).sqrt() - radius;
            let outside = most(distance, 0.0);
            self.square[l] = least(self.square[l], outside * outside);
            self.depth[l] = least(self.depth[l], distance);
        }
    }

    #[inline(always)]
    fn polygon(&mut self, sides: &[Side], x: &[f32; LANES], y: &[f32; LANES]) {
        for l in 0..LANES {
            let (mut outside, mut nearest) = (false, f32::INFINITY);
            for side in sides {
                let (rx, ry) = (x[l] - side.from[0], y[l] - side.from[1]);
                outside |= side.direction[0] * ry - side.direction[1] * rx < 0.0;
                let [ox, oy] = side.offset(x[l], y[l]);
                nearest = least(nearest, ox * ox + oy * oy);
            }
            self.square[l] = least(self.square[l], if outside { nearest } else { 0.0 });
            self.depth[l] = least(self.depth[l], if outside { 0.0 } else { -nearest.sqrt() });
        }
    }

    #[inline(always)]
    fn take(&mut self, other: &Self, lanes: &[bool; LANES]) {
        for l in 0..LANES {
            let take = |new: f32, old: f32| if lanes[l] { new } else { old };
            self.square[l] = take(other.square[l], self.square[l]);
            self.depth[l] = take(other.depth[l], self.depth[l]);
        }
    }
}
