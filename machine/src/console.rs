//! Consoles: lines in, text out.
//!
//! Each console has one line being gathered, at most one whole line waiting, and an output buffer. While a line waits
//! no further bytes are taken, so a sender that does not wait for `ok` is held back by its transport.

use core::fmt::{self, Write};

use gcode::{Decoder, Gathered, LineBuffer, MAX_LINE_LENGTH};
use heapless::{Deque, Vec};

use crate::ports::{ConsoleId, Inbox, MAX_CONSOLES, Ports, Received};

/// Output a console can be behind with; more than the longest reply of one line.
const OUTPUT_BYTES: usize = 2_048;

/// A whole line.
pub type LineBytes = Vec<u8, MAX_LINE_LENGTH>;

/// Where replies go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Target {
    /// One console.
    Console(u8),
    /// Every console.
    All,
    /// Nowhere: lines of a file played without `-v`.
    #[default]
    Nobody,
}

/// One console.
#[derive(Debug)]
pub struct Console {
    gathering: LineBuffer,
    line: Option<LineBytes>,
    output: Deque<u8, OUTPUT_BYTES>,
    /// Line numbers and checksums of this console.
    pub decoder: Decoder,
    /// Ctrl-Y was received.
    pub stop_requested: bool,
    /// Its line is being carried out.
    busy: bool,
    /// Lines its inbox had no room for, and that are not answered yet.
    lost: u32,
}

impl Console {
    const fn new() -> Self {
        Self {
            gathering: LineBuffer::new(),
            line: None,
            output: Deque::new(),
            decoder: Decoder::new(),
            stop_requested: false,
            busy: false,
            lost: 0,
        }
    }

    /// Gathers bytes until a line is whole. True when a line was dropped for being too long.
    fn gather(&mut self, inbox: &Inbox) -> bool {
        while self.line.is_none() && self.lost == 0 {
            let byte = match inbox.take() {
                Some(Received::Byte(byte)) => byte,
                Some(Received::ForgetLine) => {
                    self.gathering.clear();
                    continue;
                }
                None => {
                    self.lost = inbox.take_lost();
                    return false;
                }
            };
            match self.gathering.push(byte) {
                Some(Gathered::Line(line)) => self.line = Vec::from_slice(line).ok(),
                Some(Gathered::TooLong) => return true,
                None => {}
            }
        }
        false
    }
}

impl Write for Console {
    /// Whole pieces or nothing: a reader that fell 2 kB behind gets gaps between words, never within.
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if text.len() <= OUTPUT_BYTES - self.output.len() {
            for byte in text.bytes() {
                // There is room.
                let _ = self.output.push_back(byte);
            }
        }
        Ok(())
    }
}

/// All consoles of a board.
#[derive(Debug)]
pub struct Consoles {
    consoles: [Console; MAX_CONSOLES],
    count: usize,
    /// The console to look at first, so that a busy one cannot keep the others out.
    turn: usize,
}

impl Consoles {
    /// No line, no output.
    #[must_use]
    pub const fn new() -> Self {
        Self { consoles: [const { Console::new() }; MAX_CONSOLES], count: 0, turn: 0 }
    }

    /// How many are in use.
    pub fn set_count(&mut self, count: u8) {
        self.count = usize::from(count).min(MAX_CONSOLES);
    }

    /// How many are in use.
    #[must_use]
    pub const fn count(&self) -> u8 {
        self.count as u8
    }

    /// One console.
    pub fn get_mut(&mut self, console: u8) -> Option<&mut Console> {
        self.consoles.get_mut(usize::from(console))
    }

    /// Gathers from one console. True when a line was dropped for being too long.
    pub fn gather(&mut self, console: u8, inbox: &Inbox) -> bool {
        self.get_mut(console).is_some_and(|console| console.gather(inbox))
    }

    /// The line that waits on a console.
    #[must_use]
    pub fn waiting(&self, console: u8) -> Option<&[u8]> {
        self.consoles.get(usize::from(console))?.line.as_deref()
    }

    /// Takes the line that waits on a console.
    pub fn take_from(&mut self, console: u8) -> Option<LineBytes> {
        self.get_mut(console)?.line.take()
    }

    /// Takes the next waiting line, consoles in turn.
    pub fn take_line(&mut self) -> Option<(u8, LineBytes)> {
        for step in 0..self.count {
            let console = ((self.turn + step) % self.count) as u8;
            if let Some(line) = self.take_from(console) {
                self.turn = usize::from(console) + 1;
                if let Some(console) = self.get_mut(console) {
                    console.busy = true;
                }
                return Some((console, line));
            }
        }
        None
    }

