//! The first password of a board: who reaches it over the network may choose one, and has to type a code that
//! only who stands at the machine can read. Otherwise the first stranger would own the machine.

use super::{Asker, Word};

/// Time for which a code counts, milliseconds.
const CODE_MS: u64 = 300_000;
/// Codes that may be typed for one that is shown.
const ATTEMPTS: u8 = 3;
/// Least time between two codes, milliseconds. It doubles with each code that was used up, so that nobody
/// tries a million of them.
const REST_MS: u64 = 10_000;
/// Doublings of that time at most: 1.4 hours.
const MOST_DOUBLINGS: u8 = 9;
/// Number of codes, which have six digits.
const CODES: u32 = 1_000_000;

/// Time for which a code counts, seconds.
pub const CODE_S: u64 = CODE_MS / 1_000;

/// Reason why no code is shown, or why one is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotNow {
    /// Another visitor has a code shown, or one was shown a moment ago: seconds to wait.
    Wait(u32),
    /// No word of this visitor waits for a code.
    NoWord,
    /// The code is not the one that the machine shows.
    WrongCode,
}

/// A word that waits for its code.
#[derive(Debug)]
struct Waiting {
    asker: Asker,
    word: Word,
    code: u32,
    until_ms: u64,
    left: u8,
}

/// The procedure by which a first password is set and confirmed.
#[derive(Debug)]
pub struct First {
    waiting: Option<Waiting>,
    /// Time from which on a code may be shown again.
    next_ms: u64,
    /// Codes that were used up by wrong ones.
    used_up: u8,
}

impl First {
    /// Begins with nobody waiting.
    #[must_use]
    pub const fn new() -> Self {
        Self { waiting: None, next_ms: 0, used_up: 0 }
    }

    /// Keeps a visitor's word aside. Returns the code to be shown at the machine.
    ///
    /// # Errors
    /// Seconds to wait.
    pub fn begin(&mut self, asker: Asker, word: Word, random: u32, now_ms: u64) -> Result<u32, NotNow> {
        self.expire(now_ms);
        let wait = |until_ms: u64| Err(NotNow::Wait(until_ms.saturating_sub(now_ms).div_ceil(1_000) as u32));
        if let Some(waiting) = self.waiting.as_ref().filter(|waiting| waiting.asker != asker) {
            return wait(waiting.until_ms);
        }
        if now_ms < self.next_ms {
            return wait(self.next_ms);
        }
        let code = random % CODES;
        self.waiting = Some(Waiting { asker, word, code, until_ms: now_ms + CODE_MS, left: ATTEMPTS });
        self.next_ms = now_ms + (REST_MS << self.used_up);
        Ok(code)
    }

    /// Takes the code that a visitor has typed. Returns the visitor's word, which is the password then.
    ///
    /// # Errors
    /// The reason why there is none.
    pub fn confirm(&mut self, asker: Asker, code: &str, now_ms: u64) -> Result<Word, NotNow> {
        self.expire(now_ms);
        let waiting = self.waiting.as_mut().filter(|waiting| waiting.asker == asker).ok_or(NotNow::NoWord)?;
        let is_plain = code.len() == 6 && code.bytes().all(|digit| digit.is_ascii_digit());
        if is_plain && code.parse() == Ok(waiting.code) {
            self.used_up = 0;
            return self.waiting.take().map(|waiting| waiting.word).ok_or(NotNow::NoWord);
        }
        waiting.left -= 1;
        if waiting.left == 0 {
            self.waiting = None;
            self.used_up = (self.used_up + 1).min(MOST_DOUBLINGS);
            self.next_ms = now_ms + (REST_MS << self.used_up);
        }
        Err(NotNow::WrongCode)
    }

    /// Forgets the word of a visitor who has gone.
    pub fn forget(&mut self, asker: Asker) {
        let _gone = self.waiting.take_if(|waiting| waiting.asker == asker);
    }

    fn expire(&mut self, now_ms: u64) {
        let _late = self.waiting.take_if(|waiting| now_ms >= waiting.until_ms);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: Asker = Asker { place: 0, visit: 4 };
    const OTHER: Asker = Asker { place: 1, visit: 4 };

    fn word(text: &str) -> Word {
        Word::from_slice(text.as_bytes()).unwrap()
    }

    #[test]
    fn a_word_is_taken_with_the_code_that_is_shown() {
        let mut first = First::new();
        assert_eq!(first.confirm(ONE, "000042", 5), Err(NotNow::NoWord));
        assert_eq!(first.begin(ONE, word("correct-horse"), 7_000_042, 5), Ok(42));
        for wrong in ["42", "+00042", "000043", ""] {
            let mut first = First::new();
            first.begin(ONE, word("correct-horse"), 42, 5).unwrap();
            assert_eq!(first.confirm(ONE, wrong, 6), Err(NotNow::WrongCode), "{wrong}");
        }
        assert_eq!(first.confirm(ONE, "000042", 6).as_deref(), Ok(&b"correct-horse"[..]));
        assert_eq!(first.confirm(ONE, "000042", 6), Err(NotNow::NoWord), "it counts once");
    }

    /// The owner types the code into another page than the stranger's, whose word stays unconfirmed.
    #[test]
    fn a_code_counts_for_the_visitor_whose_word_it_is_about() {
        let mut first = First::new();
        first.begin(ONE, word("correct-horse"), 42, 0).unwrap();
        assert_eq!(first.begin(OTHER, word("battery"), 43, 1_000), Err(NotNow::Wait(299)));
        assert_eq!(first.confirm(OTHER, "000042", 1_000), Err(NotNow::NoWord));
        first.forget(OTHER);
        assert!(first.confirm(ONE, "000042", 1_000).is_ok());
        first.begin(ONE, word("correct-horse"), 42, 20_000).unwrap();
        first.forget(ONE);
        assert_eq!(first.confirm(ONE, "000042", 20_000), Err(NotNow::NoWord));
    }

    #[test]
    fn a_code_counts_for_five_minutes() {
        let mut first = First::new();
        first.begin(ONE, word("correct-horse"), 42, 0).unwrap();
        assert_eq!(first.confirm(ONE, "000042", 300_000), Err(NotNow::NoWord));
    }

    #[test]
    fn who_guesses_waits_twice_as_long_each_time() {
        let (mut first, mut now) = (First::new(), 0);
        let mut tried = 0_u64;
        for _ in 0..40 {
            while let Err(NotNow::Wait(seconds)) = first.begin(ONE, word("correct-horse"), 42, now) {
                now += u64::from(seconds) * 1_000;
            }
            while first.confirm(ONE, "999999", now) == Err(NotNow::WrongCode) {
                tried += 1;
            }
        }
        assert_eq!(tried, 120);
        assert!(now > 30 * 5_120_000, "a million guesses take years: {now} ms");
    }
}
