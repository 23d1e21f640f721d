//! Meshes: STL and OBJ files as triangles.

mod obj;
mod stl;

use std::sync::Arc;

use sidestep::space::{Hull, Mesh, Shape, Vector};

use crate::error::{FormatError, Place, quoted};

/// Corners and triangles of them, as a file has them: metres if the file says nothing else.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Triangles {
    /// The corners.
    pub vertices: Vec<Vector>,
    /// The triangles, each three corners.
    pub triangles: Vec<[u32; 3]>,
}

/// The triangles of a mesh file: STL (binary or text) or OBJ, by the file's extension.
///
/// # Errors
/// If the extension is another one, or the file is cut or not what its format allows; with the line
/// of a text.
pub fn read(file_name: &str, bytes: &[u8]) -> Result<Triangles, FormatError> {
    match super::extension(file_name).as_str() {
        "stl" => stl::read(bytes),
        "obj" => obj::read(bytes),
        _ => Err(FormatError::new(
            "a mesh",
            Place::default(),
            quoted(file_name),
            "an STL or OBJ file",
        )),
    }
}

/// A mesh file as a shape: its convex hull, or its surface; each axis scaled.
///
/// # Errors
/// As [`read`], and if a number is not allowed or a hull would have no volume.
pub fn shape(
    file_name: &str,
    bytes: &[u8],
    scale: [f64; 3],
    hull: bool,
) -> Result<Shape, FormatError> {
    let mut found = read(file_name, bytes)?;
    for vertex in &mut found.vertices {
        for k in 0..3 {
            vertex[k] *= scale[k];
        }
    }
    let made = if hull {
        Hull::around(&found.vertices).map(|hull| Shape::Hull(Arc::new(hull)))
    } else {
        Mesh::new(found.vertices, found.triangles).map(|mesh| Shape::Mesh(Arc::new(mesh)))
    };
    made.map_err(|invalid| {
        let place = Place::field(invalid.field);
        FormatError::new("a mesh", place, invalid.value, invalid.allowed)
    })
}
