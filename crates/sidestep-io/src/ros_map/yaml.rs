//! The YAML file of a ROS map. Fields that the formats do not know are passed over, as ROS does.

use serde::Deserialize;
use sidestep::plane::geometry::Point;

use crate::error::{FormatError, Place, nearest, quoted};

/// The format's name in errors.
pub(super) const FORMAT: &str = "ROS map YAML";

/// How pixels become occupancies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Mode {
    Trinary,
    Scale,
    Raw,
}

/// The checked contents of the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Header {
    pub(super) image: String,
    pub(super) resolution: f64,
    pub(super) origin: Point,
    pub(super) negate: bool,
    pub(super) occupied_thresh: f64,
    pub(super) free_thresh: f64,
    pub(super) mode: Mode,
}

/// The file as it stands.
#[derive(Deserialize)]
struct Fields {
    image: Option<String>,
    resolution: Option<f64>,
    origin: Option<Vec<f64>>,
    negate: Option<Negate>,
    occupied_thresh: Option<f64>,
    free_thresh: Option<f64>,
    mode: Option<String>,
}

/// 0 and 1 in most files, true and false in some.
#[derive(Deserialize)]
#[serde(untagged, expecting = "negate must be 0, 1, true or false")]
enum Negate {
    Number(f64),
    Word(bool),
}

impl Header {
    /// Reads and checks the YAML text.
    pub(super) fn read(text: &str) -> Result<Self, FormatError> {
        let options = serde_saphyr::options! { with_snippet: false };
        let fields: Fields =
            serde_saphyr::from_str_with_options(text, options).map_err(syntax_error)?;
        let image = required("image", fields.image)?;
        let resolution = required("resolution", fields.resolution)?;
        let origin = match required("origin", fields.origin)?.as_slice() {
            &[x, y, 0.0] => [x, y],
            [_, _, yaw] => {
                let expected = "0: a turned map is not supported; turn the image instead";
                return Err(wrong("origin[2] (yaw)", yaw, expected));
            }
            other => {
                let found = format!("{} numbers", other.len());
                return Err(wrong("origin", found, "[x, y, yaw]"));
            }
        };
        let negate = match required("negate", fields.negate)? {
            Negate::Word(negate) => negate,
            Negate::Number(0.0) => false,
            Negate::Number(1.0) => true,
            Negate::Number(other) => return Err(wrong("negate", other, "0 or 1")),
        };
        let occupied_thresh = threshold("occupied_thresh", fields.occupied_thresh)?;
        let free_thresh = threshold("free_thresh", fields.free_thresh)?;
        if free_thresh > occupied_thresh {
            let expected = format!("at most occupied_thresh = {occupied_thresh}");
            return Err(wrong("free_thresh", free_thresh, expected));
        }
        let mode = match fields.mode.as_deref() {
            None | Some("trinary") => Mode::Trinary,
            Some("scale") => Mode::Scale,
            Some("raw") => Mode::Raw,
            Some(other) => {
                let known = ["trinary", "scale", "raw"];
                let near = nearest(other, &known).map(|name| format!(" (did you mean {name}?)"));
                let expected = format!("{}{}", known.join(", "), near.unwrap_or_default());
                return Err(wrong("mode", quoted(other), expected));
            }
        };
        Ok(Self { image, resolution, origin, negate, occupied_thresh, free_thresh, mode })
    }
}

const FIELDS: &str = "the fields image (a file name), resolution, origin ([x, y, 0]), negate (0 or 1), \
     occupied_thresh, free_thresh and, if wanted, mode";

fn syntax_error(error: serde_saphyr::Error) -> FormatError {
    let place = match error.location() {
        Some(at) => Place::line(at.line() as usize).with_column(at.column() as usize),
        None => Place::default(),
    };
    // The place says the position already, and hints about the parser's options help nobody here.
    let text = error.to_string();
    let message = text.split(" at line ").next().unwrap_or(&text);
    let message = message.split(", set ").next().unwrap_or(message);
    FormatError::new(FORMAT, place, format!("a fault ({message})"), FIELDS)
}

fn required<T>(field: &str, value: Option<T>) -> Result<T, FormatError> {
    value.ok_or_else(|| wrong(field, "no such field", FIELDS))
}

fn threshold(field: &str, value: Option<f64>) -> Result<f64, FormatError> {
    let value = required(field, value)?;
    if (0.0..=1.0).contains(&value) {
        Ok(value)
    } else {
        Err(wrong(field, value, "a number from 0 to 1"))
    }
}

fn wrong(field: &str, found: impl std::fmt::Display, expected: impl Into<String>) -> FormatError {
    FormatError::new(FORMAT, Place::field(field), found, expected)
}
