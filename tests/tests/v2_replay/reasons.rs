//! Why ours differs: the file `reasons` names the row of `docs/differences.md` for each input that is
//! answered otherwise.

use std::fs;
use std::path::Path;

use super::record::{Exchange, differences};
use super::rules::matches;

/// The topics, each with the inputs it explains.
pub struct Reasons(Vec<(String, Vec<String>)>);

impl Reasons {
    /// Reads the file: `[topic]` as in the first column of the page, below it `input` or `session: input`
    /// lines, or `+line` that only ours says, or `-line` that only v2 says; `*` stands for anything.
    pub fn read(folder: &Path) -> Self {
        let page = include_str!("../../../docs/differences.md");
        let mut topics: Vec<(String, Vec<String>)> = Vec::new();
        let text = fs::read_to_string(folder.join("reasons")).expect("the reasons");
        for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with("//")) {
            if let Some(topic) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
                assert!(page.contains(&format!("\n| {topic} |")), "docs/differences.md has no row `{topic}`");
                topics.push((topic.to_owned(), Vec::new()));
            } else {
                topics.last_mut().expect("a topic first").1.push(line.to_owned());
            }
        }
        Self(topics)
    }

    /// The topic that explains this difference.
    pub fn of(&self, session: &str, exchange: &Exchange) -> Option<&str> {
        let differing = differences(&exchange.theirs, &exchange.ours);
        let says = |sign: char, pattern: &str| differing.iter().any(|(of, line)| *of == sign && matches(pattern, line));
        let fits = |pattern: &String| match (pattern.split_at(1), pattern.split_once(": ")) {
            (("+", line), _) => says('+', line),
            (("-", line), _) => says('-', line),
            (_, Some((of, input))) if !of.contains(' ') => of == session && matches(input, exchange.input()),
            _ => matches(pattern, exchange.input()),
        };
        self.0.iter().find(|(_, patterns)| patterns.iter().any(fits)).map(|(topic, _)| topic.as_str())
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
