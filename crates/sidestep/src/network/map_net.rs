//! The convolutions that read the map of a task, once for all of its trajectories.
//!
//! ```text
//! f <- relu(W_in x + b)                                  per cell
//! f_c <- relu(f_c + W [f of the 3 x 3 cells at distance d around c] + b)      for each dilation d; zero outside
//! ```
//!
//! Rows are cells, row-major. The layers' parameters lie behind those of the [`super::WaypointNet`] that they belong to.

use serde::{Deserialize, Serialize};

use super::layer::Layer;
use crate::kernels::conv::TAPS;
use crate::kernels::dense::{Activation, padded};
use crate::kernels::{Isa, LANES};

/// Numbers of a cell that go in.
pub const MAP_INPUTS: usize = 15;
/// Cells that a convolution sees.
const SEEN: usize = TAPS;

/// Sizes of a map and its network.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapShape {
    /// Cells per side.
    pub cells: usize,
    /// Features of a cell, a multiple of 16.
    pub channels: usize,
    /// One residual convolution each.
    pub dilations: Vec<usize>,
}

impl MapShape {
    pub(crate) const ALLOWED: &str = "4 to 64 cells, 16 to 128 channels (a multiple of 16) and up to 16 dilations below the cells";

    pub(crate) fn is_allowed(&self) -> bool {
        (4..=64).contains(&self.cells)
            && (LANES..=128).contains(&self.channels)
            && self.channels.is_multiple_of(LANES)
            && self.dilations.len() <= 16
            && self.dilations.iter().all(|d| (1..self.cells).contains(d))
    }

    /// Zeros around the cells.
    fn border(&self) -> usize {
        self.dilations.iter().copied().max().unwrap_or(0)
    }

    /// Cells per side with the border.
    fn side(&self) -> usize {
        self.cells + 2 * self.border()
    }

    /// `(inputs, outputs)` of each layer.
    pub(super) fn layer_sizes(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let blocks = self.dilations.iter().map(|_| (SEEN * self.channels, self.channels));
        std::iter::once((MAP_INPUTS, self.channels)).chain(blocks)
    }
}

/// Inputs, features and slopes of one map.
#[derive(Debug, Clone)]
pub struct MapScratch {
    /// `[cells^2 x padded(MAP_INPUTS)]`.
    input: Vec<f32>,
    /// Per block boundary, `[cells^2 x channels]`.
    hidden: Vec<Vec<f32>>,
    /// What a convolution reads, in a border of zeros: `[(cells + 2 border)^2 x channels]`.
    bordered: Vec<f32>,
    /// For the backward pass, `[cells^2 x SEEN channels]`.
    columns: Vec<f32>,
    slopes: Vec<f32>,
    d_active: Vec<f32>,
    d_columns: Vec<f32>,
}

impl MapScratch {
    pub(crate) fn new(shape: &MapShape) -> Self {
        let rows = shape.cells * shape.cells;
        let size = rows * shape.channels;
        let blocks = shape.dilations.len();
        Self {
            input: vec![0.0; rows * padded(MAP_INPUTS)],
            hidden: vec![vec![0.0; size]; blocks + 1],
            bordered: vec![0.0; shape.side().pow(2) * shape.channels],
            columns: Vec::new(),
            slopes: Vec::new(),
            d_active: Vec::new(),
            d_columns: Vec::new(),
        }
    }

    pub(crate) fn input(&mut self) -> &mut [f32] {
        &mut self.input
    }

    /// `[cells^2 x channels]`, as the last forward pass left them.
    pub(crate) fn features(&self) -> &[f32] {
        self.hidden.last().map_or(&[], Vec::as_slice)
    }

    /// Slopes of a loss with respect to the features, `[cells^2 x channels]`; cleared by the forward pass.
    pub(crate) fn slopes(&mut self) -> &mut [f32] {
        &mut self.slopes
    }
}

