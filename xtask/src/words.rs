//! Counts comments that a stranger cannot use: those that open with a pronoun or a wh-word, and those of a
//! few words.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};

use crate::sources;

/// First words for want of a noun.
const OPENERS: &[&str] = &[
    "he",
    "her",
    "him",
    "his",
    "how",
    "it",
    "its",
    "one",
    "ones",
    "she",
    "that",
    "their",
    "them",
    "these",
    "they",
    "this",
    "those",
    "what",
    "whatever",
    "when",
    "whenever",
    "where",
    "wherever",
    "which",
    "whichever",
    "who",
    "whoever",
    "whom",
    "whose",
    "why",
];
/// At most so many words say nothing that the code does not say.
const FEW: usize = 3;

/// Comments of a crate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Count {
    all: usize,
    opens: usize,
    short: usize,
}

/// A comment that is to be written anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    Opens,
    Short,
}

/// Prints the shares of all crates together; with the name of a folder also the shares of each crate, and
/// each such comment of the folder. Fails where the shares of all are beyond the limits, percent.
pub fn check(root: &Path, folder: Option<&str>, most: (f64, f64)) -> Result<()> {
    let mut crates: BTreeMap<String, Count> = BTreeMap::new();
    for path in sources::rust_files(root)? {
        let name = path.strip_prefix(root).unwrap_or(&path).display().to_string();
        let text = fs::read_to_string(&path).with_context(|| name.clone())?;
        let count = crates.entry(name.split('/').next().unwrap_or_default().to_owned()).or_default();
        for (line, comment) in comments(&text) {
            count.all += 1;
            for fault in faults(&comment) {
                match fault {
                    Fault::Opens => count.opens += 1,
                    Fault::Short => count.short += 1,
                }
                if folder.is_some_and(|folder| name.starts_with(folder)) {
                    println!("{name}:{line}: {comment}");
                }
            }
        }
    }
    let mut sum = Count::default();
    for count in crates.values() {
        sum = Count { all: sum.all + count.all, opens: sum.opens + count.opens, short: sum.short + count.short };
    }
    let keeps = share(sum.opens, sum.all) <= most.0 && share(sum.short, sum.all) <= most.1;
    if folder.is_some() || !keeps {
        crates.iter().for_each(|(name, count)| print(name, *count));
    }
    print("all", sum);
    if !keeps {
        bail!("the limits are {} % and {} %: xtask words FOLDER lists the comments", most.0, most.1);
    }
    Ok(())
}

fn print(name: &str, count: Count) {
    let (opens, short) = (share(count.opens, count.all), share(count.short, count.all));
    println!(
        "words: {name:<14} {:>6} comments, {opens:>4.1} % open with a pronoun, {short:>4.1} % are short",
        count.all
    );
}

fn share(part: usize, all: usize) -> f64 {
    100.0 * part as f64 / all.max(1) as f64
}

/// Comments with the line that each begins in: neighbouring lines of one kind, up to an empty one.
fn comments(text: &str) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let mut before = None;
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim_start();
        let mark = ["///", "//!", "//"].into_iter().find(|mark| line.starts_with(mark));
        let words = mark.and_then(|mark| line.strip_prefix(mark)).map_or("", str::trim);
        match found.last_mut().filter(|_| before == mark && !words.is_empty()) {
            Some((_, comment)) => {
                comment.push(' ');
                comment.push_str(words);
            }
            None if words.is_empty() => {}
            None => found.push((number, words.to_owned())),
        }
        before = mark.filter(|_| !words.is_empty());
    }
    // Rulers between parts of a file, arguments for `unsafe` and headings are no prose.
    found.retain(|(_, comment)| !["---", "SAFETY", "# "].iter().any(|head| comment.starts_with(head)));
    found
}

fn faults(comment: &str) -> impl Iterator<Item = Fault> {
    let is_part = |c: char| c.is_alphanumeric() || matches!(c, '_' | '\'' | '`' | '-');
    let mut words = comment.split(|c| !is_part(c)).filter(|word| !word.is_empty());
    let opens = words.clone().next().is_some_and(|word| OPENERS.contains(&word.to_lowercase().as_str()));
    let short = words.nth(FEW).is_none();
    [(opens, Fault::Opens), (short, Fault::Short)].into_iter().filter(|(is, _)| *is).map(|(_, fault)| fault)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(comment: &str) -> Vec<Fault> {
        faults(comment).collect()
    }

    #[test]
    fn riddles_are_found_and_sentences_are_not() {
        assert_eq!(found("It goes on as before."), [Fault::Opens]);
        assert_eq!(found("It does."), [Fault::Opens, Fault::Short]);
        assert_eq!(found("Of a motor."), [Fault::Short]);
        assert_eq!(found("Greatest height error of the fit, mm."), []);
    }

    #[test]
    fn neighbouring_lines_are_one_comment_and_rulers_none() {
        let text =
            "//! A file\n//! of words.\n\n// --- part ---\n/// A sum\n/// of two.\n///\n/// Errors.\nfn f() {} // no\n";
        let wanted = [(1, "A file of words."), (5, "A sum of two."), (8, "Errors.")];
        assert_eq!(comments(text), wanted.map(|(line, comment)| (line, comment.to_owned())));
    }
}
