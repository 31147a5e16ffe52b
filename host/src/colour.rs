//! Colours for findings, on terminals only: a file or a pipe gets the bare text.

const RED: &str = "\x1b[1;31m";
const YELLOW: &str = "\x1b[1;33m";
const BLUE: &str = "\x1b[1;34m";
const CYAN: &str = "\x1b[36m";
const BOLD: &str = "\x1b[1m";
const PLAIN: &str = "\x1b[0m";

/// Paints what `config::render_all` wrote: severity, margin, underline and help.
pub fn findings(text: &str) -> String {
    let mut mark = RED;
    text.split_inclusive('\n').map(|line| painted(line, &mut mark)).collect()
}

/// `mark` is the colour of the finding that the line belongs to.
fn painted(line: &str, mark: &mut &'static str) -> String {
    let (body, end) = line.strip_suffix('\n').map_or((line, ""), |body| (body, "\n"));
    for (word, colour) in [("error", RED), ("fatal", RED), ("warning", YELLOW)] {
        if let Some(rest) = body.strip_prefix(word).filter(|rest| rest.starts_with(':')) {
            *mark = colour;
            return format!("{colour}{word}{PLAIN}{BOLD}{rest}{PLAIN}{end}");
        }
    }
    let is_margin = |c: char| c == ' ' || c.is_ascii_digit();
    let inner = body.trim_start_matches(is_margin);
    let margin = &body[..body.len() - inner.len()];
    if let Some(help) = inner.strip_prefix("= help:") {
        return format!("{margin}{BLUE}={PLAIN} {CYAN}help:{PLAIN}{help}{end}");
    }
    if let Some(off) = inner.strip_prefix("= stays off:") {
        return format!("{margin}{BLUE}={PLAIN} {RED}stays off:{PLAIN}{off}{end}");
    }
    if let Some(place) = inner.strip_prefix("-->") {
        return format!("{margin}{BLUE}-->{PLAIN}{place}{end}");
    }
    if let Some(code) = inner.strip_prefix('|').filter(|_| body.starts_with(' ')) {
        let is_underline = code.contains('^') && code.chars().all(|c| c == ' ' || c == '^');
        let colour = if is_underline { *mark } else { PLAIN };
        return format!("{BLUE}{margin}|{PLAIN}{colour}{code}{PLAIN}{end}");
    }
    line.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOOK: &str = include_str!("../../config/tests/golden/broken.txt");

    fn without_colours(text: &str) -> String {
        text.split("\x1b[").enumerate().fold(String::new(), |out, (index, part)| {
            out + if index == 0 { part } else { part.split_once('m').map_or(part, |(_, rest)| rest) }
        })
    }

    #[test]
    fn colours_change_nothing_but_the_look() {
        assert_eq!(without_colours(&findings(BOOK)), BOOK);
    }

    #[test]
    fn errors_are_red_warnings_yellow_and_underlines_as_their_finding() {
        let painted = findings("error: a\n --> f:1:1\n  |\n1 | x\n  | ^\n  = help: h\nwarning: b\n  | ^^\n");
        assert!(painted.starts_with("\x1b[1;31merror\x1b[0m\x1b[1m: a\x1b[0m\n"), "{painted:?}");
        assert!(painted.contains("\x1b[1;31m ^\x1b[0m") && painted.contains("\x1b[1;33m ^^\x1b[0m"), "{painted:?}");
    }
}
