//! Access: who may what. A visitor has a role by a session, a key, or by what the configuration gives to all.
//!
//! Passwords are verified outside, by the board's gate, which the consoles of the network pass as well: this
//! hands out the word of one visitor at a time and hears the verdict.

mod answers;
mod digest;
mod first;
mod keys;
mod sessions;

use base::ports::KeysRecord;
use heapless::{Deque, String, Vec};
use http::Role;

use crate::calls::Id;
pub use crate::console::Asker;
pub use answers::{COOKIE, Told};
pub use digest::{Random, text_of};
pub use first::{CODE_S, First, NotNow};
pub use keys::{Keys, NAME_BYTES, NoKey};
pub use sessions::{SESSION_S, Sessions};

/// Longest password, bytes; shortest and longest that may be set.
pub const WORD_BYTES: usize = 64;
const LENGTHS: core::ops::RangeInclusive<usize> = 8..=63;
/// Logins that wait for their verdict, which takes a second each.
const ATTEMPTS: usize = 3;

/// Word that is given for the password, or is to be the password.
pub type Word = Vec<u8, WORD_BYTES>;

/// Proof by which a visitor has a role. It is looked at whenever the role counts: who has it loses the role
/// in the same moment in which the session ends or the key is revoked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pass {
    /// None: what the configuration gives to everybody.
    #[default]
    None,
    /// A key that is none, or none any more.
    WrongKey,
    /// Session, by its number.
    Session(u32),
    /// Key of a program, by its number.
    Key(u32),
    /// Login of one WebSocket, by the number of the password.
    Socket(u32),
}

/// Place that an answer goes to.
#[derive(Clone, Debug)]
pub enum Target {
    /// Nobody: the visitor has gone.
    Nobody,
    /// Request of this connection.
    Request(u8),
    /// Call of a WebSocket, with its id.
    Call(Asker, Option<Id>),
}

/// Visitor with the proof and the place that an answer goes to.
#[derive(Clone, Debug)]
pub struct Visitor {
    /// Place that the answer goes to.
    pub target: Target,
    /// Proof of the visitor.
    pub pass: Pass,
    /// Address of the visitor.
    pub from: [u8; 4],
}

/// Login that waits for its verdict.
#[derive(Debug)]
struct Attempt {
    visitor: Visitor,
    word: Word,
}

/// Verdict on a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The word is the password.
    Right,
    /// The word is not the password.
    Wrong,
    /// There is no password.
    NoPassword,
    /// Too many wrong words came: seconds to wait.
    Wait(u32),
}

/// Change that is being kept on the card.
#[derive(Debug)]
pub enum Keeping {
    /// A new password is kept.
    Password,
    /// New key, which is told when it is kept.
    NewKey(Random, String<NAME_BYTES>),
    /// The list without a revoked key is kept.
    Revoked,
}

/// State of access: sessions, keys, words that wait for their verdict.
#[derive(Debug)]
pub struct Access {
    /// Role of who shows nothing.
    without: Role,
    /// Whether the board has a password.
    pub has_password: bool,
    /// Number of the password: changed whenever the password is.
    password: u32,
    pub sessions: Sessions,
    pub keys: Keys,
    pub first: First,
    attempts: Deque<Attempt, ATTEMPTS>,
    /// Whether the first attempt is with the gate.
    is_proving: bool,
    /// Random bytes in stock.
    random: Vec<Random, 2>,
    /// Change that is being kept, and who is told of its outcome.
    keeping: Option<(Keeping, Target)>,
    /// Requests to the board: a code to be shown, a password to be made, keys to be kept.
    code: Option<(u32, [u8; 4])>,
    word: Option<Word>,
    are_keys_due: bool,
}

impl Access {
    /// Begins without password and keys. `without` is the role of who shows nothing.
    #[must_use]
    pub const fn new(without: Role) -> Self {
        Self {
            without,
            has_password: false,
            password: 0,
            sessions: Sessions::new(),
            keys: Keys::new(),
            first: First::new(),
            attempts: Deque::new(),
            is_proving: false,
            random: Vec::new(),
            keeping: None,
            code: None,
            word: None,
            are_keys_due: false,
        }
    }

