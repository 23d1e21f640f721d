//! Optimizers at work in the plane as a page of its own: one HTML file without anything from elsewhere, in which planners stand
//! side by side, with a slider over iterations and curves that follow it.
//!
//! Names and numbers of the input stand in the page as JSON that is read as data and shown as text, never as code.

use serde_json::{Value, json};
use sidestep::plane::geometry::{Point, Rect};
use sidestep::{Grid, Obstacle, PlaneTask, Trajectory};

use crate::picture::planner_style;

mod attempt;
mod bench;
mod blocked;

pub use attempt::{far, replay, run};
pub use bench::{BenchPage, BenchRow, FailedTask};
pub use blocked::blocked;

const PAGE: &str = include_str!("replay.html");

/// Places of the longer side at which distances are told.
const FIELD_SIDE: usize = 96;
/// Most cells of a grid's side that a page holds; a larger map is drawn coarser, obstacles first.
const GRID_SIDE: usize = 512;
/// Most frames of all planners together, which keeps a page under 300 kB.
pub const MOST_FRAMES: usize = 400;
const DIGITS: &[u8; 62] = b"0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";

/// What a page shows.
#[derive(Debug, Clone)]
pub struct Replay<'a> {
    /// Over everything.
    pub title: String,
    /// Parts of the line under it.
    pub lines: Vec<String>,
    /// What was asked.
    pub task: PlaneTask<'a>,
    /// Width of the clearance cost's hinge, in task units, above 0.
    pub epsilon: f64,
    /// The shortest path, drawn faint.
    pub shortest: Option<Trajectory>,
    /// The planners, from left to right.
    pub runs: Vec<Run>,
    /// Most frames of all planners together, such as [`MOST_FRAMES`].
    pub most_frames: usize,
}

/// What one planner did.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Run {
    /// The planner, as it was named.
    pub planner: String,
    /// What came out, in a sentence.
    pub text: String,
    /// Its iterates, and the plan or the last attempt.
    pub frames: Vec<Frame>,
    /// Where the last frame is blocked.
    pub blocked: Option<Block>,
}

/// Where a trajectory meets something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// The segment, from 0.
    pub segment: usize,
    /// A place on it.
    pub place: Point,
    /// The number of the obstacle, if it is one of the world's shapes.
    pub obstacle: Option<usize>,
}

/// One iterate.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Such as `12` or `start 2, 12`.
    pub label: String,
    /// U and its obstacles' part, where they are known.
    pub costs: Option<[f64; 2]>,
    /// Least distance of the robot to obstacles and bounds, in task units; negative where it is in one.
    pub clearance: f64,
    /// Whether the certificate passes it.
    pub free: bool,
    /// From start to goal, in task units.
    pub trajectory: Trajectory,
}

impl Replay<'_> {
    /// The page; `distance` is how far a place is from the obstacles, for a point robot, in task units.
    pub fn to_html(&self, distance: impl Fn(Point) -> f64) -> String {
        assembled(PAGE, &self.data(distance))
    }

    /// What the page shows, as it stands in the page; `distance` as for [`Self::to_html`].
    pub fn data(&self, distance: impl Fn(Point) -> f64) -> Value {
        let world = self.task.world;
        let bounds = world.bounds();
        let round = Rounding::of(bounds.extent());
        let shapes: Vec<Value> = world.obstacles().iter().map(|shape| round.shape(shape)).collect();
        json!({
            "title": self.title,
            "lines": self.lines,
            "world": {
                "bounds": round.all(&[bounds.min[0], bounds.min[1], bounds.max[0], bounds.max[1]]),
                "radius": self.task.robot.radius(),
                "epsilon": self.epsilon,
                "ends": [round.point(self.task.start), round.point(self.task.goal)],
                "obstacles": shapes,
                "grid": world.grid().map(grid),
                "field": field(bounds, self.epsilon, distance),
            },
            "shortest": self.shortest.as_ref().map(|path| round.path(path)),
            "stride": self.stride(),
            "runs": self.runs.iter().map(|run| self.run(run, round)).collect::<Vec<_>>(),
        })
    }

    /// Of how many iterates one is shown, the same for all planners; the last one always.
    fn stride(&self) -> usize {
        let most = (self.most_frames / self.runs.len().max(1)).max(2);
        let longest = self.runs.iter().map(|run| run.frames.len()).max().unwrap_or(0);
        longest.saturating_sub(1).div_ceil(most - 1).max(1)
    }

    fn run(&self, run: &Run, round: Rounding) -> Value {
        let stride = self.stride();
        let last = run.frames.len().saturating_sub(1);
        let shown = run.frames.iter().enumerate().filter(|(i, _)| i % stride == 0 || *i == last);
        let frames: Vec<Value> = shown
            .map(|(_, frame)| {
                json!({
                    "label": frame.label,
                    "cost": frame.costs.map(|costs| significant(costs[0])),
                    "obstacles": frame.costs.map(|costs| significant(costs[1])),
                    "length": significant(frame.trajectory.length()),
                    "clearance": significant(frame.clearance),
                    "turn": significant(frame.trajectory.sharpest_turn().to_degrees()),
                    "free": frame.free,
                    "points": round.path(&frame.trajectory),
                })
            })
            .collect();
        let style = style(&run.planner);
        json!({
            "name": run.planner,
            "text": run.text,
            "color": style["color"],
            "dash": style["dash"],
            "frames": frames,
            "blocked": run.blocked.map(|at| {
                json!({"segment": at.segment, "place": round.point(at.place), "obstacle": at.obstacle})
            }),
        })
    }
}

