//! Cost and parent of every node that a search has reached, in pages that are there only where it has: a search of a small part of
//! a large map touches nothing of the rest.

/// Nodes of a page.
const PAGE: usize = 256;

/// Least known cost and parent of a node.
type Node = (f64, u32);

const UNKNOWN: Node = (f64::INFINITY, u32::MAX);

/// Some nodes, and whether one of them was reached.
#[derive(Debug, Clone)]
struct Page {
    is_touched: bool,
    nodes: [Node; PAGE],
}

/// Costs and parents by node.
#[derive(Debug, Clone, Default)]
pub(crate) struct Nodes {
    pages: Vec<Option<Box<Page>>>,
    /// Pages that are not as new.
    touched: Vec<usize>,
}

impl Nodes {
    /// Forgets everything, for so many nodes.
    pub(crate) fn reset(&mut self, nodes: usize) {
        for page in self.touched.drain(..) {
            if let Some(Some(page)) = self.pages.get_mut(page) {
                page.nodes.fill(UNKNOWN);
                page.is_touched = false;
            }
        }
        self.pages.resize(nodes.div_ceil(PAGE), None);
    }

    /// The cost of a node; infinite where it was not reached.
    #[inline]
    pub(crate) fn cost(&self, node: usize) -> f64 {
        self.pages[node / PAGE].as_ref().map_or(f64::INFINITY, |page| page.nodes[node % PAGE].0)
    }

    /// The node that a reached one was reached from.
    pub(crate) fn parent(&self, node: usize) -> Option<usize> {
        let (cost, parent) = self.pages[node / PAGE].as_ref()?.nodes[node % PAGE];
        cost.is_finite().then_some(parent as usize)
    }

    /// A node is reached at this cost from that parent.
    pub(crate) fn reach(&mut self, node: usize, cost: f64, parent: u32) {
        let new = || Box::new(Page { is_touched: false, nodes: [UNKNOWN; PAGE] });
        let page = self.pages[node / PAGE].get_or_insert_with(new);
        if !page.is_touched {
            page.is_touched = true;
            self.touched.push(node / PAGE);
        }
        page.nodes[node % PAGE] = (cost, parent);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_reached_is_known_and_forgotten() {
        let mut nodes = Nodes::default();
        for size in [3000, 700, 2] {
            nodes.reset(size);
            assert!((0..size).all(|node| nodes.cost(node) == f64::INFINITY));
            assert_eq!(nodes.parent(1), None);
            for node in [0, 1, 255, 256, 699, 2999].into_iter().filter(|&node| node < size) {
                nodes.reach(node, node as f64, 7);
                nodes.reach(node, 0.5 * node as f64, node as u32);
                assert_eq!((nodes.cost(node), nodes.parent(node)), (0.5 * node as f64, Some(node)));
            }
        }
    }
}
