//! A panel that shows a task's world from above, with trajectories in it.

use std::sync::Arc;

use sidestep::plane::geometry::{Circle, Point, Rect};
use sidestep::plane::points;
use sidestep::{Grid, Obstacle, PlaneTask, Robot, Trajectory, World};

use super::canvas::{Canvas, Frame, Pixel, Shape, Stroke};
use super::color::{Color, LineStyle, OBSTACLE, OBSTACLE_EDGE, TEXT, WHITE, palette};
use super::legend::{self, Entry, Mark};
use super::map_axes;
use super::outline;
use super::shading::Shading;

/// A drawn trajectory or trace.
#[derive(Debug, Clone, PartialEq)]
struct Layer {
    label: String,
    style: LineStyle,
    /// One trajectory; or the iterates of an optimizer, the earliest first.
    trajectories: Vec<Trajectory>,
    fan: bool,
    /// Whether the trajectories are shown one after the other.
    moving: bool,
}

/// A task's world from above: bounds, obstacles, grid, start and goal, and what was planned.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskPanel {
    pub(super) title: String,
    pub(super) note: String,
    world: Arc<World>,
    robot: Robot,
    ends: [Point; 2],
    layers: Vec<Layer>,
    shading: Option<Shading>,
    swept: bool,
    margin: f64,
    /// Where the margin is not kept: a place, and how far around it.
    relaxed: Vec<(Point, f64)>,
    unit: String,
    blocked: Option<Blocked>,
    colors_used: usize,
}

/// Where a trajectory is blocked.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Blocked {
    segment: [Point; 2],
    place: Point,
    obstacle: Option<usize>,
}

impl TaskPanel {
    /// The task without any trajectory, titled by its name.
    pub fn new(task: PlaneTask<'_>) -> Self {
        Self {
            title: task.name.to_owned(),
            note: String::new(),
            world: Arc::clone(task.world),
            robot: task.robot,
            ends: [task.start, task.goal],
            layers: Vec::new(),
            shading: None,
            swept: true,
            margin: 0.0,
            relaxed: Vec::new(),
            unit: String::new(),
            blocked: None,
            colors_used: 0,
        }
    }

