//! Which of many pieces can be nearest to a point: a quadtree whose leaves list candidates.
//!
//! A piece can be nearest to some point of a square with middle c and half diagonal h only if its distance from c
//! is at most 2 h more than that of the piece nearest to c, and its distance from the square at most h more: going
//! from c to the point changes each distance by h at most. A square's list is filtered from its parent's, so the lists of all squares of one size cost about as much as there
//! are pieces. What is nearest by rounded arithmetic may be further by a little; each distance counts with that error.

use std::collections::VecDeque;

/// Lists of at most so many pieces are not divided further.
const LEAF: usize = 16;
/// Most divisions of the root.
const DEPTH: u32 = 12;
/// Entries over all lists, per piece, above which nothing is divided any more.
const MOST_ENTRIES_PER_PIECE: usize = 40;
/// Rounding of a distance in f32, as a part of the numbers that it is computed from.
const ROUNDING: f64 = 4e-6;
/// In [`Index::leaf`]: the point is outside the root.
pub(super) const OUTSIDE: u32 = u32::MAX;
/// In a node: the child is a leaf.
const IS_LEAF: u32 = 1 << 31;

/// Pieces whose distances bound each other, in normalised units.
pub(super) trait Pieces {
    /// How many there are.
    fn len(&self) -> usize;
    /// At most the distance to a piece from any point of the square with middle `p` and this half side, quickly; the closer,
    /// the shorter the lists.
    fn least(&self, piece: usize, p: [f64; 2], half: f64) -> f64;
    /// The distance from `p` to a piece, 0 inside.
    fn distance(&self, piece: usize, p: [f64; 2]) -> f64;
    /// The largest magnitude among the numbers of a piece.
    fn magnitude(&self, piece: usize) -> f64;
}

/// A quadtree over a square.
#[derive(Debug, Clone)]
pub(super) struct Index {
    /// Lower left corner of the root.
    low: [f32; 2],
    /// One over its side.
    inverse: f32,
    /// Children of each divided square, lower left, lower right, upper left, upper right.
    nodes: Vec<[u32; 4]>,
    /// Where the list of each leaf begins; one more than there are leaves.
    begin: Vec<u32>,
    entries: Vec<u32>,
}

/// A square that is still to be divided, or a leaf.
struct Square {
    middle: [f64; 2],
    half: f64,
    depth: u32,
    /// At least the distance from the middle to the nearest piece, with its error.
    nearest: f64,
    /// Whether it may hold some of a piece. A square that does not is only divided where that shortens its list.
    holds: bool,
    list: Vec<u32>,
    /// The node and the child's number that lead here.
    parent: Option<(usize, usize)>,
}

impl Index {
    /// The index of pieces for points in the square with this lower left corner and side; none once `go_on` is false.
    pub(super) fn new(
        pieces: &impl Pieces,
        low: [f32; 2],
        side: f32,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let half = 0.5 * f64::from(side);
        let root = Square {
            middle: low.map(|low| f64::from(low) + half),
            half,
            depth: 0,
            nearest: f64::INFINITY,
            holds: true,
            list: (0..pieces.len() as u32).collect(),
            parent: None,
        };
        let mut index = Self {
            low,
            inverse: 1.0 / side,
            nodes: Vec::new(),
            begin: vec![0],
            entries: Vec::new(),
        };
        let most = MOST_ENTRIES_PER_PIECE * pieces.len();
        let mut held = pieces.len();
        // Squares that hold pieces go first, however small; within both kinds the larger ones.
        let (mut near, mut far) = (VecDeque::from([root]), VecDeque::new());
        while let Some(square) = near.pop_front().or_else(|| far.pop_front()) {
            if !go_on() {
                return None;
            }
            let may_divide = square.list.len() > LEAF && square.depth < DEPTH && held < most;
            let children = may_divide.then(|| square.divided(pieces));
            let total = |children: &[Square; 4]| -> usize {
                children.iter().map(|child| child.list.len()).sum()
            };
            let worth = |children: &[Square; 4]| {
                square.holds || 10 * total(children) < 36 * square.list.len()
            };
            let link = match children.filter(worth) {
                Some(mut children) => {
                    held = held + total(&children) - square.list.len();
                    let node = index.nodes.len();
                    index.nodes.push([0; 4]);
                    for (number, child) in children.iter_mut().enumerate() {
                        child.parent = Some((node, number));
                    }
                    for child in children {
                        if child.holds { &mut near } else { &mut far }.push_back(child);
                    }
                    node as u32
                }
                None => {
                    index.entries.extend(&square.list);
                    index.begin.push(index.entries.len() as u32);
                    IS_LEAF | (index.begin.len() - 2) as u32
                }
            };
            if let Some((node, number)) = square.parent {
                index.nodes[node][number] = link;
            }
        }
        Some(index)
    }

    /// The leaf that holds a point; [`OUTSIDE`] where there is none.
    #[inline(always)]
    pub(super) fn leaf(&self, x: f32, y: f32) -> u32 {
        let (u, v) = ((x - self.low[0]) * self.inverse, (y - self.low[1]) * self.inverse);
        // Also false where one is not a number.
        let inside = (0.0..1.0).contains(&u) && (0.0..1.0).contains(&v);
        if !inside {
            return OUTSIDE;
        }
        if self.nodes.is_empty() {
            return 0;
        }
        let whole = (1 << DEPTH) as f32;
        let (column, row) = ((u * whole) as u32, (v * whole) as u32);
        let (mut node, mut level) = (0, DEPTH);
        loop {
            level -= 1;
            let quarter = (column >> level & 1) | (row >> level & 1) << 1;
            let link = self.nodes[node][quarter as usize];
            if link & IS_LEAF != 0 {
                return link & !IS_LEAF;
            }
            node = link as usize;
        }
    }

