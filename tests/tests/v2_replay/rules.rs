//! Reasons for different lines: the file `rules.grbl` says which lines of Velvet stand for which of v2's. A
//! reply is explained when every line in which the two differ is.

use std::cell::Cell;
use std::fs;
use std::path::Path;

use super::record::{Exchange, differences};

/// Separator of lines that belong together.
const AND: &str = " & ";

/// Lines of v2 and what ours says in their place.
struct Rule {
    /// The row of `docs/differences.md`.
    topic: String,
    /// The input that it is for; `*` for any.
    input: String,
    theirs: Vec<String>,
    ours: Vec<String>,
    text: String,
    used: Cell<bool>,
}

/// The rules of the sessions that speak GRBL's dialect.
pub struct Rules(Vec<Rule>);

impl Rules {
    /// Reads the file: `[topic]` as in the first column of the page, below it `v2's lines -> our lines`, or
    /// `input | v2's lines -> our lines`. ` & ` stands between lines, `*` for any text, and `{1}` for a text
    /// that is the same wherever it stands in the rule.
    pub fn read(folder: &Path) -> Self {
        let page = include_str!("../../../docs/differences.md");
        let text = fs::read_to_string(folder.join("rules.grbl")).expect("the rules");
        let mut topic = String::new();
        let mut rules = Vec::new();
        for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with("# ")) {
            if let Some(named) = line.strip_prefix('[').and_then(|rest| rest.strip_suffix("]:")) {
                assert!(page.contains(&format!("\n| {named} |")), "docs/differences.md has no row `{named}`");
                named.clone_into(&mut topic);
                continue;
            }
            let (input, rule) = line.split_once(" | ").unwrap_or(("*", line));
            let (theirs, ours) = rule.split_once("->").unwrap_or_else(|| panic!("no -> in `{line}`"));
            let lines = |side: &str| -> Vec<String> {
                if side.is_empty() { Vec::new() } else { side.split(AND).map(str::to_owned).collect() }
            };
            rules.push(Rule {
                topic: topic.clone(),
                input: input.to_owned(),
                theirs: lines(theirs.strip_suffix(' ').unwrap_or(theirs)),
                ours: lines(ours.strip_prefix(' ').unwrap_or(ours)),
                text: line.to_owned(),
                used: Cell::new(false),
            });
        }
        Self(rules)
    }

    /// The topics that explain this difference, one for each rule that is needed.
    pub fn of(&self, exchange: &Exchange) -> Option<Vec<&str>> {
        let side = |wanted: char| {
            let all = differences(&exchange.theirs, &exchange.ours);
            all.into_iter().filter(|(sign, _)| *sign == wanted).map(|(_, line)| line).collect::<Vec<_>>()
        };
        let mut replies = [side('-'), side('+')];
        let mut topics: Vec<&str> = Vec::new();
        let rules = || self.0.iter().filter(|rule| matches(&rule.input, exchange.input()));
        while let Some(rule) = rules().find(|rule| rule.take(&mut replies)) {
            rule.used.set(true);
            if !topics.contains(&rule.topic.as_str()) {
                topics.push(&rule.topic);
            }
        }
        replies.iter().all(Vec::is_empty).then_some(topics)
    }

    /// Rules that no reply needed.
    pub fn unused(&self) -> impl Iterator<Item = &str> {
        self.0.iter().filter(|rule| !rule.used.get()).map(|rule| rule.text.as_str())
    }
}

impl Rule {
    /// Takes its lines out of both replies, where they stand there in this order.
    fn take(&self, replies: &mut [Vec<&str>; 2]) -> bool {
        let patterns =
            |of: &'_ [String], side: usize| of.iter().map(move |line| (side, line.clone())).collect::<Vec<_>>();
        let patterns = [patterns(&self.theirs, 0), patterns(&self.ours, 1)].concat();
        let Some(mut found) = find(&patterns, [&replies[0], &replies[1]], [0, 0], &Same::default()) else {
            return false;
        };
        // From the last on, so that the places of the others stay.
        while let Some((side, at)) = found.pop() {
            replies[side].remove(at);
        }
        true
    }
}

/// The texts that `{1}` and so on stand for.
type Same = std::collections::BTreeMap<char, String>;

