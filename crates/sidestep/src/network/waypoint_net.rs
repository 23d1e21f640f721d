//! The waypoint network: the same weights at every waypoint, so it serves any number of them.
//!
//! Rows are waypoints; a residual block looks along the trajectory with a convolution over the waypoints
//! i - d, i and i + d (zero beyond the ends):
//!
//! ```text
//! h <- relu(W_in x + b)
//! h_i <- h_i + W_out relu(W_conv [h_{i-d}, h_i, h_{i+d}] + b) + b'      for each dilation d
//! output_i = W_head h_i + b''                                          a number for each direction
//! ```
//!
//! No normalisation layers. Parameters lie in the flat vector in that order, per layer weights
//! `[outputs x inputs]`, then biases; those of the convolutions over the task's map ([`super::map_net`]) follow, where the
//! network has one.

use std::ops::Range;

use super::layer::Layer;
use super::map_net::{self, MapScratch};
use super::neighbours::{add, gather, scatter};
use super::waypoint_shape::WaypointShape;
use crate::error::InvalidInput;
use crate::kernels::Isa;
use crate::kernels::dense::{Activation, padded};

/// A waypoint network with its parameters and their packed copies for the kernels.
#[derive(Debug, Clone)]
pub struct WaypointNet {
    shape: WaypointShape,
    parameters: Vec<f32>,
    layers: Vec<Layer>,
}

impl PartialEq for WaypointNet {
    fn eq(&self, other: &Self) -> bool {
        self.shape == other.shape && self.parameters == other.parameters
    }
}

/// Buffers of one forward pass, kept for the backward pass. Reuse it: it only allocates when it grows.
#[derive(Debug, Clone, Default)]
pub struct WaypointScratch {
    rows: usize,
    waypoints: usize,
    outputs: usize,
    /// `[rows x padded(inputs)]`.
    input: Vec<f32>,
    /// Per block boundary, `[rows x width]`.
    hidden: Vec<Vec<f32>>,
    /// Per block, `[rows x 3 width]`.
    neighbours: Vec<Vec<f32>>,
    /// Per block, `[rows x width]`, after the activation.
    active: Vec<Vec<f32>>,
    /// `[rows x padded(outputs)]`.
    output: Vec<f32>,
    d_output: Vec<f32>,
    /// `[rows x padded(inputs)]`, of a network with a map.
    d_input: Vec<f32>,
    d_hidden: Vec<f32>,
    d_active: Vec<f32>,
    d_neighbours: Vec<f32>,
}

impl WaypointScratch {
    /// The input rows `[rows x stride]` to be filled before [`WaypointNet::forward`], with `stride` from
    /// [`WaypointNet::input_stride`]; what lies in a row beyond the network's inputs must be finite.
    pub fn input(&mut self, rows: usize, stride: usize) -> &mut [f32] {
        self.input.resize(rows * stride, 0.0);
        &mut self.input
    }

    /// The output `[outputs]` of one row of the last forward pass.
    pub fn output(&self, row: usize) -> &[f32] {
        &self.output[row * padded(self.outputs)..][..self.outputs]
    }

    /// The outputs of some rows of the last forward pass, one after the other.
    pub fn outputs(&self, rows: Range<usize>, out: &mut Vec<f32>) {
        out.clear();
        rows.for_each(|row| out.extend_from_slice(self.output(row)));
    }

    /// The first two numbers of it: all that there are in the plane.
    pub fn pair(&self, row: usize) -> [f32; 2] {
        let row = &self.output[row * padded(self.outputs)..];
        [row[0], row[1]]
    }

    /// Slopes of the loss of the last backward pass with respect to the inputs, `[rows x stride]`; empty without a map.
    pub fn input_slopes(&self) -> &[f32] {
        &self.d_input
    }

    /// Rows of the last forward pass.
    pub fn rows(&self) -> usize {
        self.rows
    }
}

