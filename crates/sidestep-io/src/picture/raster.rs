//! Shapes to PNG, drawn by `tiny-skia` with anti-aliasing.

use tiny_skia::{
    FillRule, FilterQuality, LineCap, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap,
    PixmapPaint, Rect, StrokeDash, Transform,
};

use super::canvas::{Anchor, Canvas, Frame, Pixel, Shape, Stroke, Text};
use super::clip::Window;
use super::color::{Color, WHITE};
use super::{font, moving};
use crate::error::{FormatError, Place};

/// Most pixels of a bitmap on either side.
const MOST_SIDE: u32 = 16_384;

/// Coordinates are held within this; beyond it f32 and the rasteriser lose the picture.
const FARTHEST: f64 = 20_000.0;

/// Circles of a larger radius are drawn by the part of them that can be seen.
const LARGEST_CIRCLE: f64 = 2_000.0;

/// How far beyond the bitmap shapes reach that are cut to it; more than half of any stroke's width.
const BEYOND: f64 = 50.0;

/// The PNG of a canvas at `scale` pixels per unit, what can move as it ends.
pub(super) fn write(canvas: &Canvas, scale: f64) -> Result<Vec<u8>, FormatError> {
    let mut pixmap = sheet(canvas, scale)?;
    paint_sheet(&mut pixmap, canvas, scale, usize::MAX);
    let (width, height) = (pixmap.width() as usize, pixmap.height() as usize);
    encode(width, height, &rgb(&pixmap)).ok_or_else(failed)
}

/// The PNG of a canvas that moves: a moment for each frame of what moves, the last one held.
pub(super) fn write_moving(canvas: &Canvas, scale: f64) -> Result<Vec<u8>, FormatError> {
    let frames = moments(&canvas.shapes);
    let mut pixmap = sheet(canvas, scale)?;
    let size = [pixmap.width(), pixmap.height()];
    let shots = (0..frames.max(1)).map(|at| {
        paint_sheet(&mut pixmap, canvas, scale, at);
        rgb(&pixmap)
    });
    moving::encode(size, frames.max(1), shots).ok_or_else(failed)
}

fn failed() -> FormatError {
    FormatError::new("PNG picture", Place::default(), "an encoder that failed", "a PNG")
}

/// An empty bitmap as large as the canvas.
fn sheet(canvas: &Canvas, scale: f64) -> Result<Pixmap, FormatError> {
    let side = |length: f64| (length * scale).ceil().max(1.0).min(f64::from(u32::MAX)) as u32;
    let (width, height) = (side(canvas.width), side(canvas.height));
    let pixmap = Some((width, height))
        .filter(|_| scale.is_finite() && width.max(height) <= MOST_SIDE)
        .and_then(|(width, height)| Pixmap::new(width, height));
    pixmap.ok_or_else(|| {
        FormatError::new(
            "PNG picture",
            Place::field("width x height"),
            format!("{width} x {height} pixels"),
            format!("at most {MOST_SIDE} on either side; draw fewer panels or a smaller scale"),
        )
    })
}

fn paint_sheet(pixmap: &mut Pixmap, canvas: &Canvas, scale: f64, moment: usize) {
    pixmap.fill(paint_color(WHITE));
    let transform = Transform::from_scale(scale as f32, scale as f32);
    draw(pixmap, &canvas.shapes, transform, None, moment);
}

fn rgb(pixmap: &Pixmap) -> Vec<u8> {
    pixmap.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect()
}

/// How many frames the longest of what moves has.
fn moments(shapes: &[Shape]) -> usize {
    let of = |shape: &Shape| match shape {
        Shape::Moving { frames, .. } => frames.len(),
        Shape::Clip { shapes, .. } => moments(shapes),
        _ => 0,
    };
    shapes.iter().map(of).max().unwrap_or(0)
}

/// A PNG of opaque pixels, the top row first; `None` if the sizes disagree.
pub(super) fn encode(width: usize, height: usize, rgb: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let (width, height) = (u32::try_from(width).ok()?, u32::try_from(height).ok()?);
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(rgb).ok()?;
    writer.finish().ok()?;
    Some(bytes)
}

/// Draws shapes as they are at a moment of what moves, or as it ends.
fn draw(
    pixmap: &mut Pixmap,
    shapes: &[Shape],
    transform: Transform,
    mask: Option<&Mask>,
    moment: usize,
) {
    for shape in shapes {
        match shape {
            Shape::Area { rings, fill } => {
                let mut path = PathBuilder::new();
                for ring in rings {
                    match is_far(ring) {
                        true => add_points(&mut path, &window(pixmap, transform).ring(ring), true),
                        false => add_points(&mut path, ring, true),
                    }
                }
                fill_path(pixmap, path.finish(), *fill, transform, mask);
            }
            Shape::Line { points, closed, stroke } => {
                let mut path = PathBuilder::new();
                if is_far(points) {
                    let parts = window(pixmap, transform).line(points, *closed);
                    parts.iter().for_each(|part| add_points(&mut path, part, false));
                } else {
                    add_points(&mut path, points, *closed);
                }
                stroke_path(pixmap, path.finish(), stroke, transform, mask);
            }
            Shape::Moving { frames, stroke } => {
                let mut path = PathBuilder::new();
                let frame = frames.get(moment).or(frames.last());
                frame.into_iter().for_each(|points| add_points(&mut path, points, false));
                stroke_path(pixmap, path.finish(), stroke, transform, mask);
            }
            Shape::Circle { center, radius, fill, stroke } => {
                let [x, y] = point(*center);
                let large = *radius > LARGEST_CIRCLE || is_far(&[*center]);
                let path = || {
                    if !large {
                        return PathBuilder::from_circle(x, y, held(*radius));
                    }
                    let mut path = PathBuilder::new();
                    add_points(&mut path, &window(pixmap, transform).disc(*center, *radius), true);
                    path.finish()
                };
                let (filled, outlined) = (fill.and_then(|_| path()), stroke.and_then(|_| path()));
                if let Some(fill) = fill {
                    fill_path(pixmap, filled, *fill, transform, mask);
                }
                if let Some(stroke) = stroke {
                    stroke_path(pixmap, outlined, stroke, transform, mask);
                }
            }
            Shape::Image { frame, width, height, rgb } => {
                draw_image(pixmap, frame, [*width, *height], rgb, transform, mask);
            }
            Shape::Text(text) => draw_text(pixmap, text, transform, mask),
            Shape::Clip { frame, shapes } => {
                let clip = clip_mask(pixmap, frame, transform);
                draw(pixmap, shapes, transform, clip.as_ref().or(mask), moment);
            }
        }
    }
}

