//! Commands of the line editor, as they are typed: `f/fan/ m2 s/5/6/`.

/// Command with its text and repetitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command<'t> {
    /// Kind of the command.
    pub what: What,
    /// Number of lines searched; 0 for the rest of the file.
    pub lines: u32,
    /// Text that it looks for or inserts.
    pub text: &'t str,
    /// Number of repetitions, 0 for as often as it goes.
    pub times: u32,
}

/// Kind of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// `m`: the next line.
    Next,
    /// `m-`: the line before.
    Previous,
    /// `r`: one character to the right.
    Right,
    /// `l`: one character to the left.
    Left,
    /// `e`: erases the character at the cursor.
    EraseRight,
    /// `e-`: erases the character before the cursor.
    EraseLeft,
    /// `k`: removes the line.
    Kill,
    /// `p`: prints the line.
    Print,
    /// `g`: takes new lines.
    Get,
    /// `i`: inserts a text at the cursor.
    Insert,
    /// `b`: breaks the line at the cursor.
    Break,
    /// `j`: joins the next line to this one.
    Join,
    /// `f`: finds a text in the lines that follow.
    Find,
    /// `s`: puts a text in the place of the one found.
    Substitute,
    /// `d`: deletes a text.
    Delete,
    /// `t`: goes behind a text.
    Traverse,
    /// `u`: deletes up to a text.
    Uncover,
    /// `v`: checks that a text stands at the cursor.
    Verify,
}

/// Parses the first command of a line; returns it and the rest of the line.
///
/// # Errors
/// The text that is no command.
pub fn parse(line: &str) -> Result<(Command<'_>, &str), &str> {
    let mut letters = line.chars();
    let letter = letters.next().unwrap_or(' ').to_ascii_lowercase();
    let rest = letters.as_str();
    let (back, rest) = match rest.strip_prefix('-') {
        Some(rest) if matches!(letter, 'm' | 'e') => (true, rest),
        _ => (false, rest),
    };
    let what = match (letter, back) {
        ('m', false) => What::Next,
        ('m', true) => What::Previous,
        ('r', _) => What::Right,
        ('l', _) => What::Left,
        ('e', false) => What::EraseRight,
        ('e', true) => What::EraseLeft,
        ('k', _) => What::Kill,
        ('p', _) => What::Print,
        ('g', _) => What::Get,
        ('i', _) => What::Insert,
        ('b', _) => What::Break,
        ('j', _) => What::Join,
        ('f', _) => What::Find,
        ('s', _) => What::Substitute,
        ('d', _) => What::Delete,
        ('t', _) => What::Traverse,
        ('u', _) => What::Uncover,
        ('v', _) => What::Verify,
        _ => return Err(line),
    };
    let mut command = Command { what, lines: 1, text: "", times: 1 };
    let takes_lines = matches!(what, What::Find | What::Delete | What::Traverse | What::Uncover);
    let takes_text = takes_lines || matches!(what, What::Insert | What::Substitute | What::Verify);
    let mut rest = rest;
    if takes_lines {
        let given;
        (given, rest) = number(rest);
        command.lines = given.unwrap_or(u32::from(what != What::Find));
    }
    if takes_text {
        let mark = rest.chars().next().filter(char::is_ascii_punctuation).ok_or(line)?;
        let (text, behind) = rest.get(1..).and_then(|rest| rest.split_once(mark)).ok_or(line)?;
        if text.is_empty() && !matches!(what, What::Substitute) {
            return Err(line);
        }
        (command.text, rest) = (text, behind);
    }
    let (times, rest) = number(rest);
    command.times = times.unwrap_or(1);
    Ok((command, rest.trim_start()))
}

/// Parses the number at the beginning of a text, `*` for 0; returns it and the rest.
fn number(text: &str) -> (Option<u32>, &str) {
    if let Some(rest) = text.strip_prefix('*') {
        return (Some(0), rest);
    }
    let digits = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (digits, rest) = text.split_at(digits);
    (digits.parse().ok(), rest)
}

/// Help text of `%h`: the commands.
pub const HELP: &str = "\
m{n} next line, m-{n} previous; r{n} right, l{n} left
f{lines}/text/{n} find, s/text/ put in the place of what was found, v/text/ is it here
i/text/ insert, b break the line, j join it with the next, g{n} take lines typed (: ends them)
d{lines}/text/{n} delete, u{lines}/text/ delete up to, t{lines}/text/ go behind
e{n} erase to the right, e-{n} to the left, k{n} delete lines, p{n} print lines
n: how often, 0 or * as often as it goes; several commands may stand in a line
%h help, %c write the file and end, %q say nothing, %m say the line, %f say it after each command
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_read() {
        let command = |what, lines, text, times| Command { what, lines, text, times };
        assert_eq!(parse("m"), Ok((command(What::Next, 1, "", 1), "")));
        assert_eq!(parse("M-3 p"), Ok((command(What::Previous, 1, "", 3), "p")));
        assert_eq!(parse("f/a b/ s/c/"), Ok((command(What::Find, 0, "a b", 1), "s/c/")));
        assert_eq!(parse("d5/x/*"), Ok((command(What::Delete, 5, "x", 0), "")));
        assert_eq!(parse("i.#fan."), Ok((command(What::Insert, 1, "#fan", 1), "")));
        for wrong in ["x", "", "i", "i/a", "iabca", "f//", "3"] {
            assert_eq!(parse(wrong).map(|(command, _)| command), Err(wrong), "{wrong}");
        }
    }
}
