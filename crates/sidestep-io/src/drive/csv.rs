//! A path from a table: columns `x` and `y` by name, or the first two where there is no head.

use sidestep::error::MAX_COORDINATE;
use sidestep::plane::geometry::Point;

use crate::error::{FormatError, Place};
use crate::input::without_mark;

const FORMAT: &str = "path CSV";

/// Reads the points of a path: lines of numbers between commas, semicolons, tabs or spaces; empty lines and those
/// that begin with `#` are passed over. At least two points.
///
/// # Errors
/// If a line is no such; the message names it.
pub fn read_csv(text: &str) -> Result<Vec<Point>, FormatError> {
    let mut columns = [0, 1];
    let mut points = Vec::new();
    let mut is_first = true;
    for (index, line) in without_mark(text).lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let words: Vec<&str> = split(line);
        if std::mem::take(&mut is_first) && words.iter().any(|word| word.parse::<f64>().is_err()) {
            let column = |name: &str| words.iter().position(|word| word.eq_ignore_ascii_case(name));
            let (Some(x), Some(y)) = (column("x"), column("y")) else {
                return Err(wrong(index, line, "columns named x and y, or numbers"));
            };
            columns = [x, y];
            continue;
        }
        let mut point = [0.0; 2];
        for (value, column) in point.iter_mut().zip(columns) {
            let word = words.get(column).copied().unwrap_or_default();
            *value =
                word.parse().ok().filter(|value: &f64| value.abs() <= MAX_COORDINATE).ok_or_else(
                    || wrong(index, line, "numbers x and y of magnitude at most 1e9"),
                )?;
        }
        points.push(point);
    }
    match points.len() {
        0 | 1 => {
            let found = format!("{} points", points.len());
            Err(FormatError::new(FORMAT, Place::line(1), found, "at least 2 points"))
        }
        _ => Ok(points),
    }
}

fn split(line: &str) -> Vec<&str> {
    let separator = [',', ';', '\t'].into_iter().find(|&separator| line.contains(separator));
    match separator {
        Some(separator) => {
            line.split(separator).map(|word| word.trim().trim_matches('"')).collect()
        }
        None => line.split_whitespace().collect(),
    }
}

fn wrong(index: usize, line: &str, expected: &str) -> FormatError {
    let found: String = line.chars().take(60).collect();
    FormatError::new(FORMAT, Place::line(index + 1), format!("`{found}`"), expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_by_name_or_place() {
        let points = vec![[1.0, 2.0], [3.5, -4e3]];
        for text in [
            "x,y\n1,2\n3.5,-4e3\n",
            "1 2\n3.5 -4000",
            "# a path\n\n1;2;7\n3.5;-4000;7",
            "t,Y,X\r\n0,2,1\r\n1,-4000,3.5\r\n",
            "\u{feff}\"x\",\"y\",yaw\n1,2,0\n3.5,-4000,0",
        ] {
            assert_eq!(read_csv(text), Ok(points.clone()), "{text}");
        }
        for (text, part) in [
            ("", "0 points"),
            ("x,y\n1,2", "1 points"),
            ("x,y\n1,2\n3,z", "line 3"),
            ("x,y\n1,2\n3", "line 3"),
            ("a,b\n1,2", "columns named x and y"),
            ("1,nan\n1,2", "line 1"),
            ("1,2\n1,2e9", "1e9"),
        ] {
            let error = read_csv(text).unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
