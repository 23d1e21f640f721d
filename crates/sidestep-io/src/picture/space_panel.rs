//! A panel that shows a robot with joints and what is around it, seen from far away.

use std::sync::Arc;

use sidestep::space::{Vector, World};

use super::canvas::{Canvas, Frame, Shape, Stroke};
use super::color::{AXIS, Color, OBSTACLE, OBSTACLE_EDGE, WHITE};
use super::legend::{Entry, Mark};
use super::projection::{Outline, View, outlines};

/// A robot in one configuration: spheres, each a centre and a radius in metres.
#[derive(Debug, Clone, PartialEq)]
struct Figure {
    spheres: Vec<(Vector, f64)>,
    color: Color,
}

/// A robot in space and its surroundings from one side.
#[derive(Debug, Clone, PartialEq)]
pub struct SpacePanel {
    pub(super) title: String,
    view: View,
    world: Arc<World>,
    figures: Vec<Figure>,
    lines: Vec<(Vec<Vector>, Color)>,
    labels: Vec<(String, Color)>,
    low: [f64; 2],
    high: [f64; 2],
}

/// What is kept free around everything, as a share of it.
const RIM: f64 = 0.04;

impl SpacePanel {
    /// The surroundings alone, titled by the view.
    pub fn new(world: &Arc<World>, view: View) -> Self {
        Self {
            title: view.name.to_owned(),
            view,
            world: Arc::clone(world),
            figures: Vec::new(),
            lines: Vec::new(),
            labels: Vec::new(),
            low: [f64::INFINITY; 2],
            high: [f64::NEG_INFINITY; 2],
        }
    }

    /// Another title.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Draws the robot in one configuration: its spheres, centre and radius in metres. The picture is as large as all
    /// configurations need it to be.
    pub fn figure(mut self, spheres: &[(Vector, f64)], color: Color) -> Self {
        for &(center, radius) in spheres {
            let [x, y] = self.view.project(center);
            self.low = [self.low[0].min(x - radius), self.low[1].min(y - radius)];
            self.high = [self.high[0].max(x + radius), self.high[1].max(y + radius)];
        }
        self.figures.push(Figure { spheres: spheres.to_vec(), color });
        self
    }

    /// Draws a line through points, such as the way of a tool.
    pub fn line(mut self, points: &[Vector], color: Color) -> Self {
        self.lines.push((points.to_vec(), color));
        self
    }

    /// Says in the legend what a colour stands for.
    pub fn label(mut self, label: impl Into<String>, color: Color) -> Self {
        self.labels.push((label.into(), color));
        self
    }

    pub(super) fn legend(&self) -> Vec<Entry> {
        let entry = |(label, color): &(String, Color)| Entry {
            mark: Mark::Dot { color: *color },
            label: label.clone(),
        };
        self.labels.iter().map(entry).collect()
    }

    /// The shown part of the plane: least and greatest coordinates, metres. Obstacles count as far as they are within
    /// half a robot's size of it.
    fn shown(&self) -> [[f64; 2]; 2] {
        let (mut low, mut high) = (self.low, self.high);
        if low[0] > high[0] {
            (low, high) = ([-1.0; 2], [1.0; 2]);
        }
        let size = (high[0] - low[0]).max(high[1] - low[1]).max(1e-3);
        let (least, most) = (low.map(|v| v - 0.5 * size), high.map(|v| v + 0.5 * size));
        for (pose, shape) in self.world.objects().iter().flat_map(|object| object.shapes()) {
            for outline in outlines(&self.view, pose, shape) {
                let points = match outline {
                    Outline::Polygon(points) => points,
                    Outline::Disc([x, y], r) => vec![[x - r, y - r], [x + r, y + r]],
                };
                for p in points {
                    for k in 0..2 {
                        let v = p[k].clamp(least[k], most[k]);
                        (low[k], high[k]) = (low[k].min(v), high[k].max(v));
                    }
                }
            }
        }
        let rim = RIM * (high[0] - low[0]).max(high[1] - low[1]);
        [low.map(|v| v - rim), high.map(|v| v + rim)]
    }

    /// Height of the drawing over its width.
    pub(super) fn aspect(&self) -> f64 {
        let [low, high] = self.shown();
        ((high[1] - low[1]) / (high[0] - low[0])).clamp(0.4, 1.4)
    }

    /// Draws everything in the middle of a frame.
    pub(super) fn draw(&self, canvas: &mut Canvas, frame: Frame) {
        let [low, high] = self.shown();
        let scale = (frame.width / (high[0] - low[0])).min(frame.height / (high[1] - low[1]));
        let middle = [0, 1].map(|k| 0.5 * (low[k] + high[k]));
        let pixel = |[x, y]: [f64; 2]| {
            [
                frame.x + 0.5 * frame.width + (x - middle[0]) * scale,
                frame.y + 0.5 * frame.height - (y - middle[1]) * scale,
            ]
        };
        canvas.clipped(frame, |canvas| {
            for object in self.world.objects() {
                for (pose, shape) in object.shapes() {
                    for outline in outlines(&self.view, pose, shape) {
                        draw_obstacle(canvas, outline, scale, &pixel);
                    }
                }
            }
            for figure in &self.figures {
                let mut spheres = figure.spheres.clone();
                spheres.sort_by(|a, b| self.view.depth(a.0).total_cmp(&self.view.depth(b.0)));
                let rim = figure.color.mix(Color::hex(0x000000), 0.35);
                let stroke = Stroke::new(rim.with_opacity(0.55 * figure.color.opacity), 0.6);
                for (center, radius) in spheres {
                    canvas.shapes.push(Shape::Circle {
                        center: pixel(self.view.project(center)),
                        radius: radius * scale,
                        fill: Some(figure.color),
                        stroke: Some(stroke),
                    });
                }
            }
            for (points, color) in &self.lines {
                let points: Vec<_> = points.iter().map(|&p| pixel(self.view.project(p))).collect();
                canvas.line(points.clone(), Stroke::new(WHITE.with_opacity(0.85), 3.5));
                canvas.line(points, Stroke::new(*color, 1.8));
            }
        });
        canvas.outline(frame.corners(), Stroke::new(AXIS, 1.0));
    }
}

fn draw_obstacle(
    canvas: &mut Canvas,
    outline: Outline,
    scale: f64,
    pixel: &impl Fn([f64; 2]) -> [f64; 2],
) {
    let (fill, edge) = (OBSTACLE.with_opacity(0.45), Stroke::new(OBSTACLE_EDGE, 0.8));
    match outline {
        Outline::Disc(center, radius) => canvas.shapes.push(Shape::Circle {
            center: pixel(center),
            radius: radius * scale,
            fill: Some(fill),
            stroke: Some(edge),
        }),
        Outline::Polygon(points) => {
            let points: Vec<_> = points.into_iter().map(pixel).collect();
            canvas.area(points.clone(), fill);
            canvas.outline(points, edge);
        }
    }
}
