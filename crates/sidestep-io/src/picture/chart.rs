//! A panel with a chart: curves with a band around them, points, or bars.

use sidestep::plane::geometry::Point;

use super::axis::{Axis, Scale};
use super::canvas::{Anchor, Canvas, Frame, Shape, Stroke, Text};
use super::color::{AXIS, Color, GRID_LINE, LineStyle, QUIET, TEXT, palette};
use super::font::{self, Weight};
use super::legend::{self, Entry, Mark};
use super::plot::Plot;

/// Dash and gap of a level's line.
const LEVEL_DASH: Option<[f64; 2]> = Some([4.5, 3.3]);

/// A point of a curve with the spread around it; the band is left out where `low` and `high` are `mean`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandPoint {
    /// Place on the x axis.
    pub x: f64,
    /// The curve's value.
    pub mean: f64,
    /// The band's lower end.
    pub low: f64,
    /// The band's upper end.
    pub high: f64,
}

/// A bar with its interval; no interval is drawn where `low` and `high` are `value`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// The bar's length.
    pub value: f64,
    /// The interval's lower end.
    pub low: f64,
    /// The interval's upper end.
    pub high: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum Marks {
    Curve(Vec<BandPoint>),
    Points(Vec<Point>),
    Bars(Vec<Bar>),
    /// A dashed line across the chart.
    Level(f64),
}

#[derive(Debug, Clone, PartialEq)]
struct Series {
    label: String,
    color: Color,
    marks: Marks,
}

/// A chart with one x and one y axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chart {
    pub(super) title: String,
    x_label: String,
    y_label: String,
    x_scale: Scale,
    y_scale: Scale,
    y_range: Option<[f64; 2]>,
    categories: Vec<String>,
    series: Vec<Series>,
    colors_used: usize,
}

const TICK_SIZE: f64 = 11.0;
const LABEL_SIZE: f64 = 12.0;

