//! Dense layers: one blocked product serves the forward pass and both halves of the backward pass.
//!
//! ```text
//! forward           Y = act(X W^T + b)          sum over inputs
//! input gradient    dX = (dY W) * act'(X)       sum over outputs
//! weight gradient   dW += dY^T X, db += sum dY  sum over rows
//! ```
//!
//! Stored weights are `W[outputs][inputs]`, row-major, as PyTorch stores them. Activations are rows padded
//! with zeros to whole panels of [`LANES`] numbers, so that only the weight gradient has a ragged edge.
//! Weights are repacked once per change into panels `[panels][depth][LANES]` ([`pack_forward`],
//! [`pack_backward`]), so that the inner loop reads them in order, and small layers stay in L1.
//!
//! The order of the sums is [`product`]'s.

#![allow(clippy::too_many_arguments, reason = "kernels take flat slices and sizes")]

use super::product::{Left, Right, product};
use super::tanh::{tanh, tanh_slope};
use super::{LANES, dispatch};

/// What follows the product.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Activation {
    /// Nothing.
    Linear,
    /// The hyperbolic tangent.
    Tanh,
    /// The positive part.
    Relu,
}

/// `count` rounded up to whole panels.
pub(crate) const fn padded(count: usize) -> usize {
    count.next_multiple_of(LANES)
}

/// Packs `weights [outputs x inputs]` for the forward pass: `[padded(outputs) / LANES][inputs][LANES]`,
/// lanes over outputs, zero beyond them.
pub(crate) fn pack_forward(weights: &[f32], inputs: usize, outputs: usize, packed: &mut [f32]) {
    let panels = packed.chunks_exact_mut(inputs * LANES).zip((0..outputs).step_by(LANES));
    for (panel, first) in panels {
        let lanes = LANES.min(outputs - first);
        for lane in 0..lanes {
            let row = &weights[(first + lane) * inputs..][..inputs];
            for (group, &weight) in panel.as_chunks_mut::<LANES>().0.iter_mut().zip(row) {
                group[lane] = weight;
            }
        }
    }
}

/// Packs `weights [outputs x inputs]` for the input gradient: `[padded(inputs) / LANES][outputs][LANES]`,
/// lanes over inputs, zero beyond them.
pub(crate) fn pack_backward(weights: &[f32], inputs: usize, outputs: usize, packed: &mut [f32]) {
    let panels = packed.chunks_exact_mut(outputs * LANES).zip((0..inputs).step_by(LANES));
    for (panel, first) in panels {
        for (group, row) in
            panel.as_chunks_mut::<LANES>().0.iter_mut().zip(weights.chunks_exact(inputs))
        {
            match row[first..].first_chunk::<LANES>() {
                Some(whole) => *group = *whole,
                None => group[..inputs - first].copy_from_slice(&row[first..]),
            }
        }
    }
}

dispatch! {
    /// `y = act(x W^T + b)` for each of `rows` rows.
    ///
    /// `x [rows x x_stride]` with `inputs <= x_stride`, `packed` from [`pack_forward`], `bias` and each row
    /// of `y` padded to whole panels; padding of `y` becomes `act(0) = 0`.
    pub(crate) fn forward(
        activation: Activation,
        rows: usize,
        inputs: usize,
        x: &[f32],
        x_stride: usize,
        packed: &[f32],
        bias: &[f32],
        y: &mut [f32],
    ) = forward_body;
}

#[inline(always)]
fn forward_body<const ISA: u8>(
    activation: Activation,
    rows: usize,
    inputs: usize,
    x: &[f32],
    x_stride: usize,
    packed: &[f32],
    bias: &[f32],
    y: &mut [f32],
) {
    let columns = bias.len();
    let a = Left { values: x, row: x_stride, depth: 1 };
    let b = Right { values: packed, panel: inputs * LANES, depth: LANES };
    product::<ISA, false>(rows, columns, inputs, a, b, Some(bias), y, columns);
    let y = &mut y[..rows * columns];
    match activation {
        Activation::Linear => {}
        Activation::Tanh => y.iter_mut().for_each(|value| *value = tanh::<ISA>(*value)),
        Activation::Relu => {
            y.iter_mut().for_each(|value| *value = if *value > 0.0 { *value } else { 0.0 });
        }
    }
}

