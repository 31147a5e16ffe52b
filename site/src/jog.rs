//! Jogs while a button is held: one at a time, which lasts as long as its visitor says so.
//!
//! A jog is a line of the console, `$J -c`, which the machine ends when it is told to let go. It is handed
//! over only while no other line is in work, so that none begins when its button was let go long ago.

use heapless::String;

use crate::calls::{Call, Quantity, codes};
use crate::console::Asker;
use crate::script;

/// Time without a beat after which a jog ends, milliseconds: browsers send one each 50 ms.
pub const SILENCE_MS: u64 = 100;
/// Longest line of a jog: `$J -c X-1 F1000000`.
const LINE_BYTES: usize = 24;

/// Line of a jog.
pub type JogLine = String<LINE_BYTES>;

/// Error of a call: code and text.
pub type Error = (i32, &'static str);

/// Place of the asker whose script a jog is: no visitor has it.
pub const JOG_PLACE: u8 = u8::MAX;

/// A jog whose button is held.
#[derive(Clone, Debug)]
struct Held {
    id: u32,
    holder: Asker,
    line: JogLine,
    /// Time of the last beat.
    heard_ms: u64,
}

/// Jogs of all visitors.
#[derive(Debug, Default)]
pub struct Jogs {
    /// Number of the last jog.
    last: u32,
    held: Option<Held>,
    /// Jog whose line the machine has: the one held, or one before it that comes to its end.
    under_way: Option<u32>,
    /// Whether the machine is still to be told to let go.
    must_end: bool,
}

impl Jogs {
    /// Makes jogs of which none has begun.
    #[must_use]
    pub const fn new() -> Self {
        Self { last: 0, held: None, under_way: None, must_end: false }
    }

    /// Begins a jog: a former one of the same visitor ends. Returns its id.
    ///
    /// # Errors
    /// Parameters are wrong, or somebody else holds a button.
    pub fn start(&mut self, call: &Call, axis: &str, holder: Asker, now_ms: u64) -> Result<u32, Error> {
        let line = line(call, axis).map_err(|why| (codes::PARAMETERS, why))?;
        if self.held.as_ref().is_some_and(|held| held.holder != holder) {
            return Err((codes::BUSY, "somebody else is moving the machine by hand"));
        }
        self.let_go();
        self.last = self.last.wrapping_add(1);
        self.held = Some(Held { id: self.last, holder, line, heard_ms: now_ms });
        Ok(self.last)
    }

    /// Notes that the visitor still holds the button.
    ///
    /// # Errors
    /// The jog has ended, or is not this visitor's.
    pub fn beat(&mut self, call: &Call, holder: Asker, now_ms: u64) -> Result<(), Error> {
        let id = id(call)?;
        // A beat that comes too late does not revive its jog.
        self.watch(now_ms);
        let held = self.held.as_mut().filter(|held| held.id == id && held.holder == holder);
        held.map(|held| held.heard_ms = now_ms).ok_or((codes::MISSING, "this jog has ended, or is not yours"))
    }

    /// Ends a jog, whoever asks for it. One that has ended already is no error.
    ///
    /// # Errors
    /// The id is missing.
    pub fn stop(&mut self, call: &Call) -> Result<(), Error> {
        let id = id(call)?;
        if self.held.as_ref().is_some_and(|held| held.id == id) {
            self.let_go();
        }
        Ok(())
    }

    /// The visitor has gone.
    pub fn leave(&mut self, visitor: Asker) {
        if self.held.as_ref().is_some_and(|held| held.holder == visitor) {
            self.let_go();
        }
    }

    /// Ends the jog of a visitor who has been silent for too long.
    pub fn watch(&mut self, now_ms: u64) {
        if self.held.as_ref().is_some_and(|held| now_ms.saturating_sub(held.heard_ms) >= SILENCE_MS) {
            self.let_go();
        }
    }

    /// Lets go of the button that is held, if one is.
    pub fn let_go(&mut self) {
        if let Some(held) = self.held.take() {
            self.must_end |= self.under_way == Some(held.id);
        }
    }

    /// Returns the line of a jog that is to begin, its id and its visitor. For a console on which no line is
    /// in work.
    pub fn next_line(&mut self) -> Option<(JogLine, u32, Asker)> {
        let held = self.held.as_ref().filter(|_| self.under_way.is_none())?;
        self.under_way = Some(held.id);
        Some((held.line.clone(), held.id, held.holder))
    }

    /// Returns whether a jog is to begin, and has not.
    #[must_use]
    pub const fn waits(&self) -> bool {
        self.held.is_some() && self.under_way.is_none()
    }

    /// Returns whether the machine has the line of a jog.
    #[must_use]
    pub const fn is_under_way(&self) -> bool {
        self.under_way.is_some()
    }

    /// The machine is done with the line of a jog: let go, refused, or halted.
    pub fn ended(&mut self, id: u32) {
        if self.under_way == Some(id) {
            (self.under_way, self.must_end) = (None, false);
        }
        if self.held.as_ref().is_some_and(|held| held.id == id) {
            self.held = None;
        }
    }

    /// Takes the request to have the machine let go.
    pub const fn take_end(&mut self) -> bool {
        core::mem::replace(&mut self.must_end, false)
    }
}

/// Returns the id of the jog that a call is about.
fn id(call: &Call) -> Result<u32, Error> {
    call.number(Quantity::Id).map(|id| id as u32).ok_or((codes::PARAMETERS, "id is missing"))
}

/// Returns the line of the jog that a call asks for.
fn line(call: &Call, axis: &str) -> Result<JogLine, &'static str> {
    let letter = script::axis(axis)?;
    let sign = match call.number(Quantity::Direction) {
        Some(1.0) => "",
        Some(-1.0) => "-",
        _ => return Err("direction is missing, or neither 1 nor -1"),
    };
    let speed = script::speed(call)?;
    let mut line = JogLine::new();
    let written = core::fmt::write(&mut line, format_args!("$J -c {letter}{sign}1 F{speed:.0}"));
    written.map(|()| line).map_err(|_| "the text is too long")
}

