//! The policy's distribution: a diagonal Gaussian around the network's output, with one free
//! log-std per action coordinate that does not depend on the observation (as in Stable-Baselines3
//! and in detail 8 of Huang et al. 2022).
//!
//! ```text
//! log pi(a)  = sum_j -z_j^2 / 2 - s_j - ln(2 pi) / 2,    z_j = (a_j - m_j) exp(-s_j)
//! d / dm_j   = z_j exp(-s_j)              d / ds_j = z_j^2 - 1
//! entropy    = sum_j s_j + (1 + ln(2 pi)) / 2
//! ```

use rand_chacha::ChaCha8Rng;
pub use sidestep::rng::standard_normal;

/// ln(2 pi) / 2.
const HALF_LN_TWO_PI: f32 = 0.918_938_5;

/// Draws `action = mean + exp(log_std) * noise`, all `[actions]`.
pub fn sample(mean: &[f32], log_std: &[f32], rng: &mut ChaCha8Rng, action: &mut [f32]) {
    for (index, pair) in action.chunks_mut(2).enumerate() {
        for (offset, noise) in standard_normal(rng).into_iter().enumerate().take(pair.len()) {
            let at = 2 * index + offset;
            pair[offset] = mean[at] + log_std[at].exp() * noise;
        }
    }
}

/// The densities of one log-std, with what does not depend on the mean computed once.
#[derive(Debug, Clone)]
pub struct Density {
    /// exp(-s), `[actions]`.
    inverse_std: Vec<f32>,
    /// Sum of -s - ln(2 pi) / 2.
    peak: f32,
}

impl Density {
    /// The densities of `log_std [actions]`.
    pub fn new(log_std: &[f32]) -> Self {
        Self {
            inverse_std: log_std.iter().map(|s| (-s).exp()).collect(),
            peak: log_std.iter().map(|s| -s - HALF_LN_TWO_PI).sum(),
        }
    }

    /// ln pi(action), both slices `[actions]`.
    pub fn log_prob(&self, action: &[f32], mean: &[f32]) -> f32 {
        let square = |((a, m), inverse): ((&f32, &f32), &f32)| ((a - m) * inverse).powi(2);
        let squares: f32 = action.iter().zip(mean).zip(&self.inverse_std).map(square).sum();
        self.peak - 0.5 * squares
    }

    /// Writes `factor * d log_prob / d mean` to `mean_gradient` and adds `factor * d log_prob / d
    /// log_std` to `log_std_gradient`, all `[actions]`.
    pub fn log_prob_gradient(
        &self,
        action: &[f32],
        mean: &[f32],
        factor: f32,
        mean_gradient: &mut [f32],
        log_std_gradient: &mut [f32],
    ) {
        let moments = action.iter().zip(mean).zip(&self.inverse_std);
        let gradients = mean_gradient.iter_mut().zip(log_std_gradient);
        for (((a, m), inverse), (by_mean, by_std)) in moments.zip(gradients) {
            let z = (a - m) * inverse;
            *by_mean = factor * z * inverse;
            *by_std += factor * (z * z - 1.0);
        }
    }
}

/// The differential entropy; its gradient with respect to each log-std is 1.
pub fn entropy(log_std: &[f32]) -> f32 {
    log_std.iter().map(|s| s + 0.5 + HALF_LN_TWO_PI).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use sidestep::rng::{Purpose, stream};

    #[test]
    fn moments_of_the_samples() {
        let mut rng = stream(1, Purpose::Environment, 0, 0);
        let (mean, log_std) = ([1.0, -2.0, 0.5], [0.0, -1.0, 0.7]);
        let count = 40_000;
        let mut sums = [[0.0_f64; 2]; 3];
        for _ in 0..count {
            let mut action = [0.0; 3];
            sample(&mean, &log_std, &mut rng, &mut action);
            for j in 0..3 {
                let z = f64::from((action[j] - mean[j]) / log_std[j].exp());
                sums[j][0] += z;
                sums[j][1] += z * z;
            }
        }
        for [first, second] in sums {
            // Five standard errors.
            assert!((first / f64::from(count)).abs() < 0.025);
            assert!((second / f64::from(count) - 1.0).abs() < 0.036);
        }
    }

    proptest! {
        #[test]
        fn gradient_matches_finite_differences(
            rows in prop::collection::vec([-2.0_f32..2.0, -2.0_f32..2.0, -1.0_f32..1.0], 1..6),
        ) {
            let [a, m, s] = [0, 1, 2].map(|c| rows.iter().map(|row| row[c]).collect::<Vec<f32>>());
            let (mut dm, mut ds) = (vec![0.0; rows.len()], vec![0.0; rows.len()]);
            Density::new(&s).log_prob_gradient(&a, &m, 1.0, &mut dm, &mut ds);
            let h = 1e-2;
            for j in 0..rows.len() {
                let slope = |values: &[f32], f: &dyn Fn(&[f32]) -> f32| {
                    let mut moved = values.to_vec();
                    moved[j] = values[j] + h;
                    let above = f(&moved);
                    moved[j] = values[j] - h;
                    (above - f(&moved)) / (2.0 * h)
                };
                let by_mean = slope(&m, &|m| Density::new(&s).log_prob(&a, m));
                let by_std = slope(&s, &|s| Density::new(s).log_prob(&a, &m));
                let size = 1.0 + dm[j].abs() + ds[j].abs();
                prop_assert!((dm[j] - by_mean).abs() < 2e-3 * size, "{} {by_mean}", dm[j]);
                prop_assert!((ds[j] - by_std).abs() < 2e-3 * size, "{} {by_std}", ds[j]);
            }
        }
    }
}
