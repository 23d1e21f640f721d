//! Problems to JSON, as `problems.rs` reads them.

use serde_json::{Value, json};
use sidestep::space::{Object, Pose, Shape};

use super::problems::{PROBLEM_FORMAT, Problem};

/// The text of a file with these problems; the robot and its joints are the first one's.
///
/// Numbers are written so that they read to the same bits, poses as quaternions, whose rotations agree to
/// a few roundings. Meshes, hulls, height maps and clouds are written out.
pub fn write_problems(problems: &[Problem]) -> String {
    let (robot, joints, fixed): (&str, &[String], Value) = match problems.first() {
        Some(first) => {
            let fixed = first.fixed_joints.iter().map(|(name, v)| (name.clone(), json!(v)));
            (&first.robot, &first.joints, Value::Object(fixed.collect()))
        }
        None => ("", &[], json!({})),
    };
    let mut text = format!(
        "{{\n\"format\": {}, \"robot\": {}, \"joints\": {},\n\"fixed_joints\": {fixed},\n\"problems\": [",
        json!(PROBLEM_FORMAT),
        json!(robot),
        json!(joints)
    );
    for (i, problem) in problems.iter().enumerate() {
        let objects: Vec<Value> = problem.world.objects().iter().map(object).collect();
        let problem = json!({
            "name": problem.name,
            "start": problem.start,
            "goals": problem.goals,
            "objects": objects,
        });
        text.push_str(if i == 0 { "\n" } else { ",\n" });
        text.push_str(&problem.to_string());
    }
    text.push_str("\n]\n}\n");
    text
}

fn object(object: &Object) -> Value {
    let shapes: Vec<Value> = object.shapes().iter().map(|(pose, s)| shape(pose, s)).collect();
    json!({"name": object.name(), "shapes": shapes})
}

fn shape(pose: &Pose, shape: &Shape) -> Value {
    let sizes = match shape {
        Shape::Sphere { radius } => json!({"radius": radius}),
        Shape::Box { half_extents } => json!({"half_extents": half_extents}),
        Shape::Cylinder { radius, half_length } | Shape::Capsule { radius, half_length } => {
            json!({"radius": radius, "length": 2.0 * half_length})
        }
        Shape::Hull(hull) => json!({"vertices": hull.vertices()}),
        Shape::Mesh(mesh) => json!({"vertices": mesh.vertices(), "triangles": mesh.triangles()}),
        Shape::HeightMap(map) => {
            let rows: Vec<&[f64]> = map.heights().chunks(map.columns()).collect();
            json!({"resolution": map.resolution(), "base": map.base(), "rows": rows})
        }
        Shape::Points(cloud) => json!({"positions": cloud.points(), "radius": cloud.radius()}),
    };
    let mut value = serde_json::Map::new();
    value.insert(shape.kind().to_owned(), sizes);
    value.insert("position".to_owned(), json!(pose.translation()));
    value.insert("quaternion_wxyz".to_owned(), json!(pose.wxyz()));
    Value::Object(value)
}