impl WaypointNet {
    /// A network from its flat parameters.
    ///
    /// # Errors
    /// If the shape is not allowed, or the number of parameters is not its.
    pub fn new(shape: &WaypointShape, parameters: Vec<f32>) -> Result<Self, InvalidInput> {
        let expected = shape.parameter_count()?;
        if parameters.len() != expected {
            return Err(InvalidInput::new(
                "network.parameters",
                format!("{} numbers", parameters.len()),
                format!("{expected} numbers for {shape:?}"),
            ));
        }
        let sizes = shape.layer_sizes();
        let mut first = 0;
        let mut layers = Vec::with_capacity(sizes.len());
        for (index, &(inputs, outputs)) in sizes.iter().enumerate() {
            // First layer, convolutions and the map's; the outward layers and the head are linear.
            let head = 2 * shape.dilations.len() + 1;
            let rectified = index == 0 || index > head || index % 2 == 1 && index < head;
            let activation = if rectified { Activation::Relu } else { Activation::Linear };
            layers.push(Layer::new(inputs, outputs, first, activation));
            first += (inputs + 1) * outputs;
        }
        let mut net = Self { shape: shape.clone(), parameters, layers };
        net.pack();
        Ok(net)
    }

    /// The sizes.
    pub fn shape(&self) -> &WaypointShape {
        &self.shape
    }

    /// The flat parameters.
    pub fn parameters(&self) -> &[f32] {
        &self.parameters
    }

    /// Changes the parameters in place and repacks them for the kernels.
    pub fn update(&mut self, change: impl FnOnce(&mut [f32])) {
        change(&mut self.parameters);
        self.pack();
    }