dispatch! {
    /// `dx = (dy W) * act'(x)` for each row, where `x` is this layer's input, the output of `activation`.
    ///
    /// `dy [rows x dy_stride]` with `outputs <= dy_stride`, `packed` from [`pack_backward`]; rows of `x` and `dx` padded.
    pub(crate) fn input_gradient(
        activation: Activation,
        rows: usize,
        outputs: usize,
        dy: &[f32],
        dy_stride: usize,
        packed: &[f32],
        x: &[f32],
        dx: &mut [f32],
    ) = input_gradient_body;
}

#[inline(always)]
fn input_gradient_body<const ISA: u8>(
    activation: Activation,
    rows: usize,
    outputs: usize,
    dy: &[f32],
    dy_stride: usize,
    packed: &[f32],
    x: &[f32],
    dx: &mut [f32],
) {
    let columns = packed.len() / outputs.max(1);
    let a = Left { values: dy, row: dy_stride, depth: 1 };
    let b = Right { values: packed, panel: outputs * LANES, depth: LANES };
    product::<ISA, false>(rows, columns, outputs, a, b, None, dx, columns);
    let pairs = dx[..rows * columns].iter_mut().zip(x);
    match activation {
        Activation::Linear => {}
        Activation::Tanh => pairs.for_each(|(slope, &x)| *slope *= tanh_slope::<ISA>(x)),
        Activation::Relu => {
            pairs.for_each(|(slope, &x)| *slope = if x > 0.0 { *slope } else { 0.0 });
        }
    }
}

dispatch! {
    /// `dw [outputs x inputs] += dy^T x` and `db [outputs] += sum of rows of dy`.
    ///
    /// Rows of `x` are padded to `padded(inputs)`; `dy [rows x dy_stride]`.
    pub(crate) fn weight_gradient(
        rows: usize,
        inputs: usize,
        x: &[f32],
        dy: &[f32],
        dy_stride: usize,
        dw: &mut [f32],
        db: &mut [f32],
    ) = weight_gradient_body;
}

