//! The YAML file of a ROS map. Fields that the formats do not know are passed over, as ROS does.

use serde::Deserialize;
use serde_saphyr::Spanned;
use sidestep::plane::geometry::Point;

use crate::error::{FormatError, Place, nearest, quoted};
use crate::input::without_mark;

/// The format's name in errors.
pub(super) const FORMAT: &str = "ROS map YAML";

/// How pixels become occupancies.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

/// The checked contents of the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Header {
    pub(super) image: String,
    pub(super) resolution: f64,
    pub(super) origin: Point,
    /// Counter-clockwise turn of the map about its origin, in radians.
    pub(super) yaw: f64,
    /// Where the yaw stands.
    pub(super) yaw_place: Place,
    pub(super) negate: bool,
    pub(super) occupied_thresh: f64,
    pub(super) free_thresh: f64,
    pub(super) mode: Mode,
    /// What was guessed.
    pub(super) warnings: Vec<String>,
}

/// A value as it stands in the text, and where: so every fault has its field and line.
type Word = Spanned<String>;

/// The file as it stands.
#[derive(Deserialize)]
struct Fields {
    image: Option<Word>,
    resolution: Option<Word>,
    origin: Option<Spanned<Vec<Word>>>,
    negate: Option<Word>,
    occupied_thresh: Option<Word>,
    free_thresh: Option<Word>,
    mode: Option<Word>,
}

const NAMES: [&str; 7] =
    ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"];

impl Header {
    /// Reads and checks the YAML text.
    pub(super) fn read(text: &str) -> Result<Self, FormatError> {
        let text = without_mark(text);
        let options = serde_saphyr::options! { with_snippet: false };
        let fields: Fields = serde_saphyr::from_str_with_options(text, options)
            .map_err(|error| syntax_error(text, &error))?;
        let image = required("image", fields.image)?;
        if image.value.is_empty() {
            return Err(wrong("image", &image, "a file name"));
        }
        let resolution = number("resolution", &required("resolution", fields.resolution)?)?;
        let mut warnings = Vec::new();
        let (origin, yaw, yaw_place) = origin(&required("origin", fields.origin)?, &mut warnings)?;
        let negate = required("negate", fields.negate)?;
        let negate = match negate.value.to_ascii_lowercase().as_str() {
            "1" | "true" | "yes" | "on" | "y" => true,
            "0" | "false" | "no" | "off" | "n" => false,
            _ => return Err(wrong("negate", &negate, "0, 1, true or false")),
        };
        let occupied_thresh = threshold("occupied_thresh", fields.occupied_thresh.as_ref())?;
        let free_word = fields.free_thresh;
        let free_thresh = threshold("free_thresh", free_word.as_ref())?;
        if let Some(word) = free_word.filter(|_| free_thresh > occupied_thresh) {
            let expected = format!("at most occupied_thresh = {occupied_thresh}");
            return Err(wrong("free_thresh", &word, expected));
        }
        let mode = match fields.mode {
            None => Mode::Trinary,
            Some(word) => mode(&word)?,
        };
        Ok(Self {
            image: image.value,
            resolution,
            origin,
            yaw,
            yaw_place,
            negate,
            occupied_thresh,
            free_thresh,
            mode,
            warnings,
        })
    }
}

/// The lower left corner, the yaw, and where the yaw stands.
fn origin(
    words: &Spanned<Vec<Word>>,
    warnings: &mut Vec<String>,
) -> Result<(Point, f64, Place), FormatError> {
    const YAW: &str = "origin[2] (yaw)";
    let (yaw, yaw_place) = match words.value.as_slice() {
        [_, _] => {
            warnings.push("origin has two numbers; a yaw of 0 is taken".into());
            (0.0, Place::default())
        }
        [_, _, yaw] => (number(YAW, yaw)?, place_of(yaw).with_field(YAW)),
        others => {
            let place = place_of(words).with_field("origin");
            let found = format!("{} numbers", others.len());
            return Err(FormatError::new(FORMAT, place, found, "[x, y, yaw]"));
        }
    };
    let corner = [number("origin[0]", &words.value[0])?, number("origin[1]", &words.value[1])?];
    Ok((corner, yaw, yaw_place))
}

fn mode(word: &Word) -> Result<Mode, FormatError> {
    match word.value.as_str() {
        "trinary" => Ok(Mode::Trinary),
        "scale" => Ok(Mode::Scale),
        "raw" => Ok(Mode::Raw),
        other => {
            let known = ["trinary", "scale", "raw"];
            let near = nearest(other, &known).map(|name| format!(" (did you mean {name}?)"));
            let expected = format!("{}{}", known.join(", "), near.unwrap_or_default());
            Err(wrong("mode", word, expected))
        }
    }
}

const FIELDS: &str = "the fields image (a file name), resolution, origin ([x, y, yaw]), negate (0 or 1), \
     occupied_thresh, free_thresh and, if wanted, mode";

/// A fault that the YAML parser found, with the field on whose line it lies.
fn syntax_error(text: &str, error: &serde_saphyr::Error) -> FormatError {
    let mut place = Place::default();
    if let Some(at) = error.location() {
        place = Place::line(at.line() as usize).with_column(at.column() as usize);
        let line = text.lines().nth((at.line() as usize).saturating_sub(1)).unwrap_or_default();
        let key = line.split(':').next().unwrap_or_default().trim();
        if NAMES.contains(&key) {
            place = place.with_field(key);
        }
    }
    // The place says the position already, and hints about the parser's options help nobody here.
    let text = error.to_string();
    let message = text.split(" at line ").next().unwrap_or(&text);
    let message = message.split(", set ").next().unwrap_or(message);
    FormatError::new(FORMAT, place, format!("a fault ({message})"), FIELDS)
}

fn required<T>(field: &str, value: Option<T>) -> Result<T, FormatError> {
    value.ok_or_else(|| FormatError::new(FORMAT, Place::field(field), "no such field", FIELDS))
}

fn threshold(field: &str, word: Option<&Word>) -> Result<f64, FormatError> {
    let word = required(field, word)?;
    match number(field, word) {
        Ok(value) if (0.0..=1.0).contains(&value) => Ok(value),
        _ => Err(wrong(field, word, "a number from 0 to 1")),
    }
}

/// A finite number; YAML's `.inf` and `.nan` and what C++ writes for them are named and refused.
fn number(field: &str, word: &Word) -> Result<f64, FormatError> {
    match word.value.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(wrong(field, word, "a finite number")),
    }
}

fn wrong(field: &str, word: &Word, expected: impl Into<String>) -> FormatError {
    let known = word.value.parse::<f64>().is_ok();
    let found = if known { word.value.clone() } else { quoted(&word.value) };
    FormatError::new(FORMAT, place_of(word).with_field(field), found, expected)
}

fn place_of<T>(word: &Spanned<T>) -> Place {
    let at = word.referenced;
    Place::line(at.line() as usize).with_column(at.column() as usize)
}
