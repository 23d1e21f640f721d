//! An experiment is checked whole before its first training: an error that comes after hours is one
//! that costs hours.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Display;
use std::ops::RangeInclusive;

use sidestep::InvalidInput;
use sidestep::plan::starts::StartStrategy;
use sidestep::profile::Profile;
use sidestep::suite::Suite;

use super::config::{BaselineEntry, Experiment, Measure, PolicyEntry};
use crate::failure::Failure;
use crate::planning::planner;

/// Most tasks of a measurement, over all its seeds: some 4 kB each.
const MOST_TASKS: usize = 200_000;
/// Most starts of a task, and steps of a start.
const MOST_STARTS: usize = 10_000;
const MOST_STEPS: usize = 1_000_000;
/// Longest name of a file, in bytes, with room for what is put behind it.
const LONGEST_NAME: usize = 200;

/// Reads an experiment and checks every part of it.
pub fn read(text: &str) -> Result<Experiment, Failure> {
    let table: toml::Table =
        toml::from_str(text).map_err(|error| Failure(error.to_string().trim_end().into()))?;
    let is_training = |key: &str| ["ppo", "stages", "environment_steps"].contains(&key);
    if !table.contains_key("measure") && table.keys().any(|key| is_training(key)) {
        return Err(Failure("is a training's configuration; run `sidestep train` on it".into()));
    }
    let experiment: Experiment =
        toml::from_str(text).map_err(|error| Failure(error.to_string().trim_end().into()))?;
    check(&experiment)?;
    Ok(experiment)
}

fn check(experiment: &Experiment) -> Result<(), Failure> {
    let name = &experiment.name;
    let is_plain = |c: char| c.is_ascii_alphanumeric() || ['-', '_', '.'].contains(&c);
    if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
        let allowed = "letters, digits, `-`, `_` and `.`: it names a folder";
        return refuse("name", format!("{name:?}"), allowed);
    }
    if name.len() > LONGEST_NAME {
        return refuse("name", format!("{} bytes", name.len()), "at most 200 bytes");
    }
    if experiment.measure.is_empty() {
        return refuse("measure", "none", "at least one measurement");
    }
    for (index, measure) in experiment.measure.iter().enumerate() {
        check_measure(measure).map_err(|error| error.inside(&format!("measure[{index}]")))?;
    }
    let names: Vec<&str> = experiment.measure.iter().map(|measure| measure.name.as_str()).collect();
    unique("measure", "name", &names)?;
    for (index, entry) in experiment.policies.iter().enumerate() {
        let inside = |error: InvalidInput| error.inside(&format!("policies[{index}]"));
        check_policy(experiment, entry, &names).map_err(inside)?;
    }
    check_files(experiment)?;
    for (index, entry) in experiment.baselines.iter().enumerate() {
        let place = format!("baselines[{index}]");
        check_baseline(entry, &place, &names)?;
    }
    Ok(())
}

fn check_measure(measure: &Measure) -> Result<(), InvalidInput> {
    measure.suite.parse::<Suite>()?;
    measure.profile.parse::<Profile>()?;
    measure
        .start_strategy
        .parse::<StartStrategy>()
        .map_err(|error| InvalidInput { field: "start_strategy".into(), ..error })?;
    if measure.seeds.is_empty() {
        return Err(InvalidInput::new("seeds", "none", "at least one seed"));
    }
    unique("seeds", "", &measure.seeds)?;
    within("count", measure.count, 1..=MOST_TASKS / measure.seeds.len())?;
    within("starts", measure.starts, 1..=MOST_STARTS)?;
    within("steps", measure.steps, 1..=MOST_STEPS)
}

fn check_policy(
    experiment: &Experiment,
    entry: &PolicyEntry,
    measures: &[&str],
) -> Result<(), InvalidInput> {
    let seeds = experiment.seeds(entry);
    if seeds.is_empty() {
        return Err(InvalidInput::new("training_seeds", "none", "at least one seed"));
    }
    unique("training_seeds", "", seeds)?;
    check_paper(&entry.paper, measures)?;
    experiment.recipe(entry, 0).map_err(|error| error.inside("train")).map(|_| ())
}

/// Fails if two trainings would share their files, or a file could not have its name.
fn check_files(experiment: &Experiment) -> Result<(), InvalidInput> {
    let mut owners: HashMap<String, String> = HashMap::new();
    for (index, seed) in experiment.trainings() {
        let entry = &experiment.policies[index];
        let field = format!("policies[{index}]");
        let name = entry.file_name(seed);
        if name.len() > LONGEST_NAME || name.chars().any(char::is_control) {
            let allowed = "a row and a column that make a file's name of at most 200 bytes";
            return Err(InvalidInput::new(field, format!("{name:?}"), allowed));
        }
        let owner = format!("{field} (row {:?}, column {:?})", entry.row, entry.column);
        // Some file systems do not tell large from small letters.
        if let Some(other) = owners.insert(name.to_lowercase(), owner.clone()) {
            let allowed = format!("a file of its own; {other} has that one, so rename a row");
            return Err(InvalidInput::new(owner, format!("policies/{name}"), allowed));
        }
    }
    Ok(())
}

fn check_baseline(entry: &BaselineEntry, place: &str, measures: &[&str]) -> Result<(), Failure> {
    planner(&entry.planner).map_err(|Failure(words)| Failure::at(place, words))?;
    check_paper(&entry.paper, measures).map_err(|error| error.inside(place))?;
    Ok(())
}

