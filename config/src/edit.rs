//! Changes one setting in a configuration's text and leaves everything else as it is: comments, order, blank
//! lines.
//!
//! The text passes through line by line, so that a file of any size can be changed in fixed memory.

use crate::schema::{Form, Kind, section};
use crate::setting::flaw::Flaw;
use crate::setting::value;
use crate::suggest;
use crate::text::cut;
use heapless::String;

/// A change: `[section] key = value`. Without a value the setting's line is deleted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edit<'a> {
    /// The section's name, without brackets.
    pub section: &'a str,
    /// The key as it stands before the `=`, instance included: `fan.enable`.
    pub key: &'a str,
    /// New value; none deletes the setting.
    pub value: Option<&'a str>,
}

/// Decision about a line of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict<'l> {
    /// The line stays unchanged.
    Keep,
    /// The line is deleted.
    Delete,
    /// `key = value` replaces the line, followed by two blanks and this comment when there is one.
    Replace(&'l str),
    /// `key = value` and a blank line are inserted before the line.
    Precede,
}

/// Lines to append at the end of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Nothing is missing at the end.
    Nothing,
    /// The line `key = value`.
    Setting,
    /// A blank line, `[section]` and `key = value`.
    Section,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Before,
    Inside,
    /// The section is past or the setting is written.
    Done,
}

/// Applies an [`Edit`] to a text, line by line.
#[derive(Clone, Copy, Debug)]
pub struct Editor<'a> {
    edit: Edit<'a>,
    state: State,
    /// Whether the current line belongs to the section.
    inside: bool,
}

impl<'a> Editor<'a> {
    /// Returns an editor at the start of the text.
    #[must_use]
    pub const fn new(edit: Edit<'a>) -> Self {
        Self { edit, state: State::Before, inside: false }
    }

    /// Takes the next line, without its end. Of a long line its first 300 bytes are enough.
    pub fn line<'l>(&mut self, line: &'l str) -> Verdict<'l> {
        let (content, comment) = line.find('#').map_or((line, ""), |place| line.split_at(place));
        let content = content.trim();
        if let Some(header) = content.strip_prefix('[') {
            return self.header(header);
        }
        let key = content.split_once('=').map(|(key, _)| key.trim());
        if !self.inside || key != Some(self.edit.key) {
            return Verdict::Keep;
        }
        // The first line of the setting is changed; a second one would count instead of it.
        let first = self.state == State::Inside;
        self.state = State::Done;
        if first && self.edit.value.is_some() { Verdict::Replace(comment.trim_end()) } else { Verdict::Delete }
    }

    fn header(&mut self, header: &str) -> Verdict<'static> {
        let name = header.split_once(']').map_or(header, |(name, _)| name);
        let leaves = self.inside && name != self.edit.section;
        self.inside = name == self.edit.section;
        if self.inside && self.state == State::Before {
            self.state = State::Inside;
        }
        if leaves && self.state == State::Inside {
            self.state = State::Done;
            if self.edit.value.is_some() {
                return Verdict::Precede;
            }
        }
        Verdict::Keep
    }

    /// Ends the text and returns the lines to append.
    #[must_use]
    pub const fn end(self) -> Ending {
        match (self.edit.value, self.state) {
            (None, _) | (_, State::Done) => Ending::Nothing,
            (Some(_), State::Inside) => Ending::Setting,
            (Some(_), State::Before) => Ending::Section,
        }
    }
}

/// Whether the edit makes sense to the reader: why not and what to write instead, when it does not.
pub fn check_edit(edit: &Edit<'_>) -> Result<(), String<112>> {
    let Some((_, section)) = section(edit.section) else {
        return Err(match suggest::section(edit.section) {
            Some(meant) => cut(format_args!("there is no section [{}]: did you mean [{meant}]?", edit.section)),
            None => cut(format_args!("there is no section [{}]", edit.section)),
        });
    };
    let (is_common, key) = match (section.form, edit.key.split_once('.')) {
        (Form::Plain | Form::Keyed(_), _) => (false, edit.key),
        (Form::Named(_), Some((name, key))) => (name == "common", key),
        (Form::Named(instances), None) => {
            return Err(cut(format_args!("say which {} it is for, as in name.{}", instances.noun, edit.key)));
        }
    };
    let row = match section.form {
        Form::Keyed(_) => section.settings.first(),
        _ => section.position(key, is_common).and_then(|place| section.settings.get(place)),
    };
    let Some(row) = row else {
        let (_, fix) = suggest::key(section, key, is_common);
        return Err(cut(format_args!("[{}] has no setting '{}': {fix}", section.name, edit.key)));
    };
    let Some(value) = edit.value else { return Ok(()) };
    match fits(&row.kind, value) {
        Err(flaw) => Err(cut(format_args!("{}: {} ({})", edit.key, flaw.reason(), flaw.fix()))),
        Ok(()) => Ok(()),
    }
}

fn fits<'t>(kind: &Kind, text: &'t str) -> Result<(), Flaw<'t>> {
    value::parse(kind, text).map(drop)
}

