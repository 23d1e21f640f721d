//! One dense layer: where its parameters lie, and their copies as the kernels read them.

use std::ops::Range;

use crate::kernels::dense::{self, Activation, padded};
use crate::kernels::{Isa, conv};

/// A dense layer `y = act(W x + b)` of a network with flat parameters.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    pub inputs: usize,
    pub outputs: usize,
    /// Range of the weights `[outputs x inputs]` in the flat parameters; the biases follow it.
    pub weights: Range<usize>,
    pub activation: Activation,
    forward: Vec<f32>,
    bias: Vec<f32>,
    backward: Vec<f32>,
}

impl Layer {
    /// A layer whose parameters begin at `first`; its copies are empty until [`Layer::pack`].
    pub fn new(inputs: usize, outputs: usize, first: usize, activation: Activation) -> Self {
        Self {
            inputs,
            outputs,
            weights: first..first + inputs * outputs,
            activation,
            forward: vec![0.0; padded(outputs) * inputs],
            bias: vec![0.0; padded(outputs)],
            backward: vec![0.0; padded(inputs) * outputs],
        }
    }

    /// Range of the biases in the flat parameters.
    pub fn biases(&self) -> Range<usize> {
        self.weights.end..self.weights.end + self.outputs
    }

    /// Copies the flat `parameters` into the kernels' order.
    pub fn pack(&mut self, parameters: &[f32]) {
        let weights = &parameters[self.weights.clone()];
        dense::pack_forward(weights, self.inputs, self.outputs, &mut self.forward);
        dense::pack_backward(weights, self.inputs, self.outputs, &mut self.backward);
        let biases = self.biases();
        self.bias[..self.outputs].copy_from_slice(&parameters[biases]);
    }

    /// `y [rows x padded(outputs)]` for `x [rows x padded(inputs)]`.
    pub fn forward(&self, isa: Isa, rows: usize, x: &[f32], y: &mut [f32]) {
        let (act, stride) = (self.activation, padded(self.inputs));
        dense::forward(isa, act, rows, self.inputs, x, stride, &self.forward, &self.bias, y);
    }

    /// `y [cells^2 x outputs]` of a convolution over cells with a border; see [`conv::conv3x3`].
    pub fn convolve(
        &self,
        isa: Isa,
        cells: usize,
        border: usize,
        dilation: usize,
        x: &[f32],
        y: &mut [f32],
    ) {
        let (packed, bias, channels) = (&self.forward, &self.bias, self.outputs);
        conv::conv3x3(isa, cells, channels, border, dilation, x, packed, bias, y);
    }

    /// Adds the gradient with respect to the parameters to the flat `gradient`, given that with respect to the
    /// outputs, `dy [rows x padded(outputs)]`, and the inputs `x`.
    pub fn weight_gradient(
        &self,
        isa: Isa,
        rows: usize,
        x: &[f32],
        dy: &[f32],
        gradient: &mut [f32],
    ) {
        let (weights, biases) = gradient[self.weights.start..].split_at_mut(self.weights.len());
        let (biases, stride) = (&mut biases[..self.outputs], padded(self.outputs));
        dense::weight_gradient(isa, rows, self.inputs, x, dy, stride, weights, biases);
    }

    /// `dx [rows x padded(inputs)]`, the gradient before the activation `before` that made the inputs `x`.
    pub fn input_gradient(
        &self,
        isa: Isa,
        before: Activation,
        rows: usize,
        dy: &[f32],
        x: &[f32],
        dx: &mut [f32],
    ) {
        let stride = padded(self.outputs);
        dense::input_gradient(isa, before, rows, self.outputs, dy, stride, &self.backward, x, dx);
    }
}