fn paint_color(color: Color) -> tiny_skia::Color {
    let [r, g, b] = color.rgb;
    tiny_skia::Color::from_rgba8(r, g, b, (color.opacity.clamp(0.0, 1.0) * 255.0).round() as u8)
}

fn paint(color: Color) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color(paint_color(color));
    paint
}

/// Whether a shape reaches farther than the rasteriser can follow it.
fn is_far(points: &[Pixel]) -> bool {
    points.iter().flatten().any(|value| value.abs() > FARTHEST)
}

/// What the bitmap shows, and a little more, in the canvas's units.
fn window(pixmap: &Pixmap, transform: Transform) -> Window {
    let size = [pixmap.width(), pixmap.height()].map(f64::from);
    let scale = f64::from(transform.sx);
    Window { min: [-BEYOND; 2], max: size.map(|pixels| pixels / scale + BEYOND) }
}

fn held(value: f64) -> f32 {
    value.clamp(-FARTHEST, FARTHEST) as f32
}

fn point(p: Pixel) -> [f32; 2] {
    p.map(held)
}

fn add_points(path: &mut PathBuilder, points: &[Pixel], closed: bool) {
    for (i, &p) in points.iter().enumerate() {
        let [x, y] = point(p);
        if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    if closed && points.len() > 1 {
        path.close();
    }
}

fn fill_path(
    pixmap: &mut Pixmap,
    path: Option<Path>,
    fill: Color,
    transform: Transform,
    mask: Option<&Mask>,
) {
    if let Some(path) = path {
        pixmap.fill_path(&path, &paint(fill), FillRule::EvenOdd, transform, mask);
    }
}

fn stroke_path(
    pixmap: &mut Pixmap,
    path: Option<Path>,
    stroke: &Stroke,
    transform: Transform,
    mask: Option<&Mask>,
) {
    let Some(path) = path else { return };
    let style = tiny_skia::Stroke {
        width: held(stroke.width),
        line_cap: LineCap::Round,
        line_join: LineJoin::Round,
        dash: stroke.dash.and_then(|dash| StrokeDash::new(dash.map(held).to_vec(), 0.0)),
        ..tiny_skia::Stroke::default()
    };
    pixmap.stroke_path(&path, &paint(stroke.color), &style, transform, mask);
}

fn draw_image(
    pixmap: &mut Pixmap,
    frame: &Frame,
    [width, height]: [usize; 2],
    rgb: &[[u8; 3]],
    transform: Transform,
    mask: Option<&Mask>,
) {
    let Some(mut image) = Pixmap::new(width as u32, height as u32) else { return };
    for (pixel, &[r, g, b]) in image.pixels_mut().iter_mut().zip(rgb) {
        *pixel = tiny_skia::ColorU8::from_rgba(r, g, b, 255).premultiply();
    }
    let place = Transform::from_row(
        (frame.width / width as f64) as f32,
        0.0,
        0.0,
        (frame.height / height as f64) as f32,
        held(frame.x),
        held(frame.y),
    );
    let paint = PixmapPaint { quality: FilterQuality::Bilinear, ..PixmapPaint::default() };
    pixmap.draw_pixmap(0, 0, image.as_ref(), &paint, transform.pre_concat(place), mask);
}

fn draw_text(pixmap: &mut Pixmap, text: &Text, transform: Transform, mask: Option<&Mask>) {
    let mut glyphs = Glyphs(PathBuilder::new());
    font::outline(&text.text, text.size, text.weight, &mut glyphs);
    let Some(path) = glyphs.0.finish() else { return };
    let width = font::width(&text.text, text.size, text.weight);
    let shift = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -width / 2.0,
        Anchor::End => -width,
    };
    let [x, y] = point(text.at);
    let turn = if text.upwards { -90.0 } else { 0.0 };
    let place = Transform::from_translate(x, y)
        .pre_concat(Transform::from_rotate(turn))
        .pre_concat(Transform::from_translate(held(shift), 0.0));
    let transform = transform.pre_concat(place);
    pixmap.fill_path(&path, &paint(text.color), FillRule::Winding, transform, mask);
}

fn clip_mask(pixmap: &Pixmap, frame: &Frame, transform: Transform) -> Option<Mask> {
    let mut mask = Mask::new(pixmap.width(), pixmap.height())?;
    let [x, y] = point([frame.x, frame.y]);
    let rect = Rect::from_xywh(x, y, held(frame.width), held(frame.height))?;
    mask.fill_path(&PathBuilder::from_rect(rect), FillRule::Winding, true, transform);
    Some(mask)
}

/// Glyph outlines as one path.
struct Glyphs(PathBuilder);

impl ttf_parser::OutlineBuilder for Glyphs {
    fn move_to(&mut self, x: f32, y: f32) {
        self.0.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.0.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.0.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.0.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.0.close();
    }
}
