//! A tree of positions with its nearest-neighbour search: all nodes while they are few, then square
//! buckets searched ring by ring.

use crate::plane::geometry::{Point, Rect};

/// Up to this many nodes, all are compared.
const MOST_WITHOUT_BUCKETS: usize = 256;
/// Buckets along each axis.
const PER_AXIS: usize = 64;
/// No node.
const NONE: u32 = u32::MAX;

/// Nodes, each with the node it grew from.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    points: Vec<Point>,
    parents: Vec<u32>,
    bounds: Rect,
    /// The last node of each bucket; empty while there are few nodes.
    heads: Vec<u32>,
    /// For each node the one before it in its bucket.
    next: Vec<u32>,
}

impl Tree {
    /// A tree of one node.
    pub(super) fn new(root: Point, bounds: Rect) -> Self {
        Self { points: vec![root], parents: vec![0], bounds, heads: Vec::new(), next: Vec::new() }
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// The position of a node.
    pub(super) fn point(&self, node: usize) -> Point {
        self.points[node]
    }

    /// Adds a node and returns its index.
    pub(super) fn push(&mut self, point: Point, parent: usize) -> usize {
        let node = self.points.len();
        self.points.push(point);
        self.parents.push(parent as u32);
        if node == MOST_WITHOUT_BUCKETS {
            self.heads = vec![NONE; PER_AXIS * PER_AXIS];
            (0..=node).for_each(|node| self.file(node));
        } else if node > MOST_WITHOUT_BUCKETS {
            self.file(node);
        }
        node
    }

    /// Puts a node into its bucket.
    fn file(&mut self, node: usize) {
        let [column, row] = self.bucket(self.points[node]);
        let head = &mut self.heads[row * PER_AXIS + column];
        self.next.push(std::mem::replace(head, node as u32));
    }

    /// Sides of a bucket.
    fn bucket_size(&self) -> Point {
        self.bounds.size().map(|side| side / PER_AXIS as f64)
    }

    /// The column and row of a point's bucket.
    fn bucket(&self, p: Point) -> [usize; 2] {
        let size = self.bucket_size();
        [0, 1].map(|axis| {
            let index = (p[axis] - self.bounds.min[axis]) / size[axis];
            (index.max(0.0) as usize).min(PER_AXIS - 1)
        })
    }

    /// The node nearest to `target`; of equally near ones any, but always the same.
    pub(super) fn nearest(&self, target: Point) -> usize {
        if self.heads.is_empty() {
            return self.nearest_of_all(target);
        }
        let size = self.bucket_size();
        let [column, row] = self.bucket(target).map(|index| index as i64);
        let (mut best, mut least) = (0, f64::INFINITY);
        for ring in 0..PER_AXIS as i64 {
            // Everything in this ring and beyond is at least this far, on one axis or the other.
            let away = (ring - 1).max(0) as f64 * size[0].min(size[1]);
            if away * away > least {
                break;
            }
            let rows = (row - ring).max(0)..=(row + ring).min(PER_AXIS as i64 - 1);
            for y in rows {
                let is_edge = (y - row).abs() == ring;
                let step = if is_edge || ring == 0 { 1 } else { 2 * ring as usize };
                for x in (column - ring..=column + ring).step_by(step) {
                    if !(0..PER_AXIS as i64).contains(&x) {
                        continue;
                    }
                    let mut node = self.heads[y as usize * PER_AXIS + x as usize];
                    while node != NONE {
                        let square = distance_squared(self.points[node as usize], target);
                        if square < least {
                            (best, least) = (node as usize, square);
                        }
                        node = self.next[node as usize];
                    }
                }
            }
        }
        best
    }

    fn nearest_of_all(&self, target: Point) -> usize {
        let (mut best, mut least) = (0, f64::INFINITY);
        for (node, &point) in self.points.iter().enumerate() {
            let square = distance_squared(point, target);
            if square < least {
                (best, least) = (node, square);
            }
        }
        best
    }

    /// The positions from a node back to the root.
    pub(super) fn branch(&self, mut node: usize) -> Vec<Point> {
        let mut points = vec![self.points[node]];
        while node != 0 {
            node = self.parents[node] as usize;
            points.push(self.points[node]);
        }
        points
    }
}

fn distance_squared(a: Point, b: Point) -> f64 {
    let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
    dx * dx + dy * dy
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn buckets_match_a_scan(
            points in prop::collection::vec((-1.0..9.0_f64, 2.0..4.0_f64), 300..600),
            targets in prop::collection::vec((-2.0..10.0_f64, 1.0..5.0_f64), 20),
        ) {
            let bounds = Rect { min: [-1.0, 2.0], max: [9.0, 4.0] };
            let mut tree = Tree::new([0.0, 3.0], bounds);
            for (x, y) in points {
                tree.push([x, y], 0);
            }
            for (x, y) in targets {
                let target = [x.clamp(-1.0, 9.0), y.clamp(2.0, 4.0)];
                let (fast, slow) = (tree.nearest(target), tree.nearest_of_all(target));
                prop_assert_eq!(
                    distance_squared(tree.point(fast), target),
                    distance_squared(tree.point(slow), target)
                );
            }
        }
    }
}
