//! The files that `plan` writes: each name says its format.

use std::path::Path;

use sidestep_io::plan_json::PlanDocument;

use super::PlanArgs;
use crate::driving::FORMATS;
use crate::failure::Failure;
use crate::output::{self, Output};
use crate::planning::policy_file;

/// Fails if a file could not be written, would replace what is read or has a name of another
/// format, or if a flag would do nothing.
pub fn check(args: &PlanArgs, compared: &[String]) -> Result<(), Failure> {
    let pictures = [&args.png, &args.svg, &args.html];
    if !args.compare.is_empty() && pictures.iter().all(|path| path.is_none()) {
        let need = "draws planners beside the first, so it needs a picture: --png FILE, --svg FILE or \
                    --html FILE";
        return Err(Failure::at("--compare", need));
    }
    if args.animate && args.png.is_none() && args.svg.is_none() {
        return Err(Failure::at("--animate", "moves a picture: give --png FILE or --svg FILE"));
    }
    let formats: [(_, _, &[&str]); 5] = [
        ("--out", &args.out, &FORMATS),
        ("--trajectory", &args.trajectory, &["yaml", "yml", "json", "csv"]),
        ("--html", &args.html, &["html", "htm"]),
        ("--png", &args.png, &["png"]),
        ("--svg", &args.svg, &["svg"]),
    ];
    let mut outputs: Vec<Output<'_>> = Vec::new();
    for (flag, path, suffixes) in formats {
        let Some(path) = path else { continue };
        output::check_suffix((flag, path), suffixes)?;
        outputs.push((flag, path));
    }
    let names = std::iter::once(&args.planner).chain(compared);
    let policies = names.filter_map(|name| policy_file(name));
    let inputs = args.from.files().into_iter().chain(args.warm_start.clone()).chain(policies);
    output::check_outputs(&outputs, &inputs.collect::<Vec<_>>())
}

/// Writes the answer: as a table of points where the name ends in .csv, else whole as JSON.
pub fn write(path: &Path, answer: &PlanDocument) -> Result<(), Failure> {
    if path.extension().is_none_or(|suffix| !suffix.eq_ignore_ascii_case("csv")) {
        return output::write_file(path, answer.to_json().as_bytes());
    }
    let mut table = answer.joints.as_ref().map_or_else(|| "x,y".into(), |names| names.join(","));
    for waypoint in &answer.waypoints {
        let numbers: Vec<String> = waypoint.iter().map(f64::to_string).collect();
        table.push('\n');
        table += &numbers.join(",");
    }
    table.push('\n');
    output::write_file(path, table.as_bytes())
}