/// The whole text after the edit.
#[cfg(any(test, feature = "std"))]
#[must_use]
pub fn apply(text: &str, edit: Edit<'_>) -> std::string::String {
    let mut editor = Editor::new(edit);
    let setting = std::format!("{} = {}", edit.key, edit.value.unwrap_or(""));
    let mut out = std::string::String::new();
    for line in text.split_inclusive('\n') {
        let content = line.trim_end_matches(['\n', '\r']);
        match editor.line(content) {
            Verdict::Keep => out += line,
            Verdict::Delete => {}
            Verdict::Replace("") => out += &std::format!("{setting}\n"),
            Verdict::Replace(comment) => out += &std::format!("{setting}  {comment}\n"),
            Verdict::Precede => out += &std::format!("{setting}\n\n{line}"),
        }
    }
    let newline = if out.is_empty() || out.ends_with('\n') { "" } else { "\n" };
    match editor.end() {
        Ending::Nothing => {}
        Ending::Setting => out += &std::format!("{newline}{setting}\n"),
        Ending::Section => out += &std::format!("{newline}\n[{}]\n{setting}\n", edit.section),
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TEXT: &str = "# head\n[planner]\nplanner_queue_size = 32   # moves\n\n[switch]\n# Fan\nfan.enable = true\n";

    fn edit<'a>(section: &'a str, key: &'a str, value: Option<&'a str>) -> Edit<'a> {
        Edit { section, key, value }
    }

    #[test]
    fn a_value_changes_and_its_comment_stays() {
        let text = apply(TEXT, edit("planner", "planner_queue_size", Some("64")));
        assert_eq!(text, TEXT.replace("= 32   # moves", "= 64  # moves"));
    }

    #[test]
    fn a_new_key_ends_its_section_and_a_new_section_ends_the_file() {
        let text = apply(TEXT, edit("planner", "junction_deviation", Some("0.1")));
        assert_eq!(text, TEXT.replace("[switch]", "junction_deviation = 0.1\n\n[switch]"));
        let text = apply(TEXT, edit("switch", "fan.max_pwm", Some("100")));
        assert_eq!(text, format!("{TEXT}fan.max_pwm = 100\n"));
        let text = apply(TEXT, edit("general", "grbl_mode", Some("true")));
        assert_eq!(text, format!("{TEXT}\n[general]\ngrbl_mode = true\n"));
    }

    #[test]
    fn deleting_takes_every_line_of_the_setting_and_no_other() {
        let twice = format!("{TEXT}fan.enable = false # again\n");
        assert_eq!(apply(&twice, edit("switch", "fan.enable", None)), TEXT.replace("fan.enable = true\n", ""));
        assert_eq!(apply(TEXT, edit("planner", "fan.enable", None)), TEXT);
        assert_eq!(apply(&twice, edit("switch", "fan.enable", Some("1"))), TEXT.replace("= true", "= 1"));
    }

    #[test]
    fn what_the_reader_would_refuse_is_refused() {
        for (section, key, value, says) in [
            ("planer", "x", "1", "did you mean [planner]?"),
            ("planner", "junction_devation", "1", "did you mean junction_deviation?"),
            ("planner", "junction_deviation", "wide", "'wide' is not a number"),
            ("switch", "enable", "true", "which switch"),
            ("actuator", "common.max_rate", "1", "has no setting"),
            ("voltage monitor", "vmotor", "ADC1_1", "not a voltage input"),
        ] {
            let said = check_edit(&edit(section, key, Some(value))).unwrap_err();
            assert!(said.contains(says), "{said}");
        }
        assert_eq!(check_edit(&edit("switch", "fan.enable", Some("true"))), Ok(()));
        assert_eq!(check_edit(&edit("actuator", "common.motors_enable_pin", None)), Ok(()));
    }

    proptest! {
        /// All lines but the setting's own stay, in their order.
        #[test]
        fn everything_else_stays(lines in proptest::collection::vec("(\\[(a|b)\\]|(k|l)( = [0-9]{1,3})?( *# [ -~]{0,5})?|)", 0..12), value in proptest::option::of("[0-9]")) {
            let text = lines.join("\n");
            let edited = apply(&text, edit("a", "k", value.as_deref()));
            let others = |text: &str| {
                let mut section = String::<8>::new();
                let mut kept = std::vec::Vec::new();
                for line in text.lines() {
                    if line.starts_with('[') {
                        section = String::try_from(line).unwrap();
                    }
                    let is_it = section == "[a]" && line.starts_with("k") && line.split('#').next().unwrap().contains('=');
                    if !is_it && !line.trim().is_empty() {
                        kept.push(line.to_owned());
                    }
                }
                kept
            };
            let (mut before, after) = (others(&text), others(&edited));
            if value.is_some() && after.len() > before.len() {
                before.push("[a]".to_owned());
            }
            prop_assert_eq!(before, after);
            let written = edited.lines().filter(|line| value.as_ref().is_some_and(|v| line.starts_with(&std::format!("k = {v}")))).count();
            prop_assert!(value.is_none() || written >= 1, "{}", edited);
        }
    }
}
