//! Each part says what its documentation promises, and what does not fit is refused with both sides.

use std::sync::Arc;

use super::*;
use crate::plane::geometry::Rect;
use crate::profile::Profile;
use crate::scene::Query;
use crate::{Grid, Obstacle, Robot, Task, World};

/// A field of 64 x 64 with one square of side 4 at each centre, and the query (4, 32) to (60, 32).
fn task(centres: &[[f64; 2]], grid: Option<Grid>) -> Task {
    let square = |&[x, y]: &[f64; 2]| {
        Obstacle::Rect(Rect { min: [x - 2.0, y - 2.0], max: [x + 2.0, y + 2.0] })
    };
    let bounds = Rect { min: [0.0; 2], max: [64.0; 2] };
    let world = World::new(bounds, centres.iter().map(square).collect(), grid);
    Task::in_plane("t", Arc::new(world), Robot::Point, [4.0, 32.0], [60.0, 32.0]).unwrap()
}

fn observe(task: &Task, parts: &[ObservationPart]) -> Result<Vec<f32>, InvalidInput> {
    let mut objective = Objective::new(&Query::of(task, &Profile::DEFAULT), 3)?;
    let mut encoder = Encoder::new(parts, &objective)?;
    let (mut x, mut gradient) = (vec![0.0; 6], vec![0.0; 6]);
    objective.straight_line(&mut x);
    objective.cost_and_gradient(&x, &mut gradient);
    let mut out = vec![9.0; encoder.len(&objective)];
    encoder.encode(&objective, &x, &gradient, &mut out);
    Ok(out)
}

const FAR: [f64; 2] = [32.0, 60.0];
const NEAR: [f64; 2] = [48.0, 36.0];
const BESIDE_GOAL: [f64; 2] = [62.0, 32.0];

