//! The exact signed distance to the union of shapes.
//!
//! Outside, the distance to the union is the least distance to a shape. Inside, it is minus the
//! distance to the union's boundary ([`super::boundary`]), which is right inside overlaps too. The
//! gradient points away from the nearest boundary point; where several are nearest (the kinks), the
//! first in the order rectangles, circles, polygons decides.

use super::boundary::{Arc, UnionBoundary};
use super::{LANES, Samples};
use crate::plane::frame::Frame;
use crate::plane::world::Obstacle;

/// Shapes in normalised units, ready to be sampled.
#[derive(Debug, Clone)]
pub struct ShapeField {
    /// `[min_x, min_y, max_x, max_y]`.
    rects: Vec<[f32; 4]>,
    /// `[center_x, center_y, radius]`.
    circles: Vec<[f32; 3]>,
    polygons: Vec<Vec<Side>>,
    /// Boundary segments of the union, padded to a multiple of [`LANES`] by repetition.
    boundary: SegmentLanes,
    arcs: Vec<Arc>,
}

/// A directed side with the shape on its left.
#[derive(Debug, Clone, Copy)]
struct Side {
    from: [f32; 2],
    direction: [f32; 2],
    inverse_square: f32,
}

impl Side {
    fn new(a: [f32; 2], b: [f32; 2]) -> Self {
        let direction = [b[0] - a[0], b[1] - a[1]];
        let square = direction[0] * direction[0] + direction[1] * direction[1];
        Self { from: a, direction, inverse_square: if square > 0.0 { 1.0 / square } else { 0.0 } }
    }

    /// From the nearest point of the side to `(x, y)`.
    #[inline(always)]
    fn offset(&self, x: f32, y: f32) -> [f32; 2] {
        let (rx, ry) = (x - self.from[0], y - self.from[1]);
        let t = (rx * self.direction[0] + ry * self.direction[1]) * self.inverse_square;
        let t = t.clamp(0.0, 1.0);
        [rx - t * self.direction[0], ry - t * self.direction[1]]
    }
}

/// Segments as arrays, so that one point meets [`LANES`] of them at once.
#[derive(Debug, Clone, Default)]
struct SegmentLanes {
    from_x: Vec<f32>,
    from_y: Vec<f32>,
    direction_x: Vec<f32>,
    direction_y: Vec<f32>,
    inverse_square: Vec<f32>,
}

