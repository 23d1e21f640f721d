//! What a picture is made of: shapes in pixels, y downwards, drawn in order.
//!
//! One list of shapes becomes SVG (`svg.rs`) and PNG (`raster.rs`), so the two show the same.

use super::color::{Color, LineStyle};
use super::font::Weight;

/// A position in pixels, y downwards.
pub(super) type Pixel = [f64; 2];

/// A rectangle in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Frame {
    pub(super) fn right(&self) -> f64 {
        self.x + self.width
    }

    pub(super) fn bottom(&self) -> f64 {
        self.y + self.height
    }

    pub(super) fn corners(&self) -> Vec<Pixel> {
        let (right, bottom) = (self.right(), self.bottom());
        vec![[self.x, self.y], [right, self.y], [right, bottom], [self.x, bottom]]
    }
}

/// How a line is drawn; joins and ends are round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stroke {
    pub(super) color: Color,
    pub(super) width: f64,
    /// Lengths of dash and gap, if dashed.
    pub(super) dash: Option<[f64; 2]>,
}

impl Stroke {
    pub(super) fn new(color: Color, width: f64) -> Self {
        Self { color, width, dash: None }
    }

    pub(super) fn styled(style: LineStyle, width: f64) -> Self {
        Self { color: style.color, width, dash: style.dash }
    }
}

/// Where a text's anchor point lies in it; always on the baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// A line of text.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Text {
    pub(super) at: Pixel,
    pub(super) text: String,
    pub(super) size: f64,
    pub(super) weight: Weight,
    pub(super) color: Color,
    pub(super) anchor: Anchor,
    /// Read from the bottom to the top.
    pub(super) upwards: bool,
}

/// One thing to draw.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// Polygons filled by the even-odd rule.
    Area {
        rings: Vec<Vec<Pixel>>,
        fill: Color,
    },
    /// Open or closed lines.
    Line {
        points: Vec<Pixel>,
        closed: bool,
        stroke: Stroke,
    },
    /// A line that moves from one list of points to the next, over and over; where nothing can move it
    /// is drawn as it ends. All lists are of one length.
    Moving {
        frames: Vec<Vec<Pixel>>,
        stroke: Stroke,
    },
    Circle {
        center: Pixel,
        radius: f64,
        fill: Option<Color>,
        stroke: Option<Stroke>,
    },
    /// Opaque pixels, the top row first, stretched smoothly over a frame.
    Image {
        frame: Frame,
        width: usize,
        height: usize,
        rgb: Vec<[u8; 3]>,
    },
    Text(Text),
    /// Shapes cut off at a frame.
    Clip {
        frame: Frame,
        shapes: Vec<Shape>,
    },
}

/// A sheet with a white ground.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Canvas {
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) shapes: Vec<Shape>,
}

impl Canvas {
    /// Fills a polygon.
    pub(super) fn area(&mut self, points: Vec<Pixel>, fill: Color) {
        self.shapes.push(Shape::Area { rings: vec![points], fill });
    }

    /// Draws an open line through points.
    pub(super) fn line(&mut self, points: Vec<Pixel>, stroke: Stroke) {
        self.shapes.push(Shape::Line { points, closed: false, stroke });
    }

    /// Draws a closed line through points.
    pub(super) fn outline(&mut self, points: Vec<Pixel>, stroke: Stroke) {
        self.shapes.push(Shape::Line { points, closed: true, stroke });
    }

    /// Writes a line of regular text.
    pub(super) fn text(
        &mut self,
        at: Pixel,
        text: impl Into<String>,
        size: f64,
        color: Color,
        anchor: Anchor,
    ) {
        let text = text.into();
        let weight = Weight::Regular;
        let text = Text { at, text, size, weight, color, anchor, upwards: false };
        self.shapes.push(Shape::Text(text));
    }

    /// Draws what `draw` draws, cut off at a frame.
    pub(super) fn clipped(&mut self, frame: Frame, draw: impl FnOnce(&mut Self)) {
        let mut inner = Self { width: self.width, height: self.height, shapes: Vec::new() };
        draw(&mut inner);
        self.shapes.push(Shape::Clip { frame, shapes: inner.shapes });
    }
}
