//! cuRobo's worlds as YAML: objects by kind, then by name.
//!
//! Source: cuRobo's documentation of world configurations. `cuboid: {name: {dims: full sizes,
//! pose}}`, `sphere: {name: {radius, position or pose}}`, `capsule: {name: {radius, base, tip,
//! pose}}`, `cylinder: {name: {radius, height, pose}}`, `mesh: {name: {file_path, pose, scale}}`; a
//! pose is `[x, y, z, qw, qx, qy, qz]`. Colours and the like are passed over, other kinds refused.

use sidestep::InvalidInput;
use sidestep::space::vector::{add, scale, sub, unit};
use sidestep::space::{Pose, Shape, Vector, World};

use super::objects::Objects;
use super::{Load, mesh, tree};
use crate::error::FormatError;
use crate::json::Node;

const KINDS: [&str; 5] = ["cuboid", "sphere", "capsule", "cylinder", "mesh"];

/// The world of a cuRobo file.
pub(super) fn read(root: &Node<'_>, load: Load<'_>) -> Result<World, FormatError> {
    root.object(&KINDS)?;
    let mut objects = Objects::default();
    for (kind, group) in tree::fields(root)? {
        for (name, item) in tree::fields(&group)? {
            let (pose, shape) = read_object(kind, &item, load)?;
            objects.add(name.to_owned(), vec![(pose, shape)]);
        }
    }
    objects.world(root)
}

fn read_object(kind: &str, node: &Node<'_>, load: Load<'_>) -> Result<(Pose, Shape), FormatError> {
    let pose = match (node.optional("pose"), node.optional("position")) {
        (Some(pose), _) => tree::flat_pose(&pose)?,
        (None, Some(position)) => {
            Pose::at(tree::vector(&position)?).map_err(|invalid| tree::below(node, invalid))?
        }
        (None, None) if kind == "capsule" => Pose::IDENTITY,
        (None, None) => {
            let found = "no field \"pose\"";
            return Err(node.found(found, "\"pose\": [x, y, z, qw, qx, qy, qz]"));
        }
    };
    let number = |key| node.required(key, "a number of metres").and_then(|node| node.number());
    let made = match kind {
        "cuboid" => {
            let sizes = tree::vector(&node.required("dims", "the three full sizes")?)?;
            Shape::cuboid(sizes.map(|size| 0.5 * size))
                .map_err(|invalid| tree::renamed(invalid, "half_extents", "dims"))
        }
        "sphere" => Shape::sphere(number("radius")?),
        "cylinder" => Shape::cylinder(number("radius")?, number("height")?)
            .map_err(|invalid| tree::renamed(invalid, "length", "height")),
        "capsule" => {
            let base = tree::vector(&node.required("base", "the centre of one end")?)?;
            let tip = tree::vector(&node.required("tip", "the centre of the other end")?)?;
            let (inner, shape) =
                capsule(number("radius")?, base, tip).map_err(|e| tree::below(node, e))?;
            return Ok((pose.compose(&inner), shape));
        }
        _ => {
            let file = node.required("file_path", "the name of an STL or OBJ file")?;
            let scale = match node.optional("scale") {
                Some(scale) => tree::vector(&scale)?,
                None => [1.0; 3],
            };
            let bytes = tree::load(&file, load)?;
            return Ok((pose, mesh::shape(file.string()?, &bytes, scale, false)?));
        }
    };
    Ok((pose, made.map_err(|invalid| tree::below(node, invalid))?))
}

/// A capsule between two points: z turned into their direction.
fn capsule(radius: f64, base: Vector, tip: Vector) -> Result<(Pose, Shape), InvalidInput> {
    let along = sub(tip, base);
    let middle = scale(add(base, tip), 0.5);
    let Some([x, y, z]) = unit(along) else {
        return Ok((Pose::at(middle)?, Shape::capsule(radius, 0.0)?));
    };
    let length = sidestep::space::vector::norm(along);
    // Half-way between z and the direction lies the axis of a half turn that swaps the two.
    let pose = match unit([x, y, z + 1.0]) {
        Some([a, b, c]) => Pose::from_wxyz([0.0, a, b, c], middle)?,
        None => Pose::from_wxyz([0.0, 1.0, 0.0, 0.0], middle)?,
    };
    Ok((pose, Shape::capsule(radius, length)?))
}
