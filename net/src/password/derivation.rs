//! PBKDF2-HMAC-SHA256 (RFC 8018 section 5.2) in slices: a hash is meant to take long, and no turn may.

use hmac::{Hmac, Mac};
use sha2::Sha256;

/// Longest password, in bytes: the block of SHA-256, beyond which HMAC hashes its key first.
pub const WORD_BYTES: usize = 64;
/// Bytes of a hash.
pub const HASH_BYTES: usize = 32;

/// A hash on its way.
#[derive(Clone)]
pub struct Derivation {
    keyed: Hmac<Sha256>,
    block: [u8; HASH_BYTES],
    sum: [u8; HASH_BYTES],
    left: u32,
}

impl Derivation {
    /// Begins the hash of a password, which has so many rounds; `None` if there is none.
    pub fn new(word: &[u8], salt: &[u8], rounds: u32) -> Option<Self> {
        let keyed = Hmac::<Sha256>::new_from_slice(word).ok()?;
        let left = rounds.checked_sub(1)?;
        let mut first = keyed.clone();
        first.update(salt);
        first.update(&1_u32.to_be_bytes());
        let block: [u8; HASH_BYTES] = first.finalize().into_bytes().into();
        Some(Self { keyed, block, sum: block, left })
    }

    /// Does at most so many rounds. Returns the hash when all are done.
    pub fn advance(&mut self, rounds: u32) -> Option<[u8; HASH_BYTES]> {
        for _ in 0..rounds.min(self.left) {
            let mut next = self.keyed.clone();
            next.update(&self.block);
            self.block = next.finalize().into_bytes().into();
            for (sum, byte) in self.sum.iter_mut().zip(self.block) {
                *sum ^= byte;
            }
            self.left -= 1;
        }
        (self.left == 0).then_some(self.sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hash(word: &str, salt: &str, rounds: u32, slice: u32) -> String {
        let mut derivation = Derivation::new(word.as_bytes(), salt.as_bytes(), rounds).unwrap();
        loop {
            if let Some(hash) = derivation.advance(slice) {
                return hash.iter().map(|byte| format!("{byte:02x}")).collect();
            }
        }
    }

    /// The vectors of RFC 6070's inputs for SHA-256, and those of RFC 7914 section 11.
    #[test]
    fn hashes_are_those_of_the_standard() {
        let expected = [
            (1, "120fb6cffcf8b32c43e7225256c4f837a86548c92ccc35480805987cb70be17b"),
            (2, "ae4d0c95af6b46d32d0adff928f06dd02a303f8ef3c251dfd6e2d85a95474c43"),
            (4096, "c5e478d59288c841aa530db6845c4c8d962893a001ce4e11a4963873aa98134a"),
        ];
        for (rounds, hex) in expected {
            assert_eq!(hash("password", "salt", rounds, 200), hex);
        }
        assert!(hash("passwd", "salt", 1, 1).starts_with("55ac046e56e3089fec1691c22544b605"));
    }

    #[test]
    fn slices_do_not_change_a_hash() {
        assert_eq!(hash("a", "b", 1_000, 1), hash("a", "b", 1_000, 999));
        assert!(Derivation::new(b"a", b"b", 0).is_none());
    }
}
