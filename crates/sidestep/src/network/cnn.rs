//! The image agent's network (paper, section III.E): two convolutions with ReLU over the image, three dense layers
//! after them, and a skip connection from everything that is no image to the last layer.
//!
//! ```text
//! features = relu(C_2 * relu(C_1 * image))               [8 x 8 x 32] of [64 x 64]
//! output   = mlp(features) + W_s others + b_s            mlp: tanh, tanh, linear
//! ```
//!
//! The sum is what a last layer over (hidden units, others) computes. The convolutions serve policy and value network
//! alike, so the value network reads [`Cnn::features`] and hands its gradient back ([`Cnn::backward`]).

use std::ops::Range;

use super::convolution::{Convolution, Form};
use super::mlp::{MAX_PARAMETERS, Mlp};
use super::scratch::Scratch;
use crate::error::InvalidInput;
use crate::kernels::Isa;

/// Side of the image, in pixels.
pub const IMAGE_SIDE: usize = 64;
/// Numbers of the image.
const IMAGE: usize = IMAGE_SIDE * IMAGE_SIDE;
const FIRST: Form =
    Form { side: IMAGE_SIDE, channels: 1, size: 8, stride: 4, padding: 2, outputs: 16 };
const SECOND: Form = Form {
    side: FIRST.side_out(),
    channels: FIRST.outputs,
    size: 4,
    stride: 2,
    padding: 1,
    outputs: 32,
};
/// Numbers that the convolutions make of an image.
pub const FEATURES: usize = SECOND.positions() * SECOND.outputs;

const _: () = assert!(FIRST.is_whole() && SECOND.is_whole());

/// A convolutional network with its parameters.
#[derive(Debug, Clone)]
pub struct Cnn {
    sizes: Vec<usize>,
    image_at: usize,
    parameters: Vec<f32>,
    convolutions: [Convolution; 2],
    head: Mlp,
    /// None where the image is all there is.
    skip: Option<Mlp>,
}

impl PartialEq for Cnn {
    fn eq(&self, other: &Self) -> bool {
        (&self.sizes, self.image_at) == (&other.sizes, other.image_at)
            && self.parameters == other.parameters
    }
}

/// One named part of the flat parameters: name, shape, range.
pub type Part = (String, Vec<usize>, Range<usize>);

impl Cnn {
    /// A network for observations of `sizes[0]` numbers, of which the image begins at `image_at`. `sizes` is
    /// `[observation, FEATURES, hidden.., output]`; the flat parameters are, each with its biases behind it: the convolutions' weights
    /// `[outputs x size x size x channels]`, the dense layers' and the skip connection's `[outputs x inputs]`.
    ///
    /// # Errors
    /// If the sizes do not fit the image or each other, or the number of parameters is not theirs.
    pub fn new(
        sizes: &[usize],
        image_at: usize,
        parameters: Vec<f32>,
    ) -> Result<Self, InvalidInput> {
        let [head, skip] = Self::layer_sizes(sizes, image_at)?;
        let expected = Self::parameter_count(sizes, image_at)?;
        if parameters.len() != expected {
            return Err(InvalidInput::new(
                "network.parameters",
                format!("{} numbers", parameters.len()),
                format!("{expected} numbers for the sizes {sizes:?}"),
            ));
        }
        let at = FIRST.parameters() + SECOND.parameters();
        let split = at + Mlp::parameter_count(&head)?;
        let mut cnn = Self {
            sizes: sizes.to_vec(),
            image_at,
            convolutions: [
                Convolution::new(FIRST, 0),
                Convolution::new(SECOND, FIRST.parameters()),
            ],
            head: Mlp::new(&head, parameters[at..split].to_vec())?,
            skip: match skip[0] {
                0 => None,
                _ => Some(Mlp::new(&skip, parameters[split..].to_vec())?),
            },
            parameters,
        };
        for convolution in &mut cnn.convolutions {
            convolution.pack(&cnn.parameters);
        }
        Ok(cnn)
    }

