//! Axes: a range of values, its ticks at round numbers, and where a value lies between the ends.

/// How values are spaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Scale {
    #[default]
    Linear,
    /// By powers of ten; values of 0 and below cannot be shown.
    Log,
}

/// A range of values with its ticks.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    /// Values and labels.
    pub(super) ticks: Vec<(f64, String)>,
}

impl Axis {
    /// An axis over the values that its scale can show, `[0, 1]` if there are none. With `round`, it
    /// reaches out to the nearest ticks; otherwise it ends where the values do.
    pub(super) fn new(
        scale: Scale,
        values: impl Iterator<Item = f64>,
        most_ticks: usize,
        round: bool,
    ) -> Self {
        // Sizes that still have a finite range and a reciprocal.
        let shown = |v: &f64| match scale {
            Scale::Linear => v.abs() < 1e150,
            Scale::Log => (1e-150..1e150).contains(v),
        };
        let (mut low, mut high) = values
            .filter(shown)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            (low, high) = if scale == Scale::Log { (0.1, 1.0) } else { (0.0, 1.0) };
        }
        match scale {
            Scale::Linear => Self::linear(low, high, most_ticks, round),
            Scale::Log => Self::log(low, high, most_ticks, round),
        }
    }

    fn linear(mut low: f64, mut high: f64, most_ticks: usize, round: bool) -> Self {
        // A range too narrow for its own magnitude has no distinct ticks.
        if high - low <= 1e-9 * low.abs().max(high.abs()) {
            let reach = if low == 0.0 { 1.0 } else { 0.5 * low.abs() };
            (low, high) = (low - reach, high + reach);
        }
        let step = round_step((high - low) / most_ticks.max(1) as f64);
        if round {
            (low, high) = ((low / step).floor() * step, (high / step).ceil() * step);
        }
        let first = (low / step - 1e-9).ceil();
        let count = ((high / step + 1e-9).floor() - first).clamp(0.0, 100.0) as usize;
        let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        let tick = |i: usize| {
            let value = (first + i as f64) * step;
            (value, label(value, decimals))
        };
        Self { scale: Scale::Linear, low, high, ticks: (0..=count).map(tick).collect() }
    }

    fn log(mut low: f64, mut high: f64, most_ticks: usize, round: bool) -> Self {
        if high < 1.01 * low {
            (low, high) = (low / 2.0, high * 2.0);
        }
        let decades = high.log10() - low.log10();
        // Few decades have room for 2 and 5 between the powers of ten.
        let factors: &[f64] =
            if decades * 3.0 <= most_ticks as f64 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let every = (decades / most_ticks.max(1) as f64).ceil().max(1.0) as i32;
        let powers = low.log10().floor() as i32 - 1..=high.log10().ceil() as i32 + 1;
        let candidates = || {
            let kept = powers.clone().filter(|power| power.rem_euclid(every) == 0);
            kept.flat_map(|power| factors.iter().map(move |factor| factor * 10_f64.powi(power)))
        };
        if round {
            let below = candidates().rfind(|&v| v <= low * 1.0001);
            let above = candidates().find(|&v| v >= high * 0.9999);
            (low, high) = (below.unwrap_or(low), above.unwrap_or(high));
        }
        let inside = |v: &f64| (low * 0.9999..=high * 1.0001).contains(v);
        let ticks = candidates().filter(inside).map(|v| (v, log_label(v))).collect();
        Self { scale: Scale::Log, low, high, ticks }
    }

    /// An axis of categories: value `i` is category `i`, with half a step of room at both ends.
    pub(super) fn categories(names: &[String]) -> Self {
        let ticks = names.iter().enumerate().map(|(i, name)| (i as f64, name.clone())).collect();
        let high = names.len().max(1) as f64 - 0.5;
        Self { scale: Scale::Linear, low: -0.5, high, ticks }
    }

    /// Where a value lies: 0 at the low end, 1 at the high one; `None` if the axis cannot show it.
    pub(super) fn fraction(&self, value: f64) -> Option<f64> {
        let fraction = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        // Far outside is far enough: the pixels must stay finite too.
        fraction.is_finite().then_some(fraction.clamp(-1e3, 1e3))
    }

    /// The fraction of a value, held inside the axis; for the feet of bars and the ends of bands.
    pub(super) fn held(&self, value: f64) -> f64 {
        match self.fraction(value) {
            Some(fraction) => fraction.clamp(0.0, 1.0),
            None if value == f64::INFINITY => 1.0,
            None => 0.0,
        }
    }
}

