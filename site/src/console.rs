//! The site's console of the machine: scripts of all visitors, line by line, and what the machine says.

use base::sessions::{DONE, REFUSED};
use heapless::{Deque, String};

use crate::calls::{Id, SCRIPT_BYTES};

/// Most scripts that wait, or are carried out.
const SCRIPTS: usize = 6;
/// Bytes of lines that wait.
const WAITING_BYTES: usize = 2 * SCRIPT_BYTES;
/// Bytes of what the machine said last.
const SAID_BYTES: usize = 2_048;
/// Longest line that is passed on in one piece.
pub const LINE_BYTES: usize = 320;

/// Visitor that a script is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asker {
    /// Place of the visitor.
    pub place: u8,
    /// Number of the visit: another visitor may have come to the place.
    pub visit: u32,
}

/// Script that is carried out or waits.
#[derive(Clone, Debug)]
struct Script {
    asker: Asker,
    id: Option<Id>,
    /// Lines that are not done.
    lines: u16,
    is_refused: bool,
}

/// Script that is done.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Visitor whose script it was.
    pub asker: Asker,
    /// Id of the call; none if nobody wants an answer.
    pub id: Option<Id>,
    /// Whether a line of it was refused.
    pub is_refused: bool,
}

/// Console that all visitors share.
#[derive(Debug)]
pub struct Console {
    scripts: Deque<Script, SCRIPTS>,
    waiting: Deque<u8, WAITING_BYTES>,
    /// Whether a line has been handed to the machine and is not done.
    is_busy: bool,
    said: [u8; SAID_BYTES],
    /// Bytes said since the start.
    total: u32,
    /// Line that is being said.
    line: String<LINE_BYTES>,
}

impl Default for Console {
    fn default() -> Self {
        Self::new()
    }
}

