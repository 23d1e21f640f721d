//! Means, quantiles and confidence intervals.

/// The mean; none of nothing.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The quantile `q` in [0, 1] by linear interpolation; none of nothing. Sorts `values`.
pub fn quantile(values: &mut [f64], q: f64) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)? as f64;
    let (below, above) = ((q * last).floor() as usize, (q * last).ceil() as usize);
    Some(values[below] + (q * last).fract() * (values[above] - values[below]))
}

/// Sample standard deviation; 0 for fewer than two values.
pub fn deviation(values: &[f64]) -> f64 {
    let Some(mean) = mean(values).filter(|_| values.len() > 1) else { return 0.0 };
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (squares / (values.len() - 1) as f64).sqrt()
}

/// Student's t for a two-sided 95 % interval, by degrees of freedom from 1.
const STUDENT: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];

/// 95 % interval of the mean of several groups' shares, clipped to [0, 1].
pub fn student_interval(shares: &[f64]) -> Option<[f64; 2]> {
    let degrees = shares.len().checked_sub(1).filter(|&d| d > 0)?;
    let center = mean(shares)?;
    let t = STUDENT.get(degrees - 1).copied().unwrap_or(1.96);
    let half = t * deviation(shares) / (shares.len() as f64).sqrt();
    Some([(center - half).max(0.0), (center + half).min(1.0)])
}

/// Wilson's 95 % interval of a share.
pub fn wilson_interval(successes: usize, tasks: usize) -> [f64; 2] {
    let (n, z) = (tasks as f64, 1.96f64);
    let p = successes as f64 / n;
    let center = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    [(center - half).max(0.0), (center + half).min(1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        assert_eq!(quantile(&mut [4.0, 1.0, 3.0, 2.0], 0.5), Some(2.5));
        assert_eq!(quantile(&mut [], 0.5), None);
        assert_eq!(mean(&[1.0, 2.0, 6.0]), Some(3.0));
        assert!((deviation(&[1.0, 2.0, 3.0]) - 1.0).abs() < 1e-12);
        // R: prop.test(80, 100, correct = FALSE)
        let [low, high] = wilson_interval(80, 100);
        assert!((low - 0.7112).abs() < 1e-3 && (high - 0.8666).abs() < 1e-3, "{low} {high}");
        // R: t.test(c(0.8, 0.82, 0.78))
        let [low, high] = student_interval(&[0.8, 0.82, 0.78]).unwrap();
        assert!((low - 0.7503).abs() < 1e-3 && (high - 0.8497).abs() < 1e-3, "{low} {high}");
    }
}
