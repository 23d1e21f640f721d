//! A tree of configurations with its nearest-neighbour search: all nodes while they are few, then buckets over the first
//! two coordinates, searched ring by ring. Two configurations are at least as far apart as in these two. With more than two
//! coordinates `lanes` does it.

use super::lanes::Lanes;

/// Up to this many nodes, all are compared.
const MOST_WITHOUT_BUCKETS: usize = 256;
/// Buckets along each axis: as many as a `u64` has bits.
const PER_AXIS: usize = 64;
/// No node.
const NONE: u32 = u32::MAX;

/// Nodes, each with the node it grew from.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    dof: usize,
    /// `[nodes x dof]`.
    points: Vec<f64>,
    parents: Vec<u32>,
    /// The same points for the search, where they have more than two coordinates.
    lanes: Option<Lanes>,
    /// How far a sample may be that a node is extended towards; with more than two coordinates.
    domains: Vec<f64>,
    /// Least value of the first two coordinates, and sides of a bucket; a lone coordinate counts twice.
    least: [f64; 2],
    sides: [f64; 2],
    /// The last node of each bucket; empty while there are few nodes.
    heads: Vec<u32>,
    /// Which buckets of each row, and of each column, hold nodes: a bit each.
    rows: [u64; PER_AXIS],
    columns: [u64; PER_AXIS],
    /// For each node the one before it in its bucket.
    next: Vec<u32>,
}

impl Tree {
    /// A tree of one node `root [dof]`, in the space within `limits [dof]`.
    pub(super) fn new(root: &[f64], limits: &[[f64; 2]]) -> Self {
        let axes = [limits[0], limits[1.min(limits.len() - 1)]];
        let mut points = Vec::with_capacity(32 * root.len());
        points.extend_from_slice(root);
        Self {
            dof: root.len(),
            points,
            parents: vec![0],
            lanes: (root.len() > 2).then(|| Lanes::new(root)),
            domains: vec![f64::INFINITY],
            least: axes.map(|[least, _]| least),
            sides: axes.map(|[least, most]| (most - least) / PER_AXIS as f64),
            heads: Vec::new(),
            rows: [0; PER_AXIS],
            columns: [0; PER_AXIS],
            next: Vec::new(),
        }
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.parents.len()
    }

    /// The configuration of a node, `[dof]`.
    pub(super) fn point(&self, node: usize) -> &[f64] {
        &self.points[node * self.dof..][..self.dof]
    }

    /// Adds a node and returns its index.
    pub(super) fn push(&mut self, point: &[f64], parent: usize) -> usize {
        let node = self.len();
        self.points.extend_from_slice(point);
        self.parents.push(parent as u32);
        if let Some(lanes) = &mut self.lanes {
            lanes.push(point);
            self.domains.push(f64::INFINITY);
        } else if node == MOST_WITHOUT_BUCKETS {
            self.heads = vec![NONE; PER_AXIS * PER_AXIS];
            (0..=node).for_each(|node| self.file(node));
        } else if node > MOST_WITHOUT_BUCKETS {
            self.file(node);
        }
        node
    }

    /// How far from a node samples may be; infinite with two coordinates.
    pub(super) fn domain(&self, node: usize) -> f64 {
        self.domains.get(node).copied().unwrap_or(f64::INFINITY)
    }

    /// A node's extension was blocked: it stands at the edge of what is free, and samples beyond `domain` are in vain.
    pub(super) fn restrict(&mut self, node: usize, domain: f64) {
        if self.lanes.is_some() {
            self.domains[node] = domain;
        }
    }

    /// Puts a node into its bucket.
    fn file(&mut self, node: usize) {
        let [column, row] = self.bucket(self.point(node));
        let head = &mut self.heads[row * PER_AXIS + column];
        self.next.push(std::mem::replace(head, node as u32));
        self.rows[row] |= 1 << column;
        self.columns[column] |= 1 << row;
    }

