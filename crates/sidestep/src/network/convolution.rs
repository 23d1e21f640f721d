//! A convolution with ReLU over a square image, as a product over its patches (im2col; K. Chellapilla, S. Puri and P. Simard,
//! High performance convolutional neural networks for document processing, IWFHR 2006).
//!
//! ```text
//! y(v, u, o) = max(0, b_o + sum over (i, j, c) of W[o][i][j][c] x(s v + i - p, s u + j - p, c))
//! ```
//!
//! Images are `[side x side x channels]`, row-major, channels last, zero outside; s is the stride, p the padding. A patch is the
//! `size x size x channels` numbers under the window, one row of the product per output pixel. Backwards:
//!
//! ```text
//! dz = dy where y > 0, else 0;   dW += dz^T patches;   db += sum of dz;   dx = the patches of dz W, added up where they lie
//! ```

use std::ops::Range;

use crate::kernels::Isa;
use crate::kernels::dense::{self, Activation, padded};

/// The form of a convolution. A patch and the outputs are whole panels of the kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Form {
    /// Side of the image that goes in, in pixels.
    pub side: usize,
    /// Its channels.
    pub channels: usize,
    /// Side of the window.
    pub size: usize,
    /// Pixels from one window to the next.
    pub stride: usize,
    /// Zeros around the image.
    pub padding: usize,
    /// Channels that come out.
    pub outputs: usize,
}

impl Form {
    /// Side of the image that comes out.
    pub const fn side_out(&self) -> usize {
        (self.side + 2 * self.padding - self.size) / self.stride + 1
    }

    /// Pixels that come out.
    pub const fn positions(&self) -> usize {
        self.side_out() * self.side_out()
    }

    /// Numbers in a patch.
    pub const fn patch(&self) -> usize {
        self.size * self.size * self.channels
    }

    /// Weights and biases.
    pub const fn parameters(&self) -> usize {
        (self.patch() + 1) * self.outputs
    }

    /// Whether the kernels can read it without padding.
    pub const fn is_whole(&self) -> bool {
        padded(self.patch()) == self.patch() && padded(self.outputs) == self.outputs
    }

    /// Each run of pixels that patches and image share: (place in the patches, place in the image, length).
    fn runs(&self) -> impl Iterator<Item = (usize, usize, usize)> + '_ {
        let (side, out, row) = (self.side as isize, self.side_out(), self.size * self.channels);
        (0..out * out * self.size).filter_map(move |index| {
            let (position, i) = (index / self.size, index % self.size);
            let place = |along: usize| (along * self.stride) as isize - self.padding as isize;
            let (y, x) = (place(position / out) + i as isize, place(position % out));
            let (first, last) = (x.max(0), (x + self.size as isize).min(side));
            if y < 0 || y >= side || first >= last {
                return None;
            }
            let patch = position * self.patch() + i * row + (first - x) as usize * self.channels;
            let image = (y * side + first) as usize * self.channels;
            Some((patch, image, (last - first) as usize * self.channels))
        })
    }

    /// Copies the patches of `image` to `patches [positions x patch]`, whose places outside the image must be zero already.
    pub fn gather(&self, image: &[f32], patches: &mut [f32]) {
        for (patch, at, length) in self.runs() {
            patches[patch..patch + length].copy_from_slice(&image[at..at + length]);
        }
    }

    /// Adds the patches up where they lie in the image.
    pub fn scatter(&self, patches: &[f32], image: &mut [f32]) {
        for (patch, at, length) in self.runs() {
            let target = &mut image[at..at + length];
            target.iter_mut().zip(&patches[patch..patch + length]).for_each(|(t, p)| *t += p);
        }
    }
}

/// A convolution with its packed parameters; the flat ones belong to the network.
#[derive(Debug, Clone)]
pub(super) struct Convolution {
    pub form: Form,
    /// Range of the weights `[outputs x size x size x channels]` in the flat parameters; the biases follow.
    pub weights: Range<usize>,
    forward: Vec<f32>,
    backward: Vec<f32>,
    bias: Vec<f32>,
}

