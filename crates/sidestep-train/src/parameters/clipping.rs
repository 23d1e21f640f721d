//! Limits on the norm of a whole gradient.
//!
//! The square of a norm may overflow where the gradient itself is finite. Such a gradient is
//! clipped to nothing, so that its update moves no parameter; what the curve says of its norm is
//! summed in f64.

use sidestep::kernels::squared_norm;

/// The norm of a gradient, infinite where its square overflows.
pub fn norm(gradient: &[f32]) -> f32 {
    squared_norm(gradient).sqrt()
}

/// The norm in f64 as the curve shows it, given the sum of squares in f32.
pub fn told_norm(squared: f32, gradient: &[f32]) -> f64 {
    if squared.is_finite() {
        return f64::from(squared).sqrt();
    }
    gradient.iter().map(|&g| f64::from(g) * f64::from(g)).sum::<f64>().sqrt()
}

/// Factor that brings a gradient of this norm within the limit.
pub fn clip_factor(norm: f32, limit: f32) -> f32 {
    (limit / (norm + 1e-6)).min(1.0)
}

/// A number of the curve, at most the largest that there is: JSON knows no infinity. What is no
/// number stays none.
pub fn finite(value: f64) -> f64 {
    value.clamp(f64::MIN, f64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_beyond_f32_moves_nothing_and_is_told() {
        for (gradient, factor, told) in
            [([3.0, 4.0], 0.1, 5.0), ([3e25, 4e25], 0.0, 5e25), ([0.0, 0.0], 1.0, 0.0)]
        {
            let found = clip_factor(norm(&gradient), 0.5);
            assert!((found - factor).abs() < 1e-6, "{gradient:?}: {found}");
            let found = told_norm(squared_norm(&gradient), &gradient);
            assert!((found - told).abs() <= 1e-6 * told, "{gradient:?}: {found}");
        }
        assert_eq!([finite(f64::INFINITY), finite(-1.5)], [f64::MAX, -1.5]);
        assert!(finite(f64::NAN).is_nan());
    }
}