    /// Sizes of the dense layers and of the skip connection.
    fn layer_sizes(sizes: &[usize], image_at: usize) -> Result<[Vec<usize>; 2], InvalidInput> {
        let fits = sizes.len() >= 3
            && sizes[1] == FEATURES
            && sizes[0] >= IMAGE
            && image_at <= sizes[0] - IMAGE;
        if !fits {
            let allowed = format!(
                "[observation, {FEATURES}, .., output] with an image of {IMAGE} in the observation"
            );
            return Err(InvalidInput::new("network.sizes", format!("{sizes:?}"), allowed));
        }
        Ok([sizes[1..].to_vec(), vec![sizes[0] - IMAGE, sizes[sizes.len() - 1]]])
    }

    /// Number of parameters of a network of these sizes.
    ///
    /// # Errors
    /// If the sizes do not fit, or there would be too many.
    pub fn parameter_count(sizes: &[usize], image_at: usize) -> Result<usize, InvalidInput> {
        let [head, skip] = Self::layer_sizes(sizes, image_at)?;
        let skip = if skip[0] == 0 { 0 } else { Mlp::parameter_count(&skip)? };
        let dense = Mlp::parameter_count(&head)? + skip;
        let count = FIRST.parameters() + SECOND.parameters() + dense;
        if count > MAX_PARAMETERS {
            let allowed = format!("at most {MAX_PARAMETERS} parameters in all");
            return Err(InvalidInput::new("network.sizes", format!("{sizes:?}"), allowed));
        }
        Ok(count)
    }

    /// Numbers that the weights of each convolution sum over, and their ranges in the flat parameters; for initialisation.
    pub fn convolution_weights() -> [(usize, Range<usize>); 2] {
        let second = FIRST.parameters();
        [
            (FIRST.patch(), 0..FIRST.patch() * FIRST.outputs),
            (SECOND.patch(), second..second + SECOND.patch() * SECOND.outputs),
        ]
    }

    /// Range of the dense layers in the flat parameters.
    ///
    /// # Errors
    /// As [`Cnn::parameter_count`].
    pub fn head_range(sizes: &[usize], image_at: usize) -> Result<Range<usize>, InvalidInput> {
        let [head, _] = Self::layer_sizes(sizes, image_at)?;
        let at = FIRST.parameters() + SECOND.parameters();
        Ok(at..at + Mlp::parameter_count(&head)?)
    }

    /// Sizes `[observation, FEATURES, hidden.., output]`.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// Where the image begins in an observation.
    pub fn image_at(&self) -> usize {
        self.image_at
    }

    /// The flat parameters, laid out as in [`Cnn::new`].
    pub fn parameters(&self) -> &[f32] {
        &self.parameters
    }

    /// Changes the parameters in place and repacks them for the kernels.
    pub fn update(&mut self, change: impl FnOnce(&mut [f32])) {
        change(&mut self.parameters);
        for convolution in &mut self.convolutions {
            convolution.pack(&self.parameters);
        }
        let (_, dense) = self.parameters.split_at(self.convolutions[1].biases().end);
        let (head, skip) = dense.split_at(self.head.parameters().len());
        self.head.update(|parameters| parameters.copy_from_slice(head));
        if let Some(network) = &mut self.skip {
            network.update(|parameters| parameters.copy_from_slice(skip));
        }
    }

    /// The flat parameters by name, for files.
    pub fn parts(&self) -> Vec<Part> {
        let mut parts = Vec::new();
        for (index, convolution) in self.convolutions.iter().enumerate() {
            let Form { size, channels, outputs, .. } = convolution.form;
            let name = format!("convolutions.{index}");
            let shape = vec![outputs, size, size, channels];
            parts.push((format!("{name}.weight"), shape, convolution.weights.clone()));
            parts.push((format!("{name}.bias"), vec![outputs], convolution.biases()));
        }
        let mut first = self.convolutions[1].biases().end;
        let dense = std::iter::once((&self.head, "layers"))
            .chain(self.skip.as_ref().map(|skip| (skip, "skip")));
        for (network, group) in dense {
            for (layer, pair) in network.sizes().windows(2).enumerate() {
                let weights = first..first + pair[0] * pair[1];
                let biases = weights.end..weights.end + pair[1];
                first = biases.end;
                let name = format!("{group}.{layer}");
                parts.push((format!("{name}.weight"), vec![pair[1], pair[0]], weights));
                parts.push((format!("{name}.bias"), vec![pair[1]], biases));
            }
        }
        parts
    }