/// Buffers for the patches of one image.
#[derive(Debug, Clone, Default)]
pub(super) struct Patches {
    values: Vec<f32>,
    gradient: Vec<f32>,
}

impl Convolution {
    /// A convolution whose parameters begin at `first`.
    pub fn new(form: Form, first: usize) -> Self {
        let weights = form.patch() * form.outputs;
        Self {
            form,
            weights: first..first + weights,
            forward: vec![0.0; weights],
            backward: vec![0.0; weights],
            bias: vec![0.0; form.outputs],
        }
    }

    /// Range of the biases in the flat parameters.
    pub fn biases(&self) -> Range<usize> {
        self.weights.end..self.weights.end + self.form.outputs
    }

    /// Takes over changed parameters.
    pub fn pack(&mut self, parameters: &[f32]) {
        let weights = &parameters[self.weights.clone()];
        let (inputs, outputs) = (self.form.patch(), self.form.outputs);
        dense::pack_forward(weights, inputs, outputs, &mut self.forward);
        dense::pack_backward(weights, inputs, outputs, &mut self.backward);
        let biases = self.biases();
        self.bias.copy_from_slice(&parameters[biases]);
    }

    /// `out [positions x outputs]` of one `image`.
    pub fn forward(&self, isa: Isa, image: &[f32], patches: &mut Patches, out: &mut [f32]) {
        let (rows, inputs) = (self.form.positions(), self.form.patch());
        self.lay_out(image, patches);
        let x = &patches.values[..rows * inputs];
        dense::forward(
            isa,
            Activation::Relu,
            rows,
            inputs,
            x,
            inputs,
            &self.forward,
            &self.bias,
            out,
        );
    }

    /// Adds to `gradient` (all flat parameters) that of a loss with `slope` its gradient with respect to `out`; `slope` is
    /// changed. With `image_slope`, which must be zero, also its gradient with respect to the image.
    #[allow(clippy::too_many_arguments, reason = "like the kernels, flat slices")]
    pub fn backward(
        &self,
        isa: Isa,
        image: &[f32],
        out: &[f32],
        slope: &mut [f32],
        patches: &mut Patches,
        gradient: &mut [f32],
        image_slope: Option<&mut [f32]>,
    ) {
        let (rows, inputs, outputs) = (self.form.positions(), self.form.patch(), self.form.outputs);
        for (slope, &out) in slope.iter_mut().zip(out) {
            if out <= 0.0 {
                *slope = 0.0;
            }
        }
        self.lay_out(image, patches);
        let x = &patches.values[..rows * inputs];
        let (weights, biases) =
            gradient[self.weights.start..self.biases().end].split_at_mut(self.weights.len());
        dense::weight_gradient(isa, rows, inputs, x, slope, outputs, weights, biases);
        if let Some(image_slope) = image_slope {
            patches.gradient.resize(patches.gradient.len().max(rows * inputs), 0.0);
            let dx = &mut patches.gradient[..rows * inputs];
            let (linear, packed) = (Activation::Linear, &self.backward);
            dense::input_gradient(isa, linear, rows, outputs, slope, outputs, packed, x, dx);
            self.form.scatter(dx, image_slope);
        }
    }

