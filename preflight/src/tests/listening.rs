//! Calls of a listener, and how it can take over.

use base::failure::{ShortText, short};
use gcode::Code;
use program::{Action, CodeInfo, Effect, Interpreter, Remark};

use super::{Desk, Finding, Kind, Listener, places};

/// Listener that notes all it hears, and lets nothing come of some of it.
#[derive(Default)]
struct Notes {
    found: Vec<Finding>,
    heard: Vec<String>,
    /// Moves are not made.
    takes_moves: bool,
    /// Refuses moves, commands and codes that are left out.
    refuses: bool,
    /// Effects and words on codes that are left out come to nothing.
    swallows: bool,
    enough_after: Option<usize>,
}

impl Notes {
    fn answer<T>(&self, good: T) -> Result<T, ShortText> {
        if self.refuses { Err(short(format_args!("not here"))) } else { Ok(good) }
    }
}

impl Listener for Notes {
    fn found(&mut self, finding: &Finding) {
        self.found.push(finding.clone());
    }

    fn labelled(&mut self, line: u32, text: &str) {
        self.heard.push(format!("label {line} {text}"));
    }

    fn waited(&mut self, line: u32, seconds: f64) {
        self.heard.push(format!("wait {line} {seconds:.1}"));
    }

    fn has_heard_enough(&self) -> bool {
        self.enough_after.is_some_and(|most| self.found.len() >= most)
    }

    fn acts(&mut self, action: &Action<'_>) -> Result<bool, ShortText> {
        let is_move = matches!(action, Action::Move(_));
        if is_move { self.answer(!self.takes_moves) } else { Ok(true) }
    }

    fn acts_on_the_way(&mut self, _effect: Effect) -> bool {
        !self.swallows
    }

    fn remarks(&mut self, remark: Remark<'_>, _program: &Interpreter) {
        self.heard.push(format!("{remark:?}"));
    }

    fn commands(&mut self, text: &str) -> Result<(), ShortText> {
        self.heard.push(format!("command {text}"));
        self.answer(())
    }

    fn leaves_out(&mut self, row: Option<&CodeInfo>, code: Code) -> Result<bool, ShortText> {
        self.heard.push(format!("left out {code} {}", row.is_some()));
        self.answer(!self.swallows)
    }
}

fn hear(text: &str, mut notes: Notes) -> (Notes, f64) {
    let totals = Desk::new().hear(text, &mut notes);
    (notes, totals.travelled)
}

#[test]
fn moves_that_a_listener_takes_are_not_made() {
    let text = "G28\nG1 X10 F600\n";
    assert!((hear(text, Notes::default()).1 - 10.0).abs() < 1e-9);
    assert_eq!(hear(text, Notes { takes_moves: true, ..Notes::default() }).1, 0.0);
}

#[test]
fn refusals_of_a_listener_are_findings_with_its_words() {
    let (notes, travelled) = hear("G28\nG1 X10 F600\nM9999\nreset\n", Notes { refuses: true, ..Notes::default() });
    assert_eq!(places(&notes.found), [(2, Kind::Word), (3, Kind::Unknown), (4, Kind::Unknown)]);
    assert!(notes.found.iter().all(|finding| finding.what.as_str() == "not here"));
    assert_eq!(travelled, 0.0);
}

#[test]
fn effects_that_a_listener_swallows_are_not_checked() {
    let too_hot = "M104 S900\n";
    assert_eq!(places(&hear(too_hot, Notes::default()).0.found), [(1, Kind::TooHot)]);
    assert!(hear(too_hot, Notes { swallows: true, ..Notes::default() }).0.found.is_empty());
}

#[test]
fn codes_that_are_left_out_come_with_their_row_if_there_is_one() {
    let (notes, _) = hear("M9999\nM300\n", Notes { swallows: true, ..Notes::default() });
    assert_eq!(notes.heard, ["left out M9999 false", "left out M300 true"]);
    assert!(notes.found.is_empty(), "nothing is said of them");
}

#[test]
fn who_has_heard_enough_hears_no_more() {
    let (notes, _) = hear(&"G777\n".repeat(9), Notes { enough_after: Some(2), ..Notes::default() });
    assert_eq!(notes.found.len(), 2);
}

#[test]
fn waits_and_labels_are_at_lines_counted_without_empty_ones() {
    let (notes, _) = hear("; one\nG4 S2\n\n; two\nM486 S3\nG4 P500\n", Notes::default());
    assert_eq!(notes.heard, ["wait 1 2.0", "label 2 S3", "wait 3 0.5"]);
}

#[test]
fn comments_with_a_meaning_and_commands_are_passed_on() {
    let (notes, _) = hear("(plain)\n(MSG, hello)\nversion\n(PRINT, x)\n", Notes::default());
    assert_eq!(notes.heard, ["Message(\"hello\")", "command version", "Printed(\"x\")"]);
}