    /// Returns the role that a proof gives now.
    #[must_use]
    pub fn role(&self, pass: Pass) -> Role {
        let owns = |is_in_force| if is_in_force { Role::Own } else { self.without };
        match pass {
            Pass::None => self.without,
            Pass::WrongKey => Role::Nobody,
            Pass::Session(number) => owns(self.sessions.has(number)),
            Pass::Key(number) => self.keys.get(number).map_or(Role::Nobody, |key| key.role),
            Pass::Socket(password) => owns(password == self.password),
        }
    }

    /// Returns whether a proof is no longer one.
    #[must_use]
    pub fn has_ended(&self, pass: Pass) -> bool {
        match pass {
            Pass::None | Pass::WrongKey => false,
            Pass::Session(number) => !self.sessions.has(number),
            Pass::Key(number) => self.keys.get(number).is_none(),
            Pass::Socket(password) => password != self.password,
        }
    }

    /// Returns the role of who shows nothing.
    #[must_use]
    pub const fn without(&self) -> Role {
        self.without
    }

    /// Returns the proof of who shows a key, or else the token of a cookie.
    #[must_use]
    pub fn pass(&self, key: Option<&str>, token: Option<&str>) -> Pass {
        match (key, token) {
            (Some(key), _) => self.keys.find(key).map_or(Pass::WrongKey, Pass::Key),
            (None, Some(token)) => self.sessions.find(token).map_or(Pass::None, Pass::Session),
            (None, None) => Pass::None,
        }
    }

    /// Returns the proof of a WebSocket that has logged in.
    #[must_use]
    pub const fn socket_pass(&self) -> Pass {
        Pass::Socket(self.password)
    }

    /// The password is another one: all logins end.
    pub fn change_password(&mut self) {
        self.password = self.password.wrapping_add(1);
        self.sessions.end_all();
    }

    /// Returns whether random bytes are wanted.
    #[must_use]
    pub fn wants_random(&self) -> bool {
        !self.random.is_full()
    }

    /// Takes random bytes, each of which is used once.
    pub fn add_random(&mut self, random: Random) {
        // A stock that is full needs none.
        let _ = self.random.push(random);
    }

    /// Takes random bytes out of the stock.
    pub fn take_random(&mut self) -> Option<Random> {
        self.random.pop()
    }

    /// Queues a login. False if too many wait.
    pub fn queue(&mut self, visitor: Visitor, word: &str) -> bool {
        // A word that is too long is none, and counts as a wrong one.
        let word = Word::from_slice(word.as_bytes()).unwrap_or_default();
        self.attempts.push_back(Attempt { visitor, word }).is_ok()
    }

    /// Takes the next word to be verified, with the address of its visitor.
    pub fn take_word(&mut self) -> Option<([u8; 4], Word)> {
        if self.is_proving {
            return None;
        }
        let attempt = self.attempts.front_mut()?;
        self.is_proving = true;
        Some((attempt.visitor.from, core::mem::take(&mut attempt.word)))
    }

    /// Takes the visitor whose word was verified.
    pub fn take_verified(&mut self) -> Option<Visitor> {
        core::mem::take(&mut self.is_proving).then(|| self.attempts.pop_front().map(|attempt| attempt.visitor))?
    }

    /// Forgets what a visitor has asked for, who has gone.
    pub fn forget(&mut self, gone: impl Fn(&Target) -> bool) {
        let attempts = self.attempts.iter_mut().map(|attempt| &mut attempt.visitor.target);
        for target in attempts.chain(self.keeping.as_mut().map(|(_, target)| target)) {
            if gone(target) {
                *target = Target::Nobody;
            }
        }
    }

    /// Returns whether a change is being kept: there is no other one meanwhile.
    #[must_use]
    pub const fn is_keeping(&self) -> bool {
        self.keeping.is_some()
    }

