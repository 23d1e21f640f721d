//! Worlds in space and problems of robots with joints, from bytes.
//!
//! [`read_scene`] reads a world: our own JSON, a MoveIt planning scene (YAML, or the text of a
//! `.scene` file), a cuRobo world, a cloud of points (PCD, PLY, XYZ) or a mesh (STL, OBJ).
//! [`read_problems`] reads what a robot is asked: our own JSON, MotionBenchMaker's problems as
//! JSON; [`read_request`] a MotionBenchMaker request, whose world lies in a file beside it. Files
//! that a scene names are loaded by the caller, so that nothing here opens one.

mod curobo;
mod json;
pub mod mesh;
mod moveit;
mod moveit_text;
mod objects;
pub mod points;
mod problems;
mod tree;
mod write;

use sidestep::space::{Object, PointCloud, Pose, Shape, World};

use crate::error::{FormatError, Place};

pub use json::SCENE_FORMAT;
pub use moveit::{Request, read_request};
pub(crate) use problems::is_problems;
pub use problems::{PROBLEM_FORMAT, Problem, read_problems};
pub use write::write_problems;

/// Gives the bytes of a file by the name that another file calls it.
pub type Load<'a> = &'a mut dyn FnMut(&str) -> std::io::Result<Vec<u8>>;

/// What a reader may be told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneOptions {
    /// Radius of the ball around each point of a cloud, metres.
    pub point_radius: f64,
    /// Whether a mesh that is a file of its own stands for its convex hull (a solid) or for its
    /// surface.
    pub hull: bool,
}

impl Default for SceneOptions {
    /// Points of 1 cm, meshes as surfaces.
    fn default() -> Self {
        Self { point_radius: 0.01, hull: false }
    }
}

/// The world of a file: by its extension where that says enough, else by what it holds.
///
/// # Errors
/// If the format is none of ours, or the first fault, with its line or field.
pub fn read_scene(
    file_name: &str,
    bytes: &[u8],
    options: SceneOptions,
    load: Load<'_>,
) -> Result<World, FormatError> {
    let extension = extension(file_name);
    match extension.as_str() {
        "pcd" | "ply" | "xyz" => {
            let cloud = match extension.as_str() {
                "pcd" => points::read_pcd(bytes)?,
                "ply" => points::read_ply(bytes)?,
                _ => points::read_xyz(bytes)?,
            };
            let cloud = PointCloud::new(cloud, options.point_radius)
                .map_err(|invalid| refused("a point cloud", invalid))?;
            alone("points", Shape::Points(std::sync::Arc::new(cloud)))
        }
        "stl" | "obj" => {
            let shape = mesh::shape(file_name, bytes, [1.0; 3], options.hull)?;
            alone("mesh", shape)
        }
        "scene" => moveit_text::read(tree::text(moveit_text::FORMAT, bytes)?),
        _ => {
            let text = tree::text("a scene", bytes)?;
            if text.trim_start().starts_with('{') {
                return json::read(text, load);
            }
            let yaml = tree::yaml("scene YAML", text)?;
            let root = tree::root("scene YAML", text, &yaml);
            if root.optional("world").is_some() || root.optional("collision_objects").is_some() {
                moveit::read(&root)
            } else {
                curobo::read(&root, load)
            }
        }
    }
}

/// A world of one shape.
fn alone(name: &str, shape: Shape) -> Result<World, FormatError> {
    World::new(vec![Object::new(name, vec![(Pose::IDENTITY, shape)])])
        .map_err(|invalid| refused("a scene", invalid))
}

/// An error of the core about a whole file.
fn refused(format: &'static str, invalid: sidestep::InvalidInput) -> FormatError {
    FormatError::new(format, Place::field(invalid.field), invalid.value, invalid.allowed)
}

/// What stands behind the last dot of a file's name, in small letters.
fn extension(file_name: &str) -> String {
    file_name.rsplit_once('.').map_or("", |(_, extension)| extension).to_ascii_lowercase()
}