/// Finds the places of these patterns, each in v2's reply or Velvet's, in their order, from these places on.
fn find(
    patterns: &[(usize, String)],
    lines: [&[&str]; 2],
    from: [usize; 2],
    same: &Same,
) -> Option<Vec<(usize, usize)>> {
    let Some(((side, pattern), others)) = patterns.split_first() else { return Some(Vec::new()) };
    (from[*side]..lines[*side].len()).find_map(|at| {
        let mut same = same.clone();
        if !fits(pattern, lines[*side][at], &mut same) {
            return None;
        }
        let mut behind = from;
        behind[*side] = at + 1;
        let found = find(others, lines, behind, &same)?;
        Some([vec![(*side, at)], found].concat())
    })
}

/// `*` stands for any text, `{1}` for one that is kept.
pub fn matches(pattern: &str, text: &str) -> bool {
    fits(pattern, text, &mut Same::default())
}

fn fits(pattern: &str, text: &str, same: &mut Same) -> bool {
    let open = pattern.find(['*', '{']).unwrap_or(pattern.len());
    let (literal, rest) = pattern.split_at(open);
    let Some(text) = text.strip_prefix(literal) else { return false };
    let mut signs = rest.chars();
    let ends = || (0..=text.len()).filter(|at| text.is_char_boundary(*at)).map(|at| text.split_at(at));
    match (signs.next(), signs.next(), signs.next()) {
        (None, ..) => text.is_empty(),
        (Some('*'), ..) => ends().any(|(_, behind)| fits(&rest[1..], behind, same)),
        (Some('{'), Some(key), Some('}')) => match same.get(&key).cloned() {
            Some(known) => text.strip_prefix(&known).is_some_and(|behind| fits(&rest[3..], behind, same)),
            None => ends().any(|(taken, behind)| {
                let mut tried = same.clone();
                tried.insert(key, taken.to_owned());
                let fits = fits(&rest[3..], behind, &mut tried);
                if fits {
                    *same = tried;
                }
                fits
            }),
        },
        _ => panic!("`{pattern}` has a bracket that is no {{1}}"),
    }
}

#[test]
fn a_rule_explains_its_lines_and_no_other() {
    let rule = |text: &str| {
        let (theirs, ours) = text.split_once(" -> ").expect("an arrow");
        let lines = |side: &str| side.split(AND).map(str::to_owned).collect();
        let (topic, input, text, used) = (String::new(), "*".to_owned(), text.to_owned(), Cell::new(false));
        Rules(vec![Rule { topic, input, theirs: lines(theirs), ours: lines(ours), text, used }])
    };
    let exchange = |theirs: &[&str], ours: &[&str]| Exchange {
        theirs: theirs.iter().map(|line| (*line).to_owned()).collect(),
        ours: ours.iter().map(|line| (*line).to_owned()).collect(),
        ..Exchange::default()
    };
    let said = rule("// {1} -> [MSG:{1}]");
    assert!(said.of(&exchange(&["// a", "ok"], &["[MSG:a]", "ok"])).is_some());
    assert!(said.of(&exchange(&["// a", "// b"], &["[MSG:a]", "[MSG:b]"])).is_some());
    assert!(said.of(&exchange(&["// a"], &["[MSG:b]"])).is_none(), "another text");
    assert!(said.of(&exchange(&["// a"], &["[MSG:a]", "ok"])).is_none(), "a line too many");
    assert!(said.of(&exchange(&["// a", "ok"], &["[MSG:a]"])).is_none(), "a line that is missing");
    let place = rule("<{1}|MPos:{2}0,*|F:* -> <{1}|MPos:{2}|FS:*>");
    assert!(place.of(&exchange(&["<Idle|MPos:5.0000,x|F:1>"], &["<Idle|MPos:5.000|FS:0>"])).is_some());
    assert!(place.of(&exchange(&["<Idle|MPos:5.0000,x|F:1>"], &["<Idle|MPos:4.000|FS:0>"])).is_none());
    assert!(place.of(&exchange(&["<Idle|MPos:5.0000,x|F:1>"], &["<Run|MPos:5.000|FS:0>"])).is_none());
}
