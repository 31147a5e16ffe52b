//! Login of a visitor: the prompt, the word as it is typed, and how often.

use core::net::Ipv4Addr;

use heapless::Vec;
use smoltcp::time::{Duration, Instant};

use crate::password::{Gate, WORD_BYTES};

/// Attempts of a connection.
const ATTEMPTS: u8 = 3;
/// Time that a login may take.
const MOST_TIME: Duration = Duration::from_secs(30);
/// Time that a telnet client has to say that it is one, before it is asked for the password.
const HEARING: Duration = Duration::from_millis(300);

const PROMPT: &str = "Password: ";
const NONE_SET: &str = "No password is set, and one is required here.\r\n\
    Set one on a USB or serial console: password WORD\r\n";
const AGAIN: &str = "\r\nWrong password.\r\nPassword: ";
const TOO_MANY: &str = "\r\nWrong password. Good-bye.\r\n";
const WAIT: &str = "\r\nToo many wrong passwords came. Try again later.\r\n";
const TOO_LONG: &str = "\r\nNo password came in time. Good-bye.\r\n";

/// What a login asks of its connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    Nothing,
    /// Have the peer hide what is typed, and say this; whether a word was wrong.
    Ask(&'static str, bool),
    /// Say this and close; whether a word was wrong.
    Refuse(&'static str, bool),
    /// Let the visitor in.
    LetIn,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// Not asked yet.
    Quiet,
    Typing,
    /// The word is whole.
    Given,
    /// The word is held against the record.
    Proving,
}

/// State of a login.
#[derive(Clone, Debug)]
pub struct Login {
    stage: Stage,
    since: Instant,
    word: Vec<u8, WORD_BYTES>,
    /// Whether the word is longer than any password.
    is_too_long: bool,
    wrong: u8,
}

impl Login {
    /// Begins a login, before the visitor is asked anything.
    pub const fn new(now: Instant) -> Self {
        Self { stage: Stage::Quiet, since: now, word: Vec::new(), is_too_long: false, wrong: 0 }
    }

    /// Returns whether more of the word is wanted.
    pub fn is_typing(&self) -> bool {
        self.stage == Stage::Typing
    }

    /// Takes a byte that was typed.
    pub fn hear(&mut self, byte: u8) {
        match byte {
            b'\r' | b'\n' => self.stage = Stage::Given,
            8 | 0x7F => {
                self.word.pop();
            }
            _ => self.is_too_long |= self.word.push(byte).is_err(),
        }
    }

    /// Does what is due. `line` is the visitor's, `is_known` says that its client has shown what it is.
    pub fn run(&mut self, line: usize, from: Ipv4Addr, gate: &mut Gate, is_known: bool, now: Instant) -> Turn {
        if now >= self.since + MOST_TIME {
            return Turn::Refuse(TOO_LONG, false);
        }
        match self.stage {
            Stage::Quiet => self.ask(from, gate, is_known, now),
            Stage::Typing => Turn::Nothing,
            Stage::Given => {
                if self.is_too_long {
                    self.word.clear();
                }
                if gate.prove(line, &self.word) {
                    self.stage = Stage::Proving;
                    self.word.clear();
                    self.is_too_long = false;
                }
                Turn::Nothing
            }
            Stage::Proving => match gate.verdict(line, from, now) {
                None => Turn::Nothing,
                Some(true) => Turn::LetIn,
                Some(false) => self.again(from, gate, now),
            },
        }
    }

    fn ask(&mut self, from: Ipv4Addr, gate: &Gate, is_known: bool, now: Instant) -> Turn {
        if gate.record().is_none() {
            return Turn::Refuse(NONE_SET, false);
        }
        if gate.wait(from, now) > Duration::ZERO {
            return Turn::Refuse(WAIT, false);
        }
        if !is_known && now < self.since + HEARING {
            return Turn::Nothing;
        }
        self.stage = Stage::Typing;
        Turn::Ask(PROMPT, false)
    }

    fn again(&mut self, from: Ipv4Addr, gate: &Gate, now: Instant) -> Turn {
        self.wrong += 1;
        if self.wrong >= ATTEMPTS {
            return Turn::Refuse(TOO_MANY, true);
        }
        if gate.wait(from, now) > Duration::ZERO {
            return Turn::Refuse(WAIT, true);
        }
        self.stage = Stage::Typing;
        Turn::Ask(AGAIN, true)
    }
}
