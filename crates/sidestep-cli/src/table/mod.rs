//! `sidestep table`: a report as Markdown or CSV, the paper's numbers beside where it has them.

mod curves;
mod experiment;
mod splice;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::Global;
use crate::bench::report::{FORMAT, Report, Row};
use crate::experiment::report::{self, ExperimentReport};
use crate::failure::Failure;
use crate::input::read_text;
use crate::output;
pub use experiment::{experiment_csv, experiment_markdown};

/// Arguments of `table`.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct TableArgs {
    /// A report that `bench` or `experiment` wrote
    #[arg(required_unless_present = "splice")]
    report: Option<PathBuf>,
    /// How to render it
    #[arg(long, value_enum, default_value_t = Format::Markdown)]
    format: Format,
    /// Also draw the learning curves of an experiment's policies (.svg or .png)
    #[arg(long, conflicts_with = "splice")]
    curves: Option<PathBuf>,
    /// Write the tables of these Markdown files anew, each between `<!-- table: REPORT | HEADING... -->`
    /// and `<!-- end of table -->`
    #[arg(long, num_args = 1.., value_name = "FILE", conflicts_with = "report")]
    splice: Vec<PathBuf>,
    /// Write nothing; fail where a table is not what its report says
    #[arg(long, requires = "splice")]
    check: bool,
}

