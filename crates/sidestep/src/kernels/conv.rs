//! A residual 3 x 3 convolution with ReLU over a square of cells, read where they lie: no patches are copied.
//!
//! ```text
//! y_c = max(0, b + x_c + sum over the nine taps t and channels i of W[t][i] x_{c + t}[i])
//! ```
//!
//! Cells are rows of `channels` numbers inside a border of zeros as wide as the dilation at least. Every output number is one
//! chain of multiply-adds in the order of taps and channels, whatever the instruction set.
#![allow(clippy::too_many_arguments, reason = "kernels take flat slices and sizes")]

use super::{AVX512, LANES, dispatch, madd};

/// Taps of a convolution.
pub(crate) const TAPS: usize = 9;

dispatch! {
    /// `y [cells^2 x channels]` from `x [(cells + 2 border)^2 x channels]`, `channels` a multiple of [`LANES`], with
    /// `packed` from [`super::dense::pack_forward`] for weights `[channels x TAPS channels]`, and `dilation <= border`.
    pub(crate) fn conv3x3(
        cells: usize,
        channels: usize,
        border: usize,
        dilation: usize,
        x: &[f32],
        packed: &[f32],
        bias: &[f32],
        y: &mut [f32],
    ) = conv3x3_body;
}

#[inline(always)]
fn conv3x3_body<const ISA: u8>(
    cells: usize,
    channels: usize,
    border: usize,
    dilation: usize,
    x: &[f32],
    packed: &[f32],
    bias: &[f32],
    y: &mut [f32],
) {
    assert!(dilation <= border && channels.is_multiple_of(LANES));
    let side = cells + 2 * border;
    assert!(x.len() >= side * side * channels && y.len() >= cells * cells * channels);
    assert!(packed.len() >= TAPS * channels * channels && bias.len() >= channels);
    for panel in 0..channels / LANES {
        let weights = &packed[panel * TAPS * channels * LANES..][..TAPS * channels * LANES];
        let bias = &bias[panel * LANES..][..LANES];
        let form = Form { channels, side, border, dilation, panel };
        for line in 0..cells {
            let mut put = |column: usize, values: &[f32; LANES]| {
                let at = (line * cells + column) * channels + panel * LANES;
                y[at..at + LANES].copy_from_slice(values);
            };
            let mut column = 0;
            // A line of twelve cells fills twelve of AVX-512's registers, four cells fill eight of AVX2's.
            while ISA == AVX512 && column + 12 <= cells {
                block::<ISA, 12>(form, line, column, x, weights, bias, &mut put);
                column += 12;
            }
            while column + 4 <= cells {
                block::<ISA, 4>(form, line, column, x, weights, bias, &mut put);
                column += 4;
            }
            while column < cells {
                block::<ISA, 1>(form, line, column, x, weights, bias, &mut put);
                column += 1;
            }
        }
    }
}

#[derive(Clone, Copy)]
struct Form {
    channels: usize,
    side: usize,
    border: usize,
    dilation: usize,
    panel: usize,
}

/// One panel of outputs of `COUNT` neighbouring cells of a line.
#[inline(always)]
fn block<const ISA: u8, const COUNT: usize>(
    form: Form,
    line: usize,
    column: usize,
    x: &[f32],
    weights: &[f32],
    bias: &[f32],
    put: &mut impl FnMut(usize, &[f32; LANES]),
) {
    let Form { channels, side, border, dilation, panel } = form;
    let mut sums = [[0.0_f32; LANES]; COUNT];
    let own = ((line + border) * side + column + border) * channels + panel * LANES;
    for (cell, sum) in sums.iter_mut().enumerate() {
        let x = &x[own + cell * channels..][..LANES];
        for lane in 0..LANES {
            sum[lane] = bias[lane] + x[lane];
        }
    }
    for tap in 0..TAPS {
        let row = line + border + tap / 3 * dilation - dilation;
        let first = column + border + tap % 3 * dilation - dilation;
        let seen = &x[(row * side + first) * channels..][..COUNT * channels];
        let weights = &weights[tap * channels * LANES..][..channels * LANES];
        for (i, weights) in weights.as_chunks::<LANES>().0.iter().enumerate() {
            for (cell, sum) in sums.iter_mut().enumerate() {
                // SAFETY: `i < channels` and `cell < COUNT`, and `seen` has `COUNT * channels` numbers.
                let value = unsafe { *seen.get_unchecked(cell * channels + i) };
                for lane in 0..LANES {
                    sum[lane] = madd::<ISA>(value, weights[lane], sum[lane]);
                }
            }
        }
    }
    for (cell, sum) in sums.iter_mut().enumerate() {
        sum.iter_mut().for_each(|value| *value = if *value > 0.0 { *value } else { 0.0 });
        put(column + cell, sum);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Isa;
    use super::super::dense::pack_forward;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn convolution_matches_reference(
            cells in 4_usize..15,
            panels in 1_usize..3,
            dilation in 1_usize..4,
            more in 0_usize..2,
            pool in prop::collection::vec(-1.0_f32..1.0, 4096),
        ) {
            let (channels, border) = (panels * LANES, dilation + more);
            let side = cells + 2 * border;
            let is_inside = |i: usize| (border..border + cells).contains(&i);
            let x: Vec<f32> = (0..side * side * channels)
                .map(|i| {
                    let cell = i / channels;
                    let inside = is_inside(cell % side) && is_inside(cell / side);
                    if inside { pool[i % 4001] } else { 0.0 }
                })
                .collect();
            let inputs = TAPS * channels;
            let weights: Vec<f32> = (0..inputs * channels).map(|i| pool[i % 3989]).collect();
            let bias = &pool[..channels];
            let mut packed = vec![0.0; inputs * channels];
            pack_forward(&weights, inputs, channels, &mut packed);
            let mut seen = Vec::new();
            for isa in Isa::available() {
                let mut y = vec![9.0; cells * cells * channels];
                conv3x3(isa, cells, channels, border, dilation, &x, &packed, bias, &mut y);
                for (at, &got) in y.iter().enumerate() {
                    let (cell, o) = (at / channels, at % channels);
                    let own = (cell / cells + border) * side + cell % cells + border;
                    let mut sum = f64::from(bias[o]) + f64::from(x[own * channels + o]);
                    for tap in 0..TAPS {
                        let row = cell / cells + border + tap / 3 * dilation - dilation;
                        let column = cell % cells + border + tap % 3 * dilation - dilation;
                        for i in 0..channels {
                            let w = weights[o * inputs + tap * channels + i];
                            sum += f64::from(w) * f64::from(x[(row * side + column) * channels + i]);
                        }
                    }
                    prop_assert!((f64::from(got) - sum.max(0.0)).abs() <= 1e-4, "{at}: {got} {sum}");
                }
                seen.push(y.iter().map(|v| v.to_bits()).collect::<Vec<_>>());
            }
            for pair in seen.windows(2).skip(1) {
                prop_assert_eq!(&pair[0], &pair[1], "AVX2 and AVX-512 differ");
            }
        }
    }
}
