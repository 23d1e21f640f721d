//! Our own scene JSON, version 1.
//!
//! ```json
//! {
//!   "format": "sidestep.scene/1",
//!   "objects": [
//!     {"name": "table", "shapes": [{"box": {"half_extents": [0.4, 0.6, 0.02]}, "position": [0.5, 0, 0.3]}]},
//!     {"name": "can", "shapes": [{"cylinder": {"radius": 0.03, "length": 0.12},
//!       "position": [0.5, 0, 0.38], "quaternion_wxyz": [1, 0, 0, 0]}]}
//!   ]
//! }
//! ```
//!
//! Metres and radians. A shape is one of `sphere {radius}`, `box {half_extents}`, `cylinder
//! {radius, length}` (flat ends, about z), `capsule {radius, length}` (between the centres of its
//! ends), `hull` and `mesh` (`{file, scale}` or `{vertices}` and for a mesh `triangles`),
//! `height_map {resolution, base, rows}` (the row of the smallest y first) and `points` (`{file,
//! radius}` or `{positions, radius}`). `position` is zero and the orientation, one of
//! `quaternion_wxyz`, `quaternion_xyzw` and `rpy`, the identity where it is missing. An unknown
//! field is an error. The JSON Schema is `schemas/scene-1.schema.json`.

use std::sync::Arc;

use sidestep::space::{HeightMap, Hull, Mesh, PointCloud, Pose, Shape, Vector, World};

use super::objects::Objects;
use super::{Load, mesh, points, tree};
use crate::error::{FormatError, nearest};
use crate::json::{Json, Node, parse};

/// What `format` says in a scene of this version.
pub const SCENE_FORMAT: &str = "sidestep.scene/1";

const FORMAT: &str = "scene JSON";
const SHAPES: [&str; 8] =
    ["sphere", "box", "cylinder", "capsule", "hull", "mesh", "height_map", "points"];
const PLACE: [&str; 4] = ["position", "quaternion_wxyz", "quaternion_xyzw", "rpy"];

/// The world of a scene's text.
pub(super) fn read(text: &str, load: Load<'_>) -> Result<World, FormatError> {
    let json = parse(FORMAT, text, 1)?;
    let root = tree::root(FORMAT, text, &json);
    root.object(&["format", "objects"])?;
    let format = root.required("format", &format!("{SCENE_FORMAT:?}"))?;
    if format.string()? != SCENE_FORMAT {
        let expected = format!("{SCENE_FORMAT:?}, the one version that this program reads");
        return Err(format.wrong(expected));
    }
    read_objects(&root.required("objects", "an array of objects")?, load)
}

/// The world of an array of objects.
pub(super) fn read_objects(list: &Node<'_>, load: Load<'_>) -> Result<World, FormatError> {
    let mut objects = Objects::default();
    for item in list.items("an array of objects")? {
        item.object(&["name", "shapes"])?;
        let name = item.required("name", "a name")?.string()?.to_owned();
        let shapes = item.required("shapes", "an array of shapes")?;
        let shapes: Result<Vec<_>, _> =
            shapes.items("an array of shapes")?.map(|shape| read_shape(&shape, load)).collect();
        objects.add(name, shapes?);
    }
    objects.world(list)
}

fn read_shape(node: &Node<'_>, load: Load<'_>) -> Result<(Pose, Shape), FormatError> {
    let known: Vec<&str> = SHAPES.iter().chain(&PLACE).copied().collect();
    node.object(&known)?;
    let mut kinds = SHAPES.iter().filter_map(|&kind| Some((kind, node.optional(kind)?)));
    let (Some((kind, value)), None) = (kinds.next(), kinds.next()) else {
        return Err(node.wrong(format!("exactly one of {}", SHAPES.join(", "))));
    };
    let pose = read_pose(node)?;
    let shape = match kind {
        "sphere" => {
            value.object(&["radius"])?;
            Shape::sphere(length(&value, "radius")?)
        }
        "box" => {
            value.object(&["half_extents"])?;
            Shape::cuboid(tree::vector(&value.required("half_extents", "three numbers above 0")?)?)
        }
        "cylinder" | "capsule" => {
            value.object(&["radius", "length"])?;
            let (radius, length) = (length(&value, "radius")?, length(&value, "length")?);
            if kind == "cylinder" {
                Shape::cylinder(radius, length)
            } else {
                Shape::capsule(radius, length)
            }
        }
        "hull" | "mesh" => return Ok((pose, read_mesh(&value, kind == "hull", load)?)),
        "height_map" => read_height_map(&value)?,
        _ => read_points(&value, load)?,
    };
    Ok((pose, shape.map_err(|invalid| tree::below(&value, invalid))?))
}