/// Fills the features from the inputs.
pub(super) fn forward(shape: &MapShape, layers: &[Layer], scratch: &mut MapScratch) {
    let isa = Isa::detect();
    let rows = shape.cells * shape.cells;
    layers[0].forward(isa, rows, &scratch.input, &mut scratch.hidden[0]);
    for (block, &dilation) in shape.dilations.iter().enumerate() {
        let (before, after) = scratch.hidden.split_at_mut(block + 1);
        let (h, next) = (&before[block], &mut after[0]);
        let border = shape.border();
        let (line, first) = (shape.cells * shape.channels, border * (shape.side() + 1));
        let inner =
            scratch.bordered[first * shape.channels..].chunks_mut(shape.side() * shape.channels);
        inner.zip(h.chunks_exact(line)).for_each(|(inner, h)| inner[..line].copy_from_slice(h));
        let layer = &layers[block + 1];
        layer.convolve(isa, shape.cells, border, dilation, &scratch.bordered, next);
    }
    scratch.slopes.fill(0.0);
}

/// Prepares a map for [`backward`]: the slopes are those of no loss.
pub(super) fn begin(scratch: &mut MapScratch) {
    let size = scratch.hidden[0].len();
    scratch.slopes.clear();
    scratch.slopes.resize(size, 0.0);
    scratch.d_active.resize(size, 0.0);
    scratch.columns.resize(SEEN * size, 0.0);
    scratch.d_columns.resize(SEEN * size, 0.0);
}

/// Adds to the flat `gradient` that of the loss whose slopes were collected, and clears these.
pub(super) fn backward(
    shape: &MapShape,
    layers: &[Layer],
    scratch: &mut MapScratch,
    gradient: &mut [f32],
) {
    let isa = Isa::detect();
    let rows = shape.cells * shape.cells;
    let MapScratch { input, hidden, columns, slopes, d_active, d_columns, .. } = scratch;
    for (block, &dilation) in shape.dilations.iter().enumerate().rev() {
        for ((d, slope), &h) in d_active.iter_mut().zip(slopes.iter_mut()).zip(&hidden[block + 1]) {
            *slope = if h > 0.0 { *slope } else { 0.0 };
            *d = *slope;
        }
        gather(shape, &hidden[block], dilation, columns);
        let layer = &layers[block + 1];
        layer.weight_gradient(isa, rows, columns, d_active, gradient);
        layer.input_gradient(isa, Activation::Linear, rows, d_active, columns, d_columns);
        scatter(shape, d_columns, dilation, slopes);
    }
    for (slope, &h) in slopes.iter_mut().zip(&hidden[0]) {
        *slope = if h > 0.0 { *slope } else { 0.0 };
    }
    layers[0].weight_gradient(isa, rows, input, slopes, gradient);
    slopes.fill(0.0);
}

/// The cells that a convolution sees around a cell, with their place among the nine.
fn around(
    cells: usize,
    dilation: usize,
    cell: usize,
) -> impl Iterator<Item = (usize, Option<usize>)> {
    let (i, j) = (cell % cells, cell / cells);
    (0..SEEN).map(move |k| {
        let shift = |at: usize, step: usize| {
            (at + step * dilation).checked_sub(dilation).filter(|at| *at < cells)
        };
        let other = shift(i, k % 3).zip(shift(j, k / 3));
        (k, other.map(|(i, j)| j * cells + i))
    })
}

/// Row c of `out [cells^2 x SEEN channels]` becomes the rows of `h [cells^2 x channels]` around c.
fn gather(shape: &MapShape, h: &[f32], dilation: usize, out: &mut [f32]) {
    let channels = shape.channels;
    for (cell, out) in out.chunks_exact_mut(SEEN * channels).enumerate() {
        for (k, other) in around(shape.cells, dilation, cell) {
            let out = &mut out[k * channels..][..channels];
            match other {
                Some(other) => out.copy_from_slice(&h[other * channels..][..channels]),
                None => out.fill(0.0),
            }
        }
    }
}

/// Adds what flows back through [`gather`] to `d_h [cells^2 x channels]`.
fn scatter(shape: &MapShape, d_out: &[f32], dilation: usize, d_h: &mut [f32]) {
    let channels = shape.channels;
    for (cell, d_out) in d_out.chunks_exact(SEEN * channels).enumerate() {
        for (k, other) in around(shape.cells, dilation, cell) {
            let Some(other) = other else { continue };
            let row = &mut d_h[other * channels..][..channels];
            row.iter_mut().zip(&d_out[k * channels..]).for_each(|(sum, d)| *sum += d);
        }
    }
}