#[cfg(test)]
mod tests {
    use base::snapshot::Snapshot;

    use super::*;
    use crate::calls::Reader;

    const ONE: Asker = Asker { place: 0, visit: 1 };
    const OTHER: Asker = Asker { place: 1, visit: 1 };

    fn call(method: &str, parameters: &str) -> (Call, String<512>) {
        let mut reader = Reader::new();
        reader.read(
            &mut format!(r#"{{"method":"velvet.jog.{method}","params":{{{parameters}}}}}"#).as_bytes(),
            &Snapshot::default(),
        );
        (reader.end().expect("a call"), reader.text)
    }

    fn start(jogs: &mut Jogs, holder: Asker, now_ms: u64) -> Result<u32, Error> {
        let (call, axis) = call("start", r#""axis":"x","direction":-1,"mm_per_min":12000"#);
        jogs.start(&call, &axis, holder, now_ms)
    }

    fn beat(jogs: &mut Jogs, id: u32, holder: Asker, now_ms: u64) -> bool {
        jogs.beat(&call("beat", &format!(r#""id":{id}"#)).0, holder, now_ms).is_ok()
    }

    #[test]
    fn a_jog_lasts_while_beats_come_and_ends_once() {
        let mut jogs = Jogs::new();
        let id = start(&mut jogs, ONE, 1_000).unwrap();
        assert_eq!(jogs.next_line().map(|(line, ..)| line.as_str().to_owned()).as_deref(), Some("$J -c X-1 F12000"));
        for now in (1_050..5_000).step_by(99) {
            assert!(beat(&mut jogs, id, ONE, now), "{now}");
            jogs.watch(now + 98);
            assert!(!jogs.take_end(), "{now}");
        }
        jogs.watch(6_000);
        assert!(jogs.take_end() && !jogs.take_end());
        assert!(!beat(&mut jogs, id, ONE, 6_001), "no beat revives it");
        jogs.ended(id);
        assert!(!jogs.is_under_way() && jogs.next_line().is_none());
    }

    #[test]
    fn a_beat_that_comes_too_late_ends_the_jog_instead() {
        let mut jogs = Jogs::new();
        let id = start(&mut jogs, ONE, 1_000).unwrap();
        jogs.next_line();
        assert!(!beat(&mut jogs, id, ONE, 1_000 + SILENCE_MS) && jogs.take_end());
    }

    #[test]
    fn a_button_that_is_let_go_before_the_machine_took_the_line_moves_nothing() {
        for leaves in [false, true] {
            let mut jogs = Jogs::new();
            let id = start(&mut jogs, ONE, 0).unwrap();
            if leaves {
                jogs.leave(ONE);
            } else {
                jogs.stop(&call("stop", &format!(r#""id":{id}"#)).0).unwrap();
            }
            assert!(jogs.next_line().is_none() && !jogs.take_end(), "there is nothing to end");
        }
        let mut jogs = Jogs::new();
        start(&mut jogs, ONE, 0).unwrap();
        jogs.watch(SILENCE_MS);
        assert!(jogs.next_line().is_none());
    }

    #[test]
    fn nobody_keeps_or_takes_the_jog_of_another() {
        let mut jogs = Jogs::new();
        let id = start(&mut jogs, ONE, 0).unwrap();
        jogs.next_line();
        assert!(start(&mut jogs, OTHER, 10).is_err() && !beat(&mut jogs, id, OTHER, 10));
        jogs.leave(OTHER);
        jogs.leave(Asker { visit: 2, ..ONE });
        assert!(!jogs.take_end() && beat(&mut jogs, id, ONE, 20), "the jog goes on");
        jogs.watch(20 + SILENCE_MS);
        assert!(jogs.take_end());
        assert!(start(&mut jogs, OTHER, 200).is_ok(), "then it is the other's turn");
    }

    #[test]
    fn the_next_jog_waits_for_the_end_of_the_former_and_is_not_ended_with_it() {
        let mut jogs = Jogs::new();
        let first = start(&mut jogs, ONE, 0).unwrap();
        jogs.next_line();
        let second = start(&mut jogs, ONE, 10).unwrap();
        assert!(jogs.take_end() && jogs.next_line().is_none(), "the former brakes");
        jogs.ended(first);
        assert_eq!(jogs.next_line().map(|(_, id, _)| id), Some(second));
        assert!(!jogs.take_end() && beat(&mut jogs, second, ONE, 60));
        // The machine ends it by itself: refused, or halted.
        jogs.ended(second);
        assert!(!beat(&mut jogs, second, ONE, 70) && !jogs.take_end());
    }

    #[test]
    fn what_is_no_jog_is_refused() {
        for parameters in [
            r#""axis":"x","direction":2,"mm_per_min":600"#,
            r#""axis":"x","mm_per_min":600"#,
            r#""axis":"xy","direction":1,"mm_per_min":600"#,
            r#""axis":"x","direction":1,"mm_per_min":0"#,
        ] {
            let (call, axis) = call("start", parameters);
            assert!(Jogs::new().start(&call, &axis, ONE, 0).is_err(), "{parameters}");
        }
        assert!(Jogs::new().stop(&call("stop", "").0).is_err());
    }
}
