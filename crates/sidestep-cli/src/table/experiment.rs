//! Tables of experiments: per measurement, rows by columns of success, the paper's numbers beside, then
//! every figure of every row as a list.

use super::{grid, number};
use crate::bench::statistics::{deviation, mean};
use crate::experiment::config::{Columns, Measure};
use crate::experiment::report::{Cell, ExperimentReport};

/// The report as Markdown.
pub fn experiment_markdown(report: &ExperimentReport) -> String {
    let experiment = &report.experiment;
    let mut text = format!("{}\n", experiment.title);
    let by_measure = experiment.columns == Columns::Measures;
    if by_measure {
        text += "\n";
        text += &grid(&measures_grid(report));
    }
    for measure in &experiment.measure {
        let cells: Vec<&Cell> = report.cells.iter().filter(|c| c.measure == measure.name).collect();
        let seeds: Vec<String> = measure.seeds.iter().map(u64::to_string).collect();
        text += &format!(
            "\n**{}**: suite {}, {} tasks for each of the seeds {}, {} start(s){}, {} steps.\n\n",
            measure.name,
            measure.suite,
            measure.count,
            seeds.join(", "),
            measure.starts,
            if measure.starts > 1 {
                format!(" ({})", measure.start_strategy)
            } else {
                String::new()
            },
            measure.steps
        );
        if !by_measure {
            text += &success_grid(&cells, measure);
            text += "\n";
        }
        text += &grid(&detail(&cells));
    }
    let p = &report.provenance;
    let training: f64 =
        report.cells.iter().flat_map(|cell| &cell.training_seconds).filter(|s| s.is_finite()).sum();
    let rounds = experiment.measure.len().max(1) as f64;
    text + &format!(
        "\nMean ± standard deviation over training seeds (task seeds for planners without training), each over \
         all tasks; in brackets the paper's number and how many standard deviations of both ours lies above it (z). `{}`, commit {}, {:.0} s and {:.0} s of training on {} \
         ({} threads).\n",
        p.command,
        p.commit,
        p.seconds,
        training / rounds,
        p.processor,
        p.threads
    )
}

/// Any-step success by row and column; baselines below, in the first column.
fn success_grid(cells: &[&Cell], measure: &Measure) -> String {
    let mut columns: Vec<&str> = Vec::new();
    let mut rows: Vec<&str> = Vec::new();
    for cell in cells.iter().filter(|cell| !cell.column.is_empty()) {
        if !columns.contains(&cell.column.as_str()) {
            columns.push(&cell.column);
        }
        if !rows.contains(&cell.row.as_str()) {
            rows.push(&cell.row);
        }
    }
    if columns.is_empty() {
        return String::new();
    }
    let mut lines = vec![
        std::iter::once("any-step success %")
            .chain(columns.iter().copied())
            .map(String::from)
            .collect(),
    ];
    for row in rows {
        let mut line = vec![row.to_string()];
        for column in &columns {
            let cell = cells.iter().find(|cell| cell.row == row && cell.column == *column);
            line.push(cell.map_or_else(String::new, |cell| success(cell, measure)));
        }
        lines.push(line);
    }
    for cell in cells.iter().filter(|cell| cell.column.is_empty()) {
        let mut line = vec![format!("`{}`", cell.row), success(cell, measure)];
        line.resize(columns.len() + 1, String::new());
        lines.push(line);
    }
    grid(&lines)
}

/// Any-step success of every row in every measurement.
fn measures_grid(report: &ExperimentReport) -> Vec<Vec<String>> {
    let label = |cell: &Cell| match cell.column.as_str() {
        "" => format!("`{}`", cell.row),
        column => format!("{} {column}", cell.row),
    };
    let names = report.experiment.measure.iter().map(|measure| measure.name.as_str());
    let mut lines: Vec<Vec<String>> =
        vec![std::iter::once("any-step success %").chain(names).map(String::from).collect()];
    let mut rows: Vec<String> = Vec::new();
    for cell in &report.cells {
        if !rows.contains(&label(cell)) {
            rows.push(label(cell));
        }
    }
    for row in rows {
        let mut line = vec![row.clone()];
        for measure in &report.experiment.measure {
            let mut cells = report.cells.iter();
            let cell = cells.find(|cell| cell.measure == measure.name && label(cell) == row);
            line.push(cell.map_or_else(String::new, |cell| success(cell, measure)));
        }
        lines.push(line);
    }
    lines
}

