//! A legend: marks with labels in centred rows, as many to a row as fit.

use super::canvas::{Anchor, Canvas, Frame, Pixel, Shape, Stroke};
use super::color::{AXIS, Color, LineStyle, TEXT, WHITE};
use super::font::{self, Weight};

/// What stands before a label.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mark {
    /// A line, as it is drawn.
    Line(LineStyle),
    /// Several lines from faint to full.
    Fan { color: Color },
    /// A filled box.
    Box { color: Color },
    /// A dot.
    Dot { color: Color },
    /// The start's ring.
    Start,
    /// The goal's diamond.
    Goal,
    /// The cross where a way is blocked.
    Blocked,
}

/// A mark with its label.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    pub(super) mark: Mark,
    pub(super) label: String,
}

const SIZE: f64 = 12.0;
const ROW: f64 = 20.0;
const MARK_WIDTH: f64 = 22.0;
const MARK_GAP: f64 = 6.0;
const ENTRY_GAP: f64 = 18.0;

/// Height of the legend of `entries` in `width`, 0 if there are none.
pub(super) fn height(entries: &[Entry], width: f64) -> f64 {
    rows(&fitted(entries, width), width).len() as f64 * ROW
}

/// The entries, their labels cut to the width of the legend.
fn fitted(entries: &[Entry], width: f64) -> Vec<Entry> {
    let most = width - MARK_WIDTH - MARK_GAP;
    let cut = |label: &str| font::cut(label, SIZE, Weight::Regular, most);
    entries.iter().map(|entry| Entry { label: cut(&entry.label), ..*entry }).collect()
}

/// Draws the legend with its upper left corner at `at`.
pub(super) fn draw(canvas: &mut Canvas, entries: &[Entry], at: Pixel, width: f64) {
    let entries = fitted(entries, width);
    for (i, row) in rows(&entries, width).iter().enumerate() {
        let used: f64 = row.iter().map(entry_width).sum::<f64>() - ENTRY_GAP;
        let mut x = at[0] + (width - used).max(0.0) / 2.0;
        let middle = at[1] + (i as f64 + 0.5) * ROW;
        for entry in *row {
            draw_mark(canvas, entry.mark, [x, middle]);
            let place = [x + MARK_WIDTH + MARK_GAP, middle + 0.36 * SIZE];
            canvas.text(place, &*entry.label, SIZE, TEXT, Anchor::Start);
            x += entry_width(entry);
        }
    }
}

fn entry_width(entry: &Entry) -> f64 {
    MARK_WIDTH + MARK_GAP + font::width(&entry.label, SIZE, Weight::Regular) + ENTRY_GAP
}

fn rows(entries: &[Entry], width: f64) -> Vec<&[Entry]> {
    let mut rows = Vec::new();
    let (mut first, mut used) = (0, 0.0);
    for (i, entry) in entries.iter().enumerate() {
        let next = entry_width(entry);
        if i > first && used + next - ENTRY_GAP > width {
            rows.push(&entries[first..i]);
            (first, used) = (i, 0.0);
        }
        used += next;
    }
    if first < entries.len() {
        rows.push(&entries[first..]);
    }
    rows
}

/// Draws a mark whose left middle is at `at`.
fn draw_mark(canvas: &mut Canvas, mark: Mark, at: Pixel) {
    let [x, y] = at;
    let centre = [x + MARK_WIDTH / 2.0, y];
    let across = |dy: f64| vec![[x + 1.5, y + dy], [x + MARK_WIDTH - 1.5, y + dy]];
    match mark {
        Mark::Line(style) => canvas.line(across(0.0), Stroke::styled(style, 2.5)),
        Mark::Fan { color } => {
            for (dy, opacity) in [(-4.5, 0.2), (0.0, 0.45), (4.5, 1.0)] {
                canvas.line(across(dy), Stroke::new(color.with_opacity(opacity), 1.5));
            }
        }
        Mark::Box { color } => {
            let frame = Frame { x: x + 4.0, y: y - 6.0, width: 14.0, height: 12.0 };
            canvas.area(frame.corners(), color);
            canvas.outline(frame.corners(), Stroke::new(AXIS, 0.75));
        }
        Mark::Dot { color } => dot(canvas, centre, 4.0, color),
        Mark::Start => draw_start(canvas, centre),
        Mark::Goal => draw_goal(canvas, centre),
        Mark::Blocked => draw_cross(canvas, centre),
    }
}

/// A dot with a white rim.
pub(super) fn dot(canvas: &mut Canvas, center: Pixel, radius: f64, color: Color) {
    let stroke = Some(Stroke::new(WHITE, 1.0));
    canvas.shapes.push(Shape::Circle { center, radius, fill: Some(color), stroke });
}

/// The start: a dark ring around white.
pub(super) fn draw_start(canvas: &mut Canvas, center: Pixel) {
    for (radius, color) in [(7.0, WHITE), (6.0, TEXT), (3.2, WHITE)] {
        canvas.shapes.push(Shape::Circle { center, radius, fill: Some(color), stroke: None });
    }
}

/// The goal: a dark diamond with a white rim.
pub(super) fn draw_goal(canvas: &mut Canvas, [x, y]: Pixel) {
    for (radius, color) in [(9.0, WHITE), (7.4, TEXT)] {
        let corners = vec![[x, y - radius], [x + radius, y], [x, y + radius], [x - radius, y]];
        canvas.area(corners, color);
    }
}

/// Where a way is blocked: a dark cross with a white rim.
pub(super) fn draw_cross(canvas: &mut Canvas, [x, y]: Pixel) {
    const REACH: f64 = 6.0;
    for (width, color) in [(5.5, WHITE), (3.0, TEXT)] {
        for side in [-REACH, REACH] {
            canvas.line(
                vec![[x - REACH, y - side], [x + REACH, y + side]],
                Stroke::new(color, width),
            );
        }
    }
}
