//! Makes GRBL's lines of the machine's texts, so that a sender can count: each of its lines is answered by
//! exactly one `ok` or `error:N`, and everything else is a message that it may show or pass over.
//!
//! Text in GRBL's form (`<...>`, `[...]`, `$...`, `>...`, the banner) stays; `ok` and `error:` stay where an
//! answer is owed. Any other line becomes `[MSG:...]`.

use core::fmt::{self, Write};

use crate::reason::Reason;

/// First text of a session of this dialect, also after each reset: senders wait for it.
pub const BANNER: &str = "Grbl 1.1f ['$' for help]\n";
/// Text behind the banner while the machine is halted.
pub const LOCKED: &str = "[MSG:'$H'|'$X' to unlock]\n";

/// Place in a line at which the last piece ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Place {
    #[default]
    LineStart,
    /// Inside a line that stays as it is.
    AsItIs,
    /// Inside a message for the user.
    Message,
    /// Inside a line that began with `ok`: its end answers.
    Remark,
    /// Inside a line that began with `error:`.
    Refusal,
    /// Inside the answer `ok`.
    Ok,
}

/// State of a session's output between two pieces of text.
#[derive(Clone, Copy, Debug, Default)]
pub struct Framing {
    place: Place,
    /// Whether a line has been taken and is not answered.
    owes: bool,
}

impl Framing {
    /// Starts with no answer owed.
    #[must_use]
    pub const fn new() -> Self {
        Self { place: Place::LineStart, owes: false }
    }

    /// Notes that a line has been taken, which is owed one answer.
    pub const fn owe(&mut self) {
        self.owes = true;
    }

    /// Drops the owed answer: the sender has been told to begin anew.
    pub const fn forgive(&mut self) {
        self.owes = false;
    }

    /// Answers the line with `ok` at its end, if nothing has answered it.
    pub fn settle(&mut self, out: &mut impl Write) -> fmt::Result {
        if core::mem::take(&mut self.owes) { out.write_str("ok\n") } else { Ok(()) }
    }

    /// Refuses the line, with the number of the reason, and why.
    pub fn refuse(&mut self, reason: Reason, why: fmt::Arguments<'_>, out: &mut impl Write) -> fmt::Result {
        writeln!(out, "[MSG:{why}]")?;
        if core::mem::take(&mut self.owes) { writeln!(out, "error:{}", reason.number()) } else { Ok(()) }
    }

    /// Passes a piece of text on. `is_reply`: it may answer the line that is owed an answer.
    pub fn pass(&mut self, text: &str, is_reply: bool, out: &mut impl Write) -> fmt::Result {
        for piece in text.split_inclusive('\n') {
            let (words, ends) = piece.strip_suffix('\n').map_or((piece, false), |words| (words, true));
            let words = if self.place == Place::LineStart { self.begin(words, out)? } else { words };
            if self.place != Place::Ok {
                out.write_str(words)?;
            }
            if ends {
                self.end(is_reply, out)?;
            }
        }
        Ok(())
    }

    /// Finds out the kind of a line by its beginning; returns the part that is still to be written.
    fn begin<'t>(&mut self, words: &'t str, out: &mut impl Write) -> Result<&'t str, fmt::Error> {
        let (place, rest) = if words == "ok" {
            (Place::Ok, "")
        } else if let Some(rest) = words.strip_prefix("ok ") {
            (Place::Remark, rest.trim_start_matches("- "))
        } else if let Some(rest) = words.strip_prefix("error:") {
            (Place::Refusal, rest.trim_start())
        } else if is_grbls(words) {
            (Place::AsItIs, words)
        } else {
            (Place::Message, words.trim_start_matches("// "))
        };
        self.place = place;
        if matches!(place, Place::Remark | Place::Refusal | Place::Message) {
            out.write_str("[MSG:")?;
        }
        Ok(rest)
    }

    fn end(&mut self, is_reply: bool, out: &mut impl Write) -> fmt::Result {
        let place = core::mem::take(&mut self.place);
        match place {
            Place::LineStart | Place::AsItIs => out.write_str("\n")?,
            Place::Message | Place::Remark | Place::Refusal => out.write_str("]\n")?,
            Place::Ok => {}
        }
        let answers = is_reply && self.owes && matches!(place, Place::Ok | Place::Remark | Place::Refusal);
        if !answers {
            return Ok(());
        }
        self.owes = false;
        match place {
            Place::Refusal => writeln!(out, "error:{}", Reason::default().number()),
            _ => out.write_str("ok\n"),
        }
    }
}