    /// Ranges of each layer's weights and biases in the flat parameters.
    pub fn layer_ranges(&self) -> impl Iterator<Item = (Range<usize>, Range<usize>)> + '_ {
        self.layers.iter().map(|layer| (layer.weights.clone(), layer.biases()))
    }

    /// Numbers from one input row to the next.
    pub fn input_stride(&self) -> usize {
        padded(self.shape.inputs)
    }

    fn pack(&mut self) {
        for layer in &mut self.layers {
            layer.pack(&self.parameters);
        }
    }

    /// Buffers for the forward pass of so many rows, so that the first one does not have to make them.
    pub fn scratch(&self, rows: usize) -> WaypointScratch {
        let mut scratch = WaypointScratch::default();
        scratch.input(rows, self.input_stride());
        self.size(&mut scratch, rows);
        scratch
    }

    fn size(&self, scratch: &mut WaypointScratch, rows: usize) {
        let (width, blocks) = (self.shape.width, self.shape.dilations.len());
        let size = |buffers: &mut Vec<Vec<f32>>, count: usize, columns: usize| {
            buffers.resize_with(count, Vec::new);
            buffers.iter_mut().for_each(|buffer| buffer.resize(rows * columns, 0.0));
        };
        size(&mut scratch.hidden, blocks + 1, width);
        size(&mut scratch.neighbours, blocks, 3 * width);
        size(&mut scratch.active, blocks, width);
        scratch.outputs = self.shape.outputs;
        scratch.output.resize(rows * padded(self.shape.outputs), 0.0);
    }

    /// Runs the network on the scratch's input rows, which are trajectories of `waypoints` rows each.
    ///
    /// # Panics
    /// If the input holds no whole number of trajectories.
    pub fn forward(&self, scratch: &mut WaypointScratch, waypoints: usize) {
        let isa = Isa::detect();
        let rows = scratch.input.len() / self.input_stride();
        assert!(rows.is_multiple_of(waypoints), "{rows} rows of trajectories of {waypoints}");
        let (width, blocks) = (self.shape.width, self.shape.dilations.len());
        scratch.rows = rows;
        scratch.waypoints = waypoints;
        self.size(scratch, rows);
        self.layers[0].forward(isa, rows, &scratch.input, &mut scratch.hidden[0]);
        for (block, &dilation) in self.shape.dilations.iter().enumerate() {
            let (before, after) = scratch.hidden.split_at_mut(block + 1);
            let (h, next) = (&before[block], &mut after[0]);
            let (neighbours, active) = (&mut scratch.neighbours[block], &mut scratch.active[block]);
            gather(isa, h, waypoints, width, dilation, neighbours);
            self.layers[2 * block + 1].forward(isa, rows, neighbours, active);
            self.layers[2 * block + 2].forward(isa, rows, active, next);
            add(isa, h, next);
        }
        let head = &self.layers[2 * blocks + 1];
        head.forward(isa, rows, &scratch.hidden[blocks], &mut scratch.output);
    }

    /// Adds to the flat `gradient` that of a loss whose gradient with respect to the outputs of the last
    /// [`WaypointNet::forward`] is `output_gradient [rows x outputs]`.
    ///
    /// # Panics
    /// If `scratch` does not come from a forward pass of a network of this shape, or a slice is too short.
    pub fn backward(
        &self,
        output_gradient: &[f32],
        scratch: &mut WaypointScratch,
        gradient: &mut [f32],
    ) {
        let isa = Isa::detect();
        let WaypointScratch { rows, waypoints, .. } = *scratch;
        let (width, blocks) = (self.shape.width, self.shape.dilations.len());
        let (outputs, stride) = (self.shape.outputs, padded(self.shape.outputs));
        scratch.d_output.resize(rows * stride, 0.0);
        let given = output_gradient.chunks_exact(outputs);
        for (row, given) in scratch.d_output.chunks_exact_mut(stride).zip(given) {
            row[..outputs].copy_from_slice(given);
        }
        for buffer in [&mut scratch.d_hidden, &mut scratch.d_active] {
            buffer.resize(rows * width, 0.0);
        }
        scratch.d_neighbours.resize(3 * rows * width, 0.0);
        let linear = Activation::Linear;
        let (head, last) = (&self.layers[2 * blocks + 1], &scratch.hidden[blocks]);
        head.weight_gradient(isa, rows, last, &scratch.d_output, gradient);
        head.input_gradient(isa, linear, rows, &scratch.d_output, last, &mut scratch.d_hidden);
        for (block, &dilation) in self.shape.dilations.iter().enumerate().rev() {
            let (conv, outward) = (&self.layers[2 * block + 1], &self.layers[2 * block + 2]);
            let (active, neighbours) = (&scratch.active[block], &scratch.neighbours[block]);
            let (d_active, d_neighbours) = (&mut scratch.d_active, &mut scratch.d_neighbours);
            outward.weight_gradient(isa, rows, active, &scratch.d_hidden, gradient);
            outward.input_gradient(isa, conv.activation, rows, &scratch.d_hidden, active, d_active);
            conv.weight_gradient(isa, rows, neighbours, d_active, gradient);
            conv.input_gradient(isa, linear, rows, d_active, neighbours, d_neighbours);
            scatter(d_neighbours, waypoints, width, dilation, &mut scratch.d_hidden);
        }
        let first = &self.layers[0];
        for (slope, &h) in scratch.d_hidden.iter_mut().zip(&scratch.hidden[0]) {
            *slope = if h > 0.0 { *slope } else { 0.0 };
        }
        first.weight_gradient(isa, rows, &scratch.input, &scratch.d_hidden, gradient);
        if self.shape.map.is_some() {
            scratch.d_input.resize(rows * self.input_stride(), 0.0);
            let (d_hidden, d_input) = (&scratch.d_hidden, &mut scratch.d_input);
            first.input_gradient(isa, linear, rows, d_hidden, &scratch.input, d_input);
        }
    }

    /// Turns a map's inputs into features. Does nothing where the network has no map.
    pub fn read_map(&self, map: &mut MapScratch) {
        if let Some(shape) = &self.shape.map {
            map_net::forward(shape, self.map_layers(), map);
        }
    }

    /// Makes a map ready to collect slopes for [`WaypointNet::map_backward`].
    pub fn begin_map(&self, map: &mut MapScratch) {
        map_net::begin(map);
    }

    /// Adds to the flat `gradient` that of the loss whose slopes the map collected since it was read.
    pub fn map_backward(&self, map: &mut MapScratch, gradient: &mut [f32]) {
        if let Some(shape) = &self.shape.map {
            map_net::backward(shape, self.map_layers(), map, gradient);
        }
    }

    fn map_layers(&self) -> &[Layer] {
        &self.layers[2 * self.shape.dilations.len() + 2..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn values(count: usize, seed: u64) -> Vec<f32> {
        let mut state = seed.wrapping_add(77);
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f32 / (1 << 24) as f32 - 0.5
        };
        (0..count).map(|_| next()).collect()
    }

    /// Outputs by the formula at the head of this file, in f64.
    fn reference(
        shape: &WaypointShape,
        parameters: &[f64],
        input: &[f64],
        waypoints: usize,
    ) -> Vec<f64> {
        let width = shape.width;
        let mut at = 0;
        let mut dense = |x: &[Vec<f64>], inputs: usize, outputs: usize, relu: bool| {
            let weights = &parameters[at..at + inputs * outputs];
            let biases = &parameters[at + inputs * outputs..][..outputs];
            at += (inputs + 1) * outputs;
            let row = |x: &Vec<f64>| {
                let sums = weights.chunks(inputs).zip(biases).map(|(w, b)| {
                    let sum = b + w.iter().zip(x).map(|(w, x)| w * x).sum::<f64>();
                    if relu { sum.max(0.0) } else { sum }
                });
                sums.collect::<Vec<f64>>()
            };
            x.iter().map(row).collect::<Vec<_>>()
        };
        let x: Vec<Vec<f64>> = input.chunks(shape.inputs).map(<[f64]>::to_vec).collect();
        let mut h = dense(&x, shape.inputs, width, true);
        for &d in &shape.dilations {
            let row = |i: usize| {
                let (first, place) = (i / waypoints * waypoints, i % waypoints);
                let other = |j: Option<usize>| match j {
                    Some(j) if j < waypoints => h[first + j].clone(),
                    _ => vec![0.0; width],
                };
                [other(place.checked_sub(d)), other(Some(place)), other(Some(place + d))].concat()
            };
            let neighbours: Vec<Vec<f64>> = (0..h.len()).map(row).collect();
            let active = dense(&neighbours, 3 * width, width, true);
            let outward = dense(&active, width, width, false);
            for (h, out) in h.iter_mut().zip(outward) {
                h.iter_mut().zip(out).for_each(|(h, out)| *h += out);
            }
        }
        dense(&h, width, shape.outputs, false).concat()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn forward_and_backward_match_reference(
            inputs in 1_usize..40,
            waypoints in 1_usize..7,
            trajectories in 1_usize..4,
            dilations in prop::collection::vec(1_usize..4, 0..3),
            outputs in 1_usize..20,
            seed in 0_u64..1000,
        ) {
            let shape = WaypointShape { inputs, width: 16, dilations, outputs, map: None };
            let count = shape.parameter_count().unwrap();
            let net = WaypointNet::new(&shape, values(count, seed)).unwrap();
            let rows = waypoints * trajectories;
            let input = values(rows * inputs, seed + 1);
            let mut scratch = WaypointScratch::default();
            let stride = net.input_stride();
            for (row, given) in
                scratch.input(rows, stride).chunks_mut(stride).zip(input.chunks(inputs))
            {
                row[..inputs].copy_from_slice(given);
            }
            net.forward(&mut scratch, waypoints);
            let wide = |values: &[f32]| values.iter().map(|&v| f64::from(v)).collect::<Vec<_>>();
            let (mut exact, input) = (wide(net.parameters()), wide(&input));
            let expected = reference(&shape, &exact, &input, waypoints);
            for (row, want) in expected.chunks(outputs).enumerate() {
                for (got, want) in scratch.output(row).iter().zip(want) {
                    prop_assert!((f64::from(*got) - want).abs() <= 1e-4, "{got} {want}");
                }
            }
            let weights = values(outputs * rows, seed + 2);
            let mut gradient = vec![0.25; count];
            net.backward(&weights, &mut scratch, &mut gradient);
            let loss = |parameters: &[f64]| -> f64 {
                let outputs = reference(&shape, parameters, &input, waypoints);
                outputs.iter().zip(&weights).map(|(y, &w)| y * f64::from(w)).sum()
            };
            let h = 1e-7;
            for index in (0..count).step_by(7) {
                let value = exact[index];
                exact[index] = value + h;
                let above = loss(&exact);
                exact[index] = value - h;
                let slope = (above - loss(&exact)) / (2.0 * h);
                exact[index] = value;
                let got = f64::from(gradient[index]) - 0.25;
                prop_assert!((got - slope).abs() <= 2e-4 * (1.0 + slope.abs()), "{index}: {got} {slope}");
            }
        }
    }

    #[test]
    fn refuses_shapes_that_do_not_fit() {
        let check = |inputs: usize, width: usize, dilations: &[usize], field: &str| {
            let dilations = dilations.to_vec();
            let shape = WaypointShape { inputs, width, dilations, outputs: 2, map: None };
            assert_eq!(WaypointNet::new(&shape, Vec::new()).unwrap_err().field, field);
        };
        check(0, 16, &[1], "network.inputs");
        check(10, 17, &[1], "network.width");
        check(10, usize::MAX, &[1], "network.width");
        check(10, 16, &[0], "network.dilations");
        check(10, 16, &[1; 65], "network.dilations");
        check(10, 16, &[1], "network.parameters");
    }
}
