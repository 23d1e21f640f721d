//! The exact signed distance to the union of shapes.
//!
//! Outside, the distance to the union is the least distance to a shape. Inside, it is minus the
//! distance to the union's boundary ([`super::boundary`]), which is right inside overlaps too. The
//! gradient points away from the nearest boundary point; where several are nearest (the kinks), the
//! first in the order rectangles, circles, polygons decides.
//!
//! Above a few hundred shapes an [`Index`] names those that can be nearest to a point, so that an evaluation costs what
//! is near. Candidates are compared in the order of all pieces, so the answer is the same to the bit.

use super::boundary::{Arc, UnionBoundary};
use super::index::{Index, OUTSIDE};
use super::nearest::{Compared, Nearest, Probe};
use super::pieces::{Boundary, Shapes};
use super::segments::{SegmentLanes, Side};
use super::{LANES, Samples};
use crate::plane::frame::Frame;
use crate::plane::world::Obstacle;

/// Above this many shapes there is an index; it costs as much as some hundred blocks of points without it.
const MOST_WITHOUT_INDEX: usize = 256;

/// Shapes in normalised units, ready to be sampled.
#[derive(Debug, Clone)]
pub struct ShapeField {
    /// `[min_x, min_y, max_x, max_y]`.
    pub(super) rects: Vec<[f32; 4]>,
    /// `[center_x, center_y, radius]`.
    pub(super) circles: Vec<[f32; 3]>,
    pub(super) polygons: Vec<Vec<Side>>,
    /// Boundary segments of the union, padded to a multiple of [`LANES`] by repetition.
    boundary: SegmentLanes,
    /// How many of those are no repetition.
    segments: usize,
    arcs: Vec<Arc>,
    /// Which shapes can be nearest, by index over rectangles, circles and polygons, where there are many.
    near_shapes: Option<Index>,
    /// Which pieces of the boundary can be nearest, by index over segments and arcs, where there are many.
    near_boundary: Option<Index>,
}

