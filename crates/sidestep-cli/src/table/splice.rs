//! Tables inside documents, made from reports and never typed.
//!
//! ```text
//! <!-- table: reports/easy.json | planner | of solvable % -->
//! whatever stands here is replaced
//! <!-- end of table: do not edit; sidestep table --splice FILE -->
//! ```
//!
//! The report's path is relative to the document. Headings after it choose columns of a report of
//! `bench`; without them the table is whole, with the line that says how it was made.

use std::path::{Path, PathBuf};

use serde_json::json;

use super::{Table, columns, markdown_of, read};
use crate::Global;
use crate::failure::Failure;
use crate::input::read_text;
use crate::output;

/// What a line that a table follows begins with.
const BEGIN: &str = "<!-- table:";
/// What the line after a table begins with.
const END: &str = "<!-- end of table";
const END_LINE: &str = "<!-- end of table: do not edit; sidestep table --splice FILE -->";

/// Writes the tables of these documents anew; with `check`, fails where one is not what its report
/// says.
pub fn run(documents: &[PathBuf], check: bool, global: &Global) -> Result<(), Failure> {
    let mut stale: Vec<&PathBuf> = Vec::new();
    for document in documents {
        let text = read_text(document)?;
        let folder = document.parent().unwrap_or(Path::new(""));
        let spliced = spliced(&text, |mark| render(mark, folder))
            .map_err(|error| Failure::file(document, error))?;
        if spliced != text {
            stale.push(document);
            if !check {
                output::write_file(document, spliced.as_bytes())?;
            }
        }
    }
    if global.json {
        output::print_json(&json!({ "documents": documents, "changed": stale }))?;
    }
    match stale.first() {
        Some(first) if check => {
            let hint =
                "tables are not what their reports say; write them by `sidestep table --splice";
            Err(Failure::file(first, format!("{hint} {}`", first.display())))
        }
        _ => Ok(()),
    }
}

/// The table that a mark asks for: a path, then headings, with `|` between.
fn render(mark: &str, folder: &Path) -> Result<String, Failure> {
    let mut parts = mark.split('|').map(str::trim);
    let path = folder.join(parts.next().unwrap_or_default());
    let headings: Vec<&str> = parts.collect();
    let table = read(&path)?;
    if headings.is_empty() {
        return Ok(markdown_of(&table));
    }
    match table {
        Table::Bench(report) => {
            columns(&report, &headings).map_err(|error| Failure::file(&path, error))
        }
        Table::Experiment(_) => {
            Err(Failure::file(&path, "only a report of `bench` has columns to choose from"))
        }
    }
}

/// The text with every table rendered anew.
fn spliced(
    text: &str,
    render: impl Fn(&str) -> Result<String, Failure>,
) -> Result<String, Failure> {
    let mut spliced = String::with_capacity(text.len());
    let mut lines = text.split_inclusive('\n').enumerate();
    while let Some((index, line)) = lines.next() {
        spliced += line;
        let Some(mark) = line.trim().strip_prefix(BEGIN) else { continue };
        let at = |reason: &str| Failure(format!("line {}: {reason}", index + 1));
        let mark = mark.strip_suffix("-->").ok_or_else(|| at("the mark does not end in -->"))?;
        let is_end = |(_, line): &(usize, &str)| line.trim_start().starts_with(END);
        let is_begin = |(_, line): &(usize, &str)| line.trim_start().starts_with(BEGIN);
        let end = lines.by_ref().find(|line| is_end(line) || is_begin(line));
        if end.is_none_or(|line| is_begin(&line)) {
            return Err(at(&format!("the table has no end: a line `{END_LINE}`")));
        }
        let table = render(mark.trim()).map_err(|error| at(&error.to_string()))?;
        spliced += &format!("\n{}\n\n{END_LINE}\n", table.trim());
    }
    Ok(spliced)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shout(mark: &str) -> Result<String, Failure> {
        Ok(format!("| {} |\n", mark.to_uppercase()))
    }

    #[test]
    fn tables_are_replaced_whole_and_nothing_else_is() {
        let text = "a\n<!-- table: x | y -->\nold\n\n<!-- end of table -->\nb";
        let once = spliced(text, shout).unwrap();
        let expected = format!("a\n<!-- table: x | y -->\n\n| X | Y |\n\n{END_LINE}\nb");
        assert_eq!(once, expected);
        assert_eq!(spliced(&once, shout).unwrap(), once);
        assert_eq!(spliced("no table\r\n", shout).unwrap(), "no table\r\n");
    }

    #[test]
    fn marks_without_an_end_are_refused() {
        for (text, part) in [
            ("\n<!-- table: x -->\n", "line 2: the table has no end"),
            ("<!-- table: x -->\n<!-- table: y -->\n<!-- end of table -->", "line 1: the table"),
            ("<!-- table: x\n-->", "line 1: the mark does not end"),
        ] {
            let error = spliced(text, shout).unwrap_err().to_string();
            assert!(error.starts_with(part), "{text}: {error}");
        }
    }
}
