//! The site's console of the machine: scripts of all visitors, line by line, and what the machine says.

use base::sessions::{DONE, NEWS, REFUSED};
use heapless::{Deque, String};
use http::Role;

use crate::access::Pass;
use crate::calls::{Id, SCRIPT_BYTES};
use crate::jog::JOG_PLACE;
use crate::messages::{Messages, TEXT_BYTES};

/// Most scripts that wait, or are carried out.
const SCRIPTS: usize = 6;
/// Bytes of lines that wait.
const WAITING_BYTES: usize = 2 * SCRIPT_BYTES;
/// Bytes of what the machine said last.
pub const SAID_BYTES: usize = 4_096;
/// Longest line that is passed on in one piece.
pub const LINE_BYTES: usize = 324;
/// Mark before what is refused, and before faults.
const MARK: &str = "!! ";
/// Time for which the machine waits for a listener who takes nothing, milliseconds.
const PATIENCE_MS: u64 = 2_000;
/// Time after which a long answer to one visitor is broken off, if another's lines wait, milliseconds.
const LONG_ANSWER_MS: u64 = 500;
/// Beginning of the line that says why the machine refuses.
const REASON: &str = "error:";
/// Listener of a line that is for everybody.
const EVERYBODY: u8 = 0xFF;
/// Listener of a line that was sent to the machine: nobody hears it, and who comes later is told.
const SENT: u8 = 0xFE;
/// Command whose lines are not kept, as they hold a secret.
const SECRET: &str = "password";
/// Bytes before a line that is kept: its listener, and its time in groups of seven bits, none of which is a
/// line feed.
const HEAD_BYTES: usize = 1 + TIME_BYTES;
const TIME_BYTES: usize = 4;

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
    /// Proof of the visitor, who may have lost the role when a line's turn comes.
    pass: Pass,
    id: Option<Id>,
    /// Visitors who hear the machine's answers to it.
    listeners: Listeners,
    /// Lines that are not done.
    lines: u16,
    ending: Ending,
    /// Place of the reason that the machine has given last.
    reason: Option<u32>,
}

/// Listeners to what a script comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listeners {
    /// Everybody, as at a console that all sit at.
    All,
    /// The sender of the script, and nobody else.
    Asker,
}

/// End of a script.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// All lines were carried out.
    Done,
    /// The machine refused a line, or was stopped; where it said why, the place of that in what it said.
    Refused(Option<u32>),
    /// The answer was broken off as others waited.
    BrokenOff,
}

/// Line that the machine said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Said {
    /// Text without its line feed.
    pub text: String<LINE_BYTES>,
    /// Place of the next line.
    pub next: u32,
    /// Time since the start, seconds.
    pub at_s: u32,
    listener: u8,
}

impl Said {
    /// Returns whether the line is for nobody but one visitor.
    #[must_use]
    pub const fn is_private(&self) -> bool {
        self.listener != EVERYBODY
    }

    /// Returns whether the line was sent to the machine.
    #[must_use]
    pub const fn is_sent(&self) -> bool {
        self.listener == SENT
    }

    /// Returns why the machine refuses, where the line says that.
    #[must_use]
    pub fn reason(&self) -> &str {
        let words = self.text.strip_prefix(MARK).unwrap_or(&self.text);
        words.strip_prefix(REASON).unwrap_or(words)
    }

    /// Returns whether the visitor at this place is to hear the line.
    #[must_use]
    pub const fn is_for(&self, place: u8) -> bool {
        self.listener == EVERYBODY || self.listener == place
    }
}

/// Script that is done.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Visitor whose script it was.
    pub asker: Asker,
    /// Id of the call; none if nobody wants an answer.
    pub id: Option<Id>,
    /// End of the script: done, refused or broken off.
    pub ending: Ending,
    /// Place behind what the machine said to it, which the visitor is told before.
    pub said: u32,
}

