//! The axes of a world that is seen from above: one scale for both, ticks outside, a bar of a round length inside.

use sidestep::plane::geometry::Rect;

use super::axis::{Axis, Scale};
use super::canvas::{Anchor, Canvas, Frame, Stroke};
use super::color::{AXIS, QUIET, TEXT, WHITE};

/// Room for ticks and their labels, left and below.
const LEFT: f64 = 34.0;
const BELOW: f64 = 20.0;
const TICK: f64 = 4.0;
const SIZE: f64 = 10.0;
/// Pixels of the bar, at most.
const LONGEST: f64 = 64.0;
/// Pixels from tick to tick, at least.
const APART: f64 = 50.0;

/// Height over width of a drawing; a world of extreme sides fills only a part of it.
fn aspect(bounds: Rect) -> f64 {
    let [width, height] = bounds.size();
    height / width
}

/// Height of a drawing of this width with its axes.
pub(super) fn height(bounds: Rect, width: f64) -> f64 {
    (width - LEFT) * aspect(bounds).clamp(0.2, 1.4) + BELOW
}

/// Where the world stands in the frame of a drawing: at its top, in the middle.
pub(super) fn inside(bounds: Rect, frame: Frame) -> Frame {
    let width = (frame.width - LEFT).min((frame.height - BELOW) / aspect(bounds));
    let x = frame.x + LEFT + (frame.width - LEFT - width) / 2.0;
    Frame { x, y: frame.y, width, height: width * aspect(bounds) }
}

/// Ticks and labels around the frame of a world, and a bar that measures it.
pub(super) fn draw(canvas: &mut Canvas, bounds: Rect, frame: Frame, unit: &str) {
    let (min, max) = (bounds.min, bounds.max);
    let axis = |i: usize, length: f64| {
        let most = ((length / APART) as usize).clamp(1, 8);
        Axis::new(Scale::Linear, [min[i], max[i]].into_iter(), most, false)
    };
    let (across, up) = (axis(0, frame.width), axis(1, frame.height));
    let stroke = Stroke::new(AXIS, 1.0);
    let bottom = frame.bottom();
    for (value, label) in &across.ticks {
        let x = frame.x + across.held(*value) * frame.width;
        canvas.line(vec![[x, bottom], [x, bottom + TICK]], stroke);
        canvas.text([x, bottom + TICK + SIZE], label, SIZE, QUIET, Anchor::Middle);
    }
    for (value, label) in &up.ticks {
        let y = bottom - up.held(*value) * frame.height;
        canvas.line(vec![[frame.x - TICK, y], [frame.x, y]], stroke);
        canvas.text([frame.x - TICK - 2.0, y + 0.36 * SIZE], label, SIZE, QUIET, Anchor::End);
    }
    scale_bar(canvas, &across, bounds, frame, unit);
}

/// A bar as long as the way from tick to tick or a round part of it, with its length.
fn scale_bar(canvas: &mut Canvas, axis: &Axis, bounds: Rect, frame: Frame, unit: &str) {
    let [(first, _), (second, _), ..] = axis.ticks.as_slice() else { return };
    let pixels = |length: f64| length / bounds.size()[0] * frame.width;
    let whole = second - first;
    let parts = [whole, 0.5 * whole, 0.2 * whole];
    let step = parts.into_iter().find(|&part| pixels(part) <= LONGEST).unwrap_or(parts[2]);
    let length = pixels(step);
    let [right, y] = [frame.right() - 8.0, frame.bottom() - 8.0];
    let ground = Frame { x: right - length - 4.0, y: y - 17.0, width: length + 8.0, height: 21.0 };
    canvas.area(ground.corners(), WHITE.with_opacity(0.75));
    let bar = [[right - length, y - 4.0], [right - length, y], [right, y], [right, y - 4.0]];
    canvas.line(bar.to_vec(), Stroke::new(TEXT, 1.5));
    let said = format!("{} {unit}", (step * 1e9).round() / 1e9);
    let at = [right - length / 2.0, y - 5.0];
    canvas.text(at, said.trim(), SIZE, TEXT, Anchor::Middle);
}
