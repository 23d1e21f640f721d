//! The multi-layer perceptron of the paper (section II.B): tanh, tanh, linear.
//!
//! ```text
//! y_0 = x;   y_l = tanh(W_l y_{l-1} + b_l);   output = W_L y_{L-1} + b_L
//! ```
//!
//! The backward pass is the chain rule in the same order reversed, over the activations that the forward pass
//! left in a [`Scratch`]: with d_L the gradient with respect to the output,
//!
//! ```text
//! dW_l = d_l^T y_{l-1};   db_l = sum of d_l;   d_{l-1} = (d_l W_l) * (1 - y_{l-1}^2)
//! ```
//!
//! Policy and value network share no layer (paper), so each is an [`Mlp`] of its own.

use std::ops::Range;

use crate::error::InvalidInput;
use crate::kernels::Isa;
use crate::kernels::dense::{Activation, padded};

use super::layer::Layer;
use super::scratch::Scratch;

/// Most parameters that a network may have (256 MB); stops a hostile file before it allocates.
pub const MAX_PARAMETERS: usize = 1 << 26;

/// A perceptron with its parameters and their packed copies for the kernels.
#[derive(Debug, Clone)]
pub struct Mlp {
    sizes: Vec<usize>,
    parameters: Vec<f32>,
    layers: Vec<Layer>,
}

impl PartialEq for Mlp {
    fn eq(&self, other: &Self) -> bool {
        self.sizes == other.sizes && self.parameters == other.parameters
    }
}

/// Copies `[rows x size]` into rows padded with zeros.
fn pad_rows(values: &[f32], size: usize, target: &mut [f32]) {
    for (row, source) in target.chunks_exact_mut(padded(size)).zip(values.chunks_exact(size)) {
        row[..size].copy_from_slice(source);
        row[size..].fill(0.0);
    }
}

impl Mlp {
    /// A network from its sizes `[input, hidden.., output]` and its flat parameters: per layer the weights
    /// `[outputs x inputs]`, row-major, then the biases `[outputs]`.
    ///
    /// # Errors
    /// If there are fewer than two sizes, one is 0, or the number of parameters is too large or not theirs.
    pub fn new(sizes: &[usize], parameters: Vec<f32>) -> Result<Self, InvalidInput> {
        let expected = Self::parameter_count(sizes)?;
        if parameters.len() != expected {
            return Err(InvalidInput::new(
                "network.parameters",
                format!("{} numbers", parameters.len()),
                format!("{expected} numbers for the sizes {sizes:?}"),
            ));
        }
        let mut first = 0;
        let mut layers = Vec::with_capacity(sizes.len() - 1);
        for (index, pair) in sizes.windows(2).enumerate() {
            let (inputs, outputs) = (pair[0], pair[1]);
            let last = index + 2 == sizes.len();
            let activation = if last { Activation::Linear } else { Activation::Tanh };
            layers.push(Layer::new(inputs, outputs, first, activation));
            first += (inputs + 1) * outputs;
        }
        let mut mlp = Self { sizes: sizes.to_vec(), parameters, layers };
        mlp.pack();
        Ok(mlp)
    }

    /// Number of parameters of a network of these sizes.
    ///
    /// # Errors
    /// If there are fewer than two sizes, one is 0, or there would be more than [`MAX_PARAMETERS`].
    pub fn parameter_count(sizes: &[usize]) -> Result<usize, InvalidInput> {
        let refused = |allowed: String| {
            Err(InvalidInput::new("network.sizes", format!("{sizes:?}"), allowed))
        };
        if sizes.len() < 2 || sizes.contains(&0) {
            return refused("at least an input and an output size, each above 0".into());
        }
        let count = sizes.windows(2).try_fold(0_usize, |sum, pair| {
            pair[0].checked_add(1)?.checked_mul(pair[1])?.checked_add(sum)
        });
        match count.filter(|&count| count <= MAX_PARAMETERS) {
            Some(count) => Ok(count),
            None => refused(format!("at most {MAX_PARAMETERS} parameters in all")),
        }
    }

    /// Sizes `[input, hidden.., output]`.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// Numbers that go in.
    pub fn inputs(&self) -> usize {
        self.sizes[0]
    }

    /// Numbers that come out.
    pub fn outputs(&self) -> usize {
        self.sizes[self.sizes.len() - 1]
    }

    /// The flat parameters, laid out as in [`Mlp::new`].
    pub fn parameters(&self) -> &[f32] {
        &self.parameters
    }

    /// Changes the parameters in place and repacks them for the kernels.
    pub fn update(&mut self, change: impl FnOnce(&mut [f32])) {
        change(&mut self.parameters);
        self.pack();
    }

