//! Reasons for different replies: the file `reasons` names the row of `docs/differences.md` for each input
//! that is answered otherwise.

use std::cell::Cell;
use std::fs;
use std::path::Path;

use super::record::{Exchange, differences};
use super::rules::matches;

/// The topics, each with the inputs it explains.
pub struct Reasons(Vec<(String, Vec<Pattern>)>);

struct Pattern {
    text: String,
    used: Cell<bool>,
}

impl Reasons {
    /// Reads the file: `[topic]` as in the first column of the page, below it `input` or `session: input`
    /// lines, or `+line` that only ours says, or `-line` that only v2 says; `*` stands for anything.
    pub fn read(folder: &Path) -> Self {
        let page = include_str!("../../../docs/differences.md");
        let mut topics: Vec<(String, Vec<Pattern>)> = Vec::new();
        let text = fs::read_to_string(folder.join("reasons")).expect("the reasons");
        for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with("//")) {
            if let Some(topic) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
                assert!(page.contains(&format!("\n| {topic} |")), "docs/differences.md has no row `{topic}`");
                topics.push((topic.to_owned(), Vec::new()));
            } else {
                let pattern = Pattern { text: line.to_owned(), used: Cell::new(false) };
                topics.last_mut().expect("a topic first").1.push(pattern);
            }
        }
        Self(topics)
    }

    /// The topic that explains this difference.
    pub fn of(&self, session: &str, exchange: &Exchange) -> Option<&str> {
        let differing = differences(&exchange.theirs, &exchange.ours);
        let says = |sign: char, pattern: &str| differing.iter().any(|(of, line)| *of == sign && matches(pattern, line));
        let fits = |pattern: &str| match (pattern.split_at(1), pattern.split_once(": ")) {
            (("+", line), _) => says('+', line),
            (("-", line), _) => says('-', line),
            (_, Some((of, input))) if !of.contains(' ') => of == session && matches(input, exchange.input()),
            _ => matches(pattern, exchange.input()),
        };
        // A reason for one input comes before a pattern for many lines.
        [true, false].into_iter().find_map(|names_input| {
            self.0.iter().find_map(|(topic, patterns)| {
                let is_meant = |pattern: &&Pattern| pattern.text.contains(['*', '+', '-']) != names_input;
                patterns.iter().filter(is_meant).find(|pattern| fits(&pattern.text))?.used.set(true);
                Some(topic.as_str())
            })
        })
    }

    /// Patterns that no reply needed.
    pub fn unused(&self) -> impl Iterator<Item = &str> {
        let patterns = self.0.iter().flat_map(|(_, patterns)| patterns);
        patterns.filter(|pattern| !pattern.used.get()).map(|pattern| pattern.text.as_str())
    }
}

/// Texts that explain a command are each firmware's own: that there is one counts.
pub fn help(answer: Vec<String>, theirs: &[String]) -> Vec<String> {
    let refused = answer.iter().any(|line| line.starts_with("error"));
    if theirs.first().is_some_and(|line| line == "<help>") && answer.len() > 1 && !refused {
        return theirs.to_vec();
    }
    answer
}