/// Success with its spread; in brackets the paper's and how far ours is from it.
fn success(cell: &Cell, measure: &Measure) -> String {
    let paper = cell.paper.map_or_else(String::new, |paper| {
        let apart = apart(cell, measure, paper / 100.0);
        let apart = apart.map_or_else(String::new, |z| format!(", z {z:+.1}"));
        format!(" [{paper}{apart}]")
    });
    format!("{}{paper}", spread(&cell.any, 100.0, 1))
}

/// Tasks of the paper's test suites.
fn paper_tasks(suite: &str) -> f64 {
    if suite.starts_with("hard") { 100.0 } else { 1000.0 }
}

/// Our mean less the paper's share, in standard deviations of what is uncertain about both:
///
/// - which tasks were drawn: p (1 - p) / n, for our n tasks and for the paper's one draw;
/// - which training: our deviation s between training seeds, as s² / k in our mean of k and as s² in the
///   paper's one.
///
/// None where nothing is uncertain, as of gradient descent on tasks that it fails by definition.
fn apart(cell: &Cell, measure: &Measure, paper: f64) -> Option<f64> {
    let ours = mean(&cell.any)?;
    let is_trained = !cell.training_seconds.is_empty();
    let trainings = if is_trained { deviation(&cell.any).powi(2) } else { 0.0 };
    let tasks = (measure.count * measure.seeds.len()) as f64;
    let draws = ours * (1.0 - ours) * (1.0 / tasks + 1.0 / paper_tasks(&measure.suite));
    let variance = draws + trainings * (1.0 + 1.0 / cell.any.len() as f64);
    (variance > 0.0).then(|| (ours - paper) / variance.sqrt())
}

const HEADINGS: [&str; 11] = [
    "row",
    "column",
    "any %",
    "end %",
    "certified %",
    "of solvable %",
    "iterations",
    "us/iteration",
    "us to solve",
    "time suite: policy / gd 0.1 / gd 0.5",
    "kept at step",
];

/// Every figure of every cell.
fn detail(cells: &[&Cell]) -> Vec<Vec<String>> {
    let mut lines: Vec<Vec<String>> = vec![HEADINGS.map(String::from).to_vec()];
    for cell in cells {
        let kept: Vec<f64> = cell.kept_at_steps.iter().map(|&steps| steps as f64).collect();
        let time = [0, 1, 2].map(|index| {
            let values: Vec<f64> = cell.time.iter().map(|time| time[index]).collect();
            number(mean(&values), 2)
        });
        lines.push(vec![
            cell.row.clone(),
            cell.column.clone(),
            spread(&cell.any, 100.0, 1),
            spread(&cell.end, 100.0, 1),
            spread(&cell.certified, 100.0, 1),
            spread(&cell.certified_of_solvable, 100.0, 1),
            spread(&cell.iterations, 1.0, 1),
            spread(&cell.us_per_iteration, 1.0, 2),
            // All starts side by side until one is feasible.
            spread(&us_to_solve(cell), 1.0, 0),
            if cell.time.is_empty() { "-".into() } else { time.join(" / ") },
            number(mean(&kept), 0),
        ]);
    }
    lines
}

/// Mean microseconds until one of the starts, run side by side, is feasible.
fn us_to_solve(cell: &Cell) -> Vec<f64> {
    let pairs = cell.iterations.iter().zip(&cell.us_per_iteration);
    pairs.map(|(iterations, us)| cell.starts as f64 * iterations * us).collect()
}

/// `mean ± deviation`.
fn spread(values: &[f64], factor: f64, digits: usize) -> String {
    let Some(mean) = mean(values) else { return "-".into() };
    let deviation = deviation(values);
    format!("{:.digits$} ± {:.digits$}", factor * mean, factor * deviation)
}

/// Every cell as a line of CSV.
pub fn experiment_csv(report: &ExperimentReport) -> String {
    let cells: Vec<&Cell> = report.cells.iter().collect();
    let quote = |cell: &String| {
        if cell.contains([',', '"']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell.clone()
        }
    };
    let mut text = String::new();
    for (index, line) in detail(&cells).iter().enumerate() {
        let measure = if index == 0 { "measure" } else { &cells[index - 1].measure };
        let line: Vec<String> =
            std::iter::once(&measure.to_string()).chain(line).map(quote).collect();
        text += &(line.join(",") + "\n");
    }
    text
}
