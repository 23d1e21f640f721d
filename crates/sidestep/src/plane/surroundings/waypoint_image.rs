//! The workspace as each waypoint sees it: pictures of 16 x 16 pixels around the waypoints, side by side in one image of 64 x 64.
//!
//! ```text
//! depth in an obstacle or outside (0 at a pixel from it, 1 at eleven pixels inside),   the trajectory painted over as in `image.rs`
//! ```
//!
//! Pixels are as large as the workspace image's, and a waypoint lies in the middle of its picture, between the pixels; waypoint i
//! has the picture in column i mod 4 of row i / 4 from below. Convolutions read an image the same everywhere, so one set of
//! filters reads the surroundings of all waypoints, and what they find says where it lies from the waypoint.

use super::image::{Trail, paint};
use crate::error::InvalidInput;
use crate::network::IMAGE_SIDE;
use crate::plane::Subject;
use crate::plane::distance::LANES;
use crate::profile::NORMALISED_EXTENT;

/// Side of a waypoint's picture, in pixels.
const SIDE: usize = 16;
const PER_ROW: usize = IMAGE_SIDE / SIDE;
/// Waypoints whose pictures the image holds.
const MOST_WAYPOINTS: usize = PER_ROW * PER_ROW;
/// Depths are known this far around the workspace image, in pixels.
const AROUND: usize = SIDE;
const KNOWN: usize = IMAGE_SIDE + 2 * AROUND;
/// Depth that counts 1, in pixels.
const DEEP: f32 = 10.0;

/// Refuses more waypoints than the image holds.
pub(crate) fn check(waypoints: usize) -> Result<(), InvalidInput> {
    if waypoints <= MOST_WAYPOINTS {
        return Ok(());
    }
    let allowed = format!("at most {MOST_WAYPOINTS}, for the observation waypoint-image");
    Err(InvalidInput::new("waypoints", waypoints.to_string(), allowed))
}

/// Depths at the pixels of the workspace image and around it, `[KNOWN x KNOWN]`.
pub(crate) fn depths(subject: Subject<'_>) -> Vec<f32> {
    const { assert!((KNOWN * KNOWN).is_multiple_of(LANES)) };
    let pixel = NORMALISED_EXTENT as f32 / IMAGE_SIDE as f32;
    let scene = subject.scene;
    let first = scene.frame().to_normalised(scene.world().bounds().min);
    let place =
        |axis: usize, index: usize| first[axis] + pixel * (index as f32 + 0.5 - AROUND as f32);
    let x: Vec<f32> = (0..KNOWN * KNOWN).map(|index| place(0, index % KNOWN)).collect();
    let y: Vec<f32> = (0..KNOWN * KNOWN).map(|index| place(1, index / KNOWN)).collect();
    let mut depths = vec![0.0; KNOWN * KNOWN];
    scene.exact_field().probe_all(&x, &y, &mut depths);
    depths.iter_mut().for_each(|d| *d = ((pixel - *d) / (DEEP * pixel)).clamp(0.0, 1.0));
    depths
}

/// Draws the pictures of the waypoints of `trail` over `image`, all of it.
pub(crate) fn draw(depths: &[f32], trail: &Trail, image: &mut [f32]) {
    image.fill(0.0);
    for (index, &at) in trail.waypoints.iter().enumerate() {
        let corner = (index / PER_ROW) * SIDE * IMAGE_SIDE + (index % PER_ROW) * SIDE;
        draw_depths(depths, at, &mut image[corner..]);
        let middle = 0.5 * (SIDE as f32 - 1.0);
        for &(p, brightness) in &trail.dots {
            let from_corner = [p[0] - at[0] + middle, p[1] - at[1] + middle];
            paint(from_corner, brightness, SIDE, &mut image[corner..]);
        }
    }
}

