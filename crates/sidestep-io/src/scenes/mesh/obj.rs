//! Wavefront OBJ: `v x y z` and `f a b c ...`, corners counted from 1, or from the last one
//! backwards where negative, each perhaps with `/texture/normal`. Faces are split into triangles
//! round their first corner, which is right for convex ones. All else (groups, materials, normals)
//! is passed over.

use super::Triangles;
use crate::error::{FormatError, Place, quoted};

const FORMAT: &str = "OBJ mesh";

pub(super) fn read(bytes: &[u8]) -> Result<Triangles, FormatError> {
    let text = super::super::tree::text(FORMAT, bytes)?;
    let mut found = Triangles::default();
    for (i, line) in text.lines().enumerate() {
        let wrong = |expected: &str| {
            FormatError::new(FORMAT, Place::line(i + 1), quoted(line.trim()), expected)
        };
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut vertex = [0.0; 3];
                for value in &mut vertex {
                    let number = words.next().and_then(|word| word.parse().ok());
                    *value = number.ok_or_else(|| wrong("v and three numbers"))?;
                }
                found.vertices.push(vertex);
            }
            Some("f") => {
                let count = found.vertices.len();
                let corner = |word: &str| -> Option<u32> {
                    let number: i64 = word.split('/').next()?.parse().ok()?;
                    let index = if number < 0 { count as i64 + number } else { number - 1 };
                    u32::try_from(index).ok().filter(|&index| (index as usize) < count)
                };
                let corners: Option<Vec<u32>> = words.map(corner).collect();
                let corners = corners.filter(|corners| corners.len() >= 3).ok_or_else(|| {
                    wrong(&format!("f and three or more corners that stand above, 1 to {count}"))
                })?;
                let fan = corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]);
                found.triangles.extend(fan);
            }
            _ => {}
        }
    }
    Ok(found)
}
