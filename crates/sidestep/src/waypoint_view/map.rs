//! The map of a task: a square of cells that lies along the line from start to goal, and what the network makes of it.
//!
//! The square's side is the distance from start to goal and [`MARGIN`] beyond both; its middle is the middle of the line.
//! Cell (i, j) is row j * cells + i, i along the line, j across it. A cell's inputs are the coarse signed distances
//! at 3 x 3 points in it, how near it is to the start and to the goal, and the cells' size; then what the shortest
//! ways over those points ([`super::ways`]) say of its middle point: how much of a detour a way through it is, how
//! far along from start to goal it lies, and the length of the shortest way over the straight line's. The network's convolutions turn
//! them into features once a task ([`crate::network::WaypointNet::read_map`]); a waypoint's row holds the
//! features at the waypoint and a little ahead, behind and beside it, bilinear between the cells' middles, and detour and
//! place along at the same places, bilinear between the points.

use super::ways::Ways;
use super::{coarse, turn};
use crate::distance::{Field, LANES};
use crate::network::{MAP_INPUTS, MapScratch, MapShape};
use crate::objective::Objective;

/// Beyond start and goal, in normalised units.
const MARGIN: f32 = 1.2;
/// Points per side of a cell.
const POINTS: usize = 3;
/// Where a waypoint reads, in frame axes from its place, in normalised units.
const OFFSETS: [[f32; 2]; PLACES] = [[0.0, 0.0], [0.5, 0.0], [-0.5, 0.0], [0.0, 0.5], [0.0, -0.5]];
/// Places where a waypoint reads the map.
pub(super) const PLACES: usize = 5;
/// Numbers of the ways that it reads at each.
pub(super) const WAYS: usize = 2;
/// A detour of this counts half of the most.
const DETOUR: f32 = 1.0;

/// The map of one task.
#[derive(Debug, Clone)]
pub struct TaskMap {
    /// The middle of cell (0, 0), from the start, in frame axes.
    first: [f32; 2],
    start: [f32; 2],
    along: [f32; 2],
    /// Side of a cell, in normalised units.
    cell: f32,
    cells: usize,
    channels: usize,
    /// Per point, detour and place along, `[(POINTS cells)^2 x WAYS]`.
    ways: Vec<[f32; WAYS]>,
    scratch: MapScratch,
}

impl TaskMap {
    /// The map of the objective's task; its features are not there until the network has read it.
    pub fn new(shape: &MapShape, objective: &Objective) -> Self {
        let (start, goal) = (objective.start(), objective.goal());
        let (length, along) = super::direction(start, goal);
        let cells = shape.cells;
        let cell = (length + 2.0 * MARGIN) / cells as f32;
        let first = [0.5 * cell - MARGIN, 0.5 * cell * (1.0 - cells as f32)];
        let mut map = Self {
            first,
            start,
            along,
            cell,
            cells,
            channels: shape.channels,
            ways: Vec::new(),
            scratch: MapScratch::new(shape),
        };
        map.fill(length, objective.scene().exact_field());
        map
    }

    /// What the network reads and writes.
    pub fn scratch(&mut self) -> &mut MapScratch {
        &mut self.scratch
    }

    fn fill(&mut self, length: f32, field: &Field) {
        let side = self.cells * POINTS;
        let count = (side * side).next_multiple_of(LANES);
        let mut x = vec![self.start[0]; count];
        let mut y = vec![self.start[1]; count];
        let mut distance = vec![0.0; count];
        let step = self.cell / POINTS as f32;
        let least = self.first.map(|middle| middle - step * (POINTS / 2) as f32);
        for j in 0..side {
            for i in 0..side {
                let p = turn([least[0] + i as f32 * step, least[1] + j as f32 * step], self.along);
                x[j * side + i] = self.start[0] + p[0];
                y[j * side + i] = self.start[1] + p[1];
            }
        }
        field.probe_all(&x, &y, &mut distance);
        let longer = self.find_ways(&distance, step, length);

        let near = |middle: [f32; 2], end: f32| {
            let away = (middle[0] - end).hypot(middle[1]) / (1.5 * self.cell);
            (1.0 - away).max(0.0)
        };
        let input = self.scratch.input();
        for (index, row) in input.chunks_exact_mut(LANES).enumerate() {
            let (i, j) = (index % self.cells, index / self.cells);
            for k in 0..POINTS * POINTS {
                let (column, line) = (i * POINTS + k % POINTS, j * POINTS + k / POINTS);
                row[k] = coarse(distance[line * side + column]);
            }
            let middle =
                [self.first[0] + i as f32 * self.cell, self.first[1] + j as f32 * self.cell];
            let [detour, along] =
                self.ways[(j * POINTS + POINTS / 2) * side + i * POINTS + POINTS / 2];
            row[POINTS * POINTS..MAP_INPUTS].copy_from_slice(&[
                near(middle, 0.0),
                near(middle, length),
                2.0 * self.cell,
                detour,
                along,
                longer,
            ]);
        }
    }

