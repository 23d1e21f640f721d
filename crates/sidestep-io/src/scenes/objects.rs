//! Objects on their way into a world: names made unique, faults told by field.

use std::collections::HashMap;

use sidestep::space::{Object, Pose, Shape, World};

use crate::error::FormatError;
use crate::json::Node;

/// The objects of a scene, in its order.
#[derive(Default)]
pub(super) struct Objects {
    objects: Vec<Object>,
    /// How often a name was given.
    names: HashMap<String, usize>,
}

impl Objects {
    /// Adds an object; a name that is taken gets a number: `can`, `can (2)`.
    pub(super) fn add(&mut self, name: String, shapes: Vec<(Pose, Shape)>) {
        let mut unique = name.clone();
        while let Some(count) = self.names.get_mut(&unique) {
            *count += 1;
            unique = format!("{name} ({count})");
        }
        self.names.insert(unique.clone(), 1);
        self.objects.push(Object::new(unique, shapes));
    }

    /// The world of all objects; a refusal is told as one of `node`.
    pub(super) fn world(self, node: &Node<'_>) -> Result<World, FormatError> {
        World::new(self.objects).map_err(|invalid| super::tree::below(node, invalid))
    }

    /// The objects themselves.
    pub(super) fn into_inner(self) -> Vec<Object> {
        self.objects
    }
}
