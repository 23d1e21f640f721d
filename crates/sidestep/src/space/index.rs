//! A tree of boxes around pieces: which pieces may lie within reach of a point, without a look at
//! the rest.
//!
//! Built top-down by the median of the centres on the longest axis, so it is balanced and the same
//! on every machine. Boxes are f32, rounded outwards, and only ever lead to too many pieces, never
//! to too few.

use super::bounds::Bounds;
use super::vector::Vector;

/// Pieces in a leaf: looking at four boxes costs about as much as one step down.
const LEAF: usize = 4;

/// Deeper than any tree of 2^32 pieces, whose halves differ by at most one.
const DEEPEST: usize = 40;

/// The tree: nodes in preorder, the left child behind its parent.
#[derive(Debug, Clone, Default)]
pub(super) struct Index {
    nodes: Vec<Node>,
    /// In the leaves' order.
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    around: Rounded,
    /// Of a leaf its first piece, of an inner node its right child.
    first: u32,
    /// Pieces of a leaf; 0 in an inner node.
    count: u32,
}

#[derive(Debug, Clone, Copy)]
struct Piece {
    around: Rounded,
    id: u32,
}

/// A box in f32 that holds the one it was made of.
#[derive(Debug, Clone, Copy)]
struct Rounded {
    min: [f32; 3],
    max: [f32; 3],
}

impl Rounded {
    fn new(bounds: Bounds) -> Self {
        Self {
            min: bounds.min.map(|v| (v as f32).next_down()),
            max: bounds.max.map(|v| (v as f32).next_up()),
        }
    }

    #[inline(always)]
    fn squared_distance(&self, p: Vector) -> f64 {
        let bounds = Bounds { min: self.min.map(f64::from), max: self.max.map(f64::from) };
        bounds.squared_distance(p)
    }
}

impl Index {
    /// A tree of these boxes, each with its piece.
    pub(super) fn new(mut boxes: Vec<(Bounds, u32)>) -> Self {
        let mut index = Self { nodes: Vec::new(), pieces: Vec::with_capacity(boxes.len()) };
        if !boxes.is_empty() {
            index.grow(&mut boxes);
        }
        index
    }

    fn grow(&mut self, boxes: &mut [(Bounds, u32)]) {
        let around = boxes.iter().fold(Bounds::EMPTY, |all, (bounds, _)| all.union(*bounds));
        let at = self.nodes.len();
        let first = self.pieces.len() as u32;
        let count = if boxes.len() <= LEAF { boxes.len() as u32 } else { 0 };
        self.nodes.push(Node { around: Rounded::new(around), first, count });
        if count > 0 {
            let piece = |&(bounds, id): &(Bounds, u32)| Piece { around: Rounded::new(bounds), id };
            self.pieces.extend(boxes.iter().map(piece));
            return;
        }
        let spread = |k: usize| {
            let centers = boxes.iter().map(|(bounds, _)| bounds.center()[k]);
            let (low, high) =
                centers.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        };
        let spreads = [spread(0), spread(1), spread(2)];
        let axis = (1..3).fold(0, |best, k| if spreads[k] > spreads[best] { k } else { best });
        let middle = boxes.len() / 2;
        boxes.select_nth_unstable_by(middle, |(a, i), (b, j)| {
            a.center()[axis].total_cmp(&b.center()[axis]).then(i.cmp(j))
        });
        let (left, right) = boxes.split_at_mut(middle);
        self.grow(left);
        self.nodes[at].first = self.nodes.len() as u32;
        self.grow(right);
    }

    /// Calls `found` with every piece whose box lies within `reach` of `center`, and perhaps with a
    /// few others.
    #[inline]
    pub(super) fn near(&self, center: Vector, reach: f64, mut found: impl FnMut(u32)) {
        let square = reach * reach;
        if self.nodes.is_empty() || reach < 0.0 {
            return;
        }
        let mut open = [0u32; DEEPEST];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let at = open[depth];
            let node = &self.nodes[at as usize];
            if node.around.squared_distance(center) > square {
                continue;
            }
            if node.count == 0 {
                open[depth] = node.first;
                open[depth + 1] = at + 1;
                depth += 2;
                continue;
            }
            let leaf = node.first as usize..(node.first + node.count) as usize;
            for piece in &self.pieces[leaf] {
                if piece.around.squared_distance(center) <= square {
                    found(piece.id);
                }
            }
        }
    }
}
