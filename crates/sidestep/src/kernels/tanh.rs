//! Hyperbolic tangent as a rational function, and its derivative from its value.
//!
//! ```text
//! tanh(x) ~ z P(z^2) / Q(z^2),   z = clamp(x, -8, 8),   P, Q of degree 4
//! d tanh / dx = 1 - y^2
//! ```
//!
//! The coefficients are our own minimax fit of the relative error on [0, 8] (iteratively reweighted linearised
//! least squares at Chebyshev nodes; 6.4e-9 before rounding). In f32 the absolute error
//! is at most [`MAX_ERROR`] for every x; 1 - tanh(8) = 2.3e-7 is where the clamp holds. All
//! coefficients are positive, so nothing cancels. A division instead of `exp`, and no branch,
//! keeps it the same code on every lane.

use super::madd;

/// Largest absolute error against tanh in f64, over all f32.
#[cfg(test)]
const MAX_ERROR: f64 = 5e-7;

/// Beyond this the value stays constant at 1 - 2.3e-7 or so.
const CLAMP: f32 = 8.0;

const P: [f32; 5] = [0.999_999_99, 0.134_445_03, 3.571_604_2e-3, 2.189_476_4e-5, 1.523_056_1e-8];
const Q: [f32; 5] = [1.0, 0.467_778_3, 2.616_446_7e-2, 3.411_302e-4, 8.522_505e-7];

/// tanh(x); NaN stays NaN.
#[inline(always)]
pub(crate) fn tanh<const ISA: u8>(x: f32) -> f32 {
    // Comparisons instead of `clamp`, which asserts its bounds; both map to min/max instructions.
    let z = if x > CLAMP { CLAMP } else { x };
    let z = if z < -CLAMP { -CLAMP } else { z };
    let t = z * z;
    let horner = |c: &[f32; 5]| {
        let high = madd::<ISA>(c[4], t, c[3]);
        madd::<ISA>(madd::<ISA>(madd::<ISA>(high, t, c[2]), t, c[1]), t, c[0])
    };
    z * horner(&P) / horner(&Q)
}

/// d tanh / dx where tanh(x) = y.
#[inline(always)]
pub(crate) fn tanh_slope<const ISA: u8>(y: f32) -> f32 {
    madd::<ISA>(-y, y, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::{Isa, dispatch};
    use proptest::prelude::*;

    dispatch! {
        fn tanh_all(values: &mut [f32]) = tanh_all_body;
    }

    #[inline(always)]
    fn tanh_all_body<const ISA: u8>(values: &mut [f32]) {
        for value in values {
            *value = tanh::<ISA>(*value);
        }
    }

    proptest! {
        #[test]
        fn tanh_matches_reference(values in prop::collection::vec(-20.0_f32..20.0, 1..40)) {
            for isa in Isa::available() {
                let mut got = values.clone();
                tanh_all(isa, &mut got);
                for (x, y) in values.iter().zip(got) {
                    let error = f64::from(y) - f64::from(*x).tanh();
                    prop_assert!(error.abs() <= MAX_ERROR, "tanh({x}) = {y}, error {error}");
                }
            }
        }
    }

    #[test]
    fn error_on_a_fine_sweep_and_at_the_ends() {
        for isa in Isa::available() {
            let xs: Vec<f32> = (-400_000..=400_000).map(|i| i as f32 * 2.5e-5).collect();
            let mut ys = xs.clone();
            tanh_all(isa, &mut ys);
            for (x, y) in xs.iter().zip(&ys) {
                let exact = f64::from(*x).tanh();
                assert!((f64::from(*y) - exact).abs() <= MAX_ERROR, "{x}");
                assert!((f64::from(*y) - exact).abs() <= 5e-7 * exact.abs(), "relative at {x}");
            }
            let mut ends = [f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 0.0, -0.0, f32::NAN];
            tanh_all(isa, &mut ends);
            assert!((1.0 - ends[0]).abs() < 5e-7 && ends[0] <= 1.0);
            assert_eq!(ends[1], -ends[0]);
            assert_eq!(ends[2], ends[0]);
            assert_eq!((ends[3], ends[4]), (0.0, 0.0));
            assert!(ends[5].is_nan());
        }
    }
}
