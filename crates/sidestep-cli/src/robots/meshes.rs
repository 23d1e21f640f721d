//! Mesh files that a URDF names: where they lie, and their convex hulls.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use sidestep::InvalidInput;
use sidestep::space::{Hull, Shape, Vector};
use sidestep_io::scenes::mesh;

use crate::source;

/// Meshes of one URDF.
pub struct Meshes<'a> {
    /// The URDF's folder.
    folder: PathBuf,
    /// Packages that the command line names.
    packages: &'a [(String, PathBuf)],
    /// Hulls by name and scale; robots use a mesh more than once.
    known: HashMap<(String, [u64; 3]), Arc<Hull>>,
    /// Every file that was read.
    pub read: Vec<PathBuf>,
}

impl<'a> Meshes<'a> {
    /// Of a URDF at this path.
    pub fn new(urdf: &Path, packages: &'a [(String, PathBuf)]) -> Self {
        let folder = urdf.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).to_path_buf();
        Self { folder, packages, known: HashMap::new(), read: Vec::new() }
    }

    /// The convex hull of a mesh.
    pub fn hull(&mut self, file: &str, scale: Vector) -> Result<Arc<Hull>, InvalidInput> {
        let key = (file.to_owned(), scale.map(f64::to_bits));
        if let Some(hull) = self.known.get(&key) {
            return Ok(hull.clone());
        }
        let wrong = |found: String, allowed: &str| {
            InvalidInput::new(format!("mesh {file:?}"), found, allowed)
        };
        let path = self.find(file)?;
        let bytes = source::companion(&path).map_err(|error| {
            wrong(format!("{}, which cannot be read ({error})", path.display()), "a readable file")
        })?;
        self.read.push(path.clone());
        let shape = mesh::shape(&path.to_string_lossy(), &bytes, scale, true)
            .map_err(|error| wrong(error.to_string(), "an STL or OBJ file with a volume"))?;
        match shape {
            Shape::Hull(hull) => {
                self.known.insert(key, hull.clone());
                Ok(hull)
            }
            other => Err(wrong(other.kind().into(), "a hull")),
        }
    }

    /// Where a mesh lies.
    fn find(&self, file: &str) -> Result<PathBuf, InvalidInput> {
        let wrong = |allowed: String| InvalidInput::new("mesh", format!("{file:?}"), allowed);
        if let Some(rest) =
            file.strip_prefix("package://").or_else(|| file.strip_prefix("model://"))
        {
            let (package, inside) = rest.split_once('/').unwrap_or((rest, ""));
            let stays = Path::new(inside).components().all(|c| matches!(c, Component::Normal(_)));
            if package.is_empty() || inside.is_empty() || !stays {
                return Err(wrong("package://NAME/path".into()));
            }
            let found = self.package(package).map(|folder| folder.join(inside));
            return found.ok_or_else(|| {
                let looked = "not found around the URDF, in ROS_PACKAGE_PATH or AMENT_PREFIX_PATH";
                wrong(format!("package {package:?}: {looked}; say --package {package}=DIR"))
            });
        }
        if let Some(path) = file.strip_prefix("file://") {
            return Ok(path.into());
        }
        match file.split_once("://") {
            Some(_) => Err(wrong("a path, file:// or package://".into())),
            None => Ok(self.folder.join(file)),
        }
    }

    /// The folder of a package.
    fn package(&self, name: &str) -> Option<PathBuf> {
        if let Some((_, folder)) = self.packages.iter().find(|(known, _)| known == name) {
            return Some(folder.clone());
        }
        let around = std::fs::canonicalize(&self.folder).unwrap_or_else(|_| self.folder.clone());
        for folder in around.ancestors() {
            let names_it = folder.file_name().is_some_and(|last| last == name);
            if names_it || is_package(folder, name) {
                return Some(folder.into());
            }
            if folder.join(name).is_dir() {
                return Some(folder.join(name));
            }
        }
        let paths = |variable, below: &str| {
            let value = std::env::var_os(variable).unwrap_or_default();
            std::env::split_paths(&value).map(|path| path.join(below)).collect::<Vec<_>>()
        };
        let mut places = paths("ROS_PACKAGE_PATH", "");
        places.extend(paths("AMENT_PREFIX_PATH", "share"));
        places.into_iter().map(|place| place.join(name)).find(|place| place.is_dir())
    }
}

/// Whether a folder's `package.xml` has this name.
fn is_package(folder: &Path, name: &str) -> bool {
    let text = source::companion(&folder.join("package.xml")).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    text.split("<name>").nth(1).and_then(|rest| rest.split("</name>").next()).map(str::trim)
        == Some(name)
}
