//! Adam over a flat parameter vector, in one pass.
//!
//! Kingma and Ba 2015 (arXiv:1412.6980), Algorithm 1, with PyTorch's placement of epsilon:
//!
//! ```text
//! m <- b1 m + (1 - b1) g          v <- b2 v + (1 - b2) g^2
//! p <- p - lr / (1 - b1^t) * m / (sqrt(v) / sqrt(1 - b2^t) + epsilon)
//! ```
//!
//! All arithmetic is elementwise, so every instruction set with fused multiply-add gives the same bits.

use super::{Isa, dispatch, madd};

/// What one step needs besides the vectors; the bias corrections are computed once per step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdamStep {
    /// Factor on the gradient (gradient-norm clipping); 1 for none.
    pub gradient_scale: f32,
    /// `[b1, 1 - b1]`, the decay of the mean; the complement is taken in f64.
    pub beta1: [f32; 2],
    /// `[b2, 1 - b2]`, the decay of the mean square.
    pub beta2: [f32; 2],
    /// `lr / (1 - b1^t)`.
    pub step_size: f32,
    /// `1 / sqrt(1 - b2^t)`.
    pub root_correction: f32,
    /// `epsilon`, added to the corrected root.
    pub epsilon: f32,
}

impl AdamStep {
    /// The step number `t >= 1`, corrections in f64.
    pub fn new(
        t: u64,
        learning_rate: f64,
        [beta1, beta2]: [f64; 2],
        epsilon: f64,
        gradient_scale: f32,
    ) -> Self {
        let t = t as f64;
        Self {
            gradient_scale,
            beta1: [beta1 as f32, (1.0 - beta1) as f32],
            beta2: [beta2 as f32, (1.0 - beta2) as f32],
            step_size: (learning_rate / (1.0 - beta1.powf(t))) as f32,
            root_correction: (1.0 / (1.0 - beta2.powf(t)).sqrt()) as f32,
            epsilon: epsilon as f32,
        }
    }

    /// Steps `parameters` and the moments; all four slices have the same length, and elements
    /// beyond the shortest stay as they are.
    pub fn apply(
        self,
        parameters: &mut [f32],
        gradient: &[f32],
        mean: &mut [f32],
        mean_square: &mut [f32],
    ) {
        adam(Isa::detect(), self, parameters, gradient, mean, mean_square);
    }
}

dispatch! {
    /// See [`AdamStep::apply`].
    pub(crate) fn adam(
        step: AdamStep,
        parameters: &mut [f32],
        gradient: &[f32],
        mean: &mut [f32],
        mean_square: &mut [f32],
    ) = adam_body;
}

#[inline(always)]
fn adam_body<const ISA: u8>(
    step: AdamStep,
    parameters: &mut [f32],
    gradient: &[f32],
    mean: &mut [f32],
    mean_square: &mut [f32],
) {
    let AdamStep { gradient_scale, beta1, beta2, step_size, root_correction, epsilon } = step;
    // The betas decay; the rests are their complements.
    let ([beta1, rest1], [beta2, rest2]) = (beta1, beta2);
    let moments = mean.iter_mut().zip(mean_square);
    for ((p, g), (m, v)) in parameters.iter_mut().zip(gradient).zip(moments) {
        let g = g * gradient_scale;
        *m = madd::<ISA>(beta1, *m, rest1 * g);
        *v = madd::<ISA>(beta2, *v, rest2 * g * g);
        *p -= step_size * *m / madd::<ISA>(v.sqrt(), root_correction, epsilon);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The formula at the head of this file in f64.
    fn reference(t: u64, [p, g, m, v]: [f64; 4]) -> [f64; 3] {
        let (lr, b1, b2, epsilon) = (3e-4, 0.9, 0.999, 1e-5);
        let m = b1 * m + (1.0 - b1) * g;
        let v = b2 * v + (1.0 - b2) * g * g;
        let corrected = m / (1.0 - b1.powf(t as f64));
        let root = (v / (1.0 - b2.powf(t as f64))).sqrt();
        [p - lr * corrected / (root + epsilon), m, v]
    }

    proptest! {
        #[test]
        fn adam_matches_reference(
            t in 1_u64..5000,
            rows in prop::collection::vec([-2.0_f32..2.0, -2.0_f32..2.0, -1.0_f32..1.0, 0.0_f32..1.0], 1..70),
        ) {
            let column = |index: usize| rows.iter().map(|row| row[index]).collect::<Vec<f32>>();
            let step = AdamStep::new(t, 3e-4, [0.9, 0.999], 1e-5, 1.0);
            let mut bits = Vec::new();
            for isa in Isa::available() {
                let (mut p, g, mut m, mut v) = (column(0), column(1), column(2), column(3));
                adam(isa, step, &mut p, &g, &mut m, &mut v);
                for (index, row) in rows.iter().enumerate() {
                    let expected = reference(t, row.map(f64::from));
                    for (got, want) in [p[index], m[index], v[index]].into_iter().zip(expected) {
                        prop_assert!((f64::from(got) - want).abs() <= 2e-6 * (1.0 + want.abs()));
                    }
                }
                bits.push(p.iter().chain(&m).chain(&v).map(|x| x.to_bits()).collect::<Vec<_>>());
            }
            for pair in bits.windows(2).skip(1) {
                prop_assert_eq!(&pair[0], &pair[1], "AVX2 and AVX-512 differ");
            }
        }
    }
}
