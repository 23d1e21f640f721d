//! The robot's body as balls: sorted by link, each link with one ball around them all.

use super::chain::Chain;
use super::model::{BodyShape, Model};
use crate::error::InvalidInput;
use crate::space::vector::{Vector, add, norm, scale, sub};

/// A ball in the frame of a slot, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Its centre.
    pub center: Vector,
    /// Its radius.
    pub radius: f64,
}

/// A link that has a body.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    /// The link's name.
    pub(super) name: String,
    /// The slot that it moves with; 0 if it does not move.
    pub(super) slot: usize,
    /// The numbers of its balls.
    pub(super) balls: std::ops::Range<usize>,
    /// A ball around all of them.
    pub(super) around: Ball,
}

/// The parts of a model, sorted by slot, and all their balls.
///
/// # Errors
/// If a body is not a ball.
pub(super) fn parts(model: &Model, chain: &Chain) -> Result<(Vec<Part>, Vec<Ball>), InvalidInput> {
    let mut order: Vec<usize> = (0..model.links().len()).collect();
    order.sort_by_key(|&link| chain.links[link].0);
    let (mut parts, mut all) = (Vec::new(), Vec::new());
    for link in order {
        let (slot, place) = &chain.links[link];
        let described = &model.links()[link];
        let first = all.len();
        for (index, body) in described.bodies.iter().enumerate() {
            let BodyShape::Sphere { radius } = body.shape else {
                return Err(InvalidInput::new(
                    format!("link {}.collision[{index}]", described.name),
                    kind(&body.shape),
                    "a sphere; cover other shapes with spheres first",
                ));
            };
            all.push(Ball { center: place.apply(body.origin.translation()), radius });
        }
        if all.len() > first {
            let around = around(&all[first..]);
            let name = described.name.clone();
            parts.push(Part { name, slot: *slot, balls: first..all.len(), around });
        }
    }
    Ok((parts, all))
}

fn kind(shape: &BodyShape) -> &'static str {
    match shape {
        BodyShape::Sphere { .. } => "a sphere",
        BodyShape::Box { .. } => "a box",
        BodyShape::Cylinder { .. } => "a cylinder",
        BodyShape::Capsule { .. } => "a capsule",
        BodyShape::Mesh { .. } => "a mesh",
    }
}

/// A ball around balls, near the smallest: its centre walks towards the farthest ball in ever
/// smaller steps (M. Badoiu and K. Clarkson, Smaller core-sets for balls, SODA 2003).
fn around(balls: &[Ball]) -> Ball {
    let mut center = balls[0].center;
    let farthest = |center: Vector| {
        let reach = |ball: &&Ball| norm(sub(ball.center, center)) + ball.radius;
        balls.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))).map_or(0.0, |ball| reach(&ball))
    };
    for step in 1..=256 {
        let reach = |ball: &Ball| norm(sub(ball.center, center)) + ball.radius;
        let Some(far) = balls.iter().max_by(|a, b| reach(a).total_cmp(&reach(b))) else { break };
        let away = sub(far.center, center);
        let length = norm(away);
        if length > 0.0 {
            // The farthest point of that ball, not its centre, is what must come nearer.
            let aim = scale(away, (length + far.radius) / length);
            center = add(center, scale(aim, 1.0 / f64::from(step + 1)));
        }
    }
    // A hair larger, for the rounding of what is compared with it.
    Ball { center, radius: farthest(center) * (1.0 + 1e-12) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_goes_around_balls() {
        let ball = |x: f64, radius| Ball { center: [x, 0.0, 0.0], radius };
        for (balls, radius) in [
            (vec![ball(0.3, 0.1)], 0.1),
            (vec![ball(0.0, 0.1), ball(0.4, 0.1)], 0.3),
            (vec![ball(0.0, 0.3), ball(0.1, 0.1)], 0.3),
            (vec![ball(0.0, 0.1), ball(0.2, 0.1), ball(1.0, 0.3)], 0.7),
        ] {
            let found = around(&balls);
            for ball in &balls {
                let reach = norm(sub(ball.center, found.center)) + ball.radius;
                assert!(reach <= found.radius, "{balls:?}");
            }
            assert!(found.radius < 1.02 * radius, "{balls:?}: {}", found.radius);
        }
    }
}
