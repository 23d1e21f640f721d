//! The workspace image (paper, section III.E): obstacles and the current trajectory in one picture of 64 x 64 pixels.
//!
//! ```text
//! obstacle or outside 1,   free 0,   the trajectory painted over: value (1 - w) - w b
//! ```
//!
//! b rises from start to goal, so that the direction can be told, and is twice as much at a waypoint as between two; w is the
//! bilinear share of the pixel, so that the picture changes smoothly as a waypoint moves. The larger side of the bounds
//! fills the image; pixel (column, row) is centred at (column + 0.5, row + 0.5) 64ths of it from the lower left corner.

use crate::network::IMAGE_SIDE;
use crate::plane::Subject;
use crate::plane::world::World;

/// Points drawn between two waypoints.
const BETWEEN: usize = 7;

/// `[IMAGE_SIDE x IMAGE_SIDE]`: 1 where the pixel's centre lies in an obstacle or outside the bounds, else 0.
pub(crate) fn workspace(world: &World) -> Vec<f32> {
    let (bounds, pixel) = (world.bounds(), world.bounds().extent() / IMAGE_SIDE as f64);
    let taken = |index: usize| {
        let (column, row) = (index % IMAGE_SIDE, index / IMAGE_SIDE);
        let p = [
            bounds.min[0] + (column as f64 + 0.5) * pixel,
            bounds.min[1] + (row as f64 + 0.5) * pixel,
        ];
        let in_cell = world.grid().is_some_and(|grid| {
            let (column, row) = grid.cell_of(p);
            grid.is_occupied(column, row)
        });
        !bounds.contains(p) || in_cell || world.obstacles().iter().any(|o| o.contains(p))
    };
    (0..IMAGE_SIDE * IMAGE_SIDE).map(|index| f32::from(u8::from(taken(index)))).collect()
}

/// A trajectory as dots to paint, in pixels: (0, 0) is the middle of the first one.
#[derive(Debug, Clone, Default)]
pub(crate) struct Trail {
    /// Place and brightness, from start to goal.
    pub dots: Vec<([f32; 2], f32)>,
    /// Places of the waypoints.
    pub waypoints: Vec<[f32; 2]>,
}

impl Trail {
    /// Follows the trajectory from start over the waypoints `x [N x 2]` to the goal.
    pub fn follow(&mut self, subject: Subject<'_>, x: &[f32]) {
        let frame = subject.scene.frame();
        let bounds = subject.scene.world().bounds();
        let pixels = IMAGE_SIDE as f64 / bounds.extent();
        let place = |p: [f32; 2]| {
            let p = frame.to_task(p);
            [0, 1].map(|axis| ((p[axis] - bounds.min[axis]) * pixels - 0.5) as f32)
        };
        self.dots.clear();
        self.waypoints.clear();
        let points = x.as_chunks::<2>().0;
        self.waypoints.extend(points.iter().map(|p| place(*p)));
        let mut from = place(subject.start);
        let goal = place(subject.goal);
        for (index, &to) in self.waypoints.iter().chain([&goal]).enumerate() {
            for step in 0..=BETWEEN {
                let t = step as f32 / (BETWEEN + 1) as f32;
                let progress = (index as f32 + t) / (points.len() + 1) as f32;
                let brightness = (0.4 + 0.6 * progress) * if step == 0 { 1.0 } else { 0.5 };
                let p = [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])];
                self.dots.push((p, brightness));
            }
            from = to;
        }
        self.dots.push((goal, 1.0));
    }

    /// Paints the dots over `image [IMAGE_SIDE x IMAGE_SIDE]`.
    pub fn draw(&self, image: &mut [f32]) {
        for &(p, brightness) in &self.dots {
            paint(p, brightness, IMAGE_SIDE, image);
        }
    }
}