    /// Another title; empty for none.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// A line under the title, such as length, clearance and steps.
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }

    /// The unit of the axes, such as `m`; without this, none is named.
    pub fn unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = unit.into();
        self
    }

    /// Draws how far around the robot is to stay free, along each path and at both ends; in task units.
    pub fn margin(mut self, margin: f64) -> Self {
        self.margin = margin.max(0.0);
        self
    }

    /// Marks a place that the margin is not kept within `radius` of.
    pub fn relaxed(mut self, place: Point, radius: f64) -> Self {
        self.relaxed.push((place, radius));
        self
    }

    /// Marks where a trajectory is blocked: a segment of it, a place on that, and the obstacle of this
    /// number that it meets.
    pub fn blocked(mut self, segment: [Point; 2], place: Point, obstacle: Option<usize>) -> Self {
        self.blocked = Some(Blocked { segment, place, obstacle });
        self
    }

    /// Draws a trajectory in the next colour of the palette.
    pub fn path(self, label: impl Into<String>, trajectory: &Trajectory) -> Self {
        let color = palette(self.colors_used);
        self.path_in(label, trajectory, color)
    }

    /// Draws a trajectory in a colour or style of the caller's, say the planner's in every panel.
    pub fn path_in(
        self,
        label: impl Into<String>,
        trajectory: &Trajectory,
        style: impl Into<LineStyle>,
    ) -> Self {
        self.layer(label.into(), style.into(), std::slice::from_ref(trajectory), false)
    }

    /// Draws a trajectory dashed, as one that was given up or is shown only to compare.
    pub fn dashed_path(self, label: impl Into<String>, trajectory: &Trajectory) -> Self {
        let color = palette(self.colors_used);
        self.path_in(label, trajectory, LineStyle { color, dash: Some([7.5, 5.5]) })
    }

    /// Draws the iterates of an optimizer, the earliest first, fading from light to dark.
    pub fn trace(self, label: impl Into<String>, iterates: &[Trajectory]) -> Self {
        let color = palette(self.colors_used);
        self.trace_in(label, iterates, color)
    }

    /// Draws the iterates of an optimizer in a colour of the caller's.
    pub fn trace_in(self, label: impl Into<String>, iterates: &[Trajectory], color: Color) -> Self {
        self.layer(label.into(), color.into(), iterates, true)
    }

    /// Shows the iterates of an optimizer one after the other, in a picture that can move; in others the
    /// last. Panels of as many iterates keep in step.
    pub fn motion_in(
        mut self,
        label: impl Into<String>,
        iterates: &[Trajectory],
        style: impl Into<LineStyle>,
    ) -> Self {
        self = self.layer(label.into(), style.into(), iterates, false);
        self.layers.iter_mut().rev().take(1).for_each(|layer| layer.moving = true);
        self
    }

    /// Shades the free field by a value of each point, such as its distance to the obstacles: the
    /// lowest value darkest, the highest nearly white, in steps that read as contour lines.
    pub fn shade(mut self, value: impl Fn(Point) -> f64) -> Self {
        self.shading = Some(Shading::sample(&self.world, value));
        self
    }

    /// Leaves out the area that the robot's disc sweeps along each path.
    pub fn without_sweep(mut self) -> Self {
        self.swept = false;
        self
    }

    fn layer(mut self, label: String, style: LineStyle, of: &[Trajectory], fan: bool) -> Self {
        let trajectories = of.to_vec();
        self.layers.push(Layer { label, style, trajectories, fan, moving: false });
        self.colors_used += 1;
        self
    }

    /// What the legend says.
    pub(super) fn legend(&self) -> Vec<Entry> {
        let mut entries = vec![
            Entry { mark: Mark::Start, label: "start".into() },
            Entry { mark: Mark::Goal, label: "goal".into() },
        ];
        for layer in self.layers.iter().filter(|layer| !layer.label.is_empty()) {
            let color = layer.style.color;
            let mark = if layer.fan { Mark::Fan { color } } else { Mark::Line(layer.style) };
            entries.push(Entry { mark, label: layer.label.clone() });
        }
        if !self.relaxed.is_empty() {
            let mark = Mark::Line(relaxed_style());
            entries.push(Entry { mark, label: "margin not kept".into() });
        }
        if self.blocked.is_some() {
            entries.push(Entry { mark: Mark::Blocked, label: "blocked".into() });
        }
        entries
    }

    /// Height of a drawing of this width, its axes included.
    pub(super) fn height(&self, width: f64) -> f64 {
        map_axes::height(self.world.bounds(), width)
    }

    /// Draws the world with its axes into a frame.
    pub(super) fn draw(&self, canvas: &mut Canvas, frame: Frame) {
        let world = &self.world;
        let view = View { bounds: world.bounds(), frame: map_axes::inside(world.bounds(), frame) };
        let radius = view.scale() * self.robot.radius();
        let margin = view.scale() * self.margin;
        canvas.clipped(view.frame, |canvas| {
            if let Some(shading) = &self.shading {
                canvas.shapes.push(shading.image(view.frame));
            }
            if let Some(grid) = world.grid() {
                draw_grid(canvas, &view, grid);
            }
            let met = self.blocked.and_then(|blocked| blocked.obstacle);
            for (i, obstacle) in world.obstacles().iter().enumerate() {
                draw_obstacle(canvas, &view, obstacle, met == Some(i));
            }
            // Over the obstacles, so that a collision shows.
            for layer in
                self.layers.iter().filter(|layer| self.swept && !layer.fan && !layer.moving)
            {
                draw_sweep(canvas, &view, layer, 2.0 * (radius + margin), 0.09, margin > 0.0);
                draw_sweep(canvas, &view, layer, 2.0 * radius, 0.18, radius > 0.0);
            }
            if let Some(blocked) = self.blocked {
                canvas.line(view.pixels(&blocked.segment), Stroke::new(TEXT, 7.0));
            }
            for layer in &self.layers {
                draw_layer(canvas, &view, layer);
            }
            for (place, radius) in &self.relaxed {
                let (center, radius) = (view.pixel(*place), view.scale() * radius);
                let stroke = Some(Stroke::styled(relaxed_style(), 2.5));
                canvas.shapes.push(Shape::Circle { center, radius, fill: None, stroke });
            }
            for center in self.ends.map(|p| view.pixel(p)) {
                if radius > 4.0 {
                    let stroke = Some(Stroke::new(TEXT.with_opacity(0.7), 1.25));
                    let fill = Some(TEXT.with_opacity(0.12));
                    canvas.shapes.push(Shape::Circle { center, radius, fill, stroke });
                }
                if margin > 2.0 {
                    let stroke = Stroke { dash: Some([3.0, 3.0]), ..Stroke::new(TEXT, 1.0) };
                    let (radius, stroke) = (radius + margin, Some(stroke));
                    canvas.shapes.push(Shape::Circle { center, radius, fill: None, stroke });
                }
            }
        });
        canvas.outline(view.frame.corners(), Stroke::new(OBSTACLE_EDGE, 2.0));
        map_axes::draw(canvas, world.bounds(), view.frame, &self.unit);
        // Last and not cut off: a start in a corner must be seen whole.
        legend::draw_start(canvas, view.pixel(self.ends[0]));
        legend::draw_goal(canvas, view.pixel(self.ends[1]));
        if let Some(Blocked { place, .. }) = self.blocked {
            legend::draw_cross(canvas, view.pixel(place));
        }
    }
}

