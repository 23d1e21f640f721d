//! The map of a task: a square of cells that lies along the line from start to goal, and what the network makes of it.
//!
//! The square's side is the distance from start to goal and [`MARGIN`] beyond both; its middle is the middle of the line.
//! Cell (i, j) is row j * cells + i, i along the line, j across it. A cell's inputs are the coarse signed distances
//! at 3 x 3 points in it, how near it is to the start and to the goal, and the cells' size. The network's convolutions turn
//! them into features once a task ([`crate::network::WaypointNet::read_map`]); a waypoint's row holds the
//! features at the waypoint and a little ahead, behind and beside it, bilinear between the cells' middles.

use super::{coarse, turn};
use crate::distance::Field;
use crate::distance::LANES;
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
            row[POINTS * POINTS..MAP_INPUTS].copy_from_slice(&[
                near(middle, 0.0),
                near(middle, length),
                2.0 * self.cell,
            ]);
        }
    }

    /// Writes the features `[PLACES x channels]` that a waypoint at `p` reads.
    pub(super) fn read(&self, p: [f32; 2], out: &mut [f32]) {
        let features = self.scratch.features();
        for (offset, out) in OFFSETS.iter().zip(out.chunks_exact_mut(self.channels)) {
            out.fill(0.0);
            for (cell, weight) in self.corners(p, *offset) {
                let row = &features[cell * self.channels..][..self.channels];
                out.iter_mut().zip(row).for_each(|(out, f)| *out += weight * f);
            }
        }
    }

    /// Writes what waypoints `x [N x 2]` read to their rows `[N x stride]` of a view of `row_len` numbers.
    pub fn read_rows(&self, x: &[f32], rows: &mut [f32], stride: usize, row_len: usize) {
        let first = row_len - PLACES * self.channels;
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

    /// [`TaskMap::collect`] for waypoints `x [N x 2]`, whose rows' slopes are `rows [N x stride]` of a view of `row_len` numbers.
    pub fn collect_rows(&mut self, x: &[f32], rows: &[f32], stride: usize, row_len: usize) {
        let first = row_len - PLACES * self.channels;
        for (p, row) in x.as_chunks::<2>().0.iter().zip(rows.chunks_exact(stride)) {
            self.collect(*p, &row[first..row_len]);
        }
    }

    /// The four cells around a place with their weights.
    fn corners(&self, p: [f32; 2], offset: [f32; 2]) -> [(usize, f32); 4] {
        let own = super::back([p[0] - self.start[0], p[1] - self.start[1]], self.along);
        let last = (self.cells - 1) as f32;
        let place = [0, 1].map(|axis| {
            ((own[axis] + offset[axis] - self.first[axis]) / self.cell).clamp(0.0, last)
        });
        let base = place.map(|v| (v as usize).min(self.cells - 2));
        let [u, v] = [place[0] - base[0] as f32, place[1] - base[1] as f32];
        let cell = base[1] * self.cells + base[0];
        [
            (cell, (1.0 - u) * (1.0 - v)),
            (cell + 1, u * (1.0 - v)),
            (cell + self.cells, (1.0 - u) * v),
            (cell + self.cells + 1, u * v),
        ]
    }
}