    /// Ranges of each layer's weights `[outputs x inputs]` and biases `[outputs]` in the flat parameters.
    pub fn layer_ranges(&self) -> impl Iterator<Item = (Range<usize>, Range<usize>)> + '_ {
        self.layers.iter().map(|layer| (layer.weights.clone(), layer.biases()))
    }

    fn pack(&mut self) {
        for layer in &mut self.layers {
            layer.pack(&self.parameters);
        }
    }

    /// The output `[outputs]` for one `input [inputs]`, without allocating once `scratch` has served.
    ///
    /// # Panics
    /// If a slice is shorter than its size.
    pub fn forward(&self, input: &[f32], scratch: &mut Scratch, output: &mut [f32]) {
        self.forward_batch(&input[..self.inputs()], scratch);
        output[..self.outputs()].copy_from_slice(scratch.output(0));
    }

    /// The outputs for `inputs [rows x inputs]`, read from [`Scratch::output`]; bit-equal to
    /// [`Mlp::forward`] of each row. An incomplete last row is ignored.
    pub fn forward_batch(&self, inputs: &[f32], scratch: &mut Scratch) {
        let isa = Isa::detect();
        let rows = inputs.len() / self.inputs();
        scratch.shape(&self.sizes, rows);
        pad_rows(inputs, self.inputs(), &mut scratch.activations[0]);
        for (index, layer) in self.layers.iter().enumerate() {
            let (before, after) = scratch.activations.split_at_mut(index + 1);
            layer.forward(isa, rows, &before[index], &mut after[0]);
        }
    }

    /// Adds to `gradient` (laid out as the parameters) that of a loss whose gradient with respect to the outputs of the
    /// last [`Mlp::forward_batch`] is `output_gradient [rows x outputs]`. Sums run over rows in order.
    ///
    /// # Panics
    /// If `scratch` does not come from a forward pass of a network of these sizes, or a slice is too short.
    pub fn backward(&self, output_gradient: &[f32], scratch: &mut Scratch, gradient: &mut [f32]) {
        let isa = Isa::detect();
        let rows = scratch.rows;
        scratch.gradients.resize_with(self.sizes.len(), Vec::new);
        for (buffer, &size) in scratch.gradients.iter_mut().zip(&self.sizes).skip(1) {
            buffer.resize(rows * padded(size), 0.0);
        }
        let last = self.layers.len();
        let given = &output_gradient[..rows * self.outputs()];
        pad_rows(given, self.outputs(), &mut scratch.gradients[last]);
        for (index, layer) in self.layers.iter().enumerate().rev() {
            let (before, after) = scratch.gradients.split_at_mut(index + 1);
            let (dy, x) = (&after[0], &scratch.activations[index]);
            layer.weight_gradient(isa, rows, x, dy, gradient);
            if index > 0 {
                // The input of this layer is the output of the one before, which is never the last: tanh.
                let before_it = self.layers[index - 1].activation;
                layer.input_gradient(isa, before_it, rows, dy, x, &mut before[index]);
            }
        }
    }

    /// After [`Mlp::backward`], the gradient with respect to the inputs, left in [`Scratch::input_gradient`].
    ///
    /// # Panics
    /// As [`Mlp::backward`].
    pub fn input_gradient(&self, scratch: &mut Scratch) {
        let (layer, rows) = (&self.layers[0], scratch.rows);
        let [dx, dy, ..] = &mut scratch.gradients[..] else { return };
        dx.resize(rows * padded(layer.inputs), 0.0);
        layer.input_gradient(
            Isa::detect(),
            Activation::Linear,
            rows,
            dy,
            &scratch.activations[0],
            dx,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Outputs by the formula at the head of this file, in f64.
    fn reference(mlp: &Mlp, input: &[f32], parameters: &[f64]) -> Vec<f64> {
        let mut y: Vec<f64> = input.iter().map(|&x| f64::from(x)).collect();
        let layers: Vec<_> = mlp.layer_ranges().collect();
        for (index, (weights, biases)) in layers.iter().enumerate() {
            let rows = parameters[weights.clone()].chunks(y.len());
            let sums = rows.zip(&parameters[biases.clone()]).map(|(row, bias)| {
                let sum = bias + row.iter().zip(&y).map(|(w, x)| w * x).sum::<f64>();
                if index + 1 < layers.len() { sum.tanh() } else { sum }
            });
            y = sums.collect();
        }
        y
    }

    fn values(count: usize, seed: u64) -> Vec<f32> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f32 / (1 << 24) as f32 - 0.5
        };
        (0..count).map(|_| next()).collect()
    }

    fn network(sizes: &[usize], seed: u64) -> Mlp {
        Mlp::new(sizes, values(Mlp::parameter_count(sizes).unwrap(), seed)).unwrap()
    }

    proptest! {
        #[test]
        fn forward_matches_reference(
            sizes in prop::collection::vec(1_usize..70, 2..5),
            rows in 1_usize..12,
            seed in 0_u64..1000,
        ) {
            let mlp = network(&sizes, seed);
            let inputs = values(rows * mlp.inputs(), seed + 1);
            let (mut scratch, mut alone) = (Scratch::default(), Scratch::default());
            mlp.forward_batch(&inputs, &mut scratch);
            let exact: Vec<f64> = mlp.parameters().iter().map(|&p| f64::from(p)).collect();
            let mut output = vec![0.0; mlp.outputs()];
            for (row, input) in inputs.chunks(mlp.inputs()).enumerate() {
                for (got, want) in scratch.output(row).iter().zip(reference(&mlp, input, &exact)) {
                    prop_assert!((f64::from(*got) - want).abs() <= 1e-5, "{got} {want}");
                }
                mlp.forward(input, &mut alone, &mut output);
                prop_assert_eq!(&output[..], scratch.output(row), "one row alone differs from the batch");
            }
        }

        #[test]
        fn backward_matches_finite_differences(
            sizes in prop::collection::vec(1_usize..24, 2..5),
            rows in 1_usize..9,
            seed in 0_u64..1000,
        ) {
            let mlp = network(&sizes, seed);
            let inputs = values(rows * mlp.inputs(), seed + 1);
            // The loss is a fixed weighted sum of all outputs, so its gradient is the weights.
            let loss_weights = values(rows * mlp.outputs(), seed + 2);
            let mut scratch = Scratch::default();
            mlp.forward_batch(&inputs, &mut scratch);
            let mut gradient = vec![0.5; mlp.parameters().len()];
            mlp.backward(&loss_weights, &mut scratch, &mut gradient);
            mlp.input_gradient(&mut scratch);
            let by_input = scratch.input_gradient().to_vec();
            let mut parameters: Vec<f64> = mlp.parameters().iter().map(|&p| f64::from(p)).collect();
            let loss = |parameters: &[f64]| -> f64 {
                inputs.chunks(mlp.inputs()).flat_map(|input| reference(&mlp, input, parameters))
                    .zip(&loss_weights).map(|(y, &w)| y * f64::from(w)).sum()
            };
            let h = 1e-5;
            for (index, &got) in gradient.iter().enumerate() {
                let value = parameters[index];
                parameters[index] = value + h;
                let above = loss(&parameters);
                parameters[index] = value - h;
                let slope = (above - loss(&parameters)) / (2.0 * h);
                parameters[index] = value;
                prop_assert!((f64::from(got) - 0.5 - slope).abs() <= 2e-5, "{index}: {got} {slope}");
            }
            let width = by_input.len() / rows;
            for (index, &x) in inputs.iter().enumerate() {
                let (row, column) = (index / mlp.inputs(), index % mlp.inputs());
                let moved = |by: f64| -> f64 {
                    let mut input = inputs[row * mlp.inputs()..][..mlp.inputs()].to_vec();
                    input[column] = (f64::from(x) + by) as f32;
                    let weights = &loss_weights[row * mlp.outputs()..];
                    reference(&mlp, &input, &parameters).iter().zip(weights)
                        .map(|(y, &w)| y * f64::from(w)).sum()
                };
                let slope = (moved(1e-3) - moved(-1e-3)) / 2e-3;
                let got = f64::from(by_input[row * width + column]);
                prop_assert!((got - slope).abs() <= 2e-3 * (1.0 + slope.abs()), "{index}: {got} {slope}");
            }
        }
    }

    #[test]
    fn refuses_wrong_sizes_without_allocating() {
        let check = |sizes: &[usize], count: usize, field: &str| {
            let error = Mlp::new(sizes, vec![0.0; count]).unwrap_err();
            assert_eq!(error.field, field, "{error}");
        };
        check(&[3], 0, "network.sizes");
        check(&[3, 0, 2], 0, "network.sizes");
        check(&[usize::MAX, usize::MAX], 0, "network.sizes");
        check(&[1 << 14, 1 << 14], 0, "network.sizes");
        check(&[3, 2], 7, "network.parameters");
    }

    #[test]
    fn update_changes_the_output() {
        let mut mlp = network(&[3, 5, 2], 1);
        let (mut scratch, mut output) = (Scratch::default(), [0.0; 2]);
        mlp.update(|parameters| parameters.fill(0.0));
        mlp.forward(&[1.0, 2.0, 3.0], &mut scratch, &mut output);
        assert_eq!(output, [0.0; 2]);
    }
}
