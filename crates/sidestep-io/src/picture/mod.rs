//! Pictures of tasks, plans and training runs, as SVG text and PNG bytes.
//!
//! ```
//! use sidestep_io::picture::{BandPoint, Chart, Picture};
//!
//! let curve: Vec<BandPoint> = (0..50)
//!     .map(|i| {
//!         let mean = 1.0 - (-f64::from(i) / 12.0).exp();
//!         BandPoint { x: f64::from(i) * 1e4, mean, low: mean - 0.05, high: mean + 0.05 }
//!     })
//!     .collect();
//! let chart = Chart::new("Training", "environment steps", "success").y_range(0.0, 1.0);
//! let picture = Picture::new().panel(chart.curve("learned", &curve));
//! assert!(picture.to_svg().starts_with("<svg"));
//! assert!(picture.to_png(2.0)?.starts_with(b"\x89PNG"));
//! # Ok::<(), sidestep_io::FormatError>(())
//! ```
//!
//! A picture is a sheet of panels, each a task seen from above ([`TaskPanel`]), a robot with joints from one side
//! ([`SpacePanel`]) or a [`Chart`]. All are
//! laid out as one list of shapes, from which the SVG and the PNG are written; the font is built in.

mod axis;
mod canvas;
mod chart;
mod clip;
mod color;
mod font;
mod legend;
mod map_axes;
mod moving;
mod outline;
mod plot;
mod projection;
mod raster;
mod shading;
mod space_panel;
mod svg;
mod task_panel;

pub use chart::{BandPoint, Bar, Chart};
pub use color::{Color, LineStyle, palette, planner_style};
pub use projection::View;
pub use space_panel::SpacePanel;
pub use task_panel::TaskPanel;

use crate::error::FormatError;
use canvas::{Anchor, Canvas, Frame, Shape, Text};
use color::TEXT;
use font::Weight;
use legend::Entry;

const MARGIN: f64 = 20.0;
const GAP: f64 = 28.0;
const TITLE_SIZE: f64 = 18.0;
const TITLE_HEIGHT: f64 = 36.0;
const PANEL_TITLE_SIZE: f64 = 13.5;
const PANEL_TITLE_HEIGHT: f64 = 26.0;
const NOTE_SIZE: f64 = 11.0;
const NOTE_HEIGHT: f64 = 16.0;
const LEGEND_GAP: f64 = 10.0;

/// One part of a picture.
#[derive(Debug, Clone, PartialEq)]
pub enum Panel {
    /// A task from above.
    Task(Box<TaskPanel>),
    /// A chart.
    Chart(Box<Chart>),
    /// A robot with joints from one side.
    Space(Box<SpacePanel>),
}

impl From<TaskPanel> for Panel {
    fn from(panel: TaskPanel) -> Self {
        Self::Task(Box::new(panel))
    }
}

impl From<Chart> for Panel {
    fn from(chart: Chart) -> Self {
        Self::Chart(Box::new(chart))
    }
}

impl From<SpacePanel> for Panel {
    fn from(panel: SpacePanel) -> Self {
        Self::Space(Box::new(panel))
    }
}

impl Panel {
    fn title(&self) -> &str {
        match self {
            Self::Task(panel) => &panel.title,
            Self::Chart(chart) => &chart.title,
            Self::Space(panel) => &panel.title,
        }
    }

    /// What stands under the title.
    fn note(&self) -> &str {
        match self {
            Self::Task(panel) => &panel.note,
            Self::Chart(_) | Self::Space(_) => "",
        }
    }

    fn legend(&self) -> Vec<Entry> {
        match self {
            Self::Task(panel) => panel.legend(),
            Self::Chart(chart) => chart.legend(),
            Self::Space(panel) => panel.legend(),
        }
    }

    /// Height of the panel's body in a column of `width`.
    fn height(&self, width: f64) -> f64 {
        match self {
            Self::Task(panel) => panel.height(width),
            Self::Chart(_) => 0.66 * width,
            Self::Space(panel) => width * panel.aspect(),
        }
    }

    /// Draws the body.
    fn draw(&self, canvas: &mut Canvas, frame: Frame) {
        match self {
            Self::Task(panel) => panel.draw(canvas, frame),
            Self::Chart(chart) => chart.draw(canvas, frame),
            Self::Space(panel) => panel.draw(canvas, frame),
        }
    }
}

/// Panels side by side under one title.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Picture {
    title: String,
    columns: Option<usize>,
    panel_width: Option<f64>,
    panels: Vec<Panel>,
}

impl Picture {
    /// An empty picture.
    pub fn new() -> Self {
        Self::default()
    }

    /// A title over all panels.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Adds a panel: a [`TaskPanel`], a [`SpacePanel`] or a [`Chart`].
    pub fn panel(mut self, panel: impl Into<Panel>) -> Self {
        self.panels.push(panel.into());
        self
    }

    /// The number of panels in a row, at least 1; without this, up to three, and two of four.
    pub fn columns(mut self, columns: usize) -> Self {
        self.columns = Some(columns.max(1));
        self
    }

