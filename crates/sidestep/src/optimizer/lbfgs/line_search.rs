//! Line search of Moré & Thuente (1994, ACM TOMS 20(3), 286-307, doi:10.1145/192115.192132).
//!
//! A step α along a direction is taken where φ(α) = U(x + α d) satisfies the strong Wolfe conditions
//! φ(α) ≤ φ(0) + μ α φ'(0) and |φ'(α)| ≤ η |φ'(0)|. Until then cubics and secants through the points
//! seen narrow an interval that holds such an α. In the first stage they are those of
//! ψ(α) = φ(α) - μ α φ'(0); where the interval is taken back to φ, its ends keep the values of φ that
//! they had before (the publication takes the new ends' values), as the argmin crate does, so that
//! the iterates are that crate's to the bit.

/// μ of the sufficient decrease.
const DECREASE: f64 = 1e-4;
/// η of the curvature.
const CURVATURE: f64 = 0.9;
/// How far beyond the last step the next may lie while there is no interval.
const EXTRAPOLATION: f64 = 4.0;
/// Least share of its upper end that the interval is narrowed to.
const LEAST_WIDTH: f64 = 1e-10;
/// Share of the interval that a step safely inside leaves.
const SAFE_SHARE: f64 = 0.66;

/// A step with the value and the slope of φ (or ψ) there.
#[derive(Clone, Copy)]
struct Sample {
    step: f64,
    value: f64,
    slope: f64,
}

/// The interval of uncertainty: `best` has the least value seen, `other` is its other end.
#[derive(Clone, Copy)]
struct Interval {
    best: Sample,
    other: Sample,
    /// Whether a minimum is known to lie inside.
    bracketed: bool,
}

/// Searches from φ(0) = `value` and φ'(0) = `slope` along a direction; the value where it ends, which
/// is the last step that `phi` was asked for.
///
/// `phi` gives value and slope of φ at a step, and nothing to break the search off. Nothing too where
/// the direction does not descend or the interpolation is not finite.
pub(super) fn search(
    value: f64,
    slope: f64,
    mut phi: impl FnMut(f64) -> Option<[f64; 2]>,
) -> Option<f64> {
    if slope >= 0.0 {
        return None;
    }
    let least = f64::EPSILON.sqrt();
    let decrease = DECREASE * slope;
    let zero = Sample { step: 0.0, value, slope };
    let mut interval = Interval { best: zero, other: zero, bracketed: false };
    let mut trial = Sample { step: 1.0, value: f64::NAN, slope: f64::NAN };
    let mut widths = [f64::INFINITY; 2];
    let mut first_stage = true;
    let mut usable = true;
    loop {
        let Interval { best, other, bracketed } = interval;
        let [low, high] = if bracketed {
            [best.step.min(other.step), best.step.max(other.step)]
        } else {
            [best.step, trial.step + EXTRAPOLATION * (trial.step - best.step)]
        };
        let outside = |step: f64| bracketed && (step <= low || step >= high);
        let narrow = bracketed && high - low <= LEAST_WIDTH * high;
        let mut step = trial.step.max(least);
        if outside(step) || narrow || !usable {
            step = best.step;
        }
        let [value_here, slope_here] = phi(step)?;
        let allowed = value + step * decrease;
        let wolfe = value_here <= allowed && slope_here.abs() <= CURVATURE * -slope;
        let shortest =
            (step - least).abs() < f64::EPSILON && (value_here > allowed || slope_here >= decrease);
        if wolfe || shortest || narrow || !usable || outside(step) {
            return Some(value_here);
        }
        if first_stage && value_here <= allowed && slope_here >= DECREASE * slope {
            first_stage = false;
        }
        let here = Sample { step, value: value_here, slope: slope_here };
        if first_stage && value_here <= trial.value && value_here > allowed {
            let reduced = |s: Sample| Sample {
                step: s.step,
                value: s.value - s.step * decrease,
                slope: s.slope - decrease,
            };
            let mut inner = Interval { best: reduced(best), other: reduced(other), bracketed };
            (trial, usable) = narrow_down(&mut inner, reduced(here), [low, high])?;
            let back = |step: f64, s: Sample| Sample {
                step,
                value: s.value + step * decrease,
                slope: s.slope + decrease,
            };
            interval = Interval {
                best: back(inner.best.step, best),
                other: back(inner.other.step, other),
                bracketed: inner.bracketed,
            };
        } else {
            (trial, usable) = narrow_down(&mut interval, here, [low, high])?;
        }
        let Interval { best, other, bracketed } = interval;
        if bracketed {
            if (other.step - best.step).abs() >= SAFE_SHARE * widths[1] {
                trial.step = best.step + 0.5 * (other.step - best.step);
            }
            widths = [(other.step - best.step).abs(), widths[0]];
        }
    }
}

