//! Colours: a palette that colour-blind readers can tell apart, and the greys of the furniture.
//!
//! Source: M. Okabe, K. Ito, "Color Universal Design", 2008 (jfly.uni-koeln.de/color). Its yellow is left
//! out, too faint for a line on white; blue and vermillion come first, the pair that differs most.

/// An sRGB colour with opacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Color {
    /// Red, green and blue.
    pub rgb: [u8; 3],
    /// Opacity in `[0, 1]`.
    pub opacity: f64,
}

impl Color {
    /// An opaque colour from `0xRRGGBB`.
    pub const fn hex(value: u32) -> Self {
        Self { rgb: [(value >> 16) as u8, (value >> 8) as u8, value as u8], opacity: 1.0 }
    }

    /// The same colour at another opacity.
    pub const fn with_opacity(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// The colour at fraction `t` of the way to `other`, both taken as opaque.
    pub fn mix(self, other: Self, t: f64) -> Self {
        let channel = |i: usize| {
            let (a, b) = (f64::from(self.rgb[i]), f64::from(other.rgb[i]));
            (a + t.clamp(0.0, 1.0) * (b - a)).round() as u8
        };
        Self { rgb: [channel(0), channel(1), channel(2)], opacity: 1.0 }
    }
}

const PALETTE: [Color; 7] = [
    Color::hex(0x0072b2), // blue
    Color::hex(0xd55e00), // vermillion
    Color::hex(0x009e73), // bluish green
    Color::hex(0xcc79a7), // reddish purple
    Color::hex(0xe69f00), // orange
    Color::hex(0x56b4e9), // sky blue
    Color::hex(0x333333), // nearly black
];

/// Colour number `index` of the palette, from the start again after the last.
pub fn palette(index: usize) -> Color {
    PALETTE[index % PALETTE.len()]
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineStyle {
    /// The line's colour.
    pub color: Color,
    /// Lengths of dash and gap, in pixels; `None` for a whole line.
    pub dash: Option<[f64; 2]>,
}

impl From<Color> for LineStyle {
    fn from(color: Color) -> Self {
        Self { color, dash: None }
    }
}

/// The style of the planner of that name, wherever it is drawn: a colour that shows on white and on
/// black, and a dash. Settings after a colon change nothing.
pub fn planner_style(name: &str) -> LineStyle {
    const DASHED: Option<[f64; 2]> = Some([8.0, 4.5]);
    const DOTTED: Option<[f64; 2]> = Some([2.0, 4.5]);
    const GREY: Color = Color::hex(0x737373);
    let (color, dash) = match name.split(':').next().unwrap_or(name) {
        "sidestep-1" => (PALETTE[0], None),
        "sidestep-1-small" => (PALETTE[0], DASHED),
        "learned" => (PALETTE[0], DOTTED),
        "gd" => (PALETTE[1], None),
        "momentum" => (PALETTE[1], DASHED),
        "stomp" => (PALETTE[1], DOTTED),
        "auto" => (PALETTE[2], None),
        "shortest-path" => (GREY, DASHED),
        "rrt-connect" => (PALETTE[2], DOTTED),
        "adam" => (PALETTE[4], None),
        "chomp" => (PALETTE[3], None),
        "lbfgs" => (PALETTE[3], DASHED),
        "lm" => (PALETTE[3], DOTTED),
        _ => (PALETTE[5], None),
    };
    LineStyle { color, dash }
}

pub(super) const WHITE: Color = Color::hex(0xffffff);
/// Titles and labels.
pub(super) const TEXT: Color = Color::hex(0x1f2933);
/// Tick labels and other secondary text.
pub(super) const QUIET: Color = Color::hex(0x616e7c);
/// Axes and ticks.
pub(super) const AXIS: Color = Color::hex(0x9aa5b1);
/// Grid lines of charts.
pub(super) const GRID_LINE: Color = Color::hex(0xe4e7eb);
/// Obstacles and occupied cells.
pub(super) const OBSTACLE: Color = Color::hex(0x9fabb7);
/// Obstacles' outlines, where overlapping ones meet.
pub(super) const OBSTACLE_EDGE: Color = Color::hex(0x4a5763);
/// Low and high end of the shading of a field.
pub(super) const SHADE: [Color; 2] = [Color::hex(0xbcd6ec), Color::hex(0xfcfdfe)];