    /// The column and row of a configuration's bucket.
    fn bucket(&self, p: &[f64]) -> [usize; 2] {
        [0, 1].map(|axis| {
            let index = (p[axis.min(p.len() - 1)] - self.least[axis]) / self.sides[axis];
            (index.max(0.0) as usize).min(PER_AXIS - 1)
        })
    }

    /// The node nearest to `target [dof]`; of equally near ones any, but always the same.
    pub(super) fn nearest(&self, target: &[f64]) -> usize {
        if let Some(lanes) = &self.lanes {
            return lanes.nearest(target);
        }
        if self.heads.is_empty() {
            return self.nearest_of_all(target);
        }
        let [column, row] = self.bucket(target);
        let mut nearest = (0, f64::INFINITY);
        for ring in 0..PER_AXIS {
            // The ring's four sides, the corners with the rows.
            let (above, beside) = (edges(row, ring), edges(column, ring));
            for row in bits(above) {
                for column in bits(self.rows[row] & within(column, ring)) {
                    self.compare_bucket(column, row, target, &mut nearest);
                }
            }
            for column in bits(beside) {
                for row in bits(self.columns[column] & within(row, ring) & !above) {
                    self.compare_bucket(column, row, target, &mut nearest);
                }
            }
            // Everything beyond is at least this far, on one axis or the other.
            let away = ring as f64 * self.sides[0].min(self.sides[1]);
            if away * away > nearest.1 {
                break;
            }
        }
        nearest.0
    }

    /// Keeps a node of the bucket, and its squared distance, if it is nearer than what is known.
    #[inline]
    fn compare_bucket(
        &self,
        column: usize,
        row: usize,
        target: &[f64],
        nearest: &mut (usize, f64),
    ) {
        let mut node = self.heads[row * PER_AXIS + column];
        while node != NONE {
            let square = distance_squared(self.point(node as usize), target);
            if square < nearest.1 {
                *nearest = (node as usize, square);
            }
            node = self.next[node as usize];
        }
    }

    fn nearest_of_all(&self, target: &[f64]) -> usize {
        let (mut best, mut least) = (0, f64::INFINITY);
        for (node, point) in self.points.chunks_exact(self.dof).enumerate() {
            let square = distance_squared(point, target);
            if square < least {
                (best, least) = (node, square);
            }
        }
        best
    }

    /// The nodes from one back to the root.
    pub(super) fn branch(&self, node: usize) -> impl Iterator<Item = &[f64]> {
        let parent = |&node: &usize| (node != 0).then(|| self.parents[node] as usize);
        std::iter::successors(Some(node), parent).map(|node| self.point(node))
    }
}

/// The places `ring` away from `at`, as bits.
fn edges(at: usize, ring: usize) -> u64 {
    let below = if at >= ring { 1 << (at - ring) } else { 0 };
    let above = if at + ring < PER_AXIS { 1 << (at + ring) } else { 0 };
    below | above
}

/// The places up to `ring` away from `at`, as bits.
fn within(at: usize, ring: usize) -> u64 {
    let (first, last) = (at.saturating_sub(ring), (at + ring).min(PER_AXIS - 1));
    (u64::MAX << first) & (u64::MAX >> (PER_AXIS - 1 - last))
}

/// The places whose bits are set, in order.
fn bits(set: u64) -> impl Iterator<Item = usize> {
    let rest = |rest: &u64| Some(rest & (rest - 1)).filter(|rest| *rest != 0);
    std::iter::successors((set != 0).then_some(set), rest).map(|set| set.trailing_zeros() as usize)
}

#[inline]
fn distance_squared(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + (a - b) * (a - b))
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
            let mut tree = Tree::new(&[0.0, 3.0], &[[-1.0, 9.0], [2.0, 4.0]]);
            for (x, y) in points {
                tree.push(&[x, y], 0);
            }
            for (x, y) in targets {
                let target = [x.clamp(-1.0, 9.0), y.clamp(2.0, 4.0)];
                let (fast, slow) = (tree.nearest(&target), tree.nearest_of_all(&target));
                prop_assert_eq!(
                    distance_squared(tree.point(fast), &target),
                    distance_squared(tree.point(slow), &target)
                );
            }
        }
    }
}
