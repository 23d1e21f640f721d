//! Sine and cosine in f32 without branches, the same code on every lane.
//!
//! ```text
//! x = n π/2 + r, |r| <= π/4;   sin r ~ r + r^3 S(r^2),   cos r ~ 1 - r^2 / 2 + r^4 C(r^2)
//! ```
//!
//! π/2 is taken off in three parts, the first two so short (8 and 11 bits) that their products with n are exact
//! (W. Cody and W. Waite, Software Manual for the Elementary Functions, 1980). S and C, of degree 2,
//! are our own minimax fits (reweighted least squares; 8.9e-9 and 4.8e-10 before rounding).

use crate::kernels::madd;

/// Largest magnitude of an angle for which [`MAX_ERROR`] holds.
#[cfg(test)]
const MAX_ANGLE: f32 = 8192.0;

/// Largest absolute error of either, over all |x| up to `MAX_ANGLE`.
#[cfg(test)]
const MAX_ERROR: f64 = 1.2e-7;

const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];
const S: [f32; 3] = [-0.166_666_64, 8.332_759e-3, -1.958_916_7e-4];
const C: [f32; 3] = [4.166_664_6e-2, -1.388_736_4e-3, 2.443_809_2e-5];
/// Adding and subtracting 1.5 * 2^23 rounds to the nearest integer, whose last bits are then those of the sum.
const ROUND: f32 = 12_582_912.0;

/// `[sin x, cos x]`; of no use if x is not finite.
#[inline(always)]
pub(super) fn sin_cos<const ISA: u8>(x: f32) -> [f32; 2] {
    let shifted = madd::<ISA>(x, std::f32::consts::FRAC_2_PI, ROUND);
    let n = shifted - ROUND;
    let quadrant = shifted.to_bits();
    let r = madd::<ISA>(-n, QUARTER[0], x);
    let r = madd::<ISA>(-n, QUARTER[1], r);
    let r = madd::<ISA>(-n, QUARTER[2], r);
    let z = r * r;
    let s = madd::<ISA>(madd::<ISA>(S[2], z, S[1]), z, S[0]);
    let s = madd::<ISA>(r * z, s, r);
    let c = madd::<ISA>(madd::<ISA>(C[2], z, C[1]), z, C[0]);
    let c = madd::<ISA>(z * z, c, madd::<ISA>(z, -0.5, 1.0));
    // Quadrants 1 and 3 swap the two; 2 and 3 turn the sign of the sine, 1 and 2 that of the cosine.
    let swap = 0_u32.wrapping_sub(quadrant & 1);
    let (s, c) = (s.to_bits(), c.to_bits());
    let sin = ((s & !swap) | (c & swap)) ^ ((quadrant & 2) << 30);
    let cos = ((c & !swap) | (s & swap)) ^ ((quadrant.wrapping_add(1) & 2) << 30);
    [f32::from_bits(sin), f32::from_bits(cos)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::{Isa, dispatch};

    dispatch! {
        fn all(angles: &[f32], out: &mut [[f32; 2]]) = all_body;
    }

    #[inline(always)]
    fn all_body<const ISA: u8>(angles: &[f32], out: &mut [[f32; 2]]) {
        for (&angle, out) in angles.iter().zip(out) {
            *out = sin_cos::<ISA>(angle);
        }
    }

    #[test]
    fn error_on_fine_sweeps() {
        for (step, count) in [(1e-5, 400_000), (0.016, 500_000)] {
            let angles: Vec<f32> = (-count..=count)
                .map(|i| (f64::from(i) * step) as f32)
                .filter(|x| x.abs() <= MAX_ANGLE)
                .collect();
            for isa in Isa::available() {
                let mut out = vec![[0.0; 2]; angles.len()];
                all(isa, &angles, &mut out);
                for (&x, got) in angles.iter().zip(out) {
                    let (sin, cos) = f64::from(x).sin_cos();
                    let error =
                        (f64::from(got[0]) - sin).abs().max((f64::from(got[1]) - cos).abs());
                    assert!(error <= MAX_ERROR, "{x}: {got:?}, error {error}");
                }
            }
        }
    }
}