/// Draws the depths around `at`, a place in pixels, with the picture's first pixel first in `image`.
fn draw_depths(depths: &[f32], at: [f32; 2], image: &mut [f32]) {
    // Half a pixel from middles to corners is what `Trail` took off; NaN counts as the least.
    let half = (SIDE / 2) as f32;
    let last = (KNOWN - SIDE - 1) as f32 - 0.01;
    let place = at.map(|v| (v + 0.5 + AROUND as f32 - half).max(0.0).min(last));
    let base = place.map(|v| v as usize);
    let [u, v] = [place[0] - base[0] as f32, place[1] - base[1] as f32];
    for row in 0..SIDE {
        let first = (base[1] + row) * KNOWN + base[0];
        let (below, above) = (&depths[first..=first + SIDE], &depths[first + KNOWN..][..=SIDE]);
        let out = &mut image[row * IMAGE_SIDE..][..SIDE];
        for (column, out) in out.iter_mut().enumerate() {
            let low = below[column] + u * (below[column + 1] - below[column]);
            let high = above[column] + u * (above[column + 1] - above[column]);
            *out = low + v * (high - low);
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
    use crate::{Obstacle, Robot, Task, World};
    use std::sync::Arc;

    /// The image of waypoints in pixels from the lower left corner.
    fn picture(places: &[f32]) -> Vec<f32> {
        let bounds = Rect { min: [0.0; 2], max: [64.0; 2] };
        let rect = Rect { min: [20.0, 30.0], max: [30.0, 50.0] };
        let world = Arc::new(World::new(bounds, vec![Obstacle::Rect(rect)], None));
        let task = Task::in_plane("t", world, Robot::Point, [4.0, 32.0], [60.0, 32.0]).unwrap();
        let query = Query::of(&task, &Profile::PAPER);
        let places: Vec<f64> = places.iter().map(|&v| v.into()).collect();
        let mut x = vec![0.0; places.len()];
        query.scene().to_normalised(&places, &mut x);
        let objective = Objective::new(&query, x.len() / 2).unwrap();
        let depths = depths(objective.plane().unwrap());
        let mut trail = Trail::default();
        trail.follow(objective.plane().unwrap(), &x);
        let mut image = vec![9.0; IMAGE_SIDE * IMAGE_SIDE];
        draw(&depths, &trail, &mut image);
        image
    }

    #[test]
    fn each_waypoint_sees_depths_around_it() {
        // Waypoint 0 in free space at (14, 28), waypoint 5 at (25, 40) in the rectangle's middle, in pixels.
        let mut x = [14.0, 28.0].repeat(6);
        x[10..].copy_from_slice(&[25.0, 40.0]);
        let image = picture(&x);
        let at = |tile: usize, column: usize, row: usize| {
            image[((tile / 4) * 16 + row) * IMAGE_SIDE + (tile % 4) * 16 + column]
        };
        // Pixel (column, row) is centred at (column - 7.5, row - 7.5) from the waypoint.
        assert_eq!(at(0, 0, 0), 0.0, "(6.5, 20.5) is far from everything");
        assert!((at(0, 15, 12) - 0.25).abs() < 1e-4, "(21.5, 32.5) is 1.5 deep: {}", at(0, 15, 12));
        assert!((at(0, 13, 12) - 0.05).abs() < 1e-4, "(19.5, 32.5) is half a pixel out");
        // (23.5, 34.5) is 3.5 deep and off the trajectory.
        assert!((at(5, 6, 2) - 0.45).abs() < 1e-4, "{}", at(5, 6, 2));
        // Outside the field counts as an obstacle; the picture of a waypoint that is not there is empty.
        let outside = picture(&[1.0, 1.0]);
        assert!((outside[0] - 0.1 * (1.0 + 6.5)).abs() < 0.1, "{}", outside[0]);
        assert!(
            (0..16).all(|row| outside[row * IMAGE_SIDE + 16..][..48].iter().all(|v| *v == 0.0))
        );
    }

    #[test]
    fn the_trajectory_runs_through_the_middle() {
        let image = picture(&[14.0, 32.0, 40.0, 32.0]);
        let row = |tile: usize, row: usize| &image[row * IMAGE_SIDE + tile * 16..][..16];
        // On the line through the waypoint, between the two middle rows, so on both; nothing three rows off.
        assert!(
            [7, 8].iter().all(|&r| row(0, r)[7] < -0.1 && row(0, r)[8] < -0.1),
            "{:?}",
            row(0, 7)
        );
        assert!(row(0, 11)[..8].iter().all(|v| *v == 0.0), "{:?}", row(0, 11));
        // Brighter towards the goal.
        assert!(row(1, 7)[7] < row(0, 7)[7], "{:?} {:?}", row(0, 7), row(1, 7));
    }

    #[test]
    fn nothing_panics_far_outside_and_too_many_are_refused() {
        let image = picture(&[1e30, -1e30, f32::NAN, f32::INFINITY, -500.0, 3.0]);
        assert!(image.iter().all(|value| value.is_finite()));
        assert!(check(16).is_ok());
        let message = check(17).unwrap_err().to_string();
        assert!(message.contains("17") && message.contains("at most 16"), "{message}");
    }
}
