//! Keys of programs: named, revocable, each with a role of its own. A key is shown once; its digest is kept,
//! on the card as well, a line for each: `ROLE DIGEST NAME`.

use core::fmt::Write as _;

use base::ports::{KEYS_RECORD_BYTES, KeysRecord};
use heapless::{String, Vec};
use http::Role;

use super::digest::Digest;
use crate::role_names;

/// Keys at a time.
pub const KEYS: usize = 8;
/// Longest name of a key, bytes.
pub const NAME_BYTES: usize = 24;

// 8 bytes of a role, 32 of a digest, the name, two blanks and a line feed for each.
const _: () = assert!(KEYS_RECORD_BYTES >= KEYS * (8 + 32 + NAME_BYTES + 3), "all keys fit into their record");

/// A program's key, as a digest.
#[derive(Clone, Debug)]
pub struct Key {
    number: u32,
    digest: Digest,
    /// Name of the program that has it.
    pub name: String<NAME_BYTES>,
    /// Role that it gives.
    pub role: Role,
}

/// Reason why a key cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoKey {
    /// The name is empty, too long, or has other signs than ASCII has.
    Name,
    /// Another key has the name.
    Taken,
    /// There are as many as can be.
    Full,
}

/// Keys of all programs.
#[derive(Debug)]
pub struct Keys {
    keys: Vec<Key, KEYS>,
    /// Number of the key that was added last.
    last: u32,
}

impl Keys {
    /// Begins without any key.
    #[must_use]
    pub const fn new() -> Self {
        Self { keys: Vec::new(), last: 0 }
    }

    /// Returns the keys of all programs.
    pub fn iter(&self) -> impl Iterator<Item = &Key> {
        self.keys.iter()
    }

    /// Returns the number of a key, by its text.
    #[must_use]
    pub fn find(&self, text: &str) -> Option<u32> {
        let digest = Digest::of(text);
        self.keys.iter().find(|key| key.digest.is(&digest)).map(|key| key.number)
    }

    /// Returns the key of a number, if it has not been revoked.
    #[must_use]
    pub fn get(&self, number: u32) -> Option<&Key> {
        self.keys.iter().find(|key| key.number == number)
    }

    /// Adds a key. `text` is what programs send.
    ///
    /// # Errors
    /// The reason why there is none.
    pub fn add(&mut self, name: &str, role: Role, text: &str) -> Result<(), NoKey> {
        self.push(name, role, Digest::of(text))
    }

    fn push(&mut self, name: &str, role: Role, digest: Digest) -> Result<(), NoKey> {
        let is_plain = !name.is_empty() && name == name.trim() && name.bytes().all(|byte| (0x20..0x7F).contains(&byte));
        let name = String::try_from(name).ok().filter(|_| is_plain).ok_or(NoKey::Name)?;
        if self.keys.iter().any(|key| key.name == name) {
            return Err(NoKey::Taken);
        }
        self.last = self.last.wrapping_add(1);
        self.keys.push(Key { number: self.last, digest, name, role }).map_err(|_| NoKey::Full)
    }

    /// Revokes the key of this name. False if there is none.
    pub fn revoke(&mut self, name: &str) -> bool {
        let count = self.keys.len();
        self.keys.retain(|key| key.name != name);
        self.keys.len() < count
    }

    /// Returns the record of all keys.
    #[must_use]
    pub fn record(&self) -> KeysRecord {
        let mut record = KeysRecord::new();
        for Key { digest, name, role, .. } in &self.keys {
            // A line of each has room.
            let _ = writeln!(record, "{} {digest} {name}", role_names::name(*role));
        }
        record
    }

    /// Takes the keys of a record, in place of all others. Lines that are none are passed over: who has such
    /// a key is not let in.
    pub fn read(&mut self, record: &[u8]) {
        self.keys.clear();
        for line in core::str::from_utf8(record).unwrap_or_default().lines() {
            let mut fields = line.splitn(3, ' ');
            let role = fields.next().and_then(role_names::of_key);
            let digest = fields.next().and_then(Digest::read);
            if let (Some(role), Some(digest), Some(name)) = (role, digest, fields.next()) {
                // A key too many, or another of the same name, counts for nothing.
                let _ = self.push(name, role, digest);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_gives_its_role_until_it_is_revoked() {
        let mut keys = Keys::new();
        assert_eq!(keys.add("slicer", Role::Operate, "secret"), Ok(()));
        assert_eq!(keys.add("farm view", Role::Watch, "other"), Ok(()));
        let number = keys.find("secret").unwrap();
        assert_eq!(keys.get(number).map(|key| key.role), Some(Role::Operate));
        assert!(keys.find("Secret").is_none() && keys.find("").is_none());
        assert!(keys.revoke("slicer") && !keys.revoke("slicer"));
        assert!(keys.get(number).is_none() && keys.find("secret").is_none() && keys.find("other").is_some());
    }

    #[test]
    fn names_are_plain_and_given_once_and_keys_are_counted() {
        let mut keys = Keys::new();
        for name in ["", " a", "a ", "a\nb", "na\u{EF}ve", "a name of 25 letters, yes."] {
            assert_eq!(keys.add(name, Role::Watch, "x"), Err(NoKey::Name), "{name}");
        }
        for number in 0..KEYS {
            assert_eq!(keys.add(&format!("key {number}"), Role::Watch, "x"), Ok(()));
        }
        assert_eq!(keys.add("key 3", Role::Watch, "x"), Err(NoKey::Taken));
        assert_eq!(keys.add("more", Role::Watch, "x"), Err(NoKey::Full));
    }

    #[test]
    fn a_record_is_read_as_it_is_written_and_tells_no_key() {
        let mut keys = Keys::new();
        for number in 0..KEYS {
            let name = format!("{number}{}", "w".repeat(NAME_BYTES - 1));
            keys.add(&name, Role::Operate, &format!("secret {number}")).unwrap();
        }
        let record = keys.record();
        assert!(!String::<1_000>::try_from(core::str::from_utf8(&record).unwrap()).unwrap().contains("secret"));
        let mut read = Keys::new();
        read.read(&record);
        assert!((0..KEYS).all(|number| read.find(&format!("secret {number}")).is_some()));
        assert_eq!(read.record(), record);
        read.read(b"Own 00 x\nNobody ba7816bf8f01cfea414140de5dae2223 y\nrubbish\n\xFF");
        assert_eq!(read.iter().count(), 0);
    }
}