/// The pose that stands beside a shape: `position`, and one of three ways to say an orientation.
pub(super) fn read_pose(node: &Node<'_>) -> Result<Pose, FormatError> {
    let position = match node.optional("position") {
        Some(position) => tree::vector(&position)?,
        None => [0.0; 3],
    };
    let given: Vec<&str> =
        PLACE[1..].iter().copied().filter(|key| node.optional(key).is_some()).collect();
    if given.len() > 1 {
        return Err(node.found(given.join(" and "), "one of them"));
    }
    let pose = match given.first().and_then(|&key| Some((key, node.optional(key)?))) {
        None => Pose::at(position),
        Some(("rpy", rpy)) => Pose::from_rpy(tree::vector(&rpy)?, position),
        Some((key, value)) => {
            let numbers = tree::numbers(&value, "a unit quaternion of four numbers")?;
            let pose = match key {
                "quaternion_wxyz" => Pose::from_wxyz(numbers, position),
                _ => Pose::from_xyzw(numbers, position),
            };
            pose.map_err(|invalid| tree::renamed(invalid, "quaternion", key))
        }
    };
    pose.map_err(|invalid| tree::below(node, invalid))
}

fn length(node: &Node<'_>, key: &str) -> Result<f64, FormatError> {
    node.optional(key)
        .ok_or_else(|| node.found(format!("no field {key:?}"), "a number of metres"))?
        .number()
}

fn read_mesh(node: &Node<'_>, hull: bool, load: Load<'_>) -> Result<Shape, FormatError> {
    if let Some(file) = node.optional("file") {
        node.object(&["file", "scale"])?;
        let scale = match node.optional("scale") {
            Some(scale) => tree::vector(&scale)?,
            None => [1.0; 3],
        };
        let bytes = tree::load(&file, load)?;
        return mesh::shape(file.string()?, &bytes, scale, hull);
    }
    node.object(if hull { &["vertices"] } else { &["vertices", "triangles"] })?;
    let vertices = vectors(&node.required("vertices", "an array of points, or a \"file\"")?)?;
    let shape = if hull {
        Hull::around(&vertices).map(|hull| Shape::Hull(Arc::new(hull)))
    } else {
        let list = node.required("triangles", "an array of three corners each")?;
        let triangles: Result<Vec<_>, _> =
            list.items("an array of three corners each")?.map(|item| corners(&item)).collect();
        Mesh::new(vertices, triangles?).map(|mesh| Shape::Mesh(Arc::new(mesh)))
    };
    shape.map_err(|invalid| tree::below(node, tree::renamed(invalid, "points", "vertices")))
}

/// Points `[x, y, z]`.
pub(super) fn vectors(node: &Node<'_>) -> Result<Vec<Vector>, FormatError> {
    node.items("an array of points [x, y, z]")?.map(|item| tree::vector(&item)).collect()
}

/// Three corners of a triangle, counted from 0.
pub(super) fn corners(node: &Node<'_>) -> Result<[u32; 3], FormatError> {
    const EXPECTED: &str = "three corners, counted from 0";
    let numbers: [f64; 3] = tree::numbers(node, EXPECTED)?;
    if numbers.iter().any(|v| v.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(v)) {
        return Err(node.found(format!("{numbers:?}"), EXPECTED));
    }
    Ok(numbers.map(|v| v as u32))
}

type Made = Result<Shape, sidestep::InvalidInput>;

fn read_height_map(node: &Node<'_>) -> Result<Made, FormatError> {
    node.object(&["resolution", "base", "rows"])?;
    let resolution = length(node, "resolution")?;
    let base = match node.optional("base") {
        Some(base) => base.number()?,
        None => 0.0,
    };
    let rows = node.required("rows", "an array of rows of heights")?;
    let mut columns = 0;
    let mut heights = Vec::new();
    for row in rows.items("an array of rows of heights")? {
        let row_heights = tree::all_numbers(&row, "an array of heights")?;
        if !heights.is_empty() && row_heights.len() != columns {
            let found = format!("{} heights", row_heights.len());
            return Err(row.found(found, format!("{columns}, as the first row has")));
        }
        columns = row_heights.len();
        heights.extend(row_heights);
    }
    Ok(HeightMap::new(columns, resolution, base, heights)
        .map(|map| Shape::HeightMap(Arc::new(map)))
        .map_err(|invalid| tree::renamed(invalid, "heights", "rows")))
}

fn read_points(node: &Node<'_>, load: Load<'_>) -> Result<Made, FormatError> {
    node.object(&["file", "positions", "radius"])?;
    let radius = length(node, "radius")?;
    let positions = match (node.optional("file"), node.optional("positions")) {
        (Some(file), None) => points::read(file.string()?, &tree::load(&file, load)?)?,
        (None, Some(positions)) => vectors(&positions)?,
        _ => return Err(node.wrong("one of \"file\" and \"positions\"")),
    };
    Ok(PointCloud::new(positions, radius)
        .map(|cloud| Shape::Points(Arc::new(cloud)))
        .map_err(|invalid| tree::renamed(invalid, "points", "positions")))
}

/// A slip in the name of a format, for readers of several.
pub(super) fn similar<'a>(json: &Json, known: &[&'a str]) -> Option<&'a str> {
    match json {
        Json::String(text) => nearest(text, known),
        _ => None,
    }
}