    /// The line that [`Self::take_line`] gave has been answered.
    pub fn answered(&mut self, console: u8) {
        if let Some(console) = self.get_mut(console) {
            console.busy = false;
        }
    }

    /// Takes one lost line to be answered as a refused one, so that a sender that counts answers stays in step. It keeps its place:
    /// what came before has been answered, and there is room for the answer.
    pub fn take_lost(&mut self, console: u8) -> bool {
        let Some(console) = self.get_mut(console) else { return false };
        let tells =
            console.lost > 0 && !console.busy && console.line.is_none() && console.output.len() < OUTPUT_BYTES / 2;
        console.lost -= u32::from(tells);
        tells
    }

    /// Drops the unfinished line of a console, as an abort does.
    pub fn clear_line(&mut self, console: u8) {
        if let Some(console) = self.get_mut(console) {
            console.gathering.clear();
            console.line = None;
        }
    }

    /// Writes to consoles.
    pub fn write(&mut self, target: Target, text: fmt::Arguments<'_>) {
        let count = self.count;
        let (from, to) = match target {
            Target::Console(console) => (usize::from(console), usize::from(console) + 1),
            Target::All => (0, count),
            Target::Nobody => return,
        };
        for console in self.consoles.iter_mut().take(to.min(count)).skip(from) {
            // A console's write cannot fail.
            let _ = console.write_fmt(text);
        }
    }

    /// Bytes that wait to be sent on the console furthest behind among the target.
    #[must_use]
    pub fn backlog(&self, target: Target) -> usize {
        let behind = |console: &Console| console.output.len();
        match target {
            Target::Console(console) => self.consoles.get(usize::from(console)).map_or(0, behind),
            Target::All => self.consoles.iter().take(self.count).map(behind).max().unwrap_or(0),
            Target::Nobody => 0,
        }
    }

    /// Forgets what a target that does not listen has not taken.
    pub fn forget_output(&mut self, target: Target) {
        for (index, console) in self.consoles.iter_mut().enumerate() {
            if target == Target::All || target == Target::Console(index as u8) {
                console.output.clear();
            }
        }
    }

    /// Hands output to the ports, as much as they take.
    pub fn flush(&mut self, ports: &mut impl Ports) {
        for (index, console) in self.consoles.iter_mut().take(self.count).enumerate() {
            // Two rounds: the ring's two halves.
            for _ in 0..2 {
                let (front, _) = console.output.as_slices();
                if front.is_empty() {
                    break;
                }
                let taken = ports.console_write(ConsoleId(index as u8), front);
                for _ in 0..taken {
                    console.output.pop_front();
                }
            }
        }
    }
}

impl Default for Consoles {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn consoles() -> Consoles {
        let mut consoles = Consoles::new();
        consoles.set_count(2);
        consoles
    }

    #[test]
    fn a_waiting_line_holds_back_the_bytes_behind_it() {
        let (mut consoles, inbox) = (consoles(), Inbox::new());
        b"G28\nM105\n".iter().for_each(|byte| assert!(inbox.receive(*byte)));
        consoles.gather(1, &inbox);
        consoles.gather(1, &inbox);
        assert_eq!(consoles.waiting(1), Some(&b"G28"[..]));
        assert_eq!(consoles.take_line().map(|(console, line)| (console, line.to_vec())), Some((1, b"G28".to_vec())));
        consoles.gather(1, &inbox);
        assert_eq!(consoles.waiting(1), Some(&b"M105"[..]));
    }

    #[test]
    fn consoles_take_turns() {
        let (mut consoles, inboxes) = (consoles(), [Inbox::new(), Inbox::new()]);
        let mut order = Vec::<u8, 8>::new();
        for inbox in &inboxes {
            b"a\nb\n".iter().for_each(|byte| assert!(inbox.receive(*byte)));
        }
        for _ in 0..4 {
            for (console, inbox) in inboxes.iter().enumerate() {
                consoles.gather(console as u8, inbox);
            }
            order.push(consoles.take_line().unwrap().0).unwrap();
        }
        assert_eq!(order, [0, 1, 0, 1]);
    }

    #[test]
    fn output_goes_to_its_target_only() {
        let mut consoles = consoles();
        consoles.write(Target::Console(1), format_args!("ok {}\n", 7));
        assert_eq!((consoles.backlog(Target::Console(0)), consoles.backlog(Target::Console(1))), (0, 5));
        consoles.write(Target::All, format_args!("x"));
        consoles.write(Target::Nobody, format_args!("x"));
        assert_eq!((consoles.backlog(Target::Console(0)), consoles.backlog(Target::All)), (1, 6));
        consoles.forget_output(Target::All);
        assert_eq!(consoles.backlog(Target::All), 0);
    }
}