/// The smallest of 1, 2, 2.5 and 5 times a power of ten that is at least `step`.
fn round_step(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let steps = [1.0, 2.0, 2.5, 5.0].map(|factor| factor * power);
    steps.into_iter().find(|&s| s >= step * 0.9999).unwrap_or(10.0 * power)
}

/// A tick's value with as many decimals as its axis needs, large round ones as `20k` or `3M`.
fn label(value: f64, decimals: usize) -> String {
    let value = if value.abs() < 1e-12 { 0.0 } else { value };
    let scaled = |unit: f64, sign: &str| format!("{}{sign}", trimmed(value / unit, 2));
    match value.abs() {
        size if size >= 1e15 => format!("{value:.1e}"),
        size if size >= 1e9 => scaled(1e9, "G"),
        size if size >= 1e6 => scaled(1e6, "M"),
        size if size >= 1e4 => scaled(1e3, "k"),
        size if size > 0.0 && decimals > 6 => format!("{value:.1e}"),
        _ => trimmed(value, decimals + 1),
    }
}

fn log_label(value: f64) -> String {
    match value {
        v if v < 1e-4 => format!("{v:.0e}"),
        v if v < 1.0 => trimmed(v, 6),
        v => label(v, 0),
    }
}

/// At most `decimals` decimals, without trailing zeros.
fn trimmed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round() {
        let linear = Scale::Linear;
        for (scale, values, most, round, expected) in [
            (linear, vec![0.0, 1.0], 5, true, "0 0.2 0.4 0.6 0.8 1"),
            (linear, vec![0.03, 0.97], 5, true, "0 0.2 0.4 0.6 0.8 1"),
            (linear, vec![0.03, 0.97], 5, false, "0.2 0.4 0.6 0.8"),
            (linear, vec![0.0, 3e6], 4, true, "0 1M 2M 3M"),
            (linear, vec![0.0, 45_000.0], 5, true, "0 10k 20k 30k 40k 50k"),
            (linear, vec![-1.0, 1.5], 5, true, "-1 -0.5 0 0.5 1 1.5"),
            (linear, vec![5.0], 4, true, "2 4 6 8"),
            (linear, vec![], 2, true, "0 0.5 1"),
            (linear, vec![f64::NAN, f64::INFINITY, 0.0, 10.0], 5, true, "0 2 4 6 8 10"),
            (Scale::Log, vec![1.0, 1000.0], 5, true, "1 10 100 1000"),
            (Scale::Log, vec![3.0, 70.0], 6, true, "2 5 10 20 50 100"),
            (Scale::Log, vec![1e-5, 1.0, 0.0, -4.0], 6, true, "1e-5 0.0001 0.001 0.01 0.1 1"),
            (Scale::Log, vec![1e4, 1e6], 5, true, "10k 100k 1M"),
            (Scale::Log, vec![7.0], 5, true, "2 5 10 20"),
        ] {
            let axis = Axis::new(scale, values.iter().copied(), most, round);
            let labels: Vec<&str> = axis.ticks.iter().map(|(_, label)| label.as_str()).collect();
            assert_eq!(labels.join(" "), expected, "{scale:?} {values:?}");
        }
    }

    #[test]
    fn fractions() {
        let linear = Axis::new(Scale::Linear, [0.0, 10.0].into_iter(), 5, true);
        assert_eq!(linear.fraction(2.5), Some(0.25));
        let log = Axis::new(Scale::Log, [1.0, 100.0].into_iter(), 5, true);
        assert!((log.fraction(10.0).unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(log.fraction(-1.0), None);
        assert_eq!(log.held(0.0), 0.0);
    }
}
