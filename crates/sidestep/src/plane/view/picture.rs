//! The picture of a workspace, as a policy sees that knows pixels and no distances.
//!
//! Pixels cover the square of the paper's field around the middle of the bounds, dark where the robot's
//! reference point may not be: shade -1 inside obstacles and walls, 1 outside, and in between where an edge
//! crosses the pixel (its signed distance at the middle, in pixels, clamped to half a pixel on both
//! sides, which is how an anti-aliased edge is drawn). It is read bilinearly; outside it is dark.

use crate::plane::PlaneScene;
use crate::plane::distance::Samples;
use crate::profile::NORMALISED_EXTENT;

/// Dark pixels around the field, so that what lies outside reads as dark.
const BORDER: usize = 1;
/// Shades are told as signed distances of this size, so that a view reads them as it reads those.
const SHADE: f32 = 0.6;

/// One picture: `[side x side]` shades with a border.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Pixels per side, with the border.
    side: usize,
    shades: Vec<f32>,
    /// The middle of the lower left pixel, border included, in normalised units.
    first: [f32; 2],
    /// Pixels per normalised unit.
    density: f32,
}

impl Picture {
    /// Draws the scene with so many pixels along a side of the field.
    pub fn draw(scene: &PlaneScene, pixels: usize) -> Self {
        let bounds = scene.certifier().bounds();
        let [min, max] = [bounds.min, bounds.max].map(|p| scene.frame().to_normalised(p));
        let width = NORMALISED_EXTENT as f32;
        let density = pixels as f32 / width;
        let middle = [0, 1].map(|axis| 0.5 * (min[axis] + max[axis]));
        let inner = middle.map(|m| m - 0.5 * (width - 1.0 / density));
        let (mut x, mut y) = (vec![0.0; pixels], vec![0.0; pixels]);
        let mut distance = vec![0.0; pixels];
        let side = pixels + 2 * BORDER;
        let mut shades = vec![-SHADE; side * side];
        for i in 0..pixels {
            x[i] = inner[0] + i as f32 / density;
        }
        for row in 0..pixels {
            y.fill(inner[1] + row as f32 / density);
            scene.exact_field().probe_all(&x, &y, &mut distance);
            let out = &mut shades[(row + BORDER) * side + BORDER..][..pixels];
            for (shade, distance) in out.iter_mut().zip(&distance) {
                *shade = SHADE * (2.0 * density * distance).clamp(-1.0, 1.0);
            }
        }
        let first = inner.map(|m| m - BORDER as f32 / density);
        Self { side, shades, first, density }
    }

    /// Shades without slopes.
    #[inline(always)]
    pub(super) fn probe(&self, x: &[f32], y: &[f32], out: &mut [f32]) {
        for ((x, y), out) in x.iter().zip(y).zip(out) {
            let ([a, b, c, d], u, v) = self.corners(*x, *y);
            let (low, high) = (a + u * (b - a), c + u * (d - c));
            *out = low + v * (high - low);
        }
    }

    /// Shades and their slopes, per pixel.
    #[inline(always)]
    pub(super) fn sample(&self, x: &[f32], y: &[f32], out: &mut Samples<'_>) {
        for (i, (x, y)) in x.iter().zip(y).enumerate() {
            let ([a, b, c, d], u, v) = self.corners(*x, *y);
            let (low, high) = (a + u * (b - a), c + u * (d - c));
            out.distance[i] = low + v * (high - low);
            out.gradient_x[i] = (b - a) + v * ((d - c) - (b - a));
            out.gradient_y[i] = high - low;
        }
    }

    /// The four shades around a place, and its fractions between them.
    #[inline(always)]
    fn corners(&self, x: f32, y: f32) -> ([f32; 4], f32, f32) {
        let last = (self.side - 1) as f32;
        let u = ((x - self.first[0]) * self.density).max(0.0).min(last);
        let v = ((y - self.first[1]) * self.density).max(0.0).min(last);
        let most = self.side as i32 - 2;
        let (column, row) = ((u as i32).min(most), (v as i32).min(most));
        let at = (row * self.side as i32 + column) as usize;
        let shade = |at: usize| self.shades[at];
        let around = [shade(at), shade(at + 1), shade(at + self.side), shade(at + self.side + 1)];
        (around, u - column as f32, v - row as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Robot;
    use crate::plane::distance::LANES;
    use crate::plane::geometry::Rect;
    use crate::plane::world::{Obstacle, World};
    use crate::profile::Profile;
    use std::sync::Arc;

    /// A field of 64 x 64 with a wall from x = 20 to 30, whose right edge crosses pixels of a picture of 64.
    fn scene(robot: Robot) -> PlaneScene {
        let field = Rect::new([0.0; 2], [64.0; 2]).unwrap();
        let wall = Rect::new([20.0, 0.0], [30.25, 40.0]).unwrap();
        let world = World::new(field, vec![Obstacle::Rect(wall)], None);
        PlaneScene::new(&Arc::new(world), robot, &Profile::DEFAULT)
    }

    /// The shade at a place of the field, from -1 to 1, and its slopes per pixel.
    fn shade(picture: &Picture, p: [f32; 2]) -> (f32, [f32; 2]) {
        let [mut distance, mut gradient_x, mut gradient_y] = [[0.0; LANES]; 3];
        let mut out = Samples {
            distance: &mut distance,
            gradient_x: &mut gradient_x,
            gradient_y: &mut gradient_y,
        };
        picture.sample(&[0.1 * p[0]; LANES], &[0.1 * p[1]; LANES], &mut out);
        let mut probed = [0.0; LANES];
        picture.probe(&[0.1 * p[0]; LANES], &[0.1 * p[1]; LANES], &mut probed);
        assert_eq!(probed[3], out.distance[3]);
        let slope = [out.gradient_x[0], out.gradient_y[0]].map(|s| s / SHADE);
        (out.distance[0] / SHADE, slope)
    }

    #[test]
    fn obstacles_and_all_that_lies_outside_are_dark_and_edges_are_smooth() {
        let picture = Picture::draw(&scene(Robot::Point), 64);
        let rows = [
            ([10.5, 10.5], 1.0),
            ([25.5, 10.5], -1.0),
            // The middle of a pixel of which the wall covers a quarter.
            ([30.5, 10.5], 0.5),
            ([-3.0, 20.0], -1.0),
            ([10.0, 90.0], -1.0),
            ([25.5, 50.5], 1.0),
        ];
        for (p, expected) in rows {
            let (found, _) = shade(&picture, p);
            assert!((found - expected).abs() < 1e-4, "{p:?}: {found}, expected {expected}");
        }
        let (_, slope) = shade(&picture, [30.2, 10.5]);
        assert!(slope[0] > 0.5 && slope[1].abs() < 1e-4, "{slope:?}");
    }

    #[test]
    fn a_disc_sees_the_places_where_its_middle_may_be() {
        let picture = Picture::draw(&scene(Robot::disc(2.0).unwrap()), 64);
        assert!(shade(&picture, [31.5, 10.5]).0 < -0.9);
        assert!(shade(&picture, [33.5, 10.5]).0 > 0.9);
        assert!(shade(&picture, [1.0, 10.5]).0 < 0.0);
    }
}
