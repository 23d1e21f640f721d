//! What people type, as the parser knows it: points of two words, points below zero, names of
//! before, and a question where a planner's name belongs.

use std::ffi::OsString;

/// Flags whose value is a point.
const POINTS: [&str; 2] = ["--start", "--goal"];
/// Verbs that plan.
const PLANNING: [&str; 2] = ["plan", "bench"];
/// Coordinates that are taken together: X and Y, or a number for each joint.
const MOST_COORDINATES: usize = 64;

/// A command line and what to tell about it.
pub struct Arguments {
    /// The words that the parser gets, the program's name first.
    pub words: Vec<OsString>,
    /// What to write from now on, a sentence for each word that was replaced.
    pub notes: Vec<String>,
}

/// Replaces what the parser would not take; all else stays as it is.
pub fn understood(words: impl IntoIterator<Item = OsString>) -> Arguments {
    let words: Vec<OsString> = words.into_iter().collect();
    let verb = words.iter().skip(1).position(|word| !word.to_string_lossy().starts_with('-'));
    let verb = verb.map_or(words.len(), |position| position + 1);
    let plans = words.get(verb).is_some_and(|word| PLANNING.iter().any(|known| word == known));
    let mut understood = Arguments { words: Vec::with_capacity(words.len()), notes: Vec::new() };
    let mut rest = words.iter().enumerate();
    while let Some((index, word)) = rest.next() {
        let text = word.to_str().unwrap_or_default();
        let next = words.get(index + 1).and_then(|next| next.to_str()).unwrap_or_default();
        let asks = text == "--planner" && next == "help" || text == "--planner=help";
        if plans && asks {
            understood.words = vec![words[0].clone(), "planners".into()];
            understood.words.extend(words.iter().filter(|word| *word == "--json").cloned());
            return understood;
        }
        if text == "--" {
            understood.words.push(word.clone());
            understood.words.extend(rest.map(|(_, word)| word.clone()));
            return understood;
        }
        if index == verb && text == "oracle" {
            understood.replace("shortest", "the verb `oracle` is called `shortest` now");
        } else if plans && (text == "--clearance" || text.starts_with("--clearance=")) {
            let sentence =
                "--clearance is called --epsilon now; to keep a distance, write --margin";
            understood.replace(&text.replacen("--clearance", "--epsilon", 1), sentence);
        } else if POINTS.contains(&text) {
            let point: Vec<&str> = words[index + 1..].iter().map_while(coordinate).collect();
            let point = &point[..point.len().min(MOST_COORDINATES)];
            if point.is_empty() {
                understood.words.push(word.clone());
                continue;
            }
            understood.words.push(format!("{text}={}", point.join(",")).into());
            rest.nth(point.len() - 1);
        } else {
            understood.words.push(word.clone());
        }
    }
    understood
}

impl Arguments {
    fn replace(&mut self, word: &str, sentence: &str) {
        self.words.push(word.into());
        self.notes.push(sentence.into());
    }
}

/// A word that is one number, without a comma before or after it.
fn coordinate(word: &OsString) -> Option<&str> {
    let text = word.to_str()?.trim_matches(',');
    text.parse::<f64>().is_ok().then_some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(typed: &str, expected: &str, notes: usize) {
        let found = understood(typed.split_whitespace().map(OsString::from));
        let words: Vec<&str> = found.words.iter().map(|word| word.to_str().unwrap()).collect();
        assert_eq!(words.join(" "), expected, "{typed}");
        assert_eq!(found.notes.len(), notes, "{typed}");
    }

    #[test]
    fn words_as_the_parser_knows_them() {
        for (typed, expected, notes) in [
            ("s plan a.json", "s plan a.json", 0),
            ("s plan a.json --start 1 2 --goal 3,4", "s plan a.json --start=1,2 --goal 3,4", 0),
            ("s plan a.json --start 1, 2", "s plan a.json --start=1,2", 0),
            ("s plan a.json --start -1 -2.5e3 --json", "s plan a.json --start=-1,-2.5e3 --json", 0),
            ("s plan a.json --start 1 2 0.5", "s plan a.json --start=1,2,0.5", 0),
            ("s plan --start 1,2 a.json", "s plan --start 1,2 a.json", 0),
            ("s plan a.json --start", "s plan a.json --start", 0),
            ("s plan a.json --clearance 3", "s plan a.json --epsilon 3", 1),
            ("s --quiet bench --clearance=3", "s --quiet bench --epsilon=3", 1),
            ("s oracle a.json", "s shortest a.json", 1),
            ("s plan oracle", "s plan oracle", 0),
            ("s plan -- --clearance --start 1 2", "s plan -- --clearance --start 1 2", 0),
            ("s plan a.json --planner help", "s planners", 0),
            ("s bench --json --planner=help", "s planners --json", 0),
            ("s", "s", 0),
            ("", "", 0),
        ] {
            check(typed, expected, notes);
        }
    }
}
