//! The ground of a task's picture, shaded by a value of each point.

use sidestep::World;
use sidestep::plane::geometry::Point;

use super::canvas::{Frame, Shape};
use super::color::SHADE;

/// Samples of a shading along the longer side of the field.
const SHADE_SAMPLES: f64 = 240.0;

/// Levels that a shading is rounded to, so that its steps read as contour lines.
const SHADE_LEVELS: f64 = 12.0;

/// Brightness values over the field, the top row first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shading {
    width: usize,
    height: usize,
    values: Vec<f64>,
}

impl Shading {
    /// Samples `value` over the bounds of a world, where no obstacle covers the ground.
    pub(super) fn sample(world: &World, value: impl Fn(Point) -> f64) -> Self {
        let bounds = world.bounds();
        let size = bounds.size();
        let samples = |length: f64| (SHADE_SAMPLES * length / bounds.extent()).ceil().max(2.0);
        let (width, height) = (samples(size[0]), samples(size[1]));
        let (columns, rows) = (width as usize, height as usize);
        let cell = [size[0] / width, size[1] / height];
        let at = |i: usize| {
            let (column, row) = ((i % columns) as f64, (i / columns) as f64);
            let x = bounds.min[0] + (column + 0.5) * cell[0];
            let y = bounds.max[1] - (row + 0.5) * cell[1];
            // What lies under an obstacle has no part in the range of the shades.
            if is_covered(world, [x, y]) { f64::NAN } else { value([x, y]) }
        };
        let values = (0..columns * rows).map(at).collect();
        Self { width: columns, height: rows, values }
    }

    /// The shaded ground, from the lowest value to the highest.
    pub(super) fn image(&self, frame: Frame) -> Shape {
        let finite = || self.values.iter().copied().filter(|value| value.is_finite());
        let low = finite().fold(f64::INFINITY, f64::min);
        let high = finite().fold(f64::NEG_INFINITY, f64::max);
        let color = |&value: &f64| {
            let t = if high > low { (value - low) / (high - low) } else { 1.0 };
            let level = (t * SHADE_LEVELS).floor().min(SHADE_LEVELS - 1.0) / (SHADE_LEVELS - 1.0);
            SHADE[0].mix(SHADE[1], if level.is_nan() { 0.0 } else { level }).rgb
        };
        let rgb = self.values.iter().map(color).collect();
        Shape::Image { frame, width: self.width, height: self.height, rgb }
    }
}

fn is_covered(world: &World, p: Point) -> bool {
    let in_grid = world.grid().is_some_and(|grid| {
        let (column, row) = grid.cell_of(p);
        grid.is_occupied(column, row)
    });
    in_grid || world.obstacles().iter().any(|obstacle| obstacle.signed_distance(p) < 0.0)
}