/// Returns whether a line that begins like this has a form of GRBL's own.
fn is_grbls(words: &str) -> bool {
    let is_alarm = words.strip_prefix("ALARM:").is_some_and(|rest| !rest.starts_with(' '));
    words.is_empty()
        || words.starts_with(['[', '<', '$', '>'])
        || words.starts_with("Grbl ")
        || words.starts_with("GrblHAL ")
        || is_alarm
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn framed(pieces: &[&str], owes: bool) -> String {
        let (mut framing, mut out) = (Framing::new(), String::new());
        if owes {
            framing.owe();
        }
        pieces.iter().for_each(|piece| framing.pass(piece, true, &mut out).unwrap());
        out
    }

    #[test]
    fn what_has_grbls_form_stays_and_the_rest_is_a_message() {
        for line in
            ["<Idle|MPos:0.000,0.000,0.000>\n", "[GC:G0]\n", "$10=1\n", ">G54:ok\n", "Grbl 1.1f\n", "ALARM:1\n", "ok\n"]
        {
            assert_eq!(framed(&[line], true), line);
        }
        assert_eq!(framed(&["// NOTE the door", " is open\nA\n"], true), "[MSG:NOTE the door is open]\n[MSG:A]\n");
        assert_eq!(framed(&["ALARM: Probe fail\n"], true), "[MSG:ALARM: Probe fail]\n");
        assert_eq!(framed(&["ok ", "T:20.0", "\n"], true), "[MSG:T:20.0]\nok\n");
        assert_eq!(framed(&["error:", "no such file", "\n"], true), "[MSG:no such file]\nerror:20\n");
    }

    #[test]
    fn what_is_not_owed_is_not_answered() {
        assert_eq!(framed(&["ok\n"], false), "");
        assert_eq!(framed(&["ok\nok\nerror:late\n"], true), "ok\n[MSG:late]\n");
        let (mut framing, mut out) = (Framing::new(), String::new());
        framing.owe();
        framing.pass("error:of a heater, to everybody\nok\n", false, &mut out).unwrap();
        assert_eq!(out, "[MSG:of a heater, to everybody]\n");
        framing.refuse(Reason::Locked, format_args!("locked"), &mut out).unwrap();
        framing.settle(&mut out).unwrap();
        assert!(out.ends_with("[MSG:locked]\nerror:9\n"), "{out}");
    }

    proptest! {
        /// Any text in any pieces gives one answer, and nothing else that a sender could take for one.
        #[test]
        fn one_answer_a_line(
            pieces in proptest::collection::vec("(ok|error:|ok |// |\\[|a|\n){0,4}", 0..12), settles: bool,
        ) {
            let (mut framing, mut out) = (Framing::new(), String::new());
            framing.owe();
            for piece in &pieces {
                framing.pass(piece, true, &mut out).unwrap();
            }
            framing.pass("\n", true, &mut out).unwrap();
            let said = |out: &str| out.lines().filter(|line| *line == "ok" || line.starts_with("error:")).count();
            prop_assert!(said(&out) <= 1, "{out:?}");
            if settles {
                framing.settle(&mut out).unwrap();
                prop_assert_eq!(said(&out), 1, "{:?}", out);
            }
        }
    }
}