impl ShapeField {
    /// The field of the union of `obstacles` in the normalised units of `frame`; none once `go_on` is false.
    pub fn new(
        obstacles: &[Obstacle],
        frame: &Frame,
        size: [f32; 2],
        go_on: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let mut field = Self {
            rects: Vec::new(),
            circles: Vec::new(),
            polygons: Vec::new(),
            boundary: SegmentLanes::default(),
            segments: 0,
            arcs: Vec::new(),
            near_shapes: None,
            near_boundary: None,
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
        let union = UnionBoundary::new(obstacles, 1e-9 * frame.scale, go_on)?;
        let sides: Vec<Side> = union
            .segments
            .iter()
            .map(|&(a, b)| Side::new(frame.to_normalised(a), frame.to_normalised(b)))
            .collect();
        field.boundary = SegmentLanes::new(&sides);
        field.segments = sides.len();
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
        if obstacles.len() > MOST_WITHOUT_INDEX {
            // Room around the field, for what an optimizer tries.
            let side = 1.25 * size[0].max(size[1]);
            let low = size.map(|length| 0.5 * (length - side));
            let shapes = Shapes::new(&field);
            let boundary = Boundary::new(&sides, &field.arcs);
            let near_shapes = Index::new(&shapes, low, side, go_on)?;
            let near_boundary = Index::new(&boundary, low, side, go_on)?;
            (field.near_shapes, field.near_boundary) = (Some(near_shapes), Some(near_boundary));
        }
        Some(field)
    }

    /// The same without its indices: the slow twin.
    #[cfg(test)]
    pub(super) fn without_index(self) -> Self {
        Self { near_shapes: None, near_boundary: None, ..self }
    }

    #[cfg(test)]
    pub(super) fn shapes_index(&self) -> Option<&Index> {
        self.near_shapes.as_ref()
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

    /// Keeps the nearer of what `out` holds and these shapes.
    #[inline(always)]
    pub(crate) fn merge(&self, x: &[f32], y: &[f32], out: &mut Samples<'_>) {
        let blocks = x.as_chunks::<LANES>().0.iter().zip(y.as_chunks::<LANES>().0);
        for (block, (px, py)) in blocks.enumerate() {
            let (distance, gradient_x, gradient_y) = self.sample_block(px, py);
            for l in 0..LANES {
                let i = block * LANES + l;
                if distance[l] < out.distance[i] {
                    out.distance[i] = distance[l];
                    (out.gradient_x[i], out.gradient_y[i]) = (gradient_x[l], gradient_y[l]);
                }
            }
        }
    }

    /// Keeps the nearer of what `out` holds and [`ShapeField::probe`].
    #[inline(always)]
    pub(crate) fn probe_nearer(&self, x: &[f32], y: &[f32], out: &mut [f32]) {
        let blocks = x.as_chunks::<LANES>().0.iter().zip(y.as_chunks::<LANES>().0);
        for ((x, y), out) in blocks.zip(out.as_chunks_mut::<LANES>().0) {
            let distance = self.probe_block(x, y);
            for l in 0..LANES {
                out[l] = out[l].min(distance[l]);
            }
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
        let Probe { square, depth } = self.compared(x, y);
        std::array::from_fn(|l| if depth[l] < 0.0 { depth[l] } else { square[l].sqrt() })
    }

    /// What is known of a block of points after all shapes, or where there is an index after those that can
    /// be nearest to each.
    #[inline(always)]
    fn compared<C: Compared>(&self, x: &[f32; LANES], y: &[f32; LANES]) -> C {
        let mut all = C::default();
        match &self.near_shapes {
            None => self.compare_every(x, y, &mut all),
            Some(index) => by_leaf(index, x, y, |leaf, lanes| {
                let mut part = C::default();
                if leaf == OUTSIDE {
                    self.compare_every(x, y, &mut part);
                } else {
                    for &shape in index.candidates(leaf) {
                        match self.shape(shape) {
                            Shape::Rect(rect) => part.rect(rect, x, y),
                            Shape::Circle(circle) => part.circle(circle, x, y),
                            Shape::Polygon(sides) => part.polygon(sides, x, y),
                        }
                    }
                }
                all.take(&part, lanes);
            }),
        }
        all
    }

    #[inline(always)]
    fn compare_every<C: Compared>(&self, x: &[f32; LANES], y: &[f32; LANES], known: &mut C) {
        self.rects.iter().for_each(|rect| known.rect(rect, x, y));
        self.circles.iter().for_each(|circle| known.circle(circle, x, y));
        self.polygons.iter().for_each(|sides| known.polygon(sides, x, y));
    }

    #[inline(always)]
    fn sample_block(&self, x: &[f32; LANES], y: &[f32; LANES]) -> Block {
        // Squared distance to the nearest shape (0 inside) and the offset from its nearest point.
        let Nearest { square, offset_x, offset_y } = self.compared(x, y);
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

    /// A shape by its number: rectangles first, then circles, then polygons.
    #[inline(always)]
    pub(super) fn shape(&self, number: u32) -> Shape<'_> {
        let number = number as usize;
        let (rects, circles) = (self.rects.len(), self.circles.len());
        if number < rects {
            Shape::Rect(&self.rects[number])
        } else if number < rects + circles {
            Shape::Circle(&self.circles[number - rects])
        } else {
            Shape::Polygon(&self.polygons[number - rects - circles])
        }
    }

    /// Signed distance (at most 0) and gradient of a point inside the union or on its boundary.
    #[inline(always)]
    fn inside(&self, x: f32, y: f32) -> (f32, f32, f32) {
        let mut nearest = (f32::INFINITY, 0.0, 0.0);
        let mut normal = [0.0, 0.0];
        let near = self.near_boundary.as_ref().map(|index| (index, index.leaf(x, y)));
        let near = near.filter(|(_, leaf)| *leaf != OUTSIDE);
        let near = near.map(|(index, leaf)| index.candidates(leaf));
        let segments = self.segments;
        let nearest_segment = match near {
            None => self.boundary.nearest(x, y),
            Some(near) => {
                let among = near.iter().map(|&i| i as usize).take_while(|&i| i < segments);
                self.boundary.nearest_among(among, x, y)
            }
        };
        if let Some(i) = nearest_segment {
            let side = self.boundary.side(i);
            let [ox, oy] = side.offset(x, y);
            nearest = (ox.hypot(oy), ox, oy);
            let length = side.direction[0].hypot(side.direction[1]).max(f32::MIN_POSITIVE);
            normal = [side.direction[1] / length, -side.direction[0] / length];
        }
        let mut compare = |arc: &Arc| {
            let [ox, oy] = arc_offset(arc, x, y);
            let distance = ox.hypot(oy);
            if distance < nearest.0 {
                nearest = (distance, ox, oy);
                let (dx, dy) = (x - arc.center[0] as f32, y - arc.center[1] as f32);
                let length = dx.hypot(dy).max(f32::MIN_POSITIVE);
                normal = [dx / length, dy / length];
            }
        };
        match near {
            None => self.arcs.iter().for_each(compare),
            Some(near) => {
                let arcs = near.iter().map(|&i| i as usize).filter(|&i| i >= segments);
                arcs.for_each(|i| compare(&self.arcs[i - segments]));
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

/// One shape of a field.
pub(super) enum Shape<'a> {
    Rect(&'a [f32; 4]),
    Circle(&'a [f32; 3]),
    Polygon(&'a [Side]),
}

/// Calls `visit` with each leaf that holds one of the points, and which of them it holds.
#[inline(always)]
fn by_leaf(
    index: &Index,
    x: &[f32; LANES],
    y: &[f32; LANES],
    mut visit: impl FnMut(u32, &[bool; LANES]),
) {
    let leaves: [u32; LANES] = std::array::from_fn(|l| index.leaf(x[l], y[l]));
    let mut left = [true; LANES];
    while let Some(first) = left.iter().position(|&left| left) {
        let lanes = leaves.map(|leaf| leaf == leaves[first]);
        visit(leaves[first], &lanes);
        for l in 0..LANES {
            left[l] &= !lanes[l];
        }
    }
}

/// Distances (or squares) and two components for a block of points.
type Block = ([f32; LANES], [f32; LANES], [f32; LANES]);

/// From the nearest point of an arc to `(x, y)`.
fn arc_offset(arc: &Arc, x: f32, y: f32) -> [f32; 2] {
    offset_from_arc(arc, [f64::from(x), f64::from(y)]).map(|offset| offset as f32)
}

pub(super) fn offset_from_arc(arc: &Arc, [x, y]: [f64; 2]) -> [f64; 2] {
    let (dx, dy) = (x - arc.center[0], y - arc.center[1]);
    let turn = (dy.atan2(dx) - arc.from).rem_euclid(std::f64::consts::TAU);
    let end = arc.from + arc.sweep;
    let angle = if turn <= arc.sweep {
        arc.from + turn
    } else {
        // The end point that is nearer round the circle.
        let past_end = turn - arc.sweep;
        if past_end < std::f64::consts::TAU - turn { end } else { arc.from }
    };
    [dx - arc.radius * angle.cos(), dy - arc.radius * angle.sin()]
}
