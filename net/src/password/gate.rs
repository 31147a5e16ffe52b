//! Gate that visitors pass with the password.

use core::net::Ipv4Addr;

use heapless::Vec;
use smoltcp::time::{Duration, Instant};

use super::derivation::{Derivation, WORD_BYTES};
use super::failures::Failures;
use super::record::{ROUNDS, Record, SALT_BYTES};

/// Rounds of a hash in one turn: a million instructions.
const SLICE: u32 = 125;

/// Purpose of a hash.
enum Purpose {
    /// Visitor at this line wants in.
    Prove(usize),
    /// The password is to be another one.
    Set([u8; SALT_BYTES]),
}

/// Gate of all consoles.
pub struct Gate {
    is_required: bool,
    record: Option<Record>,
    work: Option<(Derivation, Purpose)>,
    to_set: Option<(Vec<u8, WORD_BYTES>, [u8; SALT_BYTES])>,
    /// Line whose visitor has given a word, and whether it is the password.
    verdict: Option<(usize, bool)>,
    failures: Failures,
}

impl Gate {
    /// Makes a gate without a password.
    pub const fn new(is_required: bool) -> Self {
        Self { is_required, record: None, work: None, to_set: None, verdict: None, failures: Failures::new() }
    }

    /// Returns whether visitors have to know the password.
    pub const fn is_required(&self) -> bool {
        self.is_required
    }

    /// Returns the record of the password, if there is one.
    pub const fn record(&self) -> Option<&Record> {
        self.record.as_ref()
    }

    /// Sets the record of the password, or that there is none.
    pub fn set_record(&mut self, record: Option<Record>) {
        self.record = record;
    }

    /// Begins to make another word the password. False if it is empty or too long.
    pub fn set(&mut self, word: &[u8], salt: [u8; SALT_BYTES]) -> bool {
        let Ok(word) = Vec::from_slice(word) else { return false };
        if word.is_empty() {
            return false;
        }
        self.to_set = Some((word, salt));
        true
    }

    /// Returns whether a word can be held against the record now.
    pub const fn is_free(&self) -> bool {
        self.work.is_none() && self.verdict.is_none()
    }

    /// Begins to hold a word against the record. False while another hash is in work.
    pub fn prove(&mut self, line: usize, word: &[u8]) -> bool {
        if !self.is_free() {
            return false;
        }
        match self.record.as_ref().and_then(|record| record.derive(word)) {
            Some(derivation) => self.work = Some((derivation, Purpose::Prove(line))),
            None => self.verdict = Some((line, false)),
        }
        true
    }

    /// Takes the verdict on the word of a line, when there is one.
    pub fn verdict(&mut self, line: usize, from: Ipv4Addr, now: Instant) -> Option<bool> {
        let (_, is_right) = self.verdict.take_if(|(of, _)| *of == line)?;
        if is_right {
            self.failures.forgive(from);
        } else {
            self.failures.add(from, now);
        }
        Some(is_right)
    }

    /// Forgets what a line has asked for.
    pub fn forget(&mut self, line: usize) {
        let _dropped = self.work.take_if(|(_, purpose)| matches!(purpose, Purpose::Prove(of) if *of == line));
        let _dropped = self.verdict.take_if(|(of, _)| *of == line);
    }

    /// Returns how long a visitor has to wait before a word is taken.
    pub fn wait(&self, from: Ipv4Addr, now: Instant) -> Duration {
        self.failures.wait(from, now)
    }

    /// Returns whether a hash is in work.
    pub const fn is_busy(&self) -> bool {
        self.work.is_some() || self.to_set.is_some()
    }

    /// Returns whether a new password is on its way to be in force.
    pub const fn is_setting(&self) -> bool {
        self.to_set.is_some() || matches!(self.work, Some((_, Purpose::Set(_))))
    }

    /// Does a slice of the hash in work. Returns whether there was one.
    pub fn run(&mut self) -> bool {
        if self.work.is_none()
            && let Some((word, salt)) = self.to_set.take()
        {
            self.work = Derivation::new(&word, &salt, ROUNDS).map(|hash| (hash, Purpose::Set(salt)));
        }
        let Some((derivation, purpose)) = &mut self.work else { return false };
        let Some(hash) = derivation.advance(SLICE) else { return true };
        match purpose {
            Purpose::Prove(line) => {
                let is_right = self.record.as_ref().is_some_and(|record| record.is_of(&hash));
                self.verdict = Some((*line, is_right));
            }
            Purpose::Set(salt) => self.record = Some(Record::new(*salt, hash)),
        }
        self.work = None;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FROM: Ipv4Addr = Ipv4Addr::new(10, 0, 0, 1);

    fn proves(gate: &mut Gate, word: &[u8]) -> bool {
        assert!(gate.prove(1, word));
        assert!(!gate.prove(2, word), "one at a time");
        for _ in 0..=ROUNDS / SLICE {
            gate.run();
        }
        assert_eq!(gate.verdict(2, FROM, Instant::ZERO), None);
        gate.verdict(1, FROM, Instant::ZERO).expect("a verdict")
    }

    #[test]
    fn a_password_is_set_and_proven() {
        let mut gate = Gate::new(true);
        assert!(!proves(&mut gate, b"secret"), "none is set");
        assert!(!gate.set(b"", [1; 16]) && !gate.set(&[b'x'; 65], [1; 16]));
        assert!(gate.set(b"secret", [1; 16]) && gate.is_busy() && gate.is_setting());
        while gate.run() {
            assert!(gate.is_setting() == gate.record().is_none());
        }
        assert!(!gate.is_busy() && !gate.is_setting());
        assert!(proves(&mut gate, b"secret"));
        assert!(!proves(&mut gate, b"secres") && !proves(&mut gate, b""));
        let text = gate.record().expect("a record").to_string();
        let mut other = Gate::new(true);
        other.set_record(Record::read(text.as_bytes()));
        assert!(proves(&mut other, b"secret"));
    }

    #[test]
    fn a_word_of_a_visitor_who_left_is_forgotten() {
        let mut gate = Gate::new(true);
        gate.set_record(Some(Record::new([0; 16], [0; 32])));
        assert!(gate.prove(1, b"x"));
        gate.forget(0);
        assert!(gate.is_busy());
        gate.forget(1);
        assert!(!gate.is_busy() && gate.prove(2, b"y"));
    }

    #[test]
    fn wrong_words_make_an_address_wait() {
        let mut gate = Gate::new(true);
        for _ in 0..5 {
            assert!(!proves(&mut gate, b"x"));
        }
        assert_eq!(gate.wait(FROM, Instant::ZERO), Duration::from_secs(2));
    }
}
