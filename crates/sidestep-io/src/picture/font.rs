//! The pictures' font, Noto Sans (SIL Open Font License, from the `notosans` crate): widths for the
//! layout and outlines for the bitmap. No font of the machine is ever used, so a PNG is the same anywhere.

use std::sync::LazyLock;

use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// How heavy a text is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Weight {
    Regular,
    Bold,
}

static REGULAR: LazyLock<Option<Face<'static>>> =
    LazyLock::new(|| Face::parse(notosans::REGULAR_TTF, 0).ok());
static BOLD: LazyLock<Option<Face<'static>>> =
    LazyLock::new(|| Face::parse(notosans::BOLD_TTF, 0).ok());

fn face(weight: Weight) -> Option<&'static Face<'static>> {
    match weight {
        Weight::Regular => REGULAR.as_ref(),
        Weight::Bold => BOLD.as_ref(),
    }
}

/// Calls `each` with every glyph and its offset from the text's start, in font units; returns the
/// text's whole advance. Characters that the font lacks show its box.
fn walk(face: &Face<'_>, text: &str, mut each: impl FnMut(GlyphId, f64)) -> f64 {
    let mut offset = 0.0;
    for character in text.chars() {
        let glyph = face.glyph_index(character).unwrap_or(GlyphId(0));
        each(glyph, offset);
        offset += f64::from(face.glyph_hor_advance(glyph).unwrap_or_default());
    }
    offset
}

/// The width of a text at a size, both in pixels.
pub(super) fn width(text: &str, size: f64, weight: Weight) -> f64 {
    face(weight)
        .map_or(0.0, |face| walk(face, text, |_, _| {}) * size / f64::from(face.units_per_em()))
}

/// A text that is at most `most` pixels wide: the text itself, or its beginning and an ellipsis.
pub(super) fn cut(text: &str, size: f64, weight: Weight, most: f64) -> String {
    if width(text, size, weight) <= most {
        return text.to_owned();
    }
    let mut room = most - width("…", size, weight);
    let mut kept = String::new();
    for character in text.chars() {
        room -= width(character.encode_utf8(&mut [0; 4]), size, weight);
        if room < 0.0 {
            break;
        }
        kept.push(character);
    }
    kept + "…"
}

/// The outline of a text whose baseline starts at the origin, in pixels, y downwards.
pub(super) fn outline(text: &str, size: f64, weight: Weight, sink: &mut dyn OutlineBuilder) {
    let Some(face) = face(weight) else { return };
    let scale = (size / f64::from(face.units_per_em())) as f32;
    walk(face, text, |glyph, offset| {
        let mut placed = Placed { sink: &mut *sink, scale, x: offset as f32 * scale };
        face.outline_glyph(glyph, &mut placed);
    });
}

/// Moves a glyph's outline from font units, y upwards, to its place.
struct Placed<'a> {
    sink: &'a mut dyn OutlineBuilder,
    scale: f32,
    x: f32,
}

impl Placed<'_> {
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, -y * self.scale)
    }
}

impl OutlineBuilder for Placed<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.sink.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.sink.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.place(x1, y1), self.place(x, y));
        self.sink.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2)) = (self.place(x1, y1), self.place(x2, y2));
        let (x, y) = self.place(x, y);
        self.sink.curve_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.sink.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_grow_with_text_and_size() {
        let regular = |text: &str, size: f64| width(text, size, Weight::Regular);
        assert!(regular("learned", 12.0) > regular("learn", 12.0));
        assert!((regular("gd", 24.0) - 2.0 * regular("gd", 12.0)).abs() < 1e-9);
        assert_eq!(cut("learned", 12.0, Weight::Regular, 100.0), "learned");
        let cut = cut("learned", 12.0, Weight::Regular, regular("learn", 12.0));
        assert!(cut.starts_with("lea") && cut.ends_with('…') && cut.len() < 9, "{cut}");
        assert!(width("learned", 12.0, Weight::Bold) > regular("learned", 12.0));
    }
}
