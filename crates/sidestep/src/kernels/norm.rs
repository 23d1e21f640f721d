//! Sum of squares of a flat vector, for gradient-norm clipping.
//!
//! Lane `l` sums elements `l, l + 16, ..` in order, then the lanes fold as a balanced tree: the order, and so the
//! bits, do not depend on the instruction set. The error is about `n / 16` roundings at worst.

use super::{Isa, LANES, dispatch, lane_sum, madd};

/// Sum of squares of `values`.
pub fn squared_norm(values: &[f32]) -> f32 {
    squared_norm_on(Isa::detect(), values)
}

dispatch! {
    /// See [`squared_norm`].
    fn squared_norm_on(values: &[f32]) -> f32 = squared_norm_body;
}

#[inline(always)]
fn squared_norm_body<const ISA: u8>(values: &[f32]) -> f32 {
    // Two sets of lanes would hide more latency; a step of training spends 1 % here.
    let mut lanes = [0.0; LANES];
    let (groups, rest) = values.as_chunks::<LANES>();
    for group in groups {
        for (lane, &value) in lanes.iter_mut().zip(group) {
            *lane = madd::<ISA>(value, value, *lane);
        }
    }
    for (lane, &value) in lanes.iter_mut().zip(rest) {
        *lane = madd::<ISA>(value, value, *lane);
    }
    lane_sum(lanes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn squared_norm_matches_reference(values in prop::collection::vec(-3.0_f32..3.0, 0..300)) {
            let exact: f64 = values.iter().map(|&x| f64::from(x).powi(2)).sum();
            let sums: Vec<f32> = Isa::available().map(|isa| squared_norm_on(isa, &values)).collect();
            for sum in &sums {
                prop_assert!((f64::from(*sum) - exact).abs() <= 3e-6 * exact + 1e-12);
            }
            prop_assert!(sums.iter().skip(1).all(|sum| sum.to_bits() == sums[sums.len() - 1].to_bits()));
        }
    }
}
