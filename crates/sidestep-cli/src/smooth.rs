//! `sidestep smooth`: a path that something else made, checked, made round and certified.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use sidestep::plan::polish::{polish, score};
use sidestep::plan::{Origin, Plan, Status, Watch};
use sidestep::plane::points;
use sidestep::scene::Query;
use sidestep::{Obstacle, Profile, Trajectory};
use sidestep_io::drive::read_csv;
use sidestep_io::input::Question;
use sidestep_io::plan_json::{self, PlanDocument};

use crate::Global;
use crate::bends::{BendArgs, broken};
use crate::driving::{DriveArgs, FORMATS};
use crate::failure::Failure;
use crate::input::{self, Input, InputArgs};
use crate::obstacle::{parse_obstacle, with_obstacles};
use crate::output;

/// Arguments of `smooth`.
#[derive(Args)]
#[command(
    after_help = "Example:\n  sidestep smooth path.csv --map map.yaml --robot-radius 0.2 --margin 0.1 --out smooth.csv"
)]
pub struct SmoothArgs {
    /// The path: .csv with columns x and y, a plan as JSON or an array of points [x, y]
    path: PathBuf,
    /// World in which it has to be free: any file that `sidestep plan` reads
    #[arg(long)]
    map: PathBuf,
    /// An obstacle beside the file's: rect:X0,Y0,X1,Y1, circle:X,Y,RADIUS or polygon:X,Y;X,Y;X,Y; may be
    /// repeated
    #[arg(long, value_parser = parse_obstacle)]
    obstacle: Vec<Obstacle>,
    #[command(flatten)]
    from: InputArgs,
    /// Distance that the path keeps from obstacles and walls, in task units
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    margin: f64,
    #[command(flatten)]
    bends: BendArgs,
    #[command(flatten, next_help_heading = "Output")]
    driving: DriveArgs,
    /// Write the result here: .json, .csv, .yaml (nav_msgs/Path), .geojson or .mcap
    #[arg(long, help_heading = "Output")]
    out: Option<PathBuf>,
}

/// Reads, checks, smooths and writes.
pub fn run(args: &SmoothArgs, global: &Global) -> Result<u8, Failure> {
    args.bends.check()?;
    args.driving.check()?;
    if let Some(out) = &args.out {
        output::check_suffix(("--out", out), &FORMATS)?;
        let inputs: Vec<PathBuf> =
            args.from.files().into_iter().chain([args.path.clone(), args.map.clone()]).collect();
        output::check_outputs(&[("--out", out)], &inputs)?;
    }
    let given = read_path(&args.path)?;
    let ends = (given.first().copied(), given.last().copied());
    let question =
        Question { start: ends.0, goal: ends.1, clearance: args.margin, ..Question::default() };
    let Input { mut tasks, mut warnings, .. } = input::read(&args.map, &args.from, question)?;
    let task = with_obstacles(tasks.swap_remove(0), &args.obstacle)?;
    let asked = task.with_margin(args.margin)?;
    let wishes = args.bends.wishes().unwrap_or_default();
    let begin = Instant::now();
    let query = Query::of(&asked, &Profile::DEFAULT);
    let given = Trajectory::from_points(&given);
    let (given_length, given_turn) = (given.length(), given.sharpest_turn().to_degrees());
    let plan = match query.certify(given) {
        Ok(certified) => {
            let status = Status::Solved(certified);
            let plan = Plan { status, attempt: None, steps: 0, origin: Origin::WarmStart };
            polish(&query, plan, &wishes, Watch::NONE)
        }
        Err(refused) => Plan {
            status: Status::Unsolved(sidestep::plan::Reason::NotCertified {
                violation: refused.violation,
            }),
            attempt: Some(refused.trajectory),
            steps: 0,
            origin: Origin::WarmStart,
        },
    };
    let time = begin.elapsed();
    let certified = plan.certified();
    warnings.extend(certified.and_then(|path| broken(&args.bends.wishes()?, path)));
    let robot = Query::of(&task, &Profile::DEFAULT);
    let reason = plan.status.reason();
    let made = PlanDocument::of([&task.name, "smooth"], &robot, &plan, time, reason);
    let origin = certified.map(|_| "smoothed from the given path".into());
    let answer = PlanDocument { origin, warnings, ..made };
    let world = &task.plane()?.world;
    let written = args.out.as_ref().map_or(Ok(()), |out| args.driving.write(out, &answer, world));
    if global.json {
        output::print(&answer.to_json())?;
    } else {
        answer.warnings.iter().for_each(|warning| output::tell(&format!("warning: {warning}")));
        output::print(&match certified {
            Some(path) => format!(
                "certified ({:.0} us)\nlength {:.3} (given {given_length:.3}), sharpest corner {:.0} degrees \
                 (given {given_turn:.0}), radius {:.3}, clearance {:.3}, score {:.3}\n{} points\n",
                answer.time_us,
                path.length(),
                path.sharpest_turn().to_degrees(),
                path.turning_radius(),
                answer.clearance.unwrap_or_default(),
                score(&query, path, &wishes),
                path.len(),
            ),
            None => format!("the path is not free: {}\n", answer.reason),
        })?;
    }
    written?;
    Ok(u8::from(certified.is_none()))
}

/// The points of a path file.
pub fn read_path(path: &Path) -> Result<Vec<[f64; 2]>, Failure> {
    let text = input::read_text(path)?;
    let is_table = path.extension().is_some_and(|suffix| {
        ["csv", "txt", "tsv"].iter().any(|known| suffix.eq_ignore_ascii_case(known))
    });
    let points = match is_table {
        true => read_csv(&text),
        false => plan_json::read_waypoints(&text, 2).map(|path| points(&path).to_vec()),
    };
    points.map_err(|error| Failure::file(path, error))
}