/// Console that all visitors share.
#[derive(Debug)]
pub struct Console {
    scripts: Deque<Script, SCRIPTS>,
    waiting: Deque<u8, WAITING_BYTES>,
    /// Whether a line has been handed to the machine and is not done.
    is_busy: bool,
    said: &'static mut [u8; SAID_BYTES],
    /// Bytes said since the start.
    total: u32,
    /// Line that is being said, and whether it is news that answers no script.
    line: String<LINE_BYTES>,
    is_news: bool,
    /// Time at which the script in work began, and since which its listener takes nothing.
    begun_ms: u64,
    now_s: u32,
    held_since_ms: Option<u64>,
    /// The last line that said a fault, and whether it is the one of a halt that lasts.
    fault: String<TEXT_BYTES>,
    is_halted: bool,
    /// The last messages, whatever was said behind them.
    pub messages: Messages,
}

impl Console {
    /// Makes a console that nothing was said on.
    #[must_use]
    pub const fn new(said: &'static mut [u8; SAID_BYTES]) -> Self {
        Self {
            scripts: Deque::new(),
            waiting: Deque::new(),
            is_busy: false,
            said,
            total: 0,
            line: String::new(),
            is_news: false,
            begun_ms: 0,
            now_s: 0,
            held_since_ms: None,
            fault: String::new(),
            is_halted: false,
            messages: Messages::new(),
        }
    }

    /// Takes a script. False if there is no room: nothing of it is taken.
    pub fn take(&mut self, asker: Asker, pass: Pass, id: Option<Id>, text: &str, listeners: Listeners) -> bool {
        let lines = || text.lines().map(str::trim).filter(|line| !line.is_empty());
        let bytes: usize = lines().map(|line| line.len() + 1).sum();
        if self.scripts.is_full() || bytes > WAITING_BYTES - self.waiting.len() {
            return false;
        }
        let lines_due = lines().count() as u16;
        let script = Script { asker, pass, id, listeners, lines: lines_due, ending: Ending::Done, reason: None };
        // Room was looked at.
        let _ = self.scripts.push_back(script);
        for byte in lines().flat_map(|line| line.bytes().chain([b'\n'])) {
            let _ = self.waiting.push_back(byte);
        }
        true
    }