const EXAMPLES: &str = "\
Examples:
  sidestep table report.json
  sidestep table report.json --format csv > report.csv
  sidestep table --splice README.md docs/*.md";

#[derive(Clone, Copy, ValueEnum)]
enum Format {
    Markdown,
    Csv,
}

/// A report of either kind.
enum Table {
    Bench(Box<Report>),
    Experiment(Box<ExperimentReport>),
}

/// Renders the report; as JSON, its rows or cells alone.
pub fn run(args: &TableArgs, global: &Global) -> Result<(), Failure> {
    let Some(path) = &args.report else {
        return splice::run(&args.splice, args.check, global);
    };
    let curves: Vec<_> = args.curves.iter().map(|path| ("--curves", path.as_path())).collect();
    curves.iter().try_for_each(|&out| output::check_suffix(out, &["png", "svg"]))?;
    output::check_outputs(&curves, std::slice::from_ref(path))?;
    let table = read(path)?;
    if let Some(path) = &args.curves {
        let Table::Experiment(report) = &table else {
            let reason = "cannot be drawn: a report of `bench` has no learning curves";
            return Err(Failure::file(path, reason));
        };
        curves::write(report, path)?;
    }
    match (&table, args.format) {
        (Table::Bench(report), _) if global.json => output::print_json(&report.rows),
        (Table::Experiment(report), _) if global.json => output::print_json(&report.cells),
        (_, Format::Markdown) => output::print(&markdown_of(&table)),
        (Table::Bench(report), Format::Csv) => output::print(&csv(report)),
        (Table::Experiment(report), Format::Csv) => output::print(&experiment_csv(report)),
    }
}

/// Reads a report of either kind.
fn read(path: &Path) -> Result<Table, Failure> {
    let broken = |error| Failure::file(path, format!("is not a report ({error})"));
    let value: serde_json::Value = serde_json::from_str(&read_text(path)?).map_err(broken)?;
    match value["format"].as_str() {
        Some(FORMAT) => serde_json::from_value(value).map(Table::Bench).map_err(broken),
        Some(report::FORMAT) => {
            serde_json::from_value(value).map(Table::Experiment).map_err(broken)
        }
        other => {
            let found = format!("format {other:?}; expected {FORMAT:?} or {:?}", report::FORMAT);
            Err(Failure::file(path, found))
        }
    }
}

fn markdown_of(table: &Table) -> String {
    match table {
        Table::Bench(report) => markdown(report),
        Table::Experiment(report) => experiment_markdown(report),
    }
}

/// The cell of a figure that there is not.
const NOTHING: &str = "-";

/// A column: its heading and a row's cell.
type Column = (&'static str, fn(&Row, &Report) -> String);

const COLUMNS: [Column; 21] = [
    ("planner", |row, _| format!("`{}`", row.planner)),
    ("suite", |row, _| row.suite.clone()),
    ("starts", |row, _| row.starts.to_string()),
    ("tasks", |row, _| row.tasks.to_string()),
    ("any step %", |row, _| percent(row.solved_any)),
    ("end %", |row, _| percent(row.solved_end)),
    ("paper %", |row, report| paper_value(row, report)),
    ("certified % [95 %]", |row, _| {
        let [low, high] = row.success_ci95;
        format!("{} [{:.1}, {:.1}]", percent(Some(row.success)), 100.0 * low, 100.0 * high)
    }),
    ("of solvable %", |row, _| percent(row.success_of_solvable)),
    ("iterations", |row, _| number(row.iterations_mean, 1)),
    ("us/iteration", |row, _| number(row.us_per_iteration, 2)),
    ("us/plan p50", |row, _| number(row.us_per_plan_median, 1)),
    ("us/plan p95", |row, _| number(row.us_per_plan_p95, 1)),
    ("us/world", |row, _| number(row.us_per_world_median, 0)),
    ("invalid ends", |row, _| row.invalid.map_or_else(|| NOTHING.into(), |n| n.to_string())),
    ("length", |row, _| number(row.length_mean, 3)),
    ("length/optimal", |row, _| number(row.length_ratio_median, 3)),
    ("corner p50 deg", |row, _| number(row.corner_median_deg, 1)),
    ("corner most deg", |row, _| number(row.corner_most_deg, 1)),
    ("roughness", |row, _| number(row.roughness_median, 5)),
    ("clearance", |row, _| number(row.clearance_median, 3)),
];

/// The report as a Markdown table with its provenance.
pub fn markdown(report: &Report) -> String {
    let mut lines: Vec<Vec<String>> =
        vec![COLUMNS.iter().map(|(name, _)| (*name).into()).collect()];
    lines.extend(report.rows.iter().map(|row| cells(row, report)));
    // Columns in which no row has anything are left out.
    let used: Vec<bool> = (0..COLUMNS.len())
        .map(|column| lines[1..].iter().any(|line| line[column] != NOTHING))
        .collect();
    for line in &mut lines {
        let mut used = used.iter();
        line.retain(|_| used.next() == Some(&true));
    }
    let text = grid(&lines);
    let (p, s) = (&report.provenance, &report.settings);
    let seeds: Vec<String> = s.task_seeds.iter().map(u64::to_string).collect();
    let seeds =
        if seeds.is_empty() { String::new() } else { format!(", task seeds {}", seeds.join(", ")) };
    text + &format!(
        "\nProfile {}, {} steps, {} waypoints{seeds}. `{}`, commit {}, {:.0} s on {} ({} threads).\n",
        s.profile, s.steps, s.waypoints, p.command, p.commit, p.seconds, p.processor, p.threads
    )
}

/// The columns of these headings, in this order, as a Markdown table.
fn columns(report: &Report, headings: &[&str]) -> Result<String, String> {
    let column = |heading: &&str| {
        let known = COLUMNS.iter().find(|(name, _)| name == heading);
        known.ok_or_else(|| {
            let names = COLUMNS.map(|(name, _)| name).join(", ");
            format!("there is no column `{heading}`; there are {names}")
        })
    };
    let columns: Vec<&Column> = headings.iter().map(column).collect::<Result<_, _>>()?;
    let mut lines: Vec<Vec<String>> = vec![headings.iter().map(ToString::to_string).collect()];
    for row in &report.rows {
        lines.push(columns.iter().map(|(_, cell)| cell(row, report)).collect());
    }
    Ok(grid(&lines))
}

/// Lines of cells as a Markdown table, the first line its heading.
pub fn grid(lines: &[Vec<String>]) -> String {
    let columns = lines.first().map_or(0, Vec::len);
    let width =
        |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for (index, line) in lines.iter().enumerate() {
        let padded = line.iter().zip(&widths).map(|(cell, width)| format!(" {cell:width$} "));
        text += &format!("|{}|\n", padded.collect::<Vec<_>>().join("|"));
        if index == 0 {
            let rules = widths.iter().map(|width| "-".repeat(width + 2));
            text += &format!("|{}|\n", rules.collect::<Vec<_>>().join("|"));
        }
    }
    text
}

fn csv(report: &Report) -> String {
    let quote = |cell: String| {
        if cell.contains([',', '"', '\n']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell
        }
    };
    let join =
        |cells: Vec<String>| cells.into_iter().map(quote).collect::<Vec<_>>().join(",") + "\n";
    let heading = join(COLUMNS.iter().map(|(name, _)| (*name).into()).collect());
    let rows = report.rows.iter().map(|row| {
        join(cells(row, report).into_iter().map(|cell| cell.replace('`', "")).collect())
    });
    heading + &rows.collect::<String>()
}

fn cells(row: &Row, report: &Report) -> Vec<String> {
    COLUMNS.iter().map(|(_, cell)| cell(row, report)).collect()
}

fn percent(share: Option<f64>) -> String {
    number(share.map(|share| 100.0 * share), 1)
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| NOTHING.into(), |value| format!("{value:.digits$}"))
}

/// The paper's gradient descent rows: (suite, starts, percent), from its tables I and III.
const PAPER: [(&str, usize, f64); 6] = [
    ("easy", 1, 79.7),
    ("easy", 5, 84.4),
    ("easy", 10, 86.2),
    ("hard", 1, 0.0),
    ("hard", 5, 32.0),
    ("hard", 10, 41.0),
];

fn paper_value(row: &Row, report: &Report) -> String {
    let is_papers = report.settings.profile == "paper"
        && matches!(row.planner.as_str(), "gd" | "gd:step=0.1")
        && (row.starts == 1 || report.settings.start_strategy == "paper");
    let found =
        PAPER.iter().find(|(suite, starts, _)| *suite == row.suite && *starts == row.starts);
    number(found.filter(|_| is_papers).map(|&(_, _, value)| value), 1)
}
