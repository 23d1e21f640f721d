//! Where an attempt in the plane meets something.

use sidestep::plan::Plan;
use sidestep::plane::geometry::{Point, lerp};
use sidestep::plane::points;
use sidestep::scene::Query;
use sidestep::trajectory::{ObstacleId, Violation};

use super::Block;

/// Where the last attempt is blocked; `None` for a plan, and where the scene does not tell.
pub fn blocked(query: &Query, plan: &Plan) -> Option<Block> {
    if plan.is_solved() {
        return None;
    }
    let path = plan.attempt.as_ref()?;
    let (segment, obstacle) = match query.scene().check(path).err()? {
        Violation::Collision { segment, obstacle: ObstacleId::Shape(index) } => {
            (segment, Some(index))
        }
        Violation::Collision { segment, .. } | Violation::OutOfBounds { segment, .. } => {
            (segment, None)
        }
        _ => return None,
    };
    let ends = points(path).get(segment..segment + 2)?;
    let shape = obstacle.and_then(|i| query.scene().plane()?.world().obstacles().get(i));
    let place = match shape {
        Some(shape) => deepest_along(ends, |p| shape.signed_distance(p))?.1,
        None => deepest(query, ends)?.1,
    };
    Some(Block { segment, place, obstacle })
}

/// The least distance of the robot to obstacles and bounds along some points in the plane, by samples,
/// and where: negative inside an obstacle.
pub(super) fn deepest(query: &Query, points: &[Point]) -> Option<(f64, Point)> {
    let scene = query.scene().plane()?;
    let (frame, field) = (scene.frame(), scene.field());
    deepest_along(points, |p| f64::from(field.at(frame.to_normalised(p)).0) * frame.scale)
}

fn deepest_along(points: &[Point], distance: impl Fn(Point) -> f64) -> Option<(f64, Point)> {
    const SAMPLES: u32 = 32;
    let along = |ends: &[Point]| {
        let (from, to) = (ends[0], ends[1]);
        (0..=SAMPLES).map(move |i| lerp(from, to, f64::from(i) / f64::from(SAMPLES)))
    };
    let places = points.windows(2).flat_map(along).map(|place| (distance(place), place));
    places.min_by(|a, b| a.0.total_cmp(&b.0))
}