    /// The outputs for `inputs [rows x observation]`, read from [`Scratch::output`].
    pub fn forward_batch(&self, inputs: &[f32], scratch: &mut Scratch) {
        let (isa, wide) = (Isa::detect(), self.sizes[0]);
        let rows = inputs.len() / wide;
        let mut own = scratch.image.take().unwrap_or_default();
        own.images.clear();
        own.others.clear();
        own.first.resize(rows * FIRST.positions() * FIRST.outputs, 0.0);
        own.second.resize(rows * FEATURES, 0.0);
        let outs = own
            .first
            .chunks_exact_mut(FIRST.positions() * FIRST.outputs)
            .zip(own.second.chunks_exact_mut(FEATURES));
        let [first, second] = &self.convolutions;
        for (input, (first_out, second_out)) in inputs.chunks_exact(wide).zip(outs) {
            let (before, rest) = input.split_at(self.image_at);
            let (image, after) = rest.split_at(IMAGE);
            own.images.extend_from_slice(image);
            own.others.extend_from_slice(before);
            own.others.extend_from_slice(after);
            first.forward(isa, image, &mut own.patches, first_out);
            second.forward(isa, first_out, &mut own.patches, second_out);
        }
        self.head.forward_batch(&own.second, scratch);
        if let Some(skip) = &self.skip {
            skip.forward_batch(&own.others, &mut own.skip);
            for row in 0..rows {
                let added = own.skip.output(row).iter();
                scratch.output_mut(row).iter_mut().zip(added).for_each(|(out, s)| *out += s);
            }
        }
        scratch.image = Some(own);
    }

    /// What the convolutions made of the last batch's images, `[rows x FEATURES]`.
    pub fn features(scratch: &Scratch) -> &[f32] {
        scratch.image.as_ref().map_or(&[], |own| &own.second)
    }

