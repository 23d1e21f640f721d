//! A* over the corners, with edges checked only when they come up.
//!
//! Hart, Nilsson and Raphael 1968 with the straight line as the heuristic; an edge enters the queue
//! with the cost that it has if it is free, and is checked when it leaves it (lazy weighted A*,
//! Cohen, Phillips and Likhachev 2014). Edges that no shortest path uses never enter: at a corner
//! the path must touch the obstacle on the side that it turns to (*taut*), and it must not
//! run into the obstacle whose corner it arrives at (*tangent*).
//!
//! Taut and tangent are judged with a slack of many tolerances, so that sides on one line and corners on
//! top of each other keep all their edges; a failure that has to be a proof is repeated without
//! these rules.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::corners::Corner;
use super::layer::Layer;
use super::nodes::Nodes;
use crate::plane::geometry::{Point, cross, distance, norm, scale, sub};

/// Most edges waiting, for the sake of memory (24 bytes each).
const MOST_QUEUED: usize = 1 << 24;

/// Checks from one question whether to go on to the next.
pub(super) const CHECKS_A_QUESTION: usize = 16;

/// What one search may cost.
#[derive(Clone, Copy)]
pub(crate) struct Limits<'a> {
    /// Most edges that are checked.
    pub checks: usize,
    /// Whether to go on.
    pub go_on: &'a dyn Fn() -> bool,
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Ending {
    /// The goal was reached at this cost.
    Found(f64),
    /// Everything reachable was visited.
    Exhausted,
    /// The limit of edge checks was reached.
    OutOfWork,
    /// The caller broke it off.
    BrokenOff,
}

/// An edge in the queue, smallest estimate first.
#[derive(Debug, Clone, Copy)]
struct Edge {
    /// Cost to the end of the edge and the straight line from there to the goal.
    estimate: f64,
    /// Cost to the end of the edge.
    cost: f64,
    from: u32,
    to: u32,
}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        // Reversed: the standard heap gives the greatest first. Ties go by node, for determinism.
        let key = |edge: &Self| (edge.to, edge.from);
        other.estimate.total_cmp(&self.estimate).then_with(|| key(other).cmp(&key(self)))
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Edge {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Edge {}

/// Buffers that searches reuse, and the last search's tree.
#[derive(Debug, Clone, Default)]
pub(crate) struct Workspace {
    /// Least checked cost and parent by node: the corners, then the start, then the goal.
    nodes: Nodes,
    queue: BinaryHeap<Edge>,
    /// Edges checked by the last search.
    pub(crate) checks: usize,
    pub(crate) sight: super::sight::Stack,
}

/// The rule for leaving a corner.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Taut {
    /// Unit direction of arrival.
    arrival: Point,
    /// Uncertainty of that direction, as a slope.
    blur: f64,
    /// 1 where the obstacle is on the left, -1 on the right.
    side: f64,
    corner: Corner,
}

impl Taut {
    /// The rule after arriving at `corner` by `step`; none where the side is not clear.
    fn new(corner: Corner, step: Point, slack: f64) -> Option<Self> {
        let (before, after) = (cross(step, corner.before), cross(step, corner.after));
        let left = before >= -slack && after >= -slack;
        let right = before <= slack && after <= slack;
        let length = norm(step);
        if left == right || length <= slack {
            return None;
        }
        let side = if left { 1.0 } else { -1.0 };
        Some(Self { arrival: scale(step, 1.0 / length), blur: slack / length, side, corner })
    }

    /// Whether a taut path may go on by `step`, whose length is given.
    #[inline]
    fn allows(&self, step: Point, length: f64, slack: f64) -> bool {
        self.side * cross(self.arrival, step) >= -(slack + self.blur * length)
            && self.side * cross(step, self.corner.before) >= -slack
            && self.side * cross(step, self.corner.after) >= -slack
    }

    /// The directions in which a taut path may go on, as an angle to begin from and a
    /// counter-clockwise sweep, a little wider than [`allows`](Self::allows) far from the corner.
    pub(crate) fn cone(&self) -> (f64, f64) {
        let straight = self.arrival[1].atan2(self.arrival[0]);
        let border = if self.side > 0.0 { self.corner.after } else { self.corner.before };
        let bend =
            cross(self.arrival, border).atan2(crate::plane::geometry::dot(self.arrival, border));
        let margin = 1e-6 + self.blur;
        let sweep = (self.side * bend).max(0.0) + 2.0 * margin;
        if self.side > 0.0 {
            (straight - margin, sweep)
        } else {
            (straight + margin - sweep, sweep)
        }
    }
}