fn check_paper(paper: &BTreeMap<String, f64>, measures: &[&str]) -> Result<(), InvalidInput> {
    match paper.keys().find(|name| !measures.contains(&name.as_str())) {
        None => Ok(()),
        Some(unknown) => Err(InvalidInput::new("paper", unknown, measures.join(", "))),
    }
}

fn within(field: &str, value: usize, range: RangeInclusive<usize>) -> Result<(), InvalidInput> {
    if range.contains(&value) {
        return Ok(());
    }
    let allowed = format!("a number from {} to {}", range.start(), range.end());
    Err(InvalidInput::new(field, value, allowed))
}

/// Fails if a value of a list comes twice; `key` is its place within an item.
fn unique<T: Display + Eq + std::hash::Hash>(
    list: &str,
    key: &str,
    values: &[T],
) -> Result<(), InvalidInput> {
    let mut seen = HashSet::new();
    match values.iter().position(|value| !seen.insert(value)) {
        None => Ok(()),
        Some(index) => {
            let dot = if key.is_empty() { "" } else { "." };
            let field = format!("{list}[{index}]{dot}{key}");
            Err(InvalidInput::new(field, &values[index], "each one once"))
        }
    }
}

fn refuse(field: &str, value: impl Display, allowed: &str) -> Result<(), Failure> {
    Err(InvalidInput::new(field, value, allowed).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
        name = "x"
        title = "t"
        training_seeds = [1]
        [[measure]]
        name = "m"
        suite = "easy"
        count = 2
        seeds = [2]
        [[policies]]
        row = "a b"
        column = "c"
        [[baselines]]
        planner = "gd"
    "#;

    #[test]
    fn what_is_wrong_is_told_before_the_first_training() {
        assert!(read(GOOD).is_ok());
        let check = |from: &str, to: &str, parts: &[&str]| {
            let text = GOOD.replacen(from, to, 1);
            assert_ne!(text, GOOD, "{from}");
            let Failure(message) = read(&text).err().unwrap_or(Failure("accepted".into()));
            for part in parts {
                assert!(message.contains(part), "{to}: {message}");
            }
        };
        check("name = \"x\"", "name = \"../x\"", &["name: \"../x\"", "names a folder"]);
        check("name = \"x\"", "name = \"\"", &["name: \"\""]);
        check("suite = \"easy\"", "suite = \"eazy\"", &["measure[0].suite: `eazy`", "easy"]);
        check("count = 2", "count = 0", &["measure[0].count: 0", "from 1 to 200000"]);
        check(
            "count = 2",
            "count = 9223372036854775807",
            &["measure[0].count: 9223372036854775807"],
        );
        check("seeds = [2]", "seeds = []", &["measure[0].seeds"]);
        check("seeds = [2]", "seeds = [2, 2]", &["measure[0].seeds[1]: 2"]);
        check("seeds = [2]", "seeds = [2]\nstarts = 0", &["measure[0].starts: 0", "from 1"]);
        check("seeds = [2]", "seeds = [2]\nsteps = 9223372036854775807", &["measure[0].steps"]);
        check("seeds = [2]", "seeds = [2]\nprofile = \"no\"", &["measure[0].profile: `no`"]);
        let zigzag = "seeds = [2]\nstart_strategy = \"zigzag\"";
        check("seeds = [2]", zigzag, &["measure[0].start_strategy: `zigzag`", "via-point"]);
        check("planner = \"gd\"", "planner = \"gdx\"", &["baselines[0]", "gdx", "gd"]);
        check("training_seeds = [1]", "", &["policies[0].training_seeds: none"]);
        check("training_seeds = [1]", "training_seeds = [1, 1]", &["training_seeds[1]: 1"]);
        let other = "column = \"c\"\n[[policies]]\nrow = \"a\"\ncolumn = \"b c\"";
        check("column = \"c\"", other, &["policies[1]", "policies/a-b-c-seed-1", "policies[0]"]);
        let paper = "column = \"c\"\npaper = { n = 3 }";
        check("column = \"c\"", paper, &["policies[0].paper: n", "expected m"]);
        let unknown = "column = \"c\"\ntrain = { ppo.stps = 3 }";
        check("column = \"c\"", unknown, &["policies[0].train.ppo.stps", "steps"]);
        let twice =
            "seeds = [2]\n[[measure]]\nname = \"m\"\nsuite = \"hard\"\ncount = 2\nseeds = [2]";
        check("seeds = [2]", twice, &["measure[1].name: m", "each one once"]);
        check("column", "colum", &["colum"]);
        let Failure(message) = read("environment_steps = 100").err().unwrap();
        assert!(message.contains("sidestep train"), "{message}");
    }

    #[test]
    fn every_experiment_and_training_of_the_project_passes() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments");
        let mut counts = [0, 0];
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let text = std::fs::read_to_string(&path).unwrap();
            // Policies are named from the project's root.
            let root = concat!("learned:", env!("CARGO_MANIFEST_DIR"), "/../../policies/");
            let text = text.replace("learned:policies/", root);
            let is_experiment = text.contains("[[measure]]");
            if is_experiment {
                read(&text).unwrap_or_else(|Failure(words)| panic!("{}: {words}", path.display()));
            } else {
                sidestep_train::Recipe::from_toml(&text)
                    .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            }
            counts[usize::from(is_experiment)] += 1;
        }
        assert!(counts.iter().all(|&count| count >= 3), "{counts:?}");
    }
}
