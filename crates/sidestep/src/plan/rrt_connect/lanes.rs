//! Nearest of many configurations with more than two numbers: all are compared, sixteen at once, in f32.
//!
//! A tree of a robot with joints has a few hundred nodes of 6 to 14 numbers, where structures that prune are
//! slower than reading everything.

use crate::kernels::{Isa, LANES, dispatch, madd};

/// One number of sixteen nodes.
type Lane = [f32; LANES];

/// The nodes of a tree.
#[derive(Debug, Clone)]
pub(super) struct Lanes {
    dof: usize,
    count: usize,
    /// `[block of 16 nodes][coordinate][lane]`. Lanes without a node are infinite.
    values: Vec<Lane>,
}

impl Lanes {
    /// One node, `root [dof]`.
    pub(super) fn new(root: &[f64]) -> Self {
        let mut lanes = Self { dof: root.len(), count: 0, values: Vec::new() };
        lanes.push(root);
        lanes
    }

    /// Adds a node.
    pub(super) fn push(&mut self, point: &[f64]) {
        let (block, lane) = (self.count / LANES * self.dof, self.count % LANES);
        if lane == 0 {
            self.values.resize(block + self.dof, [f32::INFINITY; LANES]);
        }
        for (lanes, &value) in self.values[block..].iter_mut().zip(point) {
            lanes[lane] = value as f32;
        }
        self.count += 1;
    }

    /// The node nearest to `target [dof]`, but for rounding; of equally near ones always the same.
    pub(super) fn nearest(&self, target: &[f64]) -> usize {
        nearest(Isa::detect(), &self.values, target) as usize
    }
}

dispatch! {
    /// The number of the nearest node; see [`Lanes::nearest`].
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
            let mut lanes = Lanes::new(&nodes[0]);
            nodes[1..].iter().for_each(|node| lanes.push(node));
            let square = |node: &[f64; 3]| -> f64 {
                node.iter().zip(&target).map(|(a, b)| (a - b).powi(2)).sum()
            };
            let least = nodes.iter().map(square).fold(f64::INFINITY, f64::min);
            for isa in Isa::available() {
                let found = nearest(isa, &lanes.values, &target) as usize;
                prop_assert!(square(&nodes[found]) <= least + 1e-5);
            }
        }
    }
}