#[test]
fn positions_are_in_half_extents_from_the_centre() {
    let task = task(&[FAR], None);
    let ends = observe(&task, &[ObservationPart::Ends]).unwrap();
    let expected = [-28.0, 0.0, 28.0, 0.0].map(|p: f32| p / 32.0);
    assert!(ends.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{ends:?}");
    let waypoints = observe(&task, &[ObservationPart::Trajectory]).unwrap();
    assert!((waypoints[0] + 14.0 / 32.0).abs() < 1e-6 && waypoints[2].abs() < 1e-6);
    let boxes = observe(&task, &[ObservationPart::Obstacles { count: 2 }]).unwrap();
    let expected = [0.0, 28.0 / 32.0, 4.0 / 32.0, 4.0 / 32.0, 0.0, 0.0, 0.0, 0.0];
    assert!(boxes.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{boxes:?}");
}

#[test]
fn nearest_obstacles_come_first_and_there_may_be_any_number() {
    let nearest = |centres: &[[f64; 2]], count: usize| -> Vec<[f32; 2]> {
        let parts = [ObservationPart::NearestObstacles { count }];
        let seen = observe(&task(centres, None), &parts).unwrap();
        seen.chunks(4).map(|b| [32.0 + 32.0 * b[0], 32.0 + 32.0 * b[1]]).collect()
    };
    let close = |got: &[[f32; 2]], expected: &[[f64; 2]]| {
        assert_eq!(got.len(), expected.len());
        for (got, want) in got.iter().zip(expected) {
            assert!((0..2).all(|axis| (f64::from(got[axis]) - want[axis]).abs() < 1e-4), "{got:?}");
        }
    };
    close(&nearest(&[FAR, NEAR, BESIDE_GOAL], 3), &[BESIDE_GOAL, NEAR, FAR]);
    close(&nearest(&[NEAR, BESIDE_GOAL, FAR], 2), &[BESIDE_GOAL, NEAR]);
    // Where there are fewer, the rest is zero: the field's centre in these units.
    close(&nearest(&[FAR], 2), &[FAR, [32.0, 32.0]]);
}

#[test]
fn a_waypoint_sees_the_obstacles_nearest_to_it() {
    // Waypoints at (18, 32), (32, 32) and (46, 32); a square of side 4 around each centre.
    let parts = [ObservationPart::WaypointObstacles { count: 2 }];
    let seen = observe(&task(&[FAR, NEAR, [20.0, 31.0]], None), &parts).unwrap();
    let expected = [
        [2.0, -1.0, 4.0, 4.0],  // it is inside of this one
        [14.0, 20.0, 4.0, 4.0], // (14, 28) away, which counts as 20 across
    ];
    let close = |got: &[f32], want: [f64; 4]| {
        let same = got.iter().zip(want).all(|(a, b)| (100.0 * f64::from(*a) - b).abs() < 1e-4);
        assert!(same, "{got:?} {want:?}");
    };
    close(&seen[..4], expected[0]);
    close(&seen[8..12], [-12.0, -1.0, 4.0, 4.0]);
    close(&seen[12..16], [16.0, 4.0, 4.0, 4.0]);
    close(&seen[16..20], [2.0, 4.0, 4.0, 4.0]);
    let far = observe(&task(&[FAR], None), &parts).unwrap();
    close(&far[..4], expected[1]);
    close(&far[4..8], [0.0; 4]);
}

#[test]
fn what_does_not_fit_names_both_sides() {
    let check = |task: &Task, part: ObservationPart, expected: &[&str]| {
        let message = observe(task, &[part]).unwrap_err().to_string();
        assert!(expected.iter().all(|part| message.contains(part)), "{message}");
    };
    let three = task(&[FAR, NEAR, BESIDE_GOAL], None);
    check(&three, ObservationPart::Obstacles { count: 2 }, &["3 obstacles", "at most 2 shapes"]);
    let grid = Grid::new(2, 2, 1.0, [0.0; 2], vec![true; 4]).unwrap();
    let gridded = task(&[FAR], Some(grid));
    check(&gridded, ObservationPart::Obstacles { count: 2 }, &["occupancy grid", "obstacles:2"]);
    let nearest = ObservationPart::NearestObstacles { count: 2 };
    check(&gridded, nearest, &["occupancy grid", "nearest-obstacles:2"]);
    let around = ObservationPart::WaypointObstacles { count: 2 };
    check(&gridded, around, &["occupancy grid", "waypoint-obstacles:2"]);
    let image = observe(&gridded, &[ObservationPart::Image]).unwrap();
    assert_eq!((image.len(), image[0]), (64 * 64, 1.0), "an image shows a grid");
}

#[test]
fn names_read_back_and_a_part_appears_once() {
    let parts = [
        ObservationPart::Gradient,
        ObservationPart::ObstacleCost,
        ObservationPart::PreviousGradients { count: 3 },
        ObservationPart::Trajectory,
        ObservationPart::Obstacles { count: 10 },
        ObservationPart::NearestObstacles { count: 8 },
        ObservationPart::WaypointObstacles { count: 2 },
        ObservationPart::Ends,
        ObservationPart::Image,
    ];
    for part in parts.into_iter().chain([ObservationPart::WaypointImage]) {
        assert_eq!(part.name().parse::<ObservationPart>(), Ok(part));
    }
    let both = [ObservationPart::WaypointImage, ObservationPart::Gradient, ObservationPart::Image];
    assert_eq!(image_place(&both, 10, 2), Some(0));
    let message = observation_len(&both, 10, 2).unwrap_err().to_string();
    assert!(message.contains("one image"), "{message}");
    let message = observation_len(&both[..2], 17, 2).unwrap_err().to_string();
    assert!(message.contains("at most 16"), "{message}");
    assert_eq!(image_place(&parts, 10, 2), Some(20 + 11 + 60 + 20 + 40 + 32 + 80 + 4));
    assert_eq!(
        observation_len(&parts, 10, 2).unwrap(),
        20 + 11 + 60 + 20 + 40 + 32 + 80 + 4 + 4096
    );
    let twice = observation_len(&[ObservationPart::Image, ObservationPart::Image], 10, 2);
    assert!(twice.unwrap_err().to_string().contains("each kind of part once"));
    for wrong in [
        "imag",
        "image:2",
        "ends:1",
        "nearest-obstacles",
        "nearest-obstacles:0",
        "waypoint-obstacles:65",
    ] {
        let message = wrong.parse::<ObservationPart>().unwrap_err().to_string();
        assert!(message.contains(wrong), "{message}");
    }
}
