//! A robot's collision shapes as balls that cover them, so that what is proved of the balls holds
//! for the shapes.

use std::sync::Arc;

use super::model::{Body, BodyShape, Model};
use crate::error::InvalidInput;
use crate::space::vector::Vector;
use crate::space::{Cover, Hull, Pose, Shape};

/// Gives the convex hull of a mesh by its file's name and the factors of its coordinates.
pub type MeshHull<'a> = &'a mut dyn FnMut(&str, Vector) -> Result<Arc<Hull>, InvalidInput>;

impl Model {
    /// The same robot with balls for bodies that cover the surfaces of all its shapes (of a mesh,
    /// of its convex hull) and stick out of them by at most `overhang` metres; and by how much the
    /// worst does. Balls stay what they are.
    ///
    /// # Errors
    /// If `hull` fails, or a shape cannot be covered so closely; with the link's name.
    pub fn covered(self, overhang: f64, hull: MeshHull<'_>) -> Result<(Self, f64), InvalidInput> {
        let mut worst = 0.0_f64;
        let mut bodies = Vec::with_capacity(self.links().len());
        for link in self.links() {
            let mut balls = Vec::new();
            for (index, body) in link.bodies.iter().enumerate() {
                let cover = solid(&body.shape, hull)
                    .and_then(|shape| Cover::new(&shape, overhang))
                    .map_err(|e| e.inside(&format!("link {}.collision[{index}]", link.name)))?;
                worst = worst.max(cover.overhang);
                for (center, radius) in cover.balls {
                    let origin = body.origin.compose(&Pose::at(center)?);
                    balls.push(Body { origin, shape: BodyShape::Sphere { radius } });
                }
            }
            bodies.push(balls);
        }
        Ok((self.with_bodies(bodies)?, worst))
    }
}

fn solid(shape: &BodyShape, hull: MeshHull<'_>) -> Result<Shape, InvalidInput> {
    match shape {
        BodyShape::Sphere { radius } => Shape::sphere(*radius),
        BodyShape::Box { half_extents } => Shape::cuboid(*half_extents),
        BodyShape::Cylinder { radius, length } => Shape::cylinder(*radius, *length),
        BodyShape::Capsule { radius, length } => Shape::capsule(*radius, *length),
        BodyShape::Mesh { file, scale } => Ok(Shape::Hull(hull(file, *scale)?)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Link;
    use super::*;

    #[test]
    fn every_kind_of_body_is_covered() {
        let corners: Vec<Vector> =
            (0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -0.1 } else { 0.1 })).collect();
        let shapes = [
            BodyShape::Sphere { radius: 0.1 },
            BodyShape::Box { half_extents: [0.1; 3] },
            BodyShape::Cylinder { radius: 0.1, length: 0.2 },
            BodyShape::Capsule { radius: 0.1, length: 0.2 },
            BodyShape::Mesh { file: "cube.stl".into(), scale: [1.0; 3] },
        ];
        let origin = Pose::from_rpy([0.0, 0.0, 1.0], [1.0, 2.0, 3.0]).unwrap();
        let bodies = shapes.into_iter().map(|shape| Body { origin, shape }).collect();
        let model = Model::new("m", vec![Link { name: "l".into(), bodies }], vec![]).unwrap();
        let mut hull = |file: &str, _: Vector| {
            assert_eq!(file, "cube.stl");
            Hull::around(&corners).map(Arc::new)
        };
        let (covered, worst) = model.clone().covered(0.02, &mut hull).unwrap();
        assert!(worst > 0.0 && worst <= 0.02 + 1e-12, "{worst}");
        let balls = &covered.links()[0].bodies;
        assert!(balls.len() > 10);
        assert!(balls.iter().all(|body| matches!(body.shape, BodyShape::Sphere { .. })));
        // All around the same place.
        for ball in balls {
            let [x, y, z] = ball.origin.translation();
            assert!((x - 1.0).abs() + (y - 2.0).abs() + (z - 3.0).abs() < 0.35);
        }
        let error = model.covered(1e-9, &mut hull).unwrap_err();
        assert_eq!(error.field, "link l.collision[1].overhang");
    }
}