#[inline(always)]
fn weight_gradient_body<const ISA: u8>(
    rows: usize,
    inputs: usize,
    x: &[f32],
    dy: &[f32],
    dy_stride: usize,
    dw: &mut [f32],
    db: &mut [f32],
) {
    let outputs = db.len();
    let a = Left { values: dy, row: 1, depth: dy_stride };
    let b = Right { values: x, panel: LANES, depth: padded(inputs) };
    product::<ISA, true>(outputs, inputs, rows, a, b, None, dw, inputs);
    for row in dy.chunks_exact(dy_stride).take(rows) {
        for (sum, value) in db.iter_mut().zip(row) {
            *sum += value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::Isa;
    use proptest::prelude::*;

    /// Rows padded to whole panels.
    fn pad(values: &[f32], size: usize) -> Vec<f32> {
        let rows = values.chunks(size);
        rows.flat_map(|row| {
            row.iter().copied().chain(std::iter::repeat_n(0.0, padded(size) - size))
        })
        .collect()
    }

    /// `sum over k of a(k) b(k)` in f64 with the bound that f32 chains of that many terms keep.
    fn close(got: f32, start: f32, terms: impl Iterator<Item = (f32, f32)>) -> bool {
        let (mut sum, mut size, mut count) = (f64::from(start), f64::from(start).abs(), 1.0);
        for (a, b) in terms {
            let term = f64::from(a) * f64::from(b);
            sum += term;
            size += term.abs();
            count += 1.0;
        }
        (f64::from(got) - sum).abs() <= f64::from(f32::EPSILON) * count * size + 1e-12
    }

    fn numbers(max: usize) -> impl Strategy<Value = Vec<f32>> {
        prop::collection::vec(-2.0_f32..2.0, max)
    }

    fn bits(values: &[f32]) -> Vec<u32> {
        values.iter().map(|x| x.to_bits()).collect()
    }

    proptest! {
        #[test]
        fn products_match_reference(
            rows in 1_usize..11,
            inputs in 1_usize..40,
            outputs in 1_usize..70,
            pool in numbers(10 * 40 + 70 * 40 + 70 + 10 * 70 + 70 * 40),
        ) {
            let (x, rest) = pool.split_at(rows * inputs);
            let (w, rest) = rest.split_at(outputs * inputs);
            let (b, rest) = rest.split_at(outputs);
            let dy = &rest[..rows * outputs];
            let (po, pi) = (padded(outputs), padded(inputs));
            let (mut front, mut back) = (vec![0.0; po * inputs], vec![0.0; pi * outputs]);
            pack_forward(w, inputs, outputs, &mut front);
            pack_backward(w, inputs, outputs, &mut back);
            let (xs, dys, bias) = (pad(x, inputs), pad(dy, outputs), pad(b, outputs));
            let mut seen = Vec::new();
            for isa in Isa::available() {
                let (mut y, mut dx) = (vec![9.0; rows * po], vec![9.0; rows * pi]);
                let (mut dw, mut db) = (w.to_vec(), b.to_vec());
                let linear = Activation::Linear;
                forward(isa, linear, rows, inputs, &xs, pi, &front, &bias, &mut y);
                input_gradient(isa, linear, rows, outputs, &dys, po, &back, &xs, &mut dx);
                weight_gradient(isa, rows, inputs, &xs, &dys, po, &mut dw, &mut db);
                for r in 0..rows {
                    for o in 0..po {
                        let terms = (0..inputs).filter(|_| o < outputs).map(|i| (w[o * inputs + i], x[r * inputs + i]));
                        prop_assert!(close(y[r * po + o], bias[o], terms), "y[{r}][{o}]");
                    }
                    for i in 0..pi {
                        let terms = (0..outputs).filter(|_| i < inputs).map(|o| (w[o * inputs + i], dy[r * outputs + o]));
                        prop_assert!(close(dx[r * pi + i], 0.0, terms), "dx[{r}][{i}]");
                    }
                }
                for o in 0..outputs {
                    let column = (0..rows).map(|r| dy[r * outputs + o]);
                    prop_assert!(close(db[o], b[o], column.clone().map(|d| (d, 1.0))), "db[{o}]");
                    for i in 0..inputs {
                        let terms = column.clone().zip((0..rows).map(|r| x[r * inputs + i]));
                        prop_assert!(close(dw[o * inputs + i], w[o * inputs + i], terms), "dw[{o}][{i}]");
                    }
                }
                let (mut curved, mut slope) = (y.clone(), dx.clone());
                forward(isa, Activation::Tanh, rows, inputs, &xs, pi, &front, &bias, &mut curved);
                input_gradient(isa, Activation::Tanh, rows, outputs, &dys, po, &back, &xs, &mut slope);
                for (curved, flat) in curved.iter().zip(&y) {
                    prop_assert!((f64::from(*curved) - f64::from(*flat).tanh()).abs() <= 1e-6);
                }
                for ((slope, flat), x) in slope.iter().zip(&dx).zip(&xs) {
                    prop_assert!((slope - flat * (1.0 - x * x)).abs() <= 1e-5 * (1.0 + flat.abs()));
                }
                seen.push([y, dx, dw, db, curved, slope].map(|values| bits(&values)));
            }
            for pair in seen.windows(2).skip(1) {
                prop_assert_eq!(&pair[0], &pair[1], "AVX2 and AVX-512 differ");
            }
        }
    }
}