/// Whether a path may arrive at `corner` by `step` without running into its obstacle.
#[inline]
fn tangent(corner: &Corner, step: Point, slack: f64) -> bool {
    let (before, after) = (cross(step, corner.before), cross(step, corner.after));
    before.max(after) <= slack || before.min(after) >= -slack
}

impl Workspace {
    /// Searches a shortest path over the layer's corners.
    ///
    /// `pruned` applies the taut and tangent rules.
    pub(crate) fn search(
        &mut self,
        layer: &Layer,
        start: Point,
        goal: Point,
        pruned: bool,
        limits: Limits<'_>,
    ) -> Ending {
        let n = layer.len();
        let (start_node, goal_node) = (n, n + 1);
        let ends_in_band = [start, goal]
            .map(|end| layer.band > 0.0 && layer.certifier.clearance_of(&[end]) <= layer.band);
        self.nodes.reset(n + 2);
        self.queue.clear();
        self.checks = 0;
        let position = |node: usize| match node {
            _ if node == start_node => start,
            _ if node == goal_node => goal,
            _ => layer.corner(node).at,
        };
        self.nodes.reach(start_node, 0.0, start_node as u32);
        let mut node = start_node;
        loop {
            let from = position(self.nodes.parent(node).unwrap_or(start_node));
            self.expand(layer, node, [from, position(node)], goal, pruned, ends_in_band);
            // The next edge that is free and an improvement.
            node = loop {
                let Some(edge) = self.queue.pop() else { return Ending::Exhausted };
                let to = edge.to as usize;
                if edge.cost >= self.nodes.cost(to) {
                    continue;
                }
                if self.checks == limits.checks || self.queue.len() > MOST_QUEUED {
                    return Ending::OutOfWork;
                }
                if self.checks.is_multiple_of(CHECKS_A_QUESTION) && !(limits.go_on)() {
                    return Ending::BrokenOff;
                }
                self.checks += 1;
                let (a, b) = (position(edge.from as usize), position(to));
                if layer.certifier.segment_is_free(a, b) {
                    self.nodes.reach(to, edge.cost, edge.from);
                    break to;
                }
            };
            if node == goal_node {
                return Ending::Found(self.nodes.cost(goal_node));
            }
        }
    }

    /// Queues the edges that leave `node`, which was reached by `arrival`.
    fn expand(
        &mut self,
        layer: &Layer,
        node: usize,
        arrival: [Point; 2],
        goal: Point,
        pruned: bool,
        ends_in_band: [bool; 2],
    ) {
        let at = arrival[1];
        let n = layer.len();
        let slack = layer.slack;
        let base = self.nodes.cost(node);
        let taut = (pruned && node < n)
            .then(|| Taut::new(*layer.corner(node), sub(at, arrival[0]), slack))
            .flatten();
        let Self { nodes, queue, sight, .. } = self;
        let leads_on =
            |step: Point, length: f64| taut.is_none_or(|t| t.allows(step, length, slack));
        let step = sub(goal, at);
        let length = norm(step);
        if !pruned || ends_in_band[1] || leads_on(step, length) {
            let total = base + length;
            queue.push(Edge { estimate: total, cost: total, from: node as u32, to: n as u32 + 1 });
        }
        // Between an arc and its polygon the rules do not hold.
        let is_inside_band = ends_in_band[0] && node == n;
        let mut consider = |to: usize| {
            let corner = layer.corner(to);
            let step = sub(corner.at, at);
            let length = norm(step);
            let total = base + length;
            if total >= nodes.cost(to) {
                return;
            }
            if pruned && !(is_inside_band || tangent(corner, step, slack) && leads_on(step, length))
            {
                return;
            }
            let estimate = total + distance(corner.at, goal);
            queue.push(Edge { estimate, cost: total, from: node as u32, to: to as u32 });
        };
        match &layer.sight {
            None => (0..n).for_each(consider),
            Some(view) => {
                view.visit(sight, &layer.more_rows, at, taut.map(|t| t.cone()), &mut consider)
            }
        }
    }

    /// The points from start to goal that the last search found, in order.
    pub(crate) fn path(&self, layer: &Layer, start: Point, goal: Point) -> Vec<Point> {
        let n = layer.len();
        let mut points = vec![goal];
        let mut node = self.nodes.parent(n + 1).unwrap_or(n);
        while node != n {
            points.push(layer.corner(node).at);
            node = self.nodes.parent(node).unwrap_or(n);
        }
        points.push(start);
        points.reverse();
        points
    }
}