    /// Adds to `gradient` (laid out as the parameters) that of a loss, given its gradients with respect to the outputs
    /// `[rows x outputs]` and, through anything else that reads them, to the features `[rows x FEATURES]`.
    ///
    /// # Panics
    /// If `scratch` does not come from a forward pass of such a network, or a slice is too short.
    pub fn backward(
        &self,
        output_gradient: &[f32],
        feature_gradient: Option<&[f32]>,
        scratch: &mut Scratch,
        gradient: &mut [f32],
    ) {
        let isa = Isa::detect();
        let mut own = scratch.image.take().unwrap_or_default();
        let at = self.convolutions[1].biases().end;
        let (_, dense) = gradient.split_at_mut(at);
        let (head, skip) = dense.split_at_mut(self.head.parameters().len());
        self.head.backward(output_gradient, scratch, head);
        self.head.input_gradient(scratch);
        if let Some(network) = &self.skip {
            network.backward(output_gradient, &mut own.skip, skip);
        }
        own.second_slope.clear();
        own.second_slope.extend_from_slice(scratch.input_gradient());
        if let Some(more) = feature_gradient {
            own.second_slope.iter_mut().zip(more).for_each(|(slope, more)| *slope += more);
        }
        let [first, second] = &self.convolutions;
        let wide = FIRST.positions() * FIRST.outputs;
        for row in 0..own.images.len() / IMAGE {
            let image = &own.images[row * IMAGE..][..IMAGE];
            let first_out = &own.first[row * wide..][..wide];
            let second_out = &own.second[row * FEATURES..][..FEATURES];
            let slope = &mut own.second_slope[row * FEATURES..][..FEATURES];
            own.first_slope.clear();
            own.first_slope.resize(wide, 0.0);
            let through = Some(&mut own.first_slope[..]);
            second.backward(isa, first_out, second_out, slope, &mut own.patches, gradient, through);
            let slope = &mut own.first_slope;
            first.backward(isa, image, first_out, slope, &mut own.patches, gradient, None);
        }
        scratch.image = Some(own);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(count: usize, seed: f32, scale: f32) -> Vec<f32> {
        (0..count).map(|i| scale * ((i as f32 + seed) * 0.713).sin()).collect()
    }

    fn network(others: usize, image_at: usize) -> Cnn {
        let sizes = [IMAGE + others, FEATURES, 12, 5, 3];
        let count = Cnn::parameter_count(&sizes, image_at).unwrap();
        let mut cnn = Cnn::new(&sizes, image_at, values(count, 1.0, 0.08)).unwrap();
        // Large biases keep the convolutions off ReLU's kinks, which are tested where they are computed.
        // Small weights behind them keep tanh off its flat ends.
        for (name, _, range) in cnn.parts() {
            cnn.update(|parameters| match name.as_str() {
                "convolutions.0.bias" | "convolutions.1.bias" => parameters[range].fill(4.0),
                "layers.0.weight" => parameters[range].iter_mut().for_each(|p| *p *= 0.02),
                _ => {}
            });
        }
        cnn
    }

    #[test]
    fn gradient_matches_finite_differences() {
        for (others, image_at) in [(0, 0), (4, 0), (4, 3)] {
            let cnn = network(others, image_at);
            let rows = 2;
            let inputs = values(rows * (IMAGE + others), 4.0, 1.0);
            let (outputs, features) =
                (values(rows * 3, 2.0, 1.0), values(rows * FEATURES, 9.0, 0.1));
            // The loss weighs outputs and features, as policy and value network do together.
            let loss = |cnn: &Cnn| -> f64 {
                let mut scratch = Scratch::default();
                cnn.forward_batch(&inputs, &mut scratch);
                let dot = |a: &[f32], b: &[f32]| -> f64 {
                    a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
                };
                let out: f64 =
                    (0..rows).map(|r| dot(scratch.output(r), &outputs[3 * r..][..3])).sum();
                out + dot(Cnn::features(&scratch), &features)
            };
            let (mut scratch, mut gradient) =
                (Scratch::default(), vec![0.0; cnn.parameters().len()]);
            cnn.forward_batch(&inputs, &mut scratch);
            cnn.backward(&outputs, Some(&features), &mut scratch, &mut gradient);
            for (name, _, range) in cnn.parts() {
                // Along the gradient itself, part by part: one number that sums over all of its entries.
                let part = &gradient[range.clone()];
                let square: f64 = part.iter().map(|g| f64::from(*g).powi(2)).sum();
                // A step that moves the loss by so little stays off tanh's bends, and by so much off rounding.
                let h = (1e-2 / square.sqrt()).min(3e-3 / square);
                let moved = |by: f64| {
                    let mut moved = cnn.clone();
                    moved.update(|p| {
                        for (p, g) in p[range.clone()].iter_mut().zip(part) {
                            *p += (by * f64::from(*g)) as f32;
                        }
                    });
                    loss(&moved)
                };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                assert!(
                    square > 0.0 && (slope / square - 1.0).abs() < 0.03,
                    "{name}: {slope} {square}"
                );
            }
        }
    }

    #[test]
    fn a_batch_is_its_rows_and_parts_cover_the_parameters() {
        let cnn = network(6, 2);
        let inputs = values(3 * (IMAGE + 6), 8.0, 1.0);
        let (mut together, mut alone) = (Scratch::default(), Scratch::default());
        cnn.forward_batch(&inputs, &mut together);
        for (row, input) in inputs.chunks(IMAGE + 6).enumerate() {
            cnn.forward_batch(input, &mut alone);
            assert_eq!(alone.output(0), together.output(row));
        }
        let mut next = 0;
        for (name, shape, range) in cnn.parts() {
            assert_eq!((range.start, range.len()), (next, shape.iter().product()), "{name}");
            next = range.end;
        }
        assert_eq!(next, cnn.parameters().len());
    }

    #[test]
    fn refuses_sizes_that_do_not_fit() {
        let check = |sizes: &[usize], image_at: usize| {
            let error = Cnn::parameter_count(sizes, image_at).unwrap_err();
            assert_eq!(error.field, "network.sizes", "{error}");
        };
        check(&[IMAGE, 10, 3], 0);
        check(&[IMAGE - 1, FEATURES, 3], 0);
        check(&[IMAGE + 2, FEATURES, 3], 3);
        check(&[IMAGE], 0);
        check(&[IMAGE, FEATURES, 1 << 15, 3], 0);
    }
}