    /// The width of a panel in units of the SVG, held to 120 to 2000; without this, 640 for a lone
    /// column, 420 for two and 320 for more.
    pub fn panel_width(mut self, width: f64) -> Self {
        self.panel_width = Some(width.clamp(120.0, 2000.0));
        self
    }

    /// The picture as an SVG document.
    pub fn to_svg(&self) -> String {
        svg::write(&self.layout())
    }

    /// The picture as a PNG with `scale` pixels to a unit of the SVG; 2 suits most screens.
    ///
    /// # Errors
    /// If a side would be over 16384 pixels.
    pub fn to_png(&self, scale: f64) -> Result<Vec<u8>, FormatError> {
        raster::write(&self.layout(), scale)
    }

    /// The picture as a PNG that moves (APNG), where [`TaskPanel::motion_in`] has something to move; at
    /// `scale` pixels to a unit of the SVG.
    ///
    /// # Errors
    /// As [`Picture::to_png`].
    pub fn to_moving_png(&self, scale: f64) -> Result<Vec<u8>, FormatError> {
        raster::write_moving(&self.layout(), scale)
    }

    fn layout(&self) -> Canvas {
        let columns = self.columns.unwrap_or(if self.panels.len() == 4 { 2 } else { 3 });
        let columns = columns.min(self.panels.len()).max(1);
        let panel_width = self.panel_width.unwrap_or(match columns {
            1 => 640.0,
            2 => 420.0,
            _ => 320.0,
        });
        let inner_width = columns as f64 * (panel_width + GAP) - GAP;
        let mut canvas = Canvas { width: inner_width + 2.0 * MARGIN, ..Canvas::default() };
        let mut y = MARGIN;
        if !self.title.is_empty() {
            let size = (TITLE_SIZE, Weight::Bold);
            heading(&mut canvas, &self.title, size, [MARGIN, y], inner_width);
            y += TITLE_HEIGHT;
        }
        let shared = shared_legend(&self.panels);
        for (i, row) in self.panels.chunks(columns).enumerate() {
            y += if i > 0 { GAP } else { 0.0 };
            let titled = row.iter().any(|panel| !panel.title().is_empty());
            let noted = row.iter().any(|panel| !panel.note().is_empty());
            let note_y = y + if titled { PANEL_TITLE_HEIGHT } else { 0.0 };
            let body_y = note_y + if noted { NOTE_HEIGHT } else { 0.0 };
            let height = row.iter().map(|panel| panel.height(panel_width)).fold(0.0, f64::max);
            let mut row_bottom = body_y + height;
            for (column, panel) in row.iter().enumerate() {
                let x = MARGIN + column as f64 * (panel_width + GAP);
                let bold = Weight::Bold;
                heading(&mut canvas, panel.title(), (PANEL_TITLE_SIZE, bold), [x, y], panel_width);
                let (size, at) = ((NOTE_SIZE, Weight::Regular), [x, note_y - 5.0]);
                heading(&mut canvas, panel.note(), size, at, panel_width);
                panel.draw(&mut canvas, Frame { x, y: body_y, width: panel_width, height });
                if shared.is_none() {
                    let entries = panel.legend();
                    let legend_y = body_y + height + LEGEND_GAP;
                    legend::draw(&mut canvas, &entries, [x, legend_y], panel_width);
                    let legend_height = legend::height(&entries, panel_width);
                    row_bottom = row_bottom.max(legend_y + legend_height);
                }
            }
            y = row_bottom;
        }
        if let Some(entries) = shared.filter(|entries| !entries.is_empty()) {
            y += LEGEND_GAP;
            legend::draw(&mut canvas, &entries, [MARGIN, y], inner_width);
            y += legend::height(&entries, inner_width);
        }
        canvas.height = y + MARGIN;
        canvas
    }
}

/// Text centred over `width` from `at`, its upper left corner; smaller and then cut if it would
/// not fit.
fn heading(
    canvas: &mut Canvas,
    text: &str,
    (size, weight): (f64, Weight),
    at: [f64; 2],
    width: f64,
) {
    if text.is_empty() {
        return;
    }
    let needed = font::width(text, size, weight);
    let fitting = size * (width / needed.max(1.0)).clamp(0.55, 1.0);
    canvas.shapes.push(Shape::Text(Text {
        at: [at[0] + width / 2.0, at[1] + size],
        text: font::cut(text, fitting, weight, width),
        size: fitting,
        weight,
        color: TEXT,
        anchor: Anchor::Middle,
        upwards: false,
    }));
}

/// One legend for all panels, if no label has two marks and no mark two labels.
fn shared_legend(panels: &[Panel]) -> Option<Vec<Entry>> {
    let mut entries: Vec<Entry> = Vec::new();
    for entry in panels.iter().flat_map(Panel::legend) {
        let known = entries.iter().find(|e| e.label == entry.label || e.mark == entry.mark);
        match known {
            None => entries.push(entry),
            Some(known) if *known == entry => {}
            Some(_) => return None,
        }
    }
    Some(entries)
}