/// Paints a point over the four pixels around it, those that lie in the square of `side` pixels whose first is the first of
/// `image`; rows are [`IMAGE_SIDE`] apart.
pub(crate) fn paint(p: [f32; 2], brightness: f32, side: usize, image: &mut [f32]) {
    let corner = p.map(f32::floor);
    let part = [p[0] - corner[0], p[1] - corner[1]];
    let side = 0..side as i64;
    for (dy, wy) in [(0, 1.0 - part[1]), (1, part[1])] {
        for (dx, wx) in [(0, 1.0 - part[0]), (1, part[0])] {
            let (column, row) =
                ((corner[0] as i64).saturating_add(dx), (corner[1] as i64).saturating_add(dy));
            let weight = wx * wy;
            if side.contains(&column) && side.contains(&row) && weight.is_finite() {
                let pixel = &mut image[row as usize * IMAGE_SIDE + column as usize];
                *pixel = *pixel * (1.0 - weight) - weight * brightness;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::Objective;
    use crate::plane::geometry::Rect;
    use crate::profile::Profile;
    use crate::scene::Query;
    use crate::{Obstacle, Robot, Task};
    use std::sync::Arc;

    #[test]
    fn obstacles_are_one_and_the_trajectory_is_painted_over_them() {
        let bounds = Rect { min: [0.0; 2], max: [64.0, 32.0] };
        let rect = Rect { min: [10.0, 5.0], max: [20.0, 9.0] };
        let world = Arc::new(World::new(bounds, vec![Obstacle::Rect(rect)], None));
        let empty = workspace(&world);
        let at = |image: &[f32], column: usize, row: usize| image[row * IMAGE_SIDE + column];
        assert_eq!((at(&empty, 10, 5), at(&empty, 19, 8)), (1.0, 1.0));
        assert_eq!((at(&empty, 9, 5), at(&empty, 20, 8), at(&empty, 63, 31)), (0.0, 0.0, 0.0));
        assert_eq!(at(&empty, 0, 32), 1.0, "outside the bounds");
        for profile in [Profile::DEFAULT, Profile::PAPER] {
            let task =
                Task::in_plane("t", world.clone(), Robot::Point, [2.5, 6.5], [24.5, 6.5]).unwrap();
            let objective = Objective::new(&Query::of(&task, &profile), 1).unwrap();
            let (mut image, mut trail) = (empty.clone(), Trail::default());
            let mut x = [0.0; 2];
            objective.straight_line(&mut x);
            trail.follow(objective.plane().unwrap(), &x);
            trail.draw(&mut image);
            // Start, waypoint and goal lie on pixels' centres: columns 2, 13 and 24 of row 6.
            for (column, value) in [(2, -0.4), (13, -0.7), (24, -1.0)] {
                let got = at(&image, column, 6);
                assert!((got - value).abs() < 0.02, "{column}: {got}");
            }
            assert!((at(&image, 2, 12) - 0.0).abs() < 1e-6 && at(&image, 15, 8) == 1.0);
            let mut moved = empty.clone();
            trail.follow(objective.plane().unwrap(), &[x[0] + 0.01, x[1]]);
            trail.draw(&mut moved);
            let change: f32 = image.iter().zip(&moved).map(|(a, b)| (a - b).abs()).sum();
            assert!(change > 0.0 && change < 1.5, "{change}");
        }
    }

    #[test]
    fn nothing_is_painted_outside() {
        let mut image = vec![0.5; IMAGE_SIDE * IMAGE_SIDE];
        for p in [[-5.0, 3.0], [64.5, 3.0], [f32::NAN, 1.0], [1e30, -1e30]] {
            paint(p, 1.0, IMAGE_SIDE, &mut image);
        }
        let painted = image.iter().filter(|value| **value != 0.5).count();
        assert!(painted <= 4, "{painted}");
        paint([-0.5, -0.5], 1.0, IMAGE_SIDE, &mut image);
        assert!((image[0] - (0.5 * 0.75 - 0.25)).abs() < 0.5);
    }
}