    /// Returns whether no script waits, and none is carried out.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.scripts.is_empty()
    }

    /// Returns whether lines wait or are carried out that are not only answered to one visitor.
    #[must_use]
    pub fn works_for_all(&self) -> bool {
        self.scripts.iter().any(|script| script.listeners == Listeners::All)
    }

    /// Returns the script whose line is carried out, or is the next. Scripts before it may be done, whose
    /// outcome nobody has taken.
    fn in_work(&self) -> Option<&Script> {
        self.scripts.iter().find(|script| script.lines > 0)
    }

    fn in_work_mut(&mut self) -> Option<&mut Script> {
        self.scripts.iter_mut().find(|script| script.lines > 0)
    }

    /// Returns the next line for the machine, with its line feed, if the one before is done, and the role
    /// that its sender has now. Lines of who may not send them any longer are refused.
    pub fn next_line(&mut self, now_ms: u64, role_of: impl Fn(Pass) -> Role) -> Option<(String<SCRIPT_BYTES>, Role)> {
        loop {
            if self.is_busy || self.waiting.is_empty() {
                return None;
            }
            let script = self.in_work_mut()?;
            let role = role_of(script.pass);
            // Visitors who watch may ask; the machine decides which lines are questions.
            let least = if script.listeners == Listeners::Asker { Role::Watch } else { Role::Operate };
            if role >= least {
                let is_kept = script.listeners == Listeners::All && script.asker.place != JOG_PLACE;
                (self.begun_ms, self.now_s) = (now_ms, (now_ms / 1_000) as u32);
                let line = self.take_line()?;
                if is_kept
                    && !line.trim_start().get(..SECRET.len()).is_some_and(|word| word.eq_ignore_ascii_case(SECRET))
                {
                    self.keep(SENT, "", &line);
                }
                return Some((line, role));
            }
            script.ending = Ending::Refused(None);
            script.lines -= 1;
            self.take_line()?;
            self.is_busy = false;
        }
    }

    fn take_line(&mut self) -> Option<String<SCRIPT_BYTES>> {
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
            script.ending = Ending::Refused(script.reason);
        }
    }

    /// Returns whether the answer in work is to be broken off: it is long, for one visitor alone, and a jog
    /// or lines of others wait. True once.
    pub fn breaks_off(&mut self, now_ms: u64, jog_waits: bool) -> bool {
        let is_long = self.is_busy && now_ms.saturating_sub(self.begun_ms) >= LONG_ANSWER_MS;
        let others_wait = jog_waits || self.works_for_all();
        let script = self.in_work_mut().filter(|script| script.listeners == Listeners::Asker);
        let Some(script) = script.filter(|script| is_long && others_wait && script.ending != Ending::BrokenOff) else {
            return false;
        };
        script.ending = Ending::BrokenOff;
        true
    }

    /// Takes an outcome, when the first script is done.
    pub fn take_outcome(&mut self) -> Option<Outcome> {
        self.scripts.front().filter(|script| script.lines == 0)?;
        let said = self.total;
        self.scripts.pop_front().map(|Script { asker, id, ending, .. }| Outcome { asker, id, ending, said })
    }

    /// Returns who alone hears what is said now, if somebody does.
    #[must_use]
    pub fn only_listener(&self) -> Option<Asker> {
        let script = self.in_work().filter(|script| self.is_busy && script.listeners == Listeners::Asker);
        script.map(|script| script.asker)
    }

    /// Returns how many bytes can be heard, so that a listener who has heard all up to this place misses
    /// nothing; all of them while nobody alone listens, or who does takes nothing for seconds.
    pub fn room(&mut self, heard: Option<u32>, now_ms: u64) -> usize {
        let Some(heard) = heard else {
            self.held_since_ms = None;
            return usize::MAX;
        };
        let behind = self.total.wrapping_sub(heard) as usize + self.line.len();
        // With the head of each line, the shortest lines take seven bytes where two were heard.
        let room = SAID_BYTES.saturating_sub(behind + HEAD_BYTES + LINE_BYTES) / 4;
        if room > 0 {
            self.held_since_ms = None;
            return room;
        }
        let since = *self.held_since_ms.get_or_insert(now_ms);
        if now_ms.saturating_sub(since) >= PATIENCE_MS { usize::MAX } else { 0 }
    }

    /// Hears what the machine says.
    pub fn hear(&mut self, bytes: &[u8], now_ms: u64) {
        self.now_s = (now_ms / 1_000) as u32;
        for byte in bytes {
            match *byte {
                DONE => self.end_line(false),
                REFUSED => self.end_line(true),
                NEWS => {
                    self.pass_on();
                    self.is_news = true;
                }
                b'\n' => {
                    self.pass_on();
                    self.is_news = false;
                }
                b'\r' => {}
                byte => {
                    // Text of the machine is ASCII but for names of files.
                    if self.line.len() + 4 + MARK.len() > LINE_BYTES {
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
        if let Some(script) = self.in_work_mut() {
            if is_refused && script.ending == Ending::Done {
                script.ending = Ending::Refused(script.reason);
            }
            script.lines = script.lines.saturating_sub(1);
        }
    }

    fn pass_on(&mut self) {
        let line = core::mem::take(&mut self.line);
        if line == "ok" || line.is_empty() {
            return;
        }
        let is_fault = ["ALARM:", "ERROR:"].iter().any(|begin| line.starts_with(begin));
        if is_fault && !self.is_halted {
            self.fault.clear();
            for letter in line.chars() {
                // A text that is too long is cut.
                let _cut = self.fault.push(letter);
            }
        }
        let listener = self.only_listener().filter(|_| !self.is_news).map_or(EVERYBODY, |asker| asker.place);
        let is_reason = line.starts_with(REASON);
        let at = self.total;
        if is_reason
            && self.is_busy
            && !self.is_news
            && let Some(script) = self.in_work_mut()
        {
            script.reason = Some(at);
        }
        if listener == EVERYBODY {
            self.messages.take(&line, self.now_s);
        }
        // A visitor who alone listens gets the machine's own words.
        let mark = if (is_fault || is_reason) && listener == EVERYBODY { MARK } else { "" };
        self.keep(listener, mark, &line);
    }

    /// Keeps a line, with or without its line feed.
    fn keep(&mut self, listener: u8, mark: &str, line: &str) {
        let time: [u8; TIME_BYTES] = core::array::from_fn(|group| 0x80 | (self.now_s >> (7 * group)) as u8);
        let head = [listener].into_iter().chain(time);
        let letters = line.trim_end().bytes().map(|byte| if byte.is_ascii() { byte } else { b'?' });
        for byte in head.chain(mark.bytes()).chain(letters).chain([b'\n']) {
            if let Some(place) = self.said.get_mut(self.total as usize % SAID_BYTES) {
                *place = byte;
            }
            self.total = self.total.wrapping_add(1);
        }
    }

    /// Keeps the fault that was said last while the machine is halted: what is said later is not its reason.
    pub const fn keep_fault(&mut self, is_halted: bool) {
        self.is_halted = is_halted;
    }

    /// Returns the last line that said a fault: the reason of a halt, while there is one.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        Some(self.fault.as_str()).filter(|text| !text.is_empty())
    }

    /// Returns the place behind all that was said.
    #[must_use]
    pub const fn end(&self) -> u32 {
        self.total
    }

    /// Returns the line at a place of what was said. What has been overwritten is passed over.
    #[must_use]
    pub fn line(&self, at: u32) -> Option<Said> {
        let behind = self.total.wrapping_sub(at);
        if behind == 0 {
            return None;
        }
        let is_lost = self.is_lost(at);
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
        let listener = next()?;
        let at_s =
            (0..TIME_BYTES).fold(0, |at_s, group| at_s | u32::from(next().unwrap_or_default() & 0x7F) << (7 * group));
        let mut text = String::new();
        while let Some(byte) = next().filter(|byte| *byte != b'\n') {
            // Lines are no longer than that.
            let _ = text.push(char::from(byte));
        }
        Some(Said { text, next: at, at_s, listener })
    }

    /// Returns the place of the first of so many lines that everybody may be told later.
    #[must_use]
    pub fn last(&self, count: usize) -> u32 {
        let byte = |at: u32| self.said.get(at as usize % SAID_BYTES).copied().unwrap_or_default();
        let (mut at, mut left) = (self.total, count);
        let oldest = self.total.wrapping_sub(self.total.min(SAID_BYTES as u32 - 1));
        while at != oldest && left > 0 {
            at = at.wrapping_sub(1);
            // The first line begins where the machine did, or behind another one's end.
            let is_begin = at == 0 || at != oldest && byte(at.wrapping_sub(1)) == b'\n';
            left -= usize::from(is_begin && byte(at) >= SENT);
        }
        at
    }

    /// Returns the next line that everybody may be told later, from a place on.
    #[must_use]
    pub fn next_kept(&self, mut at: u32) -> Option<Said> {
        loop {
            let said = self.line(at)?;
            if said.listener >= SENT {
                return Some(said);
            }
            at = said.next;
        }
    }

    /// Returns whether what was said at a place has been overwritten.
    #[must_use]
    pub const fn is_lost(&self, at: u32) -> bool {
        self.total.wrapping_sub(at) as usize > SAID_BYTES
    }
}

#[cfg(test)]
mod tests;
