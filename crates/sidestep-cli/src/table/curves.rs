//! Learning curves of an experiment as a picture: a panel for each row of the table, a curve for each column.

use std::path::Path;

use sidestep_io::picture::{BandPoint, Chart, Picture};

use crate::bench::statistics::{deviation, mean};
use crate::experiment::report::{Cell, ExperimentReport};
use crate::failure::Failure;
use crate::output;

/// Pixels per unit of a picture.
const PNG_SCALE: f64 = 1.5;

/// Writes the picture, SVG where the name ends so, else PNG. A report without curves is an error.
pub fn write(report: &ExperimentReport, path: &Path) -> Result<(), Failure> {
    let picture = picture(report).ok_or_else(|| {
        Failure::file(
            path,
            "cannot be drawn: the report has no policy that was validated in training",
        )
    })?;
    if path.extension().is_some_and(|extension| extension == "svg") {
        return output::write_file(path, picture.to_svg().as_bytes());
    }
    let png = picture.to_png(PNG_SCALE).map_err(|error| Failure::file(path, error))?;
    output::write_file(path, &png)
}

fn picture(report: &ExperimentReport) -> Option<Picture> {
    // Every measurement repeats the trainings of its policies.
    let first = &report.experiment.measure.first()?.name;
    let has_curve = |cell: &&Cell| cell.curves.iter().any(|curve| !curve.is_empty());
    let cells: Vec<&Cell> =
        report.cells.iter().filter(|cell| cell.measure == *first).filter(has_curve).collect();
    let mut rows: Vec<&str> = cells.iter().map(|cell| cell.row.as_str()).collect();
    rows.dedup();
    if rows.is_empty() {
        return None;
    }
    let title = format!("{}: validation in training", report.experiment.name);
    let over = &cells[0].curves_over;
    let picture = Picture::new().title(title).columns(2);
    Some(rows.iter().fold(picture, |picture, row| {
        let chart = Chart::new(*row, over, "solved").y_range(0.0, 1.0);
        let own = cells.iter().filter(|cell| cell.row == *row);
        picture.panel(own.fold(chart, |chart, cell| chart.curve(&cell.column, &band(cell))))
    }))
}

/// Mean and standard deviation over the trainings, at the units where the first of them was validated.
fn band(cell: &Cell) -> Vec<BandPoint> {
    let Some(first) = cell.curves.first() else { return Vec::new() };
    let point = |&[x, _]: &[f64; 2]| {
        let at = |curve: &Vec<[f64; 2]>| curve.iter().find(|p| p[0] == x).map(|p| p[1]);
        let values: Vec<f64> = cell.curves.iter().filter_map(at).collect();
        let (mean, deviation) = (mean(&values).unwrap_or_default(), deviation(&values));
        BandPoint { x, mean, low: mean - deviation, high: mean + deviation }
    };
    first.iter().map(point).collect()
}