/// One update of the interval by the sample `here`: the sample with the next step in it, and whether
/// that step is of use. Nothing where the interpolation is not finite.
fn narrow_down(
    interval: &mut Interval,
    here: Sample,
    [low, high]: [f64; 2],
) -> Option<(Sample, bool)> {
    let Interval { best, other, bracketed } = *interval;
    let ends = [best.step.min(other.step), best.step.max(other.step)];
    if (bracketed && (here.step <= ends[0] || here.step >= ends[1]))
        || best.slope * (here.step - best.step) >= 0.0
        || high < low
    {
        return Some((here, false));
    }
    let turns = here.slope * (best.slope / best.slope.abs()) < 0.0;
    let secant = here.step + (here.slope / (here.slope - best.slope)) * (best.step - here.step);
    let (next, inside);
    if here.value > best.value {
        // Higher: a minimum lies between. The cubic's, or half-way to the parabola's.
        let (theta, gamma) = cubic(best, here, false)?;
        let gamma = if here.step < best.step { -gamma } else { gamma };
        let ratio = ((gamma - best.slope) + theta) / (((gamma - best.slope) + gamma) + here.slope);
        let by_cubic = best.step + ratio * (here.step - best.step);
        let chord = (best.value - here.value) / (here.step - best.step) + best.slope;
        let by_parabola = best.step + ((best.slope / chord) / 2.0) * (here.step - best.step);
        next = if (by_cubic - best.step).abs() < (by_parabola - best.step).abs() {
            by_cubic
        } else {
            by_cubic + (by_parabola - by_cubic) / 2.0
        };
        interval.bracketed = true;
        inside = true;
    } else if turns {
        // Lower, and the slope has turned: a minimum lies between. The farther of cubic and secant.
        let (theta, gamma) = cubic(best, here, false)?;
        let gamma = if here.step > best.step { -gamma } else { gamma };
        let ratio = ((gamma - here.slope) + theta) / (((gamma - here.slope) + gamma) + best.slope);
        let by_cubic = here.step + ratio * (best.step - here.step);
        let farther = (by_cubic - here.step).abs() > (secant - here.step).abs();
        next = if farther { by_cubic } else { secant };
        interval.bracketed = true;
        inside = false;
    } else if here.slope.abs() < best.slope.abs() {
        // Lower and flatter: the cubic counts only if it has a minimum beyond the step.
        let (theta, gamma) = cubic(best, here, true)?;
        let gamma = if here.step > best.step { -gamma } else { gamma };
        let ratio = ((gamma - here.slope) + theta) / ((gamma + (best.slope - here.slope)) + gamma);
        let by_cubic = if ratio < 0.0 && gamma != 0.0 {
            here.step + ratio * (best.step - here.step)
        } else if here.step > best.step {
            high
        } else {
            low
        };
        let [to_cubic, to_secant] = [by_cubic, secant].map(|step| (here.step - step).abs());
        let nearer = if bracketed { to_cubic < to_secant } else { to_cubic > to_secant };
        next = if nearer { by_cubic } else { secant };
        inside = true;
    } else {
        // Lower and steeper: to the cubic with the other end, or as far as allowed.
        next = if bracketed {
            let (theta, gamma) = cubic(other, here, false)?;
            let gamma = if here.step > other.step { -gamma } else { gamma };
            let ratio =
                ((gamma - here.slope) + theta) / (((gamma - here.slope) + gamma) + other.slope);
            here.step + ratio * (other.step - here.step)
        } else if here.step > best.step {
            high
        } else {
            low
        };
        inside = false;
    }
    if here.value > best.value {
        interval.other = here;
    } else {
        if turns {
            interval.other = best;
        }
        interval.best = here;
    }
    let mut next = high.min(next).max(low);
    if interval.bracketed && inside {
        let Interval { best, other, .. } = *interval;
        let safe = best.step + SAFE_SHARE * (other.step - best.step);
        next = if other.step > best.step { next.min(safe) } else { next.max(safe) };
    }
    Some((Sample { step: next, ..here }, true))
}

/// θ and γ of the cubic through two samples, γ's radicand no less than 0 where asked;
/// nothing where they are not finite.
fn cubic(a: Sample, b: Sample, at_least_zero: bool) -> Option<(f64, f64)> {
    let theta = 3.0 * (a.value - b.value) / (b.step - a.step) + a.slope + b.slope;
    let terms = [theta, a.slope, b.slope];
    if !terms.iter().all(|term| term.is_finite()) {
        return None;
    }
    let scale = terms.into_iter().fold(f64::NEG_INFINITY, |s, t| if t >= s { t } else { s });
    let radicand = (theta / scale).powi(2) - (a.slope / scale) * (b.slope / scale);
    let radicand = if at_least_zero { radicand.max(0.0) } else { radicand };
    Some((theta, scale * radicand.sqrt()))
}
