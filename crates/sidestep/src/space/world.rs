//! Named objects in space, and the distance to each of their pieces.

use super::blocks::{self, Blocks, Frame32, PointBlock, Primitive};
use super::bounds::Bounds;
use super::index::Index;
use super::pose::Pose;
use super::shape::Shape;
use super::vector::{Vector, norm};
use crate::error::InvalidInput;
use crate::kernels::{Isa, LANES};

/// A convex piece of a world, numbered from 0 in the order of the objects and their shapes.
pub type PieceId = u32;

/// Most pieces that a world may have.
pub const MAX_PIECES: usize = 1 << 28;

/// A signed distance in metres and the unit normal there: the gradient, or a subgradient where
/// there is a kink.
pub type Distance = (f64, Vector);

/// A solid with a name: shapes, each at a pose in the world's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Object {
    name: String,
    shapes: Vec<(Pose, Shape)>,
}

impl Object {
    /// An object of these shapes; they may overlap.
    pub fn new(name: impl Into<String>, shapes: Vec<(Pose, Shape)>) -> Self {
        Self { name: name.into(), shapes }
    }

    /// What the object is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its shapes, each with its pose in the world's frame.
    pub fn shapes(&self) -> &[(Pose, Shape)] {
        &self.shapes
    }
}

/// Everything that a robot must not touch.
#[derive(Debug, Clone, Default)]
pub struct World {
    objects: Vec<Object>,
    parts: Vec<Part>,
    /// The part of each piece.
    part_of: Vec<u32>,
    index: Index,
    bounds: Option<Bounds>,
}

/// A shape of an object, ready for questions.
#[derive(Debug, Clone)]
struct Part {
    object: u32,
    /// Which of the object's shapes.
    shape: u32,
    first: PieceId,
    frame: Frame32,
    /// Distance of the shape's farthest point from its own origin, metres.
    radius: f64,
}

/// Worlds of equal objects are equal.
impl PartialEq for World {
    fn eq(&self, other: &Self) -> bool {
        self.objects == other.objects
    }
}

