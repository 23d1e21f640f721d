//! The map of a task: a square of cells that lies along the line from start to goal, and what the network makes of it.
//!
//! The square's side is the distance from start to goal and [`MARGIN`] beyond both; its middle is the middle of the line.
//! Cell (i, j) is row j * cells + i, i along the line, j across it. A cell's inputs are the coarse signed distances
//! at 3 x 3 points in it, how near it is to the start and to the goal, and the cells' size; then what the shortest
//! ways round the obstacles ([`super::ways`]) say of its middle: how much of a detour a way through it is, how
//! far along from start to goal it lies, and the length of the shortest way over the straight line's. The network's convolutions turn
//! them into features once a task ([`crate::network::WaypointNet::read_map`]); a waypoint's row holds the
//! features at the waypoint and a little ahead, behind and beside it, bilinear between the cells' middles, detour and
//! place along at the same places, and where on the shortest way a waypoint of its number would lie.

use super::bilinear::{Corners, bilinear};
use super::coarse;
use super::look::{Axes, Look};
use super::parts::ViewParts;
use super::picture::Picture;
use super::ways::{WAYS, Ways};
use std::sync::Arc;

use crate::kernels::{Isa, dispatch};
use crate::network::{MAP_INPUTS, MapScratch, MapShape};
use crate::plane::Subject;
use crate::plane::distance::{Field, LANES};

/// Beyond start and goal, in normalised units.
const MARGIN: f32 = 1.2;
/// Points per side of a cell.
const POINTS: usize = 3;
/// Where a waypoint reads, in frame axes from its place, in normalised units.
const OFFSETS: [[f32; 2]; PLACES] = [[0.0, 0.0], [0.5, 0.0], [-0.5, 0.0], [0.0, 0.5], [0.0, -0.5]];
/// Offsets to the shortest way are multiplied by this.
const WISH: f32 = 0.6;
/// Places where a waypoint reads the map.
pub(super) const PLACES: usize = 5;

/// Numbers that a waypoint reads of a map of so many channels.
pub(super) fn read_len(channels: usize) -> usize {
    PLACES * (channels + WAYS) + 2
}

/// The map of one task.
#[derive(Debug, Clone)]
pub struct TaskMap {
    /// The middle of cell (0, 0), from the start, in frame axes.
    first: [f32; 2],
    axes: Axes,
    /// Side of a cell, in normalised units.
    cell: f32,
    cells: usize,
    channels: usize,
    /// The ways round obstacles, which a picture does not tell.
    ways: Option<Arc<Ways>>,
    picture: Option<Arc<Picture>>,
    backwards: bool,
    scratch: MapScratch,
}

impl TaskMap {
    /// The map of the subject's task; its features are not there until the network has read it.
    pub fn new(parts: &ViewParts, shape: &MapShape, subject: Subject<'_>) -> Self {
        let axes = Axes::new(subject, Look::default());
        let length = axes.length;
        let cells = shape.cells;
        let cell = (length + 2.0 * MARGIN) / cells as f32;
        let first = [0.5 * cell - MARGIN, 0.5 * cell * (1.0 - cells as f32)];
        let mut map = Self {
            first,
            axes,
            cell,
            cells,
            channels: shape.channels,
            ways: parts.picture.is_none().then(|| Arc::new(Ways::new(subject))),
            picture: parts.picture.map(|pixels| Arc::new(Picture::draw(subject.scene, pixels))),
            backwards: false,
            scratch: MapScratch::new(shape),
        };
        map.fill(length, subject.scene.exact_field());
        map
    }

    /// The map of the same task looked at another way; it shares the ways, which are the longer part of the work.
    pub fn other(&self, subject: Subject<'_>, look: Look) -> Self {
        let axes = Axes::new(subject, look);
        let mut map = Self { axes, backwards: look.backwards, ..self.clone() };
        map.fill(axes.length, subject.scene.exact_field());
        map
    }

    /// What the network reads and writes.
    pub fn scratch(&mut self) -> &mut MapScratch {
        &mut self.scratch
    }

    /// What the network reads of each cell, `[cells x cells x 15]`.
    pub fn cells(&mut self) -> Vec<f32> {
        let rows = self.scratch.input().chunks_exact(LANES);
        rows.flat_map(|row| &row[..MAP_INPUTS]).copied().collect()
    }

    /// Where waypoints `x [N x 2]` read features, `[N x PLACES x 2]`: column and row, in cells; beyond the outermost cells' middles
    /// is read as there.
    pub fn places(&self, x: &[f32]) -> Vec<f32> {
        let points = x.as_chunks::<2>().0.iter();
        points.flat_map(|p| OFFSETS.map(|offset| self.place(*p, offset))).flatten().collect()
    }

