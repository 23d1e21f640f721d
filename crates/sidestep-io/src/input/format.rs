//! The kinds of files, by name and by first bytes.

use std::fmt;
use std::str::FromStr;

use sidestep::InvalidInput;

use super::text::decode;
use crate::benchmarks::barn;
use crate::error::{FormatError, Place, quoted};
use crate::scenes;

/// A kind of file that holds tasks or a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Task JSON: a task or an array of tasks.
    Json,
    /// Task JSON, one task a line.
    JsonLines,
    /// BARN worlds as JSON.
    Barn,
    /// A MovingAI map.
    MovingAiMap,
    /// A MovingAI scenario, its maps beside it.
    MovingAiScen,
    /// A ROS map's YAML, its image beside it.
    RosMap,
    /// MPNet Simple2D worlds, `obs.dat` beside them.
    Mpnet,
    /// Problems of a robot with joints, as JSON.
    Problems,
    /// A picture of a workspace: PNG, PGM or JPEG.
    Picture,
}

/// Bytes of a file that its kind is guessed from.
const HEAD: usize = 4096;

impl Format {
    /// Every kind, with its name.
    pub const ALL: [(Self, &'static str); 9] = [
        (Self::Json, "json"),
        (Self::JsonLines, "jsonl"),
        (Self::Barn, "barn"),
        (Self::MovingAiMap, "map"),
        (Self::MovingAiScen, "scen"),
        (Self::RosMap, "ros"),
        (Self::Mpnet, "mpnet"),
        (Self::Problems, "problems"),
        (Self::Picture, "picture"),
    ];

    /// The kind of the file of this name, or where the name says nothing, of these bytes. Whether JSON is
    /// a task, BARN worlds or problems of a robot with joints follows from the bytes alone.
    ///
    /// # Errors
    /// If neither says what it is.
    pub fn of(name: &str, bytes: &[u8]) -> Result<Self, FormatError> {
        let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension);
        let found = match extension.to_ascii_lowercase().as_str() {
            "json" => Some(json(bytes)),
            "jsonl" | "ndjson" => Some(Self::JsonLines),
            "map" => Some(Self::MovingAiMap),
            "scen" => Some(Self::MovingAiScen),
            "yaml" | "yml" => Some(Self::RosMap),
            "dat" => Some(Self::Mpnet),
            "png" | "pgm" | "jpg" | "jpeg" => Some(Self::Picture),
            _ => by_content(bytes),
        };
        found.ok_or_else(|| {
            let start = quoted(&String::from_utf8_lossy(&bytes[..bytes.len().min(20)]));
            let found = if bytes.is_empty() {
                "an empty file".into()
            } else {
                format!("an unknown kind of file that begins with {start}")
            };
            let expected = "a name that ends in .json, .jsonl, .map, .scen, .yaml, .yml, .dat, .png, \
                            .pgm or .jpg, or the kind given (json, jsonl, barn, map, scen, ros, mpnet, \
                            problems, picture)";
            FormatError::new("input", Place::default(), found, expected)
        })
    }

    /// What people call it, for messages.
    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Json | Self::JsonLines => "task JSON",
            Self::Barn => "BARN worlds",
            Self::MovingAiMap => "MovingAI map",
            Self::MovingAiScen => "MovingAI scen",
            Self::RosMap => "ROS map YAML",
            Self::Mpnet => "MPNet Simple2D",
            Self::Problems => "problems JSON",
            Self::Picture => "picture",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::ALL.iter().find(|(format, _)| format == self).map_or("", |(_, name)| name);
        f.write_str(name)
    }
}

impl FromStr for Format {
    type Err = InvalidInput;

    fn from_str(name: &str) -> Result<Self, InvalidInput> {
        Self::ALL.iter().find(|(_, known)| *known == name).map(|&(format, _)| format).ok_or_else(
            || {
                let names = Self::ALL.map(|(_, name)| name).join(", ");
                InvalidInput::new("format", quoted(name), format!("one of {names}"))
            },
        )
    }
}