    /// Asks the board to show a code to who stands at it; `from` has asked for it.
    pub const fn show_code(&mut self, code: u32, from: [u8; 4]) {
        self.code = Some((code, from));
    }

    /// Asks the board to make a word the password.
    pub fn keep_password(&mut self, word: Word, target: Target) {
        (self.word, self.keeping) = (Some(word), Some((Keeping::Password, target)));
    }

    /// Asks the board to keep all keys.
    pub fn keep_keys(&mut self, keeping: Keeping, target: Target) {
        (self.are_keys_due, self.keeping) = (true, Some((keeping, target)));
    }

    /// Takes the outcome of keeping a change.
    pub const fn take_kept(&mut self) -> Option<(Keeping, Target)> {
        self.keeping.take()
    }

    /// Takes the code that the board is to show.
    pub const fn take_code(&mut self) -> Option<(u32, [u8; 4])> {
        self.code.take()
    }

    /// Takes the word that is to be the password.
    pub const fn take_password(&mut self) -> Option<Word> {
        self.word.take()
    }

    /// Returns whether the keys are to be kept.
    #[must_use]
    pub const fn has_keys_to_keep(&self) -> bool {
        self.are_keys_due
    }

    /// Takes the record of all keys, if it is to be kept.
    pub fn take_keys(&mut self) -> Option<KeysRecord> {
        core::mem::take(&mut self.are_keys_due).then(|| self.keys.record())
    }
}

/// Returns whether a word may be a password: as the machine's command has it.
#[must_use]
pub fn is_fit(word: &str) -> bool {
    LENGTHS.contains(&word.len()) && word.bytes().all(|byte| (0x20..0x7F).contains(&byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_role_ends_with_its_proof() {
        let mut access = Access::new(Role::Watch);
        access.sessions.begin("token", 0);
        access.keys.add("slicer", Role::Operate, "key").unwrap();
        let (session, key, socket) =
            (access.pass(None, Some("token")), access.pass(Some("key"), Some("token")), access.socket_pass());
        let roles = [session, key, socket, Pass::None].map(|pass| access.role(pass));
        assert_eq!(roles, [Role::Own, Role::Operate, Role::Own, Role::Watch]);
        access.change_password();
        let roles = [session, key, socket, Pass::None].map(|pass| access.role(pass));
        assert_eq!(roles, [Role::Watch, Role::Operate, Role::Watch, Role::Watch], "keys stay");
        assert!([session, socket].iter().all(|pass| access.has_ended(*pass)));
        access.keys.revoke("slicer");
        assert_eq!((access.role(key), access.has_ended(key)), (Role::Nobody, true));
        assert_eq!(access.role(access.pass(Some("guess"), Some("token"))), Role::Nobody, "less than without any");
    }

    #[test]
    fn words_are_verified_one_at_a_time_and_who_has_gone_is_nobody() {
        let mut access = Access::new(Role::Nobody);
        let visitor = |place| Visitor { target: Target::Request(place), pass: Pass::None, from: [10, 0, 0, place] };
        assert!(access.queue(visitor(1), "one") && access.queue(visitor(2), "two") && access.queue(visitor(3), "x"));
        assert!(!access.queue(visitor(4), "four"));
        assert_eq!(
            access.take_word().map(|(from, word)| (from, word.to_vec())),
            Some(([10, 0, 0, 1], b"one".to_vec()))
        );
        assert!(access.take_word().is_none());
        access.forget(|target| matches!(target, Target::Request(1)));
        assert!(matches!(access.take_verified(), Some(Visitor { target: Target::Nobody, .. })));
        assert!(access.take_verified().is_none(), "its verdict was taken");
        assert!(access.take_word().is_some_and(|(_, word)| word == b"two"));
    }

    #[test]
    fn passwords_are_of_eight_plain_letters_or_more() {
        assert!(is_fit("correct-horse") && is_fit("a b c d e") && is_fit(&"x".repeat(63)));
        assert!(!is_fit("short") && !is_fit(&"x".repeat(64)) && !is_fit("naive\u{E9}naive") && !is_fit("tab\tabcdef"));
    }
}