impl World {
    /// A world of these objects; none at all is allowed.
    ///
    /// # Errors
    /// If a name is empty or taken, an object has no shape, or a shape's number is not allowed.
    pub fn new(objects: Vec<Object>) -> Result<Self, InvalidInput> {
        let mut names = std::collections::HashSet::new();
        let (mut parts, mut part_of, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
        for (i, object) in objects.iter().enumerate() {
            let place = format!("objects[{i}]");
            if object.name.is_empty() || !names.insert(object.name.as_str()) {
                let found = format!("{:?}", object.name);
                return Err(InvalidInput::new(
                    format!("{place}.name"),
                    found,
                    "a name that no other object has",
                ));
            }
            if object.shapes.is_empty() {
                return Err(InvalidInput::new(
                    format!("{place}.shapes"),
                    "none",
                    "at least one shape",
                ));
            }
            for (j, (pose, shape)) in object.shapes.iter().enumerate() {
                shape.clone().checked().map_err(|e| e.inside(&format!("{place}.shapes[{j}]")))?;
                if part_of.len() + shape.pieces() > MAX_PIECES {
                    let found = format!("more than {MAX_PIECES} pieces");
                    let allowed = format!("at most {MAX_PIECES} triangles, points and cells");
                    return Err(InvalidInput::new("objects", found, allowed));
                }
                let first = part_of.len() as PieceId;
                part_of.resize(part_of.len() + shape.pieces(), parts.len() as u32);
                let mut radius = 0.0_f64;
                for piece in 0..shape.pieces() {
                    let Some(bounds) = shape.piece_bounds(piece) else { continue };
                    boxes.push((placed(bounds, pose), first + piece as PieceId));
                    let farthest = [0, 1, 2].map(|k| bounds.min[k].abs().max(bounds.max[k].abs()));
                    radius = radius.max(norm(farthest));
                }
                let frame = Frame32::new(pose);
                parts.push(Part { object: i as u32, shape: j as u32, first, frame, radius });
            }
        }
        let bounds = boxes.iter().map(|(bounds, _)| *bounds).reduce(Bounds::union);
        Ok(Self { index: Index::new(boxes), objects, parts, part_of, bounds })
    }

    /// The objects, in the order in which they were given.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Number of pieces; piece ids are below it.
    pub fn pieces(&self) -> usize {
        self.part_of.len()
    }

    /// A box around everything, in metres; nothing if the world is empty.
    pub fn bounds(&self) -> Option<Bounds> {
        self.bounds
    }

    /// The object that a piece belongs to.
    pub fn object_of(&self, piece: PieceId) -> &Object {
        &self.objects[self.part(piece).object as usize]
    }

    /// The name of the object that a piece belongs to.
    pub fn name_of(&self, piece: PieceId) -> &str {
        &self.object_of(piece).name
    }

    /// Signed distance from `p` to a piece, negative inside, and the unit normal there; f64, exact
    /// but for rounding.
    ///
    /// The distance is 1-Lipschitz and convex in `p`, and the normal a subgradient of it.
    #[inline]
    pub fn distance(&self, piece: PieceId, p: Vector) -> Distance {
        let part = self.part(piece);
        let (pose, shape) = self.shape_of(part);
        let (distance, normal) =
            shape.distance((piece - part.first) as usize, pose.apply_inverse(p));
        (distance, pose.rotate(normal))
    }

    /// The pieces that may lie within `reach` of `center` (metres): all that do, and perhaps a few
    /// others. `found` is cleared first; no order is promised, but the same question gives the same
    /// answer.
    #[inline]
    pub fn near(&self, center: Vector, reach: f64, found: &mut Vec<PieceId>) {
        found.clear();
        self.index.near(center, reach, |piece| found.push(piece));
    }

    /// [`Self::distance`] of one piece for blocks of points, in f32: `distances[block][lane]` and
    /// `normals[block][axis][lane]` answer for `points[block][axis][lane]`. The slices are equally
    /// long.
    ///
    /// A distance is off by at most [`Self::block_error`].
    #[inline]
    pub fn block_distances(
        &self,
        piece: PieceId,
        points: &[PointBlock],
        distances: &mut [[f32; LANES]],
        normals: &mut [PointBlock],
    ) {
        let part = self.part(piece);
        let (_, shape) = self.shape_of(part);
        let i = (piece - part.first) as usize;
        let mut blocks = Blocks { points, distances, normals };
        blocks::distances(Isa::detect(), shape, i, &part.frame, &mut blocks);
    }

    /// The piece as a primitive, if it is one; its distances are those of [`Self::block_distances`] to the bit.
    #[inline]
    pub(crate) fn primitive(&self, piece: PieceId) -> Option<Primitive> {
        let part = self.part(piece);
        Primitive::of(&self.shape_of(part).1, (piece - part.first) as usize, &part.frame)
    }

    /// The axis-aligned box around a piece, in metres; none if there is nothing.
    pub(crate) fn piece_bounds(&self, piece: PieceId) -> Option<Bounds> {
        let part = self.part(piece);
        let (pose, shape) = self.shape_of(part);
        Some(placed(shape.piece_bounds((piece - part.first) as usize)?, pose))
    }

    /// How far a distance of [`Self::block_distances`] may be from the exact one for the same f32
    /// point, in metres, if no point is farther than `reach` from the world's origin. The bound is
    /// derived in `space/blocks.rs`.
    pub fn block_error(&self, piece: PieceId, reach: f64) -> f64 {
        let part = self.part(piece);
        let away = norm(self.shape_of(part).0.translation());
        blocks::ERROR * (reach + away + part.radius)
    }

    #[inline(always)]
    fn part(&self, piece: PieceId) -> &Part {
        &self.parts[self.part_of[piece as usize] as usize]
    }

    #[inline(always)]
    fn shape_of(&self, part: &Part) -> &(Pose, Shape) {
        &self.objects[part.object as usize].shapes[part.shape as usize]
    }
}

/// The axis-aligned box around a box at a pose.
fn placed(bounds: Bounds, pose: &Pose) -> Bounds {
    let center = pose.apply(bounds.center());
    let half = [0, 1, 2].map(|k| 0.5 * (bounds.max[k] - bounds.min[k]));
    let reach = pose.rotation().map(|row| (0..3).map(|k| row[k].abs() * half[k]).sum::<f64>());
    Bounds {
        min: [0, 1, 2].map(|k| center[k] - reach[k]),
        max: [0, 1, 2].map(|k| center[k] + reach[k]),
    }
}