    /// The patches of `image`, with zeros outside it.
    fn lay_out(&self, image: &[f32], patches: &mut Patches) {
        let count = self.form.positions() * self.form.patch();
        patches.values.clear();
        patches.values.resize(count, 0.0);
        self.form.gather(image, &mut patches.values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORM: Form = Form { side: 7, channels: 4, size: 4, stride: 2, padding: 1, outputs: 16 };

    fn values(count: usize, seed: f32) -> Vec<f32> {
        (0..count).map(|i| ((i as f32 + seed) * 0.713).sin()).collect()
    }

    /// The formula at the head of this file.
    fn reference(form: Form, image: &[f32], parameters: &[f64]) -> Vec<f64> {
        let side = form.side_out();
        let pixel = |y: isize, x: isize, c: usize| {
            let inside = |v: isize| v >= 0 && v < form.side as isize;
            if inside(y) && inside(x) {
                f64::from(image[(y as usize * form.side + x as usize) * form.channels + c])
            } else {
                0.0
            }
        };
        let mut out = Vec::new();
        for (v, u) in (0..side).flat_map(|v| (0..side).map(move |u| (v, u))) {
            for o in 0..form.outputs {
                let mut sum = parameters[form.patch() * form.outputs + o];
                for (i, j) in (0..form.size).flat_map(|i| (0..form.size).map(move |j| (i, j))) {
                    for c in 0..form.channels {
                        let place = |at: usize, k: usize| {
                            (at * form.stride + k) as isize - form.padding as isize
                        };
                        let w = ((o * form.size + i) * form.size + j) * form.channels + c;
                        sum += parameters[w] * pixel(place(v, i), place(u, j), c);
                    }
                }
                out.push(sum.max(0.0));
            }
        }
        out
    }

    #[test]
    fn forward_matches_reference() {
        for form in [FORM, Form { side: 8, channels: 1, size: 8, stride: 4, padding: 2, ..FORM }] {
            assert!(form.is_whole());
            let image = values(form.side * form.side * form.channels, 3.0);
            let parameters = values(form.parameters(), 5.0);
            let mut convolution = Convolution::new(form, 0);
            convolution.pack(&parameters);
            let exact: Vec<f64> = parameters.iter().map(|&p| f64::from(p)).collect();
            let expected = reference(form, &image, &exact);
            for isa in Isa::available() {
                let mut out = vec![9.0; form.positions() * form.outputs];
                convolution.forward(isa, &image, &mut Patches::default(), &mut out);
                for (got, want) in out.iter().zip(&expected) {
                    assert!((f64::from(*got) - want).abs() < 2e-5, "{got} {want}");
                }
            }
        }
    }

    #[test]
    fn backward_matches_finite_differences() {
        let image = values(FORM.side * FORM.side * FORM.channels, 1.0);
        let parameters = values(FORM.parameters(), 2.0);
        let weights = values(FORM.positions() * FORM.outputs, 7.0);
        let mut convolution = Convolution::new(FORM, 0);
        convolution.pack(&parameters);
        let (mut patches, isa) = (Patches::default(), Isa::detect());
        let mut out = vec![0.0; weights.len()];
        convolution.forward(isa, &image, &mut patches, &mut out);
        let (mut gradient, mut image_slope) = (vec![0.5; parameters.len()], vec![0.0; image.len()]);
        let (slope, image_gradient) = (&mut weights.clone(), Some(&mut image_slope[..]));
        convolution.backward(isa, &image, &out, slope, &mut patches, &mut gradient, image_gradient);
        let loss = |image: &[f32], parameters: &[f64]| -> f64 {
            let out = reference(FORM, image, parameters);
            out.iter().zip(&weights).map(|(y, &w)| y * f64::from(w)).sum()
        };
        let exact: Vec<f64> = parameters.iter().map(|&p| f64::from(p)).collect();
        let h = 1e-6;
        for index in (0..exact.len()).step_by(13).chain(exact.len() - 16..exact.len()) {
            let moved = |by: f64| {
                let mut moved = exact.clone();
                moved[index] += by;
                loss(&image, &moved)
            };
            let slope = (moved(h) - moved(-h)) / (2.0 * h);
            let got = f64::from(gradient[index]) - 0.5;
            assert!((got - slope).abs() < 2e-4 * (1.0 + slope.abs()), "{index}: {got} {slope}");
        }
        for index in (0..image.len()).step_by(5) {
            let moved = |by: f32| {
                let mut moved = image.clone();
                moved[index] += by;
                loss(&moved, &exact)
            };
            let slope = (moved(1e-3) - moved(-1e-3)) / 2e-3;
            let got = f64::from(image_slope[index]);
            assert!((got - slope).abs() < 2e-2 * (1.0 + slope.abs()), "{index}: {got} {slope}");
        }
    }
}
