//! Record of the password, as text: `pbkdf2-sha256$ROUNDS$SALT$HASH`, the last two in hexadecimal digits.

use core::fmt::{self, Display, Formatter};

use super::derivation::{Derivation, HASH_BYTES};

/// Bytes of a salt.
pub const SALT_BYTES: usize = 16;
/// Longest record, in bytes.
pub const RECORD_BYTES: usize = 128;
/// Rounds of a new record.
pub const ROUNDS: u32 = 10_000;
/// Most rounds of a record: what is kept elsewhere must not stop the board.
const MOST_ROUNDS: u32 = 200_000;
const SCHEME: &str = "pbkdf2-sha256";

/// Record of a password, from which it cannot be told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Record {
    rounds: u32,
    salt: [u8; SALT_BYTES],
    hash: [u8; HASH_BYTES],
}

impl Record {
    pub(super) const fn new(salt: [u8; SALT_BYTES], hash: [u8; HASH_BYTES]) -> Self {
        Self { rounds: ROUNDS, salt, hash }
    }

    /// Reads a record; `None` if the text is none.
    #[must_use]
    pub fn read(text: &[u8]) -> Option<Self> {
        let mut fields = core::str::from_utf8(text).ok()?.trim_ascii().split('$');
        let is_ours = fields.next()? == SCHEME;
        let rounds = fields.next()?.parse().ok()?;
        let record = Self { rounds, salt: hexadecimal(fields.next()?)?, hash: hexadecimal(fields.next()?)? };
        let is_whole = is_ours && (1..=MOST_ROUNDS).contains(&rounds) && fields.next().is_none();
        is_whole.then_some(record)
    }

    /// Begins the hash of a word, to hold it against the record.
    pub(super) fn derive(&self, word: &[u8]) -> Option<Derivation> {
        Derivation::new(word, &self.salt, self.rounds)
    }

    /// Compares a hash, in a time that does not tell where it differs.
    pub(super) fn is_of(&self, hash: &[u8; HASH_BYTES]) -> bool {
        let differs = self.hash.iter().zip(hash).fold(0, |sum, (a, b)| sum | (a ^ b));
        core::hint::black_box(differs) == 0
    }
}

impl Display for Record {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{SCHEME}${}$", self.rounds)?;
        self.salt.iter().try_for_each(|byte| write!(f, "{byte:02x}"))?;
        f.write_str("$")?;
        self.hash.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

fn hexadecimal<const N: usize>(text: &str) -> Option<[u8; N]> {
    let digits = text.as_bytes();
    if digits.len() != 2 * N {
        return None;
    }
    let mut bytes = [0; N];
    for (byte, pair) in bytes.iter_mut().zip(digits.chunks_exact(2)) {
        for digit in pair {
            *byte = *byte << 4 | char::from(*digit).to_digit(16)? as u8;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_read_as_it_is_written() {
        let record = Record::new([0xA5; SALT_BYTES], [0x0F; HASH_BYTES]);
        let text = record.to_string();
        assert!(text.starts_with("pbkdf2-sha256$10000$a5a5") && text.len() <= RECORD_BYTES, "{text}");
        assert_eq!(Record::read(format!("{text}\r\n").as_bytes()), Some(record));
        for broken in
            ["", "$", &text[1..], &text[..text.len() - 1], &text.replace("10000", "0"), &text.replace("0f", "+f")]
        {
            assert_eq!(Record::read(broken.as_bytes()), None, "{broken}");
        }
        assert_eq!(Record::read(text.replace("10000", "999999999").as_bytes()), None);
        assert_eq!(Record::read(&[0xFF; 9]), None);
    }

    #[test]
    fn hashes_are_compared_whole() {
        let record = Record::new([0; SALT_BYTES], [7; HASH_BYTES]);
        let mut other = [7; HASH_BYTES];
        assert!(record.is_of(&other));
        other[31] ^= 1;
        assert!(!record.is_of(&other));
    }
}