    /// Writes the features `[PLACES x channels]` and ways `[PLACES x WAYS]` that a waypoint at `p` reads.
    pub(super) fn read(&self, p: [f32; 2], out: &mut [f32]) {
        let features = self.scratch.features();
        let (features_out, ways_out) = out.split_at_mut(PLACES * self.channels);
        for (offset, out) in OFFSETS.iter().zip(ways_out.chunks_exact_mut(WAYS)) {
            out.fill(0.0);
            for (point, weight) in self.points(p, *offset) {
                out.iter_mut().zip(self.ways[point]).for_each(|(out, way)| *out += weight * way);
            }
        }
        for (offset, out) in OFFSETS.iter().zip(features_out.chunks_exact_mut(self.channels)) {
            out.fill(0.0);
            for (cell, weight) in self.corners(p, *offset) {
                let row = &features[cell * self.channels..][..self.channels];
                out.iter_mut().zip(row).for_each(|(out, f)| *out += weight * f);
            }
        }
    }

    /// Writes what waypoints `x [N x 2]` read to their rows `[N x stride]` of a view of `row_len` numbers.
    pub fn read_rows(&self, x: &[f32], rows: &mut [f32], stride: usize, row_len: usize) {
        let first = row_len - PLACES * (self.channels + WAYS);
        for (p, row) in x.as_chunks::<2>().0.iter().zip(rows.chunks_exact_mut(stride)) {
            self.read(*p, &mut row[first..row_len]);
        }
    }

    /// Adds `slope [PLACES x channels]`, the slope of a loss with respect to what a waypoint at `p` read, to that with
    /// respect to the features.
    fn collect(&mut self, p: [f32; 2], slope: &[f32]) {
        for (offset, slope) in OFFSETS.iter().zip(slope.chunks_exact(self.channels)) {
            for (cell, weight) in self.corners(p, *offset) {
                let row = &mut self.scratch.slopes()[cell * self.channels..][..self.channels];
                row.iter_mut().zip(slope).for_each(|(sum, s)| *sum += weight * s);
            }
        }
    }

    /// Collects the slopes of a loss with respect to what waypoints `x [N x 2]` read: `rows [N x stride]` are the slopes of
    /// their rows, of a view of `row_len` numbers.
    pub fn collect_rows(&mut self, x: &[f32], rows: &[f32], stride: usize, row_len: usize) {
        let first = row_len - PLACES * (self.channels + WAYS);
        for (p, row) in x.as_chunks::<2>().0.iter().zip(rows.chunks_exact(stride)) {
            self.collect(*p, &row[first..][..PLACES * self.channels]);
        }
    }

    /// The four cells around a place with their weights.
    fn corners(&self, p: [f32; 2], offset: [f32; 2]) -> [(usize, f32); 4] {
        let own = self.own(p, offset);
        bilinear([0, 1].map(|axis| (own[axis] - self.first[axis]) / self.cell), self.cells)
    }

    /// The four points around a place with their weights.
    fn points(&self, p: [f32; 2], offset: [f32; 2]) -> [(usize, f32); 4] {
        let own = self.own(p, offset);
        bilinear(self.among_points(own), self.cells * POINTS)
    }

    /// A place from the start, in frame axes.
    fn own(&self, p: [f32; 2], offset: [f32; 2]) -> [f32; 2] {
        let own = super::back([p[0] - self.start[0], p[1] - self.start[1]], self.along);
        [own[0] + offset[0], own[1] + offset[1]]
    }

    /// Column and row among the points.
    fn among_points(&self, own: [f32; 2]) -> [f32; 2] {
        let step = self.cell / POINTS as f32;
        [0, 1].map(|axis| (own[axis] - self.first[axis]) / step + (POINTS / 2) as f32)
    }

    /// Fills the ways from the points' signed distances; returns the shortest way over the straight line, less 1, at most 3.
    fn find_ways(&mut self, distance: &[f32], step: f32, length: f32) -> f32 {
        let side = self.cells * POINTS;
        let mut ways = Ways::new(side);
        let ends = [[0.0, 0.0], [length, 0.0]].map(|end| self.among_points(end));
        ways.solve(distance, step, ends);
        let point = |at: usize| ways.get(at % side, at / side);
        let shortest =
            (0..side * side).map(|at| point(at)[0] + point(at)[1]).fold(f32::INFINITY, f32::min);
        let way = |at: usize| {
            let [from, to] = point(at);
            let detour = ((from + to - shortest) * step).max(0.0);
            [2.0 * detour / (detour + DETOUR), (from - to) / (from + to).max(1.0)]
        };
        self.ways = (0..side * side).map(way).collect();
        (shortest * step / length.max(step) - 1.0).clamp(0.0, 3.0)
    }
}

/// The four nodes around a place in a square of `side` x `side` nodes with their weights.
fn bilinear(place: [f32; 2], side: usize) -> [(usize, f32); 4] {
    let place = place.map(|v| v.clamp(0.0, (side - 1) as f32));
    let base = place.map(|v| (v as usize).min(side - 2));
    let [u, v] = [place[0] - base[0] as f32, place[1] - base[1] as f32];
    let node = base[1] * side + base[0];
    [
        (node, (1.0 - u) * (1.0 - v)),
        (node + 1, u * (1.0 - v)),
        (node + side, (1.0 - u) * v),
        (node + side + 1, u * v),
    ]
}