impl SegmentLanes {
    fn new(sides: &[Side]) -> Self {
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

    fn side(&self, i: usize) -> Side {
        Side {
            from: [self.from_x[i], self.from_y[i]],
            direction: [self.direction_x[i], self.direction_y[i]],
            inverse_square: self.inverse_square[i],
        }
    }

    /// Index of the segment nearest to `(x, y)`.
    #[inline(always)]
    fn nearest(&self, x: f32, y: f32) -> Option<usize> {
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
}

impl ShapeField {
    /// The field of the union of `obstacles` in the normalised units of `frame`.
    pub fn new(obstacles: &[Obstacle], frame: &Frame) -> Self {
        let mut field = Self {
            rects: Vec::new(),
            circles: Vec::new(),
            polygons: Vec::new(),
            boundary: SegmentLanes::default(),
            arcs: Vec::new(),
        };
        for obstacle in obstacles {
            match obstacle {
                Obstacle::Rect(rect) => {
                    let ([x0, y0], [x1, y1]) =
                        (frame.to_normalised(rect.min), frame.to_normalised(rect.max));
                    field.rects.push([x0, y0, x1, y1]);
                }
                Obstacle::Circle(circle) => {
                    let [x, y] = frame.to_normalised(circle.center);
                    field.circles.push([x, y, (circle.radius / frame.scale) as f32]);
                }
                Obstacle::Polygon(polygon) => field.polygons.push(
                    polygon
                        .edges()
                        .map(|(a, b)| Side::new(frame.to_normalised(a), frame.to_normalised(b)))
                        .collect(),
                ),
            }
        }
        let union = UnionBoundary::new(obstacles, 1e-9 * frame.scale);
        let sides: Vec<Side> = union
            .segments
            .iter()
            .map(|&(a, b)| Side::new(frame.to_normalised(a), frame.to_normalised(b)))
            .collect();
        field.boundary = SegmentLanes::new(&sides);
        field.arcs = union
            .arcs
            .iter()
            .map(|arc| Arc {
                center: [
                    (arc.center[0] - frame.origin[0]) / frame.scale,
                    (arc.center[1] - frame.origin[1]) / frame.scale,
                ],
                radius: arc.radius / frame.scale,
                ..*arc
            })
            .collect();
        field
    }

    /// Samples all points; slices have equal length, a multiple of [`LANES`].
    #[inline(always)]
    pub(crate) fn sample(&self, x: &[f32], y: &[f32], out: &mut Samples<'_>) {
        for block in 0..x.len() / LANES {
            let range = block * LANES..(block + 1) * LANES;
            let mut px = [0.0; LANES];
            let mut py = [0.0; LANES];
            px.copy_from_slice(&x[range.clone()]);
            py.copy_from_slice(&y[range.clone()]);
            let (distance, gradient_x, gradient_y) = self.sample_block(&px, &py);
            out.distance[range.clone()].copy_from_slice(&distance);
            out.gradient_x[range.clone()].copy_from_slice(&gradient_x);
            out.gradient_y[range].copy_from_slice(&gradient_y);
        }
    }

    /// Signed distances by the least over the shapes: exact outside the union, and inside a single shape; where shapes
    /// overlap it is less deep than the union. Slices have equal length, a multiple of [`LANES`].
    #[inline(always)]
    pub(crate) fn probe(&self, x: &[f32], y: &[f32], out: &mut [f32]) {
        for block in 0..x.len() / LANES {
            let range = block * LANES..(block + 1) * LANES;
            let mut px = [0.0; LANES];
            let mut py = [0.0; LANES];
            px.copy_from_slice(&x[range.clone()]);
            py.copy_from_slice(&y[range.clone()]);
            out[range].copy_from_slice(&self.probe_block(&px, &py));
        }
    }

    #[inline(always)]
    fn probe_block(&self, x: &[f32; LANES], y: &[f32; LANES]) -> [f32; LANES] {
        // Outside, the least square decides and no depth is below 0; inside, the least depth.
        let (mut square, mut depth) = ([f32::INFINITY; LANES], [0.0_f32; LANES]);
        let least = |a: f32, b: f32| if a < b { a } else { b };
        let most = |a: f32, b: f32| if a > b { a } else { b };
        for &[min_x, min_y, max_x, max_y] in &self.rects {
            for l in 0..LANES {
                let dx = most(min_x - x[l], x[l] - max_x);
                let dy = most(min_y - y[l], y[l] - max_y);
                let (ox, oy) = (most(dx, 0.0), most(dy, 0.0));
                square[l] = least(square[l], ox * ox + oy * oy);
                depth[l] = least(depth[l], most(dx, dy));
            }
        }
        for &[center_x, center_y, radius] in &self.circles {
            for l in 0..LANES {
                let (dx, dy) = (x[l] - center_x, y[l] - center_y);
                let distance = (dx * dx + dy * dy).sqrt() - radius;
                let outside = most(distance, 0.0);
                square[l] = least(square[l], outside * outside);
                depth[l] = least(depth[l], distance);
            }
        }
        for sides in &self.polygons {
            for l in 0..LANES {
                let (mut outside, mut nearest) = (false, f32::INFINITY);
                for side in sides {
                    let (rx, ry) = (x[l] - side.from[0], y[l] - side.from[1]);
                    outside |= side.direction[0] * ry - side.direction[1] * rx < 0.0;
                    let [ox, oy] = side.offset(x[l], y[l]);
                    nearest = least(nearest, ox * ox + oy * oy);
                }
                square[l] = least(square[l], if outside { nearest } else { 0.0 });
                depth[l] = least(depth[l], if outside { 0.0 } else { -nearest.sqrt() });
            }
        }
        std::array::from_fn(|l| if depth[l] < 0.0 { depth[l] } else { square[l].sqrt() })
    }

    #[inline(always)]
    fn sample_block(&self, x: &[f32; LANES], y: &[f32; LANES]) -> Block {
        let (square, offset_x, offset_y) = self.outside(x, y);
        let (mut distance, mut gradient_x, mut gradient_y) = (square, offset_x, offset_y);
        for l in 0..LANES {
            distance[l] = square[l].sqrt();
            gradient_x[l] = offset_x[l] / distance[l];
            gradient_y[l] = offset_y[l] / distance[l];
        }
        for l in 0..LANES {
            if square[l] == 0.0 {
                (distance[l], gradient_x[l], gradient_y[l]) = self.inside(x[l], y[l]);
            }
        }
        (distance, gradient_x, gradient_y)
    }

    /// Squared distance to the nearest shape (0 inside) and the offset from its nearest point.
    #[inline(always)]
    fn outside(&self, x: &[f32; LANES], y: &[f32; LANES]) -> Block {
        let mut best = [f32::INFINITY; LANES];
        let (mut best_x, mut best_y) = ([0.0; LANES], [0.0; LANES]);
        for &[min_x, min_y, max_x, max_y] in &self.rects {
            let (known, known_x, known_y) = (best, best_x, best_y);
            for l in 0..LANES {
                let dx = x[l] - x[l].max(min_x).min(max_x);
                let dy = y[l] - y[l].max(min_y).min(max_y);
                let square = dx * dx + dy * dy;
                let nearer = square < known[l];
                best[l] = if nearer { square } else { known[l] };
                best_x[l] = if nearer { dx } else { known_x[l] };
                best_y[l] = if nearer { dy } else { known_y[l] };
            }
        }
        let mut keep = |l: usize, square: f32, offset_x: f32, offset_y: f32| {
            let nearer = square < best[l];
            best[l] = if nearer { square } else { best[l] };
            best_x[l] = if nearer { offset_x } else { best_x[l] };
            best_y[l] = if nearer { offset_y } else { best_y[l] };
        };
        for &[center_x, center_y, radius] in &self.circles {
            for l in 0..LANES {
                let (dx, dy) = (x[l] - center_x, y[l] - center_y);
                let to_center = (dx * dx + dy * dy).sqrt();
                let outside = (to_center - radius).max(0.0);
                let factor = outside / to_center.max(f32::MIN_POSITIVE);
                keep(l, outside * outside, dx * factor, dy * factor);
            }
        }
        for sides in &self.polygons {
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
                keep(l, if outside { nearest[0] } else { 0.0 }, nearest[1], nearest[2]);
            }
        }
        (best, best_x, best_y)
    }

    /// Signed distance (at most 0) and gradient of a point inside the union or on its boundary.
    #[inline(always)]
    fn inside(&self, x: f32, y: f32) -> (f32, f32, f32) {
        let mut nearest = (f32::INFINITY, 0.0, 0.0);
        let mut normal = [0.0, 0.0];
        if let Some(i) = self.boundary.nearest(x, y) {
            let side = self.boundary.side(i);
            let [ox, oy] = side.offset(x, y);
            nearest = (ox.hypot(oy), ox, oy);
            let length = side.direction[0].hypot(side.direction[1]).max(f32::MIN_POSITIVE);
            normal = [side.direction[1] / length, -side.direction[0] / length];
        }
        for arc in &self.arcs {
            let [ox, oy] = arc_offset(arc, x, y);
            let distance = ox.hypot(oy);
            if distance < nearest.0 {
                nearest = (distance, ox, oy);
                let (dx, dy) = (x - arc.center[0] as f32, y - arc.center[1] as f32);
                let length = dx.hypot(dy).max(f32::MIN_POSITIVE);
                normal = [dx / length, dy / length];
            }
        }
        let (depth, ox, oy) = nearest;
        if depth > 1e-6 {
            (-depth, -ox / depth, -oy / depth)
        } else {
            (-depth, normal[0], normal[1])
        }
    }
}

/// Distances (or squares) and two components for a block of points.
type Block = ([f32; LANES], [f32; LANES], [f32; LANES]);

/// From the nearest point of an arc to `(x, y)`.
fn arc_offset(arc: &Arc, x: f32, y: f32) -> [f32; 2] {
    let (dx, dy) = (f64::from(x) - arc.center[0], f64::from(y) - arc.center[1]);
    let turn = (dy.atan2(dx) - arc.from).rem_euclid(std::f64::consts::TAU);
    let end = arc.from + arc.sweep;
    let angle = if turn <= arc.sweep {
        arc.from + turn
    } else {
        // The end point that is nearer round the circle.
        let past_end = turn - arc.sweep;
        if past_end < std::f64::consts::TAU - turn { end } else { arc.from }
    };
    [(dx - arc.radius * angle.cos()) as f32, (dy - arc.radius * angle.sin()) as f32]
}
