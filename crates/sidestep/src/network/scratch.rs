//! What forward passes leave for backward passes.

use super::convolution::Patches;
use crate::kernels::dense::padded;

/// What one forward pass leaves for the backward pass. Reuse it: it only allocates when it grows.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    pub(super) rows: usize,
    pub(super) outputs: usize,
    /// Per layer boundary, `[rows x padded(size)]`; the first holds the input.
    pub(super) activations: Vec<Vec<f32>>,
    /// Gradients with respect to `activations`, before the activation function.
    pub(super) gradients: Vec<Vec<f32>>,
    /// What a convolutional network needs besides.
    pub(super) image: Option<Box<ImageScratch>>,
}

impl Scratch {
    /// Rows of the last forward pass.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Output `[outputs]` of one row of the last forward pass.
    pub fn output(&self, row: usize) -> &[f32] {
        match self.activations.last() {
            Some(last) => &last[row * padded(self.outputs)..][..self.outputs],
            None => &[],
        }
    }

    /// The same, to be added to.
    pub(super) fn output_mut(&mut self, row: usize) -> &mut [f32] {
        let (outputs, at) = (self.outputs, row * padded(self.outputs));
        self.activations.last_mut().map_or(&mut [], |last| &mut last[at..at + outputs])
    }

    /// Gradient with respect to the inputs, `[rows x padded(inputs)]`, from [`Mlp::input_gradient`](super::Mlp::input_gradient).
    pub fn input_gradient(&self) -> &[f32] {
        self.gradients.first().map_or(&[], |first| first)
    }

    /// Room for this many rows of a network of these sizes.
    pub(super) fn shape(&mut self, sizes: &[usize], rows: usize) {
        self.rows = rows;
        self.outputs = *sizes.last().unwrap_or(&0);
        self.activations.resize_with(sizes.len(), Vec::new);
        for (buffer, &size) in self.activations.iter_mut().zip(sizes) {
            buffer.resize(rows * padded(size), 0.0);
        }
    }
}

/// What a forward pass leaves for the backward pass.
#[derive(Debug, Clone, Default)]
pub(super) struct ImageScratch {
    /// `[rows x IMAGE]`.
    pub(super) images: Vec<f32>,
    /// Outputs of the convolutions, `[rows x positions x outputs]`.
    pub(super) first: Vec<f32>,
    pub(super) second: Vec<f32>,
    pub(super) others: Vec<f32>,
    pub(super) skip: Scratch,
    pub(super) patches: Patches,
    pub(super) first_slope: Vec<f32>,
    pub(super) second_slope: Vec<f32>,
}
