//! A tree of configurations and its nearest-neighbour search: all nodes are compared, sixteen at once.
//!
//! A tree of an arm has a few hundred nodes of 6 to 14 numbers, where structures that prune are
//! slower than reading everything: 1,000 nodes of seven joints take half a microsecond.

use crate::kernels::{Isa, LANES, dispatch, madd};

/// One number of sixteen nodes.
type Lane = [f32; LANES];

/// Nodes, each with the node it grew from.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    dof: usize,
    /// `[node][coordinate]`, f64: what the motions are certified with.
    values: Vec<f64>,
    /// `[block of 16 nodes][coordinate][lane]`, f32: what the search reads. Lanes without a node are infinite.
    lanes: Vec<Lane>,
    parents: Vec<u32>,
}

impl Tree {
    /// A tree of one node.
    pub(super) fn new(root: &[f64]) -> Self {
        let mut tree =
            Self { dof: root.len(), values: Vec::new(), lanes: Vec::new(), parents: Vec::new() };
        tree.push(root, 0);
        tree
    }

    /// Number of nodes.
    pub(super) fn len(&self) -> usize {
        self.parents.len()
    }

    /// The configuration of a node.
    pub(super) fn node(&self, node: usize) -> &[f64] {
        &self.values[node * self.dof..][..self.dof]
    }

    /// Adds a node and returns its number.
    pub(super) fn push(&mut self, configuration: &[f64], parent: usize) -> usize {
        let node = self.len();
        if node.is_multiple_of(LANES) {
            self.lanes.resize(self.lanes.len() + self.dof, [f32::INFINITY; LANES]);
        }
        let block = node / LANES * self.dof;
        for (lanes, &value) in self.lanes[block..].iter_mut().zip(configuration) {
            lanes[node % LANES] = value as f32;
        }
        self.values.extend_from_slice(configuration);
        self.parents.push(parent as u32);
        node
    }

    /// The node nearest to `target` by Euclidean distance of all coordinates; of equally near ones always the same.
    pub(super) fn nearest(&self, target: &[f64]) -> usize {
        nearest(Isa::detect(), &self.lanes, target) as usize
    }

    /// Appends the configurations from a node back to the root.
    pub(super) fn branch(&self, mut node: usize, path: &mut Vec<f64>) {
        path.extend_from_slice(self.node(node));
        while node != 0 {
            node = self.parents[node] as usize;
            path.extend_from_slice(self.node(node));
        }
    }
}

dispatch! {
    /// The number of the nearest node; see [`Tree::nearest`].
    fn nearest(lanes: &[Lane], target: &[f64]) -> u32 = nearest_body;
}

#[inline(always)]
fn nearest_body<const ISA: u8>(lanes: &[Lane], target: &[f64]) -> u32 {
    let mut least = [f32::INFINITY; LANES];
    let mut best = [0_u32; LANES];
    for (block, coordinates) in lanes.chunks_exact(target.len()).enumerate() {
        let mut square = [0.0_f32; LANES];
        for (values, &aim) in coordinates.iter().zip(target) {
            let aim = aim as f32;
            for lane in 0..LANES {
                let away = values[lane] - aim;
                square[lane] = madd::<ISA>(away, away, square[lane]);
            }
        }
        for lane in 0..LANES {
            let nearer = square[lane] < least[lane];
            least[lane] = if nearer { square[lane] } else { least[lane] };
            best[lane] = if nearer { block as u32 } else { best[lane] };
        }
    }
    let mut winner = 0;
    for lane in 1..LANES {
        if least[lane] < least[winner] {
            winner = lane;
        }
    }
    best[winner] * LANES as u32 + winner as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn nearest_matches_a_scan(
            nodes in prop::collection::vec(prop::array::uniform3(-3.0..3.0_f64), 1..80),
            target in prop::array::uniform3(-4.0..4.0_f64),
        ) {
            let mut tree = Tree::new(&nodes[0]);
            for node in &nodes[1..] {
                tree.push(node, 0);
            }
            let square = |node: &[f64]| -> f64 {
                node.iter().zip(&target).map(|(a, b)| (a - b).powi(2)).sum()
            };
            let least = nodes.iter().map(|node| square(node)).fold(f64::INFINITY, f64::min);
            prop_assert!(square(tree.node(tree.nearest(&target))) <= least + 1e-5);
            for isa in Isa::available() {
                prop_assert!(square(tree.node(nearest(isa, &tree.lanes, &target) as usize)) <= least + 1e-5);
            }
        }
    }
}