impl Chart {
    /// An empty chart.
    pub fn new(
        title: impl Into<String>,
        x_label: impl Into<String>,
        y_label: impl Into<String>,
    ) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            ..Self::default()
        }
    }

    /// Spaces the x axis by powers of ten; points at 0 and below are left out.
    pub fn log_x(mut self) -> Self {
        self.x_scale = Scale::Log;
        self
    }

    /// Spaces the y axis by powers of ten; points at 0 and below are left out.
    pub fn log_y(mut self) -> Self {
        self.y_scale = Scale::Log;
        self
    }

    /// Makes the y axis reach from `low` to `high`, such as 0 to 1 for a success rate; what lies
    /// outside is cut off. Without this, the axis holds all values.
    pub fn y_range(mut self, low: f64, high: f64) -> Self {
        self.y_range = Some([low, high]);
        self
    }

    /// Draws a curve and its band.
    pub fn curve(self, label: impl Into<String>, points: &[BandPoint]) -> Self {
        let color = palette(self.colors_used);
        self.curve_in(label, points, color)
    }

    /// Draws a curve and its band in a colour of the caller's.
    pub fn curve_in(self, label: impl Into<String>, points: &[BandPoint], color: Color) -> Self {
        self.add(label.into(), color, Marks::Curve(points.to_vec()))
    }

    /// Draws points `[x, y]`.
    pub fn points(self, label: impl Into<String>, points: &[Point]) -> Self {
        let color = palette(self.colors_used);
        self.add(label.into(), color, Marks::Points(points.to_vec()))
    }

    /// Names the groups of bars along the x axis.
    pub fn categories(mut self, names: &[&str]) -> Self {
        self.categories = names.iter().map(|&name| name.to_owned()).collect();
        self
    }

    /// Draws one bar in each category, beside those of the other series.
    pub fn bars(self, label: impl Into<String>, bars: &[Bar]) -> Self {
        let color = palette(self.colors_used);
        self.add(label.into(), color, Marks::Bars(bars.to_vec()))
    }

    /// Draws a dashed line at a value of the y axis, such as a published result.
    pub fn level(mut self, label: impl Into<String>, y: f64) -> Self {
        let series = Series { label: label.into(), color: QUIET, marks: Marks::Level(y) };
        self.series.push(series);
        self
    }

    fn add(mut self, label: String, color: Color, marks: Marks) -> Self {
        self.series.push(Series { label, color, marks });
        self.colors_used += 1;
        self
    }

    /// What the legend says.
    pub(super) fn legend(&self) -> Vec<Entry> {
        let entry = |series: &Series| {
            let color = series.color;
            let mark = match series.marks {
                Marks::Curve(_) => Mark::Line(color.into()),
                Marks::Level(_) => Mark::Line(LineStyle { color, dash: LEVEL_DASH }),
                Marks::Points(_) => Mark::Dot { color },
                Marks::Bars(_) => Mark::Box { color },
            };
            Entry { mark, label: series.label.clone() }
        };
        self.series.iter().filter(|series| !series.label.is_empty()).map(entry).collect()
    }

    fn x_axis(&self, most_ticks: usize) -> Axis {
        if !self.categories.is_empty() {
            return Axis::categories(&self.categories);
        }
        let values = self.series.iter().flat_map(|series| -> Vec<f64> {
            match &series.marks {
                Marks::Curve(points) => points.iter().map(|p| p.x).collect(),
                Marks::Points(points) => points.iter().map(|p| p[0]).collect(),
                Marks::Bars(_) | Marks::Level(_) => Vec::new(),
            }
        });
        let scattered = self.series.iter().any(|series| matches!(series.marks, Marks::Points(_)));
        Axis::new(self.x_scale, values, most_ticks, scattered)
    }

    fn y_axis(&self, most_ticks: usize) -> Axis {
        let values = self.series.iter().flat_map(|series| -> Vec<f64> {
            match &series.marks {
                Marks::Curve(points) => {
                    points.iter().flat_map(|p| [p.mean, p.low, p.high]).collect()
                }
                Marks::Points(points) => points.iter().map(|p| p[1]).collect(),
                Marks::Bars(bars) => {
                    let ends = bars.iter().flat_map(|bar| [bar.value, bar.low, bar.high]);
                    ends.chain([0.0]).collect()
                }
                Marks::Level(y) => vec![*y],
            }
        });
        match self.y_range {
            Some(ends) => Axis::new(self.y_scale, ends.into_iter(), most_ticks, false),
            None => Axis::new(self.y_scale, values, most_ticks, true),
        }
    }

    /// Draws the chart into a frame that holds its axes and labels too.
    pub(super) fn draw(&self, canvas: &mut Canvas, frame: Frame) {
        let y_axis = self.y_axis((frame.height / 45.0) as usize);
        let x_axis = self.x_axis((frame.width / 70.0) as usize);
        let tick_width =
            |(_, label): &(f64, String)| font::width(label, TICK_SIZE, Weight::Regular);
        let widest = y_axis.ticks.iter().map(tick_width).fold(0.0, f64::max);
        let left = widest + 10.0 + if self.y_label.is_empty() { 0.0 } else { 20.0 };
        let below = 20.0 + if self.x_label.is_empty() { 0.0 } else { 20.0 };
        // Half of the last tick's label sticks out on the right.
        let right = x_axis.ticks.last().map_or(0.0, |tick| tick_width(tick) / 2.0).min(20.0);
        let plot = Frame {
            x: frame.x + left,
            y: frame.y + 6.0,
            width: (frame.width - left - right).max(1.0),
            height: (frame.height - below - 6.0).max(1.0),
        };
        let plotted = Plot { frame: plot, x: x_axis, y: y_axis };
        self.draw_axes(canvas, &plotted, frame);
        // A little over the frame, so that a curve along its edge keeps its full width.
        let clip = Frame {
            x: plot.x - 2.0,
            y: plot.y - 2.0,
            width: plot.width + 4.0,
            height: plot.height + 4.0,
        };
        canvas.clipped(clip, |canvas| self.draw_series(canvas, &plotted));
    }

    fn draw_axes(&self, canvas: &mut Canvas, plot: &Plot, outer: Frame) {
        let frame = plot.frame;
        for (value, label) in &plot.y.ticks {
            let y = frame.bottom() - plot.y.held(*value) * frame.height;
            canvas.line(vec![[frame.x, y], [frame.right(), y]], Stroke::new(GRID_LINE, 1.0));
            let place = [frame.x - 7.0, y + 0.36 * TICK_SIZE];
            canvas.text(place, &**label, TICK_SIZE, QUIET, Anchor::End);
        }
        let axis = Stroke::new(AXIS, 1.25);
        let base = frame.bottom();
        for (value, label) in &plot.x.ticks {
            let x = frame.x + plot.x.held(*value) * frame.width;
            if self.categories.is_empty() {
                canvas.line(vec![[x, base], [x, base + 4.0]], axis);
            }
            let room = frame.width / plot.x.ticks.len() as f64;
            let label = font::cut(label, TICK_SIZE, Weight::Regular, room.max(40.0));
            canvas.text([x, base + 17.0], label, TICK_SIZE, QUIET, Anchor::Middle);
        }
        canvas.line(vec![[frame.x, base], [frame.right(), base]], axis);
        let middle = frame.x + frame.width / 2.0;
        let place = [middle, outer.bottom() - 4.0];
        canvas.text(place, &*self.x_label, LABEL_SIZE, TEXT, Anchor::Middle);
        canvas.shapes.push(Shape::Text(Text {
            at: [outer.x + LABEL_SIZE, frame.y + frame.height / 2.0],
            text: self.y_label.clone(),
            size: LABEL_SIZE,
            weight: Weight::Regular,
            color: TEXT,
            anchor: Anchor::Middle,
            upwards: true,
        }));
    }

    fn draw_series(&self, canvas: &mut Canvas, plot: &Plot) {
        // All bands lie under all curves.
        for series in &self.series {
            if let Marks::Curve(points) = &series.marks {
                plot.band(canvas, points, series.color.with_opacity(0.18));
            }
        }
        let groups = self.series.iter().filter(|s| matches!(s.marks, Marks::Bars(_))).count();
        let mut group = 0;
        for series in &self.series {
            match &series.marks {
                Marks::Curve(points) => plot.curve(canvas, points, series.color),
                Marks::Points(points) => {
                    for at in points.iter().filter_map(|&p| plot.pixel(p)) {
                        legend::dot(canvas, at, 4.0, series.color.with_opacity(0.85));
                    }
                }
                Marks::Bars(bars) => {
                    plot.bars(canvas, bars, series.color, group, groups);
                    group += 1;
                }
                Marks::Level(y) => {
                    if let Some(fraction) = plot.y.fraction(*y) {
                        let y = plot.frame.bottom() - fraction * plot.frame.height;
                        let ends = vec![[plot.frame.x, y], [plot.frame.right(), y]];
                        let style = LineStyle { color: series.color, dash: LEVEL_DASH };
                        canvas.line(ends, Stroke::styled(style, 1.5));
                    }
                }
            }
        }
    }
}