fn json(bytes: &[u8]) -> Format {
    match decode("JSON", bytes) {
        Ok(text) if scenes::is_problems(&text) => Format::Problems,
        Ok(text) if barn::is_barn(&text) => Format::Barn,
        _ => Format::Json,
    }
}

/// The kind that the first words say. MPNet's numbers say nothing of themselves.
fn by_content(bytes: &[u8]) -> Option<Format> {
    if [&b"\x89PNG"[..], b"\xff\xd8\xff", b"P5", b"P2"].iter().any(|mark| bytes.starts_with(mark)) {
        return Some(Format::Picture);
    }
    // Cut in a character, the head is still good enough.
    let head = &bytes[..bytes.len().min(HEAD)];
    let head = match decode("input", head) {
        Ok(text) => text.into_owned(),
        Err(_) => String::from_utf8_lossy(head).into_owned(),
    };
    let mut lines = head.lines().map(str::trim).filter(|line| !line.is_empty());
    let first = lines.next()?;
    let words: Vec<&str> = first.split_whitespace().collect();
    match words.as_slice() {
        // A whole document on the first line and another on the second.
        [word, ..] if word.starts_with('{') && first.ends_with('}') => match lines.next() {
            Some(second) if second.starts_with('{') => Some(Format::JsonLines),
            _ => Some(json(bytes)),
        },
        [word, ..] if word.starts_with(['{', '[']) => Some(json(bytes)),
        ["type", "octile"] | ["height" | "width", _] => Some(Format::MovingAiMap),
        ["version", _] => Some(Format::MovingAiScen),
        [bucket, .., _, _, _, _, _, _, _] if bucket.parse::<u32>().is_ok() => {
            Some(Format::MovingAiScen)
        }
        _ => head
            .lines()
            .any(|line| line.trim_start().starts_with("image:"))
            .then_some(Format::RosMap),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_first_bytes_say_what_a_file_is() {
        for (name, bytes, expected) in [
            ("a/b.JSON", "{}", Some(Format::Json)),
            ("b.json", "{\"start\": 1, \"worlds\": {}}", Some(Format::Barn)),
            ("b.json", "{\"format\": \"sidestep.problems/1\"}", Some(Format::Problems)),
            ("b.ndjson", "", Some(Format::JsonLines)),
            ("c.map", "{}", Some(Format::MovingAiMap)),
            ("c.map.scen", "", Some(Format::MovingAiScen)),
            ("m.yml", "", Some(Format::RosMap)),
            ("obs.dat", "", Some(Format::Mpnet)),
            ("-", "\u{feff}{\n\"format\"", Some(Format::Json)),
            ("/dev/fd/63", "[{}]", Some(Format::Json)),
            ("-", "{\"a\": 1}\n{\"a\": 2}\n", Some(Format::JsonLines)),
            ("-", "{\"a\": 1}\n\n", Some(Format::Json)),
            ("-", "{\"worlds\": {}, \"start\": 0}", Some(Format::Barn)),
            ("-", "\r\ntype octile\r\nheight 3", Some(Format::MovingAiMap)),
            ("-", "version 1\n0 a.map", Some(Format::MovingAiScen)),
            ("-", "0\ta b.map\t4\t4\t0\t0\t1\t1\t1.4", Some(Format::MovingAiScen)),
            ("-", "# a map\nimage: room.pgm\n", Some(Format::RosMap)),
            ("folder.d/file", "P5 1 1 255 x", Some(Format::Picture)),
            ("-", "", None),
            ("picture.png", "\u{1}", Some(Format::Picture)),
            ("movie.gif", "GIF89a", None),
        ] {
            assert_eq!(Format::of(name, bytes.as_bytes()).ok(), expected, "{name} {bytes:?}");
        }
        for (format, name) in Format::ALL {
            assert_eq!((name.parse(), format.to_string()), (Ok(format), name.to_string()));
        }
        assert!("yaml".parse::<Format>().is_err());
    }
}