/// Of the circles within which the margin is not kept.
fn relaxed_style() -> LineStyle {
    LineStyle { color: palette(1), dash: Some([2.0, 4.0]) }
}

/// The area that a disc sweeps along the layer's trajectories.
fn draw_sweep(
    canvas: &mut Canvas,
    view: &View,
    layer: &Layer,
    width: f64,
    opacity: f64,
    there: bool,
) {
    for trajectory in layer.trajectories.iter().filter(|_| there) {
        let stroke = Stroke::new(layer.style.color.with_opacity(opacity), width);
        canvas.line(view.pixels(points(trajectory)), stroke);
    }
}

fn draw_grid(canvas: &mut Canvas, view: &View, grid: &Grid) {
    let corner = |&(column, row): &(u32, u32)| {
        view.pixel(grid.cell_rect(i64::from(column), i64::from(row)).min)
    };
    let rings = outline::rings(grid);
    let rings: Vec<Vec<Pixel>> =
        rings.iter().map(|ring| ring.iter().map(corner).collect()).collect();
    canvas.shapes.push(Shape::Area { rings: rings.clone(), fill: OBSTACLE });
    // The edges of cells about as small as a pixel would only blur the map.
    if grid.resolution() * view.scale() >= 1.5 {
        for ring in rings {
            canvas.outline(ring, Stroke::new(OBSTACLE_EDGE, 1.0));
        }
    }
}

fn draw_obstacle(canvas: &mut Canvas, view: &View, obstacle: &Obstacle, met: bool) {
    let edge = if met { Stroke::new(TEXT, 3.0) } else { Stroke::new(OBSTACLE_EDGE, 1.0) };
    let corners = match obstacle {
        Obstacle::Circle(Circle { center, radius }) => {
            canvas.shapes.push(Shape::Circle {
                center: view.pixel(*center),
                radius: radius * view.scale(),
                fill: Some(OBSTACLE),
                stroke: Some(edge),
            });
            return;
        }
        Obstacle::Rect(rect) => view.pixels(&rect.corners()),
        Obstacle::Polygon(polygon) => view.pixels(polygon.vertices()),
    };
    canvas.area(corners.clone(), OBSTACLE);
    canvas.outline(corners, edge);
}

fn draw_layer(canvas: &mut Canvas, view: &View, layer: &Layer) {
    if layer.moving {
        let frames: Vec<Vec<Pixel>> =
            layer.trajectories.iter().map(|trajectory| view.pixels(points(trajectory))).collect();
        let rim = Stroke::new(WHITE.with_opacity(0.85), 4.5);
        for stroke in [rim, Stroke::styled(layer.style, 2.5)] {
            canvas.shapes.push(Shape::Moving { frames: frames.clone(), stroke });
        }
        return;
    }
    let last = layer.trajectories.len().saturating_sub(1);
    for (i, trajectory) in layer.trajectories.iter().enumerate() {
        let line = view.pixels(points(trajectory));
        if layer.fan {
            let age = i as f64 / last.max(1) as f64;
            let opacity = if i == last { 1.0 } else { 0.12 + 0.5 * age };
            let width = if i == last { 2.5 } else { 1.25 };
            canvas.line(line, Stroke::new(layer.style.color.with_opacity(opacity), width));
        } else {
            // A white rim keeps the line legible where it crosses an obstacle or another line.
            canvas.line(line.clone(), Stroke::new(WHITE.with_opacity(0.85), 4.5));
            canvas.line(line, Stroke::styled(layer.style, 2.5));
        }
    }
}

/// From task units, y upwards, to pixels, y downwards.
struct View {
    bounds: Rect,
    frame: Frame,
}

impl View {
    fn scale(&self) -> f64 {
        self.frame.width / self.bounds.size()[0]
    }

    fn pixel(&self, p: Point) -> Pixel {
        [
            self.frame.x + (p[0] - self.bounds.min[0]) * self.scale(),
            self.frame.y + (self.bounds.max[1] - p[1]) * self.scale(),
        ]
    }

    /// The finite ones of some points.
    fn pixels(&self, points: &[Point]) -> Vec<Pixel> {
        let finite = points.iter().filter(|p| p[0].is_finite() && p[1].is_finite());
        finite.map(|&p| self.pixel(p)).collect()
    }
}
