//! MoveIt's `.scene` files: a planning scene's geometry as text.
//!
//! Source: MoveIt's documentation of its scene files and the texts that it writes. A name; then for
//! each object `* id`, in files of today the object's position and orientation (xyzw), the number
//! of shapes, and for each shape its kind and sizes, position, orientation and a colour; in files
//! of today the number of named frames and these; at the end a dot. Sizes: box x y z (full), sphere
//! radius, cylinder radius length, mesh corners triangles and then both. What is not read is
//! refused.

use std::sync::Arc;

use sidestep::InvalidInput;
use sidestep::space::{Mesh, Pose, Shape, World};

use super::objects::Objects;
use crate::error::{FormatError, Place, quoted};

pub(super) const FORMAT: &str = "MoveIt .scene";

/// The world of a `.scene` text.
pub(super) fn read(text: &str) -> Result<World, FormatError> {
    let mut words = Words::new(text);
    // The scene's name fills the first line.
    words.rest_of_line();
    let mut objects = Objects::default();
    loop {
        let line = words.line();
        if line == "." {
            break;
        }
        let name = line.strip_prefix('*').map(str::trim).filter(|name| !name.is_empty());
        let Some(name) = name else {
            let found = if line.is_empty() { "the end of the file".into() } else { quoted(line) };
            return Err(words.wrong(found, "\"* name\" of an object, or a dot at the end"));
        };
        // Files of before 2020 have no pose of the object: their next line is a number alone.
        let posed = words.words_on_line() > 1;
        let base = if posed { words.pose()? } else { Pose::IDENTITY };
        let count = words.count("the number of shapes")?;
        let mut shapes = Vec::new();
        for _ in 0..count {
            let shape = words.shape()?;
            shapes.push((base.compose(&words.pose()?), shape));
            for _ in 0..4 {
                words.number("a colour of four numbers")?;
            }
        }
        if posed {
            for _ in 0..words.count("the number of named frames")? {
                words.line();
                words.pose()?;
            }
        }
        objects.add(name.to_owned(), shapes);
    }
    World::new(objects.into_inner()).map_err(|invalid| words.refused(invalid))
}

/// The words of a text, and on which line they stand.
struct Words<'a> {
    rest: &'a str,
    line: usize,
}

impl<'a> Words<'a> {
    fn new(text: &'a str) -> Self {
        Self { rest: text, line: 1 }
    }

    fn wrong(&self, found: impl std::fmt::Display, expected: &str) -> FormatError {
        FormatError::new(FORMAT, Place::line(self.line), found, expected)
    }

    fn refused(&self, invalid: InvalidInput) -> FormatError {
        let place = Place::line(self.line).with_field(invalid.field);
        FormatError::new(FORMAT, place, invalid.value, invalid.allowed)
    }

    fn skip_space(&mut self) {
        let start = self.rest.trim_start();
        let skipped = &self.rest[..self.rest.len() - start.len()];
        self.line += skipped.matches('\n').count();
        self.rest = start;
    }

    fn next(&mut self, expected: &str) -> Result<&'a str, FormatError> {
        self.skip_space();
        let end = self.rest.find(char::is_whitespace).unwrap_or(self.rest.len());
        if end == 0 {
            return Err(self.wrong("the end of the file", expected));
        }
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        Ok(word)
    }

    /// The rest of the next line that is not empty.
    fn line(&mut self) -> &'a str {
        self.skip_space();
        self.rest_of_line()
    }

    fn rest_of_line(&mut self) -> &'a str {
        self.rest = self.rest.trim_start_matches([' ', '\t']);
        let end = self.rest.find('\n').unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest;
        line.trim()
    }

    fn words_on_line(&mut self) -> usize {
        self.skip_space();
        self.rest.lines().next().map_or(0, |line| line.split_whitespace().count())
    }

    fn number(&mut self, expected: &str) -> Result<f64, FormatError> {
        let word = self.next(expected)?;
        word.parse().map_err(|_| self.wrong(quoted(word), expected))
    }

    fn numbers<const N: usize>(&mut self, expected: &str) -> Result<[f64; N], FormatError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number(expected)?;
        }
        Ok(numbers)
    }

    fn count(&mut self, expected: &str) -> Result<u32, FormatError> {
        let word = self.next(expected)?;
        word.parse().map_err(|_| self.wrong(quoted(word), expected))
    }

    fn pose(&mut self) -> Result<Pose, FormatError> {
        let position = self.numbers("a position of three numbers")?;
        let xyzw = self.numbers("an orientation of four numbers, xyzw")?;
        Pose::from_xyzw(xyzw, position).map_err(|invalid| self.refused(invalid))
    }

    fn shape(&mut self) -> Result<Shape, FormatError> {
        const KINDS: &str = "box, sphere, cylinder or mesh";
        let made = match self.next(KINDS)? {
            "box" => {
                let sizes: [f64; 3] = self.numbers("three full sizes")?;
                Shape::cuboid(sizes.map(|size| 0.5 * size))
            }
            "sphere" => Shape::sphere(self.number("a radius")?),
            "cylinder" => {
                let [radius, length] = self.numbers("a radius and a length")?;
                Shape::cylinder(radius, length)
            }
            "mesh" => {
                let corners = self.count("the number of corners")?;
                let triangles = self.count("the number of triangles")?;
                // Grown as they are read: a number in a file reserves nothing.
                let (mut vertices, mut faces) = (Vec::new(), Vec::new());
                for _ in 0..corners {
                    vertices.push(self.numbers("a corner of three numbers")?);
                }
                for _ in 0..triangles {
                    let mut face = [0; 3];
                    for corner in &mut face {
                        *corner = self.count("three corners, counted from 0")?;
                    }
                    faces.push(face);
                }
                Mesh::new(vertices, faces).map(|mesh| Shape::Mesh(Arc::new(mesh)))
            }
            other => return Err(self.wrong(quoted(other), KINDS)),
        };
        made.map_err(|invalid| self.refused(invalid))
    }
}
