//! Which pieces of the world may be near to a part of the body, and how far sixteen points are from one.
//!
//! Of a world with few pieces (a shelf, a table) the boxes around them lie side by side, and sixteen are looked at
//! at once; larger ones have the tree of [`World::near`].

use std::sync::Arc;

use super::lanes::{Lane, Points};
use crate::kernels::LANES;
use crate::kernels::lanes::above;
use crate::space::{PieceId, Primitive, World};

/// A world with more pieces than this is asked by its tree.
const FEW: usize = 64;

/// A world, ready for the questions of an arm.
#[derive(Debug, Clone)]
pub(super) struct Surroundings {
    world: Arc<World>,
    /// `[group of 16 pieces]`: least and largest coordinates of their boxes; none where there are too many.
    boxes: Option<Vec<[Points; 2]>>,
    /// The pieces that are primitives, where there are few pieces.
    primitives: Vec<Option<Primitive>>,
}

impl Surroundings {
    pub(super) fn new(world: Arc<World>) -> Self {
        if world.pieces() > FEW {
            return Self { world, boxes: None, primitives: Vec::new() };
        }
        let groups = world.pieces().div_ceil(LANES);
        let nowhere = [[[f32::INFINITY; LANES]; 3], [[f32::NEG_INFINITY; LANES]; 3]];
        let mut boxes = vec![nowhere; groups];
        let pieces = 0..world.pieces() as PieceId;
        for piece in pieces.clone() {
            let (group, lane) = (piece as usize / LANES, piece as usize % LANES);
            let Some(bounds) = world.piece_bounds(piece) else { continue };
            for axis in 0..3 {
                boxes[group][0][axis][lane] = (bounds.min[axis] as f32).next_down();
                boxes[group][1][axis][lane] = (bounds.max[axis] as f32).next_up();
            }
        }
        let primitives = pieces.map(|piece| world.primitive(piece)).collect();
        Self { world, boxes: Some(boxes), primitives }
    }

    /// The pieces that may come within `reach` of the box between `low` and `high`: all that do, and perhaps a few others.
    /// `found` is cleared first.
    #[inline(always)]
    pub(super) fn near<const ISA: u8>(
        &self,
        [low, high]: &[[f32; 3]; 2],
        reach: f32,
        found: &mut Vec<PieceId>,
    ) {
        // More than the differences below lose by rounding.
        let reach = reach * (1.0 + 1e-5) + 1e-6;
        let Some(boxes) = &self.boxes else {
            let (mut center, mut square) = ([0.0; 3], 0.0);
            for axis in 0..3 {
                center[axis] = 0.5 * (f64::from(low[axis]) + f64::from(high[axis]));
                square += (0.5 * (f64::from(high[axis]) - f64::from(low[axis]))).powi(2);
            }
            self.world.near(center, f64::from(reach) + square.sqrt(), found);
            return;
        };
        found.clear();
        for (group, [least, largest]) in boxes.iter().enumerate() {
            let mut gap: Lane = [0.0; LANES];
            for lane in 0..LANES {
                for axis in 0..3 {
                    let before = least[axis][lane] - high[axis];
                    let behind = low[axis] - largest[axis][lane];
                    let away = if before > behind { before } else { behind };
                    gap[lane] = if away > gap[lane] { away } else { gap[lane] };
                }
            }
            // What is behind the last piece is infinitely far, but for boxes with a NaN.
            let pieces = self.primitives.len() - group * LANES;
            let known = if pieces < LANES { (1 << pieces) - 1 } else { 0xffff };
            let mut bits = !above::<ISA>(&gap, reach) & known;
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                found.push((group * LANES + lane) as PieceId);
            }
        }
    }

    #[inline(always)]
    fn primitive(&self, piece: PieceId) -> Option<Primitive> {
        match &self.boxes {
            Some(_) => self.primitives[piece as usize],
            None => self.world.primitive(piece),
        }
    }

    /// Distances of sixteen points from a piece.
    #[inline(always)]
    pub(super) fn distances<const ISA: u8>(&self, piece: PieceId, points: &Points) -> Lane {
        if let Some(primitive) = self.primitive(piece) {
            return primitive.distances::<ISA>(points);
        }
        let (mut distances, mut normals) = ([[0.0; LANES]], [[[0.0; LANES]; 3]]);
        let points = std::slice::from_ref(points);
        self.world.block_distances(piece, points, &mut distances, &mut normals);
        distances[0]
    }

    /// Distances of sixteen points from a piece and the normals there.
    #[inline(always)]
    pub(super) fn answer<const ISA: u8>(&self, piece: PieceId, points: &Points) -> (Lane, Points) {
        let (mut distances, mut normals) = ([[0.0; LANES]], [[[0.0; LANES]; 3]]);
        if let Some(primitive) = self.primitive(piece) {
            primitive.answer::<ISA>(points, &mut distances[0], &mut normals[0]);
        } else {
            let points = std::slice::from_ref(points);
            self.world.block_distances(piece, points, &mut distances, &mut normals);
        }
        (distances[0], normals[0])
    }
}
