//! Shapes cut to what a bitmap can show, in f64: the rasteriser counts in f32 and loses what reaches far
//! beyond the picture, and a far corner that is only held back bends the edges that lead to it.

use super::canvas::Pixel;

/// A rectangle of the canvas that holds all of it, strokes' widths included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    pub(super) min: Pixel,
    pub(super) max: Pixel,
}

impl Window {
    /// The part of a filled ring inside (I. Sutherland and G. Hodgman, doi:10.1145/360767.360802). Edges
    /// along the window are none of the ring's.
    pub(super) fn ring(&self, ring: &[Pixel]) -> Vec<Pixel> {
        let mut ring = ring.to_vec();
        for axis in 0..2 {
            for (border, sense) in [(self.min[axis], 1.0), (self.max[axis], -1.0)] {
                let depth = |p: Pixel| sense * (p[axis] - border);
                let mut kept = Vec::with_capacity(ring.len() + 4);
                for (i, &b) in ring.iter().enumerate() {
                    let a = ring[(i + ring.len() - 1) % ring.len()];
                    if (depth(a) < 0.0) != (depth(b) < 0.0) {
                        kept.push(crossing(a, b, depth(a), depth(b)));
                    }
                    if depth(b) >= 0.0 {
                        kept.push(b);
                    }
                }
                ring = kept;
            }
        }
        ring
    }

    /// The parts of a line inside.
    pub(super) fn line(&self, points: &[Pixel], closed: bool) -> Vec<Vec<Pixel>> {
        let mut parts: Vec<Vec<Pixel>> = Vec::new();
        let back = points.first().filter(|_| closed);
        for pair in points
            .windows(2)
            .map(|pair| [pair[0], pair[1]])
            .chain(back.zip(points.last()).map(|(&first, &last)| [last, first]))
        {
            let Some([a, b]) = self.segment(pair) else { continue };
            match parts.last_mut() {
                Some(part) if part.last() == Some(&a) => part.push(b),
                _ => parts.push(vec![a, b]),
            }
        }
        parts
    }

    /// The part of a segment inside.
    fn segment(&self, [mut a, mut b]: [Pixel; 2]) -> Option<[Pixel; 2]> {
        for axis in 0..2 {
            for (border, sense) in [(self.min[axis], 1.0), (self.max[axis], -1.0)] {
                let (da, db) = (sense * (a[axis] - border), sense * (b[axis] - border));
                match (da >= 0.0, db >= 0.0) {
                    (true, true) => {}
                    (true, false) => b = crossing(a, b, da, db),
                    (false, true) => a = crossing(a, b, da, db),
                    (false, false) => return None,
                }
            }
        }
        Some([a, b])
    }

    /// The part of a large disc inside as a ring, a corner for each unit of width.
    pub(super) fn disc(&self, center: Pixel, radius: f64) -> Vec<Pixel> {
        let left = self.min[0].max(center[0] - radius);
        let right = self.max[0].min(center[0] + radius);
        let is_number = center.iter().chain([&radius]).all(|value| value.is_finite());
        if left >= right || !is_number {
            return Vec::new();
        }
        let steps = (right - left).ceil().max(1.0) as usize;
        let half = |x: f64| {
            let offset = x - center[0];
            // As a product, which loses nothing where the difference is small.
            ((radius - offset).max(0.0) * (radius + offset).max(0.0)).sqrt()
        };
        let side = |sense: f64| {
            (0..=steps).map(move |i| {
                let x = left + (right - left) * i as f64 / steps as f64;
                [x, (center[1] + sense * half(x)).clamp(self.min[1], self.max[1])]
            })
        };
        let lower: Vec<Pixel> = side(1.0).collect();
        side(-1.0).chain(lower.into_iter().rev()).collect()
    }
}

/// Where a segment crosses a border from which its ends are `da` and `db` away.
fn crossing(a: Pixel, b: Pixel, da: f64, db: f64) -> Pixel {
    let t = da / (da - db);
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const WINDOW: Window = Window { min: [-50.0, -50.0], max: [450.0, 350.0] };

    /// Whether a point lies in a ring, by its crossings.
    fn holds(ring: &[Pixel], p: Pixel) -> bool {
        let crosses = |i: &usize| {
            let (a, b) = (ring[*i], ring[(i + 1) % ring.len()]);
            (a[1] > p[1]) != (b[1] > p[1])
                && p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1])
        };
        (0..ring.len()).filter(crosses).count() % 2 == 1
    }

    proptest! {
        #[test]
        fn what_is_cut_off_lies_outside(
            ring in prop::collection::vec([-1e4..1e4, -1e4..1e4f64], 3..9),
            p in [0.0..400.0f64, 0.0..300.0f64],
        ) {
            prop_assert_eq!(holds(&WINDOW.ring(&ring), p), holds(&ring, p));
            for part in WINDOW.line(&ring, true) {
                for q in part {
                    let inside = |k: usize| (WINDOW.min[k] - 1e-6..=WINDOW.max[k] + 1e-6).contains(&q[k]);
                    prop_assert!(inside(0) && inside(1), "{:?}", q);
                }
            }
        }

        #[test]
        fn a_disc_is_a_disc(
            center in [-1e7..1e7f64, -1e7..1e7f64],
            off in -400.0..400.0f64,
            p in [0.0..400.0f64, 0.0..300.0f64],
        ) {
            let to_p = (center[0] - p[0]).hypot(center[1] - p[1]);
            let radius = (to_p + off).max(2000.0);
            prop_assume!((to_p - radius).abs() > 0.5);
            prop_assert_eq!(holds(&WINDOW.disc(center, radius), p), to_p < radius);
        }
    }
}
