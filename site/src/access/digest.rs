//! Digests of secrets: what is kept of tokens and keys, from which nobody can tell them.

use core::fmt::{self, Display, Formatter};

use heapless::String;
use sha2::{Digest as _, Sha256};

/// Bytes of a secret, out of the chip's generator: 128 bits, which nobody guesses.
pub const SECRET_BYTES: usize = 16;
/// Bytes that are kept of a digest.
const DIGEST_BYTES: usize = 16;

/// Random bytes of a secret.
pub type Random = [u8; SECRET_BYTES];
/// Secret as it is written: 32 hexadecimal digits.
pub type SecretText = String<{ 2 * SECRET_BYTES }>;

/// Writes random bytes as the text of a secret.
#[must_use]
pub fn text_of(random: &Random) -> SecretText {
    let mut text = SecretText::new();
    for nibble in random.iter().flat_map(|byte| [byte >> 4, byte & 15]) {
        // Two digits a byte have room.
        let _ = text.push(char::from_digit(u32::from(nibble), 16).unwrap_or_default());
    }
    text
}

/// Digest of a secret's text: the first half of its SHA-256. Secrets are random, so it needs no salt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest([u8; DIGEST_BYTES]);

impl Digest {
    /// Returns the digest of a text.
    #[must_use]
    pub fn of(text: &str) -> Self {
        let whole: [u8; 32] = Sha256::digest(text.as_bytes()).into();
        let mut digest = [0; DIGEST_BYTES];
        digest.iter_mut().zip(whole).for_each(|(place, byte)| *place = byte);
        Self(digest)
    }

    /// Returns whether two digests are the same, in a time that does not tell where they differ.
    #[must_use]
    pub fn is(&self, other: &Self) -> bool {
        http::is_same(&self.0, &other.0)
    }

    /// Reads a digest as [`Display`] writes it.
    #[must_use]
    pub fn read(text: &str) -> Option<Self> {
        let digits = text.as_bytes();
        let mut digest = [0; DIGEST_BYTES];
        for (place, pair) in digest.iter_mut().zip(digits.chunks_exact(2)) {
            for digit in pair {
                *place = *place << 4 | char::from(*digit).to_digit(16)? as u8;
            }
        }
        (digits.len() == 2 * DIGEST_BYTES).then_some(Self(digest))
    }
}

impl Display for Digest {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_is_that_of_the_standard_and_read_as_it_is_written() {
        let digest = Digest::of("abc");
        assert_eq!(digest.to_string(), "ba7816bf8f01cfea414140de5dae2223", "FIPS 180-4, the first half");
        assert!(Digest::read(&digest.to_string()).is_some_and(|read| read.is(&digest)));
        assert!(!digest.is(&Digest::of("abd")));
        for broken in ["", "ba", "ba7816bf8f01cfea414140de5dae22234", "xa7816bf8f01cfea414140de5dae2223"] {
            assert_eq!(Digest::read(broken), None, "{broken}");
        }
    }

    #[test]
    fn secrets_are_written_in_hexadecimal_digits() {
        assert_eq!(text_of(&[0x0A; 16]).as_str(), "0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a0a");
    }
}
