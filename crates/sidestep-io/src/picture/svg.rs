//! Shapes to SVG 1.1 text.
//!
//! Text stays text: it carries the width that the layout measured (`textLength`), so that a viewer
//! without the font still fits it in its place.

use std::fmt::Write;

use super::canvas::{Anchor, Canvas, Frame, Pixel, Shape, Stroke, Text};
use super::color::Color;
use super::font::{self, Weight};
use super::raster;

/// A moving picture begins anew after this.
const SECONDS: u32 = 8;
/// The part of that in which it moves; in the rest it shows how it ends.
const MOVES: f64 = 0.75;

/// The whole document.
pub(super) fn write(canvas: &Canvas) -> String {
    let (width, height) = (number(canvas.width), number(canvas.height));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" \
         width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"'Noto Sans', 'Helvetica Neue', Arial, sans-serif\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    let mut clips = 0;
    write_shapes(&mut svg, &canvas.shapes, &mut clips);
    svg += "</svg>\n";
    svg
}

fn write_shapes(svg: &mut String, shapes: &[Shape], clips: &mut usize) {
    for shape in shapes {
        match shape {
            Shape::Area { rings, fill } => {
                let data: String = rings.iter().map(|ring| path_data(ring, true)).collect();
                put(svg, &format!("<path d=\"{data}\" fill-rule=\"evenodd\"{}/>", fill_of(*fill)));
            }
            Shape::Line { points, closed, stroke } => {
                let data = path_data(points, *closed);
                put(svg, &format!("<path d=\"{data}\" fill=\"none\"{}/>", stroke_of(stroke)));
            }
            Shape::Moving { frames, stroke } => put(svg, &moving(frames, stroke)),
            Shape::Circle { center, radius, fill, stroke } => {
                let fill = fill.map_or(" fill=\"none\"".to_owned(), fill_of);
                let stroke = stroke.as_ref().map(stroke_of).unwrap_or_default();
                let (x, y, r) = (number(center[0]), number(center[1]), number(*radius));
                put(svg, &format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"{fill}{stroke}/>"));
            }
            Shape::Image { frame, width, height, rgb } => {
                if let Some(png) = raster::encode(*width, *height, rgb.as_flattened()) {
                    let data = base64(&png);
                    let place = frame_of(frame);
                    put(
                        svg,
                        &format!(
                            "<image{place} preserveAspectRatio=\"none\" \
                             xlink:href=\"data:image/png;base64,{data}\"/>"
                        ),
                    );
                }
            }
            Shape::Text(text) => put(svg, &text_element(text)),
            Shape::Clip { frame, shapes } => {
                let id = *clips;
                *clips += 1;
                let place = frame_of(frame);
                put(svg, &format!("<clipPath id=\"clip{id}\"><rect{place}/></clipPath>"));
                put(svg, &format!("<g clip-path=\"url(#clip{id})\">"));
                write_shapes(svg, shapes, clips);
                put(svg, "</g>");
            }
        }
    }
}

fn put(svg: &mut String, element: &str) {
    svg.push_str(element);
    svg.push('\n');
}

/// A path whose points are animated (SMIL, so without a script): evenly through the frames, then still.
fn moving(frames: &[Vec<Pixel>], stroke: &Stroke) -> String {
    let data: Vec<String> = frames.iter().map(|points| path_data(points, false)).collect();
    let Some(last) = data.last() else { return String::new() };
    let moves = (data.len() - 1).max(1) as f64;
    let times = (0..data.len()).map(|i| format!("{:.4}", MOVES * i as f64 / moves));
    let times: Vec<String> = times.chain(["1".into()]).collect();
    format!(
        "<path d=\"{last}\" fill=\"none\"{}><animate attributeName=\"d\" dur=\"{SECONDS}s\" \
         repeatCount=\"indefinite\" keyTimes=\"{}\" values=\"{};{last}\"/></path>",
        stroke_of(stroke),
        times.join(";"),
        data.join(";"),
    )
}

fn text_element(text: &Text) -> String {
    let Text { at, text, size, weight, color, anchor, upwards } = text;
    let mut place = format!(" x=\"{}\" y=\"{}\"", number(at[0]), number(at[1]));
    if *upwards {
        let _ = write!(place, " transform=\"rotate(-90 {} {})\"", number(at[0]), number(at[1]));
    }
    let anchor = match anchor {
        Anchor::Start => "",
        Anchor::Middle => " text-anchor=\"middle\"",
        Anchor::End => " text-anchor=\"end\"",
    };
    let weight_name = match weight {
        Weight::Regular => "",
        Weight::Bold => " font-weight=\"bold\"",
    };
    let width = number(font::width(text, *size, *weight));
    format!(
        "<text{place} font-size=\"{}\"{anchor}{weight_name}{} textLength=\"{width}\" \
         lengthAdjust=\"spacingAndGlyphs\">{}</text>",
        number(*size),
        fill_of(*color),
        escaped(text)
    )
}

fn frame_of(frame: &Frame) -> String {
    format!(
        " x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"",
        number(frame.x),
        number(frame.y),
        number(frame.width),
        number(frame.height)
    )
}

fn path_data(points: &[Pixel], closed: bool) -> String {
    let mut data = String::new();
    for (i, p) in points.iter().enumerate() {
        let command = if i == 0 { 'M' } else { 'L' };
        let _ = write!(data, "{command}{} {}", number(p[0]), number(p[1]));
    }
    if closed && !points.is_empty() {
        data.push('Z');
    }
    data
}

fn hex(color: Color) -> String {
    let [r, g, b] = color.rgb;
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn fill_of(color: Color) -> String {
    let opacity = match color.opacity {
        1.0 => String::new(),
        opacity => format!(" fill-opacity=\"{}\"", number(opacity)),
    };
    format!(" fill=\"{}\"{opacity}", hex(color))
}

fn stroke_of(stroke: &Stroke) -> String {
    let mut text = format!(
        " stroke=\"{}\" stroke-width=\"{}\" stroke-linecap=\"round\" stroke-linejoin=\"round\"",
        hex(stroke.color),
        number(stroke.width)
    );
    if stroke.color.opacity != 1.0 {
        let _ = write!(text, " stroke-opacity=\"{}\"", number(stroke.color.opacity));
    }
    if let Some([dash, gap]) = stroke.dash {
        let _ = write!(text, " stroke-dasharray=\"{} {}\"", number(dash), number(gap));
    }
    text
}

/// At most two decimals: a hundredth of a pixel is not seen.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Text for XML; control characters, which XML cannot hold, become spaces.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '\u{fffe}' | '\u{ffff}' => out.push(' '),
            character if character.is_control() => out.push(' '),
            character => out.push(character),
        }
    }
    out
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |i: usize| u32::from(chunk.get(i).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize];
            text.push(if i <= chunk.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_rfc_4648() {
        for (bytes, expected) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(bytes.as_bytes()), expected);
        }
    }

    #[test]
    fn numbers_and_text() {
        for (value, expected) in
            [(1.0, "1"), (0.126, "0.13"), (-0.001, "0"), (10.5, "10.5"), (100.0, "100")]
        {
            assert_eq!(number(value), expected);
        }
        assert_eq!(escaped("a<b & \"c\"\u{0}"), "a&lt;b &amp; \"c\" ");
    }
}
