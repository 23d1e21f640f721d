//! A grid's rows as strings: `.` free, `#` occupied, each with an optional repeat count before it.

use sidestep::plane::world::MAX_GRID_CELLS;

use crate::PACKED_CELLS;

/// Rows of at most this many cells are written cell by cell, so that a person sees the map.
const PLAIN_WIDTH: usize = 128;

/// One run of a row: how many cells, and whether they are occupied.
type Run = (usize, bool);

/// The runs of a row's text.
///
/// # Errors
/// The problem and what is allowed, in words.
fn runs(row: &str) -> Result<Vec<Run>, (String, String)> {
    let mut runs = Vec::new();
    let mut count: Option<usize> = None;
    for (position, c) in row.chars().enumerate() {
        match c {
            '0'..='9' => {
                let digit = c as usize - '0' as usize;
                let value = count.unwrap_or(0) * 10 + digit;
                if value == 0 || value > MAX_GRID_CELLS {
                    return Err((
                        format!("a repeat count of {value} at character {}", position + 1),
                        format!("a count from 1 to {MAX_GRID_CELLS}, without leading zeros"),
                    ));
                }
                count = Some(value);
            }
            '.' | '#' => runs.push((count.take().unwrap_or(1), c == '#')),
            _ => {
                return Err((
                    format!("{c:?} at character {}", position + 1),
                    "'.' (free) or '#' (occupied), each after an optional count".into(),
                ));
            }
        }
    }
    match count {
        Some(count) => Err((
            format!("a row that ends in the count {count}"),
            "'.' (free) or '#' (occupied) after the count".into(),
        )),
        None => Ok(runs),
    }
}

/// The number of cells of a row's text.
pub(super) fn width(row: &str) -> Result<usize, (String, String)> {
    let cells = runs(row)?.iter().fold(0_usize, |sum, &(count, _)| sum.saturating_add(count));
    if cells == 0 || cells > MAX_GRID_CELLS {
        return Err((format!("a row of {cells} cells"), format!("1 to {MAX_GRID_CELLS} cells")));
    }
    Ok(cells)
}

/// Appends the cells of a row's text, whose width has been checked.
pub(super) fn append(row: &str, cells: &mut Vec<bool>) {
    for (count, occupied) in runs(row).unwrap_or_default() {
        cells.resize(cells.len() + count, occupied);
    }
}

/// The text of a row of a grid of `all` cells. Grids that only a large file may ask for are written plainly.
pub(super) fn text(cells: &[bool], all: usize) -> String {
    let symbol = |occupied: bool| if occupied { '#' } else { '.' };
    if cells.len() <= PLAIN_WIDTH || all > PACKED_CELLS {
        return cells.iter().map(|&occupied| symbol(occupied)).collect();
    }
    let mut text = String::new();
    for run in cells.chunk_by(|a, b| a == b) {
        if run.len() > 1 {
            text += &run.len().to_string();
        }
        text.push(symbol(run[0]));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_and_cells() {
        for (row, expected) in [
            (".#.", vec![false, true, false]),
            ("3.2#", vec![false, false, false, true, true]),
            ("10#", vec![true; 10]),
        ] {
            let mut cells = Vec::new();
            append(row, &mut cells);
            assert_eq!(cells, expected, "{row}");
            assert_eq!(width(row), Ok(expected.len()), "{row}");
        }
        let long: Vec<bool> = (0..300).map(|i| i % 100 < 30).collect();
        assert_eq!(text(&long, 300), "30#70.30#70.30#70.");
        for bad in ["", "x", "0.", "03.", "3", "999999999999.", "268435456.1#"] {
            assert!(width(bad).is_err(), "{bad:?}");
        }
    }
}