/// A page of its parts, and its data as JSON in which nothing can end the element that holds it.
fn assembled(page: &str, data: &Value) -> String {
    let parts = [
        ("STYLE\n", include_str!("style.css")),
        ("PLAYER\n", include_str!("player.html")),
        ("VIEW\n", include_str!("view.js")),
        ("PLAY\n", include_str!("replay.js")),
        ("BENCH\n", include_str!("bench.js")),
    ];
    let page =
        parts.iter().fold(page.to_owned(), |page, (name, part)| page.replacen(name, part, 1));
    page.replacen("DATA", &data.to_string().replace('<', "\\u003c"), 1)
}

/// A planner's colour and dash, as pages know them.
fn style(planner: &str) -> Value {
    let style = planner_style(planner);
    let [red, green, blue] = style.color.rgb;
    json!({
        "name": planner,
        "color": format!("#{red:02x}{green:02x}{blue:02x}"),
        "dash": style.dash.map_or_else(Vec::new, |dash| dash.to_vec()),
    })
}

/// Numbers to a ten thousandth of the field, which is less than a pixel.
#[derive(Clone, Copy)]
struct Rounding {
    digits: i32,
}

impl Rounding {
    fn of(extent: f64) -> Self {
        Self { digits: (4 - extent.max(1e-9).log10().ceil() as i32).clamp(-12, 12) }
    }

    fn number(self, value: f64) -> f64 {
        let unit = 10_f64.powi(self.digits);
        let rounded = (value * unit).round() / unit;
        if rounded.is_finite() { rounded } else { 0.0 }
    }

    fn all(self, values: &[f64]) -> Vec<f64> {
        values.iter().map(|value| self.number(*value)).collect()
    }

    fn point(self, p: Point) -> Vec<f64> {
        self.all(&p)
    }

    fn path(self, path: &Trajectory) -> Vec<Vec<f64>> {
        path.configurations().map(|point| self.all(point)).collect()
    }

    fn shape(self, shape: &Obstacle) -> Value {
        match shape {
            Obstacle::Rect(rect) => {
                let (low, high) = (rect.min, rect.max);
                json!({"rect": self.all(&[low[0], low[1], high[0], high[1]])})
            }
            Obstacle::Circle(circle) => {
                let [x, y] = circle.center;
                json!({"circle": self.all(&[x, y, circle.radius])})
            }
            Obstacle::Polygon(polygon) => {
                let corners = polygon.vertices().iter().map(|p| self.point(*p));
                json!({"polygon": corners.collect::<Vec<_>>()})
            }
        }
    }
}

/// Five digits; nothing where it is no number.
fn significant(value: f64) -> Option<f64> {
    if value == 0.0 || !value.is_finite() {
        return value.is_finite().then_some(0.0);
    }
    let unit = 10_f64.powi(4 - value.abs().log10().floor() as i32);
    Some((value * unit).round() / unit).filter(|value| value.is_finite())
}

/// Cells as hexadecimal digits, four cells each, row by row from the lowest; coarser where there are many.
fn grid(grid: &Grid) -> Value {
    let stride = grid.width().max(grid.height()).div_ceil(GRID_SIDE).max(1);
    let (width, height) = (grid.width().div_ceil(stride), grid.height().div_ceil(stride));
    let mut taken = vec![false; (width * height).next_multiple_of(4)];
    for (at, _) in grid.cells().iter().enumerate().filter(|(_, taken)| **taken) {
        let (column, row) = (at % grid.width() / stride, at / grid.width() / stride);
        taken[row * width + column] = true;
    }
    let digit = |cells: &[bool]| cells.iter().fold(0, |sum, &cell| 2 * sum + u32::from(cell));
    let cells: String =
        taken.chunks(4).map(|cells| char::from_digit(digit(cells), 16).unwrap_or('0')).collect();
    json!({
        "width": width, "height": height, "resolution": grid.resolution() * stride as f64,
        "origin": grid.origin(), "cells": cells,
    })
}

/// Distances over the bounds, a digit for each place, row by row from the lowest.
fn field(bounds: Rect, epsilon: f64, distance: impl Fn(Point) -> f64) -> Value {
    let (low, high) = (bounds.min, bounds.max);
    let extent = bounds.extent();
    let count = |side: f64| ((FIELD_SIDE as f64 * side / extent).ceil() as usize).max(1);
    let (columns, rows) = (count(high[0] - low[0]), count(high[1] - low[1]));
    let middle = |i: usize, count: usize| (i as f64 + 0.5) / count as f64;
    let places = (0..columns * rows).map(|at| {
        let across = low[0] + middle(at % columns, columns) * (high[0] - low[0]);
        let up = low[1] + middle(at / columns, rows) * (high[1] - low[1]);
        distance([across, up])
    });
    let far = 2.0 * epsilon;
    let least = -epsilon;
    let digit = |value: f64| {
        let share = ((value - least) / (far - least)).clamp(0.0, 1.0);
        char::from(DIGITS[(share * 61.0).round() as usize])
    };
    let values: String = places.map(digit).collect();
    json!({"columns": columns, "rows": rows, "low": least, "high": far, "values": values})
}

#[cfg(test)]
mod tests;