impl Console {
    /// Makes a console that nothing was said on.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            scripts: Deque::new(),
            waiting: Deque::new(),
            is_busy: false,
            said: [0; SAID_BYTES],
            total: 0,
            line: String::new(),
        }
    }

    /// Takes a script. False if there is no room: nothing of it is taken.
    pub fn take(&mut self, asker: Asker, id: Option<Id>, text: &str) -> bool {
        let lines = || text.lines().map(str::trim).filter(|line| !line.is_empty());
        let bytes: usize = lines().map(|line| line.len() + 1).sum();
        if self.scripts.is_full() || bytes > WAITING_BYTES - self.waiting.len() {
            return false;
        }
        let script = Script { asker, id, lines: lines().count() as u16, is_refused: false };
        // Room was looked at.
        let _ = self.scripts.push_back(script);
        for byte in lines().flat_map(|line| line.bytes().chain([b'\n'])) {
            let _ = self.waiting.push_back(byte);
        }
        true
    }

    /// Returns bytes of the next line for the machine, if the one before is done: all up to its line feed.
    pub fn next_line(&mut self) -> Option<String<SCRIPT_BYTES>> {
        if self.is_busy || self.waiting.is_empty() {
            return None;
        }
        let mut line = heapless::Vec::<u8, SCRIPT_BYTES>::new();
        while let Some(byte) = self.waiting.pop_front() {
            // A line is no longer than a script.
            let _ = line.push(byte);
            if byte == b'\n' {
                break;
            }
        }
        self.is_busy = true;
        String::from_utf8(line).ok()
    }

    /// Drops what waits, as the machine is stopped.
    pub fn drop_waiting(&mut self) {
        self.waiting.clear();
        for (place, script) in self.scripts.iter_mut().enumerate() {
            script.lines = u16::from(place == 0 && self.is_busy);
            script.is_refused = true;
        }
    }

    /// Takes an outcome, when the first script is done.
    pub fn take_outcome(&mut self) -> Option<Outcome> {
        self.scripts.front().filter(|script| script.lines == 0)?;
        self.scripts.pop_front().map(|Script { asker, id, is_refused, .. }| Outcome { asker, id, is_refused })
    }

    /// Hears what the machine says.
    pub fn hear(&mut self, bytes: &[u8]) {
        for byte in bytes {
            match *byte {
                DONE => self.end_line(false),
                REFUSED => self.end_line(true),
                b'\n' => self.pass_on(),
                b'\r' => {}
                byte => {
                    // Text of the machine is ASCII but for names of files.
                    if self.line.len() + 4 > LINE_BYTES {
                        self.pass_on();
                    }
                    let _ = self.line.push(if byte.is_ascii() { char::from(byte) } else { '?' });
                }
            }
        }
    }

    fn end_line(&mut self, is_refused: bool) {
        if !core::mem::take(&mut self.is_busy) {
            return;
        }
        if let Some(script) = self.scripts.front_mut() {
            script.is_refused |= is_refused;
            script.lines = script.lines.saturating_sub(1);
        }
    }

    fn pass_on(&mut self) {
        let line = core::mem::take(&mut self.line);
        if line == "ok" || line.is_empty() {
            return;
        }
        for byte in line.bytes().chain([b'\n']) {
            if let Some(place) = self.said.get_mut(self.total as usize % SAID_BYTES) {
                *place = byte;
            }
            self.total = self.total.wrapping_add(1);
        }
    }

    /// Returns the place behind all that was said.
    #[must_use]
    pub const fn end(&self) -> u32 {
        self.total
    }

    /// Returns the line at a place of what was said, and the place of the next one. What has been overwritten
    /// is passed over.
    #[must_use]
    pub fn line(&self, at: u32) -> Option<(String<LINE_BYTES>, u32)> {
        let behind = self.total.wrapping_sub(at);
        if behind == 0 {
            return None;
        }
        let is_lost = behind as usize > SAID_BYTES;
        let mut at = if is_lost { self.total.wrapping_sub(SAID_BYTES as u32) } else { at };
        let mut next = || {
            let byte = (at != self.total).then(|| self.said.get(at as usize % SAID_BYTES).copied()).flatten();
            at = at.wrapping_add(u32::from(byte.is_some()));
            byte
        };
        if is_lost {
            // The first line is not whole.
            while next().is_some_and(|byte| byte != b'\n') {}
        }
        let mut line = String::new();
        while let Some(byte) = next().filter(|byte| *byte != b'\n') {
            // Lines are no longer than that.
            let _ = line.push(char::from(byte));
        }
        Some((line, at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASKER: Asker = Asker { place: 1, visit: 7 };

    #[test]
    fn a_script_is_handed_over_line_by_line_and_done_with_the_last() {
        let mut console = Console::new();
        assert!(console.take(ASKER, Some(Id::Number(5)), "G28\n\n M104 S200 \nG1 X1"));
        assert_eq!(console.next_line().as_deref(), Some("G28\n"));
        assert_eq!(console.next_line(), None, "one at a time");
        console.hear(b"ok\n\x06");
        assert_eq!(console.next_line().as_deref(), Some("M104 S200\n"));
        console.hear(b"error:too hot\n\x15");
        assert!(console.take_outcome().is_none());
        assert_eq!(console.next_line().as_deref(), Some("G1 X1\n"));
        console.hear(b"ok\n\x06");
        let outcome = console.take_outcome().expect("an outcome");
        assert_eq!((outcome.asker, outcome.id, outcome.is_refused), (ASKER, Some(Id::Number(5)), true));
        assert_eq!(console.line(0), Some(("error:too hot".try_into().unwrap(), 14)));
        assert_eq!(console.line(14), None);
    }

    #[test]
    fn a_script_that_has_no_room_is_not_begun() {
        let mut console = Console::new();
        let long = "G1 X1\n".repeat(80);
        assert!(console.take(ASKER, None, &long) && console.take(ASKER, None, &long));
        assert!(!console.take(ASKER, None, &long));
        assert!(console.take(ASKER, None, "M105"), "a short one fits");
        console.next_line();
        console.drop_waiting();
        assert_eq!(console.next_line(), None);
        assert!(console.take_outcome().is_none(), "the first line is still in work");
        console.hear(b"\x15");
        assert_eq!((0..4).filter_map(|_| console.take_outcome()).filter(|outcome| outcome.is_refused).count(), 3);
    }

    #[test]
    fn a_listener_who_is_behind_misses_whole_lines() {
        let mut console = Console::new();
        for number in 0..500 {
            console.hear(format!("line {number}\n").as_bytes());
        }
        let (first, mut at) = console.line(0).expect("a line");
        assert!(first.starts_with("line ") && first.len() == 8, "{first}");
        let mut last = first;
        while let Some((line, next)) = console.line(at) {
            (last, at) = (line, next);
        }
        assert_eq!((last.as_str(), at), ("line 499", console.end()));
    }
}