    fn fill(&mut self, length: f32, field: &Field) {
        let (axes, start) = (self.axes, self.axes.start);
        let side = self.cells * POINTS;
        let count = (side * side).next_multiple_of(LANES);
        let mut x = vec![start[0]; count];
        let mut y = vec![start[1]; count];
        let mut distance = vec![0.0; count];
        let step = self.cell / POINTS as f32;
        let least = self.first.map(|middle| middle - step * (POINTS / 2) as f32);
        for j in 0..side {
            for i in 0..side {
                let p = axes.turn([least[0] + i as f32 * step, least[1] + j as f32 * step]);
                x[j * side + i] = start[0] + p[0];
                y[j * side + i] = start[1] + p[1];
            }
        }
        match &self.picture {
            Some(picture) => picture.probe(&x, &y, &mut distance),
            None => field.probe_all(&x, &y, &mut distance),
        }
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
            let p = axes.turn(middle);
            let at = [start[0] + p[0], start[1] + p[1]];
            let ([detour, along], longer) = match &self.ways {
                Some(ways) => (ways.read(at, self.backwards), ways.longer()),
                None => ([0.0; WAYS], 0.0),
            };
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

    /// Writes what waypoint `i` at `p` reads: features `[PLACES x channels]`, ways `[PLACES x WAYS]` and the offset to the shortest way.
    pub(super) fn read(&self, i: usize, p: [f32; 2], out: &mut [f32]) {
        self.read_features(p, out);
        let Some(own) = &self.ways else { return };
        let (ways, offset) = out[PLACES * self.channels..].split_at_mut(PLACES * WAYS);
        for (offset, out) in OFFSETS.iter().zip(ways.chunks_exact_mut(WAYS)) {
            let around = self.axes.turn(*offset);
            let at = [p[0] + around[0], p[1] + around[1]];
            out.copy_from_slice(&own.read(at, self.backwards));
        }
        let route = own.route();
        let wish = route[if self.backwards { route.len() - 1 - i } else { i }];
        let away = [WISH * (wish[0] - p[0]), WISH * (wish[1] - p[1])];
        offset[..2].copy_from_slice(&self.axes.back(away));
    }

    fn read_features(&self, p: [f32; 2], out: &mut [f32]) {
        let corners = OFFSETS.map(|offset| self.corners(p, offset));
        mix(Isa::detect(), self.scratch.features(), self.channels, &corners, out);
    }

    /// Writes the features that waypoints `x [N x 2]` read to their rows `[N x stride]` of a view of `row_len` numbers.
    pub fn read_rows(&self, x: &[f32], rows: &mut [f32], stride: usize, row_len: usize) {
        let first = row_len - read_len(self.channels);
        for (p, row) in x.as_chunks::<2>().0.iter().zip(rows.chunks_exact_mut(stride)) {
            self.read_features(*p, &mut row[first..][..PLACES * self.channels]);
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
        let first = row_len - read_len(self.channels);
        for (p, row) in x.as_chunks::<2>().0.iter().zip(rows.chunks_exact(stride)) {
            self.collect(*p, &row[first..][..PLACES * self.channels]);
        }
    }

    /// Column and row of a place, in cells.
    fn place(&self, p: [f32; 2], offset: [f32; 2]) -> [f32; 2] {
        let start = self.axes.start;
        let own = self.axes.back([p[0] - start[0], p[1] - start[1]]);
        [0, 1].map(|axis| (own[axis] + offset[axis] - self.first[axis]) / self.cell)
    }

    /// The four cells around a place with their weights.
    fn corners(&self, p: [f32; 2], offset: [f32; 2]) -> Corners {
        bilinear(self.place(p, offset), self.cells)
    }
}

dispatch! {
    /// For each place the sum of its corners' rows of `features [.. x channels]` by their weights, `[PLACES x channels]`.
    fn mix(features: &[f32], channels: usize, corners: &[Corners; PLACES], out: &mut [f32]) = mix_body;
}

#[inline(always)]
fn mix_body<const ISA: u8>(
    features: &[f32],
    channels: usize,
    corners: &[Corners; PLACES],
    out: &mut [f32],
) {
    for (corners, out) in corners.iter().zip(out.chunks_exact_mut(channels)) {
        let rows = corners.map(|(cell, weight)| (&features[cell * channels..][..channels], weight));
        for (block, out) in out.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
            let mut sums = [0.0; LANES];
            for (row, weight) in rows {
                let row = &row[block * LANES..][..LANES];
                for lane in 0..LANES {
                    sums[lane] += weight * row[lane];
                }
            }
            *out = sums;
        }
    }
}
