//! The inside of a chart: from values to pixels, and the marks drawn there.

use sidestep::plane::geometry::Point;

use super::axis::Axis;
use super::canvas::{Canvas, Frame, Pixel, Stroke};
use super::chart::{BandPoint, Bar};
use super::color::{Color, TEXT};
use super::legend;

/// The frame inside the axes.
pub(super) struct Plot {
    pub(super) frame: Frame,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

impl Plot {
    fn at(&self, x: f64, y: f64) -> Pixel {
        [self.frame.x + x * self.frame.width, self.frame.bottom() - y * self.frame.height]
    }

    pub(super) fn pixel(&self, p: Point) -> Option<Pixel> {
        Some(self.at(self.x.fraction(p[0])?, self.y.fraction(p[1])?))
    }

    pub(super) fn band(&self, canvas: &mut Canvas, points: &[BandPoint], color: Color) {
        let has_spread = points.iter().any(|p| p.low < p.mean || p.mean < p.high);
        let drawn = || {
            let finite = points.iter().filter(|p| !p.low.is_nan() && !p.high.is_nan());
            finite.filter_map(|p| Some((self.x.fraction(p.x)?, p)))
        };
        if has_spread {
            let upper = drawn().map(|(x, p)| self.at(x, self.y.held(p.high)));
            let mut lower: Vec<_> = drawn().map(|(x, p)| self.at(x, self.y.held(p.low))).collect();
            lower.reverse();
            canvas.area(upper.chain(lower).collect(), color);
        }
    }

    /// The curve, broken where a value cannot be shown.
    pub(super) fn curve(&self, canvas: &mut Canvas, points: &[BandPoint], color: Color) {
        let pixels: Vec<_> = points.iter().map(|p| self.pixel([p.x, p.mean])).collect();
        for part in pixels.split(|pixel| pixel.is_none()) {
            let part: Vec<_> = part.iter().copied().flatten().collect();
            match part.as_slice() {
                [] => {}
                &[only] => legend::dot(canvas, only, 3.0, color),
                _ => canvas.line(part, Stroke::new(color, 2.25)),
            }
        }
    }

    pub(super) fn bars(
        &self,
        canvas: &mut Canvas,
        bars: &[Bar],
        color: Color,
        group: usize,
        groups: usize,
    ) {
        // All groups' bars fill 80 % of a category's width.
        let width = 0.8 / groups.max(1) as f64;
        for (i, bar) in bars.iter().enumerate() {
            let left = i as f64 - 0.4 + group as f64 * width;
            let (Some(from), Some(to)) =
                (self.x.fraction(left + 0.04 * width), self.x.fraction(left + 0.96 * width))
            else {
                continue;
            };
            let (foot, top) = (self.y.held(0.0), self.y.held(bar.value));
            let corners = [(from, foot), (to, foot), (to, top), (from, top)];
            canvas.area(corners.iter().map(|&(x, y)| self.at(x, y)).collect(), color);
            if bar.low < bar.value || bar.value < bar.high {
                let middle = (from + to) / 2.0;
                let ends =
                    [self.at(middle, self.y.held(bar.low)), self.at(middle, self.y.held(bar.high))];
                let stroke = Stroke::new(TEXT, 1.25);
                canvas.line(ends.to_vec(), stroke);
                for [x, y] in ends {
                    canvas.line(vec![[x - 3.0, y], [x + 3.0, y]], stroke);
                }
            }
        }
    }
}
