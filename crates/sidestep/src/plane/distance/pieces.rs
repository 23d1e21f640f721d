//! What an [`Index`](super::index::Index) asks of the shapes of a field and of the pieces of their union's boundary.

use super::boundary::Arc;
use super::index::Pieces;
use super::segments::Side;
use super::shapes::{Shape, ShapeField, offset_from_arc};

/// The shapes of a field as an index sees them.
pub(super) struct Shapes<'a> {
    field: &'a ShapeField,
    /// A box round each shape.
    boxes: Vec<[f64; 4]>,
}

impl<'a> Shapes<'a> {
    pub fn new(field: &'a ShapeField) -> Self {
        let rects = field.rects.iter().map(|rect| rect.map(f64::from));
        let circles = field.circles.iter().map(|circle| {
            let [x, y, radius] = circle.map(f64::from);
            [x - radius, y - radius, x + radius, y + radius]
        });
        let polygons = field.polygons.iter().map(|sides| {
            let mut around = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
            for [x, y] in sides.iter().map(|side| side.from.map(f64::from)) {
                around = [around[0].min(x), around[1].min(y), around[2].max(x), around[3].max(y)];
            }
            around
        });
        Self { field, boxes: rects.chain(circles).chain(polygons).collect() }
    }
}

impl Pieces for Shapes<'_> {
    fn len(&self) -> usize {
        self.boxes.len()
    }

    fn least(&self, piece: usize, p: [f64; 2], half: f64) -> f64 {
        distance_from_box(&self.boxes[piece], p, half)
    }

    fn distance(&self, piece: usize, p: [f64; 2]) -> f64 {
        match self.field.shape(piece as u32) {
            Shape::Rect(_) => self.least(piece, p, 0.0),
            Shape::Circle(circle) => {
                let [x, y, radius] = circle.map(f64::from);
                ((p[0] - x).hypot(p[1] - y) - radius).max(0.0)
            }
            Shape::Polygon(sides) => {
                let is_outside = sides.iter().any(|side| side.distance(p).1);
                let distances = sides.iter().map(|side| side.distance(p).0);
                if is_outside { distances.fold(f64::INFINITY, f64::min) } else { 0.0 }
            }
        }
    }

    fn magnitude(&self, piece: usize) -> f64 {
        match self.field.shape(piece as u32) {
            // Sides are compared, and their distances rounded only as a part of themselves.
            Shape::Rect(_) => 0.0,
            _ => self.boxes[piece].iter().fold(0.0, |most, x| most.max(x.abs())),
        }
    }
}

/// The pieces of a union's boundary as an index sees them.
pub(super) struct Boundary<'a> {
    sides: &'a [Side],
    arcs: &'a [Arc],
    /// A box round each segment.
    boxes: Vec<[f64; 4]>,
}

impl<'a> Boundary<'a> {
    pub fn new(sides: &'a [Side], arcs: &'a [Arc]) -> Self {
        let boxes = sides.iter().map(|side| {
            let [x, y] = side.from.map(f64::from);
            let [dx, dy] = side.direction.map(f64::from);
            [x + dx.min(0.0), y + dy.min(0.0), x + dx.max(0.0), y + dy.max(0.0)]
        });
        Self { sides, arcs, boxes: boxes.collect() }
    }
}

impl Pieces for Boundary<'_> {
    fn len(&self) -> usize {
        self.sides.len() + self.arcs.len()
    }

    fn least(&self, piece: usize, p: [f64; 2], half: f64) -> f64 {
        match self.boxes.get(piece) {
            Some(around) => distance_from_box(around, p, half),
            None => {
                // That of the whole circle.
                let arc = &self.arcs[piece - self.sides.len()];
                let (dx, dy) = (p[0] - arc.center[0], p[1] - arc.center[1]);
                let ring = ((dx * dx + dy * dy).sqrt() - arc.radius).abs();
                ring - half * std::f64::consts::SQRT_2
            }
        }
    }

    fn distance(&self, piece: usize, p: [f64; 2]) -> f64 {
        match self.sides.get(piece) {
            Some(side) => side.distance(p).0,
            None => {
                let [ox, oy] = offset_from_arc(&self.arcs[piece - self.sides.len()], p);
                ox.hypot(oy)
            }
        }
    }

    fn magnitude(&self, piece: usize) -> f64 {
        match self.sides.get(piece) {
            Some(side) => side.magnitude(),
            None => {
                let arc = &self.arcs[piece - self.sides.len()];
                arc.center[0].abs().max(arc.center[1].abs()) + arc.radius
            }
        }
    }
}

/// The distance between a box and the square with this middle and half side.
fn distance_from_box(&[min_x, min_y, max_x, max_y]: &[f64; 4], p: [f64; 2], half: f64) -> f64 {
    let (dx, dy) = ((min_x - p[0]).max(p[0] - max_x), (min_y - p[1]).max(p[1] - max_y));
    let (dx, dy) = ((dx - half).max(0.0), (dy - half).max(0.0));
    (dx * dx + dy * dy).sqrt()
}