    /// The candidates of a leaf, ascending.
    #[inline(always)]
    pub(super) fn candidates(&self, leaf: u32) -> &[u32] {
        let leaf = leaf as usize;
        &self.entries[self.begin[leaf] as usize..self.begin[leaf + 1] as usize]
    }
}

impl Square {
    /// The four quarters with what of the list can be nearest there.
    fn divided(&self, pieces: &impl Pieces) -> [Self; 4] {
        let half = 0.5 * self.half;
        std::array::from_fn(|number| {
            let side = |bit: usize| if number & bit == 0 { -half } else { half };
            let middle = [self.middle[0] + side(1), self.middle[1] + side(2)];
            let size = middle[0].abs().max(middle[1].abs()) + half;
            let error = |piece: u32, distance: f64| {
                ROUNDING * (size + distance + pieces.magnitude(piece as usize))
            };
            let radius = 1.0001 * half * std::f64::consts::SQRT_2;
            // From the parent's middle the nearest piece is at most so much further.
            let mut nearest = self.nearest + radius;
            for &piece in &self.list {
                if pieces.least(piece as usize, middle, 0.0) < nearest {
                    let distance = pieces.distance(piece as usize, middle);
                    nearest = nearest.min(distance + error(piece, distance));
                }
            }
            // The rounding of a place is far below a part in ten thousand of the smallest square.
            let mut holds = false;
            let list = self.list.iter().copied().filter(|&piece| {
                let least = pieces.least(piece as usize, middle, 1.0001 * half);
                holds |= least <= 0.0;
                least <= nearest + radius + error(piece, least) && {
                    let least = pieces.least(piece as usize, middle, 0.0);
                    least <= nearest + 2.0 * radius + error(piece, least)
                }
            });
            let list = list.collect();
            let depth = self.depth + 1;
            Self { middle, half, depth, nearest, holds, list, parent: None }
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::shapes::ShapeField;
    use super::super::{LANES, Samples};
    use crate::plane::frame::Frame;
    use crate::plane::geometry::{Circle, ConvexPolygon, Rect};
    use crate::plane::world::Obstacle;
    use crate::profile::Profile;

    /// Shapes on a lattice, so that ties happen; a few of them large.
    fn shape() -> impl Strategy<Value = Obstacle> {
        let size = prop_oneof![9 => 1..8_i32, 1 => 8..80_i32];
        (0..3, 0..400_i32, 0..400_i32, size.clone(), size).prop_map(|(kind, x, y, w, h)| {
            let [x, y, w, h] = [x, y, w, h].map(|i| 0.25 * f64::from(i));
            match kind {
                0 => Obstacle::Rect(Rect::new([x, y], [x + w, y + h]).unwrap()),
                1 => Obstacle::Circle(Circle::new([x, y], w).unwrap()),
                _ => {
                    let corners = vec![[x, y], [x + w, y], [x + w / 2.0, y + h]];
                    Obstacle::Polygon(ConvexPolygon::new(corners).unwrap())
                }
            }
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn an_index_changes_no_bit(
            shapes in prop::collection::vec(shape(), 257..600),
            points in prop::collection::vec((-100..500_i32, -100..500_i32, -9..9_i32), 64),
        ) {
            let frame = Frame::new(&Profile::DEFAULT, Rect { min: [0.0; 2], max: [100.0; 2] });
            let indexed = ShapeField::new(&shapes, &frame, [6.4; 2], &|| true).unwrap();
            let plain = indexed.clone().without_index();
            let coordinate = |i: i32, by: i32| 0.016 * i as f32 + 1e-6 * by as f32;
            let x: Vec<f32> = points.iter().map(|&(x, _, by)| coordinate(x, by)).collect();
            let y: Vec<f32> = points.iter().map(|&(_, y, by)| coordinate(y, -by)).collect();
            assert_eq!(x.len() % LANES, 0);
            let answers = [&indexed, &plain].map(|field| {
                let mut all = [(); 4].map(|()| vec![0.0; x.len()]);
                let [distance, gradient_x, gradient_y, probed] = &mut all;
                field.sample(&x, &y, &mut Samples { distance, gradient_x, gradient_y });
                field.probe(&x, &y, probed);
                all.map(|values| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
            });
            prop_assert_eq!(&answers[0], &answers[1]);
        }
    }

    #[test]
    fn leaves_are_short_where_shapes_are_small() {
        let square = |i: usize| {
            let corner = [(i % 100) as f64, (i / 100) as f64];
            Obstacle::Rect(Rect::new(corner, corner.map(|x| x + 0.4)).unwrap())
        };
        let shapes: Vec<_> = (0..10_000).map(square).collect();
        let frame = Frame::new(&Profile::DEFAULT, Rect { min: [0.0; 2], max: [100.0; 2] });
        let field = ShapeField::new(&shapes, &frame, [6.4; 2], &|| true).unwrap();
        let index = field.shapes_index().unwrap();
        let mut most = 0;
        for i in 0..10_000 {
            let p = [i % 100, i / 100].map(|i| 0.064 * (i as f32 + 0.7));
            most = most.max(index.candidates(index.leaf(p[0], p[1])).len());
        }
        assert!(most <= 16, "{most}");
        assert!(index.entries.len() < 30 * shapes.len(), "{}", index.entries.len());
    }
}
