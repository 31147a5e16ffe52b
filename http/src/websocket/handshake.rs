//! Answer to the key of a handshake (RFC 6455, section 4.2.2).

use sha1::{Digest as _, Sha1};

/// Text that only a server of WebSockets knows to add.
const GUID: &[u8] = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
/// Letters of the answer.
pub const ACCEPT_BYTES: usize = 28;
/// Letters of base 64.
const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Returns the answer to a key. None if it is not the base 64 of 16 bytes.
#[must_use]
pub fn accept(key: &str) -> Option<[u8; ACCEPT_BYTES]> {
    let key = key.as_bytes();
    let digits = key.strip_suffix(b"==")?;
    let last = digits.last().and_then(|letter| value(*letter))?;
    if digits.len() != 22 || !digits.iter().all(|letter| value(*letter).is_some()) || last & 15 != 0 {
        return None;
    }
    let mut hash = Sha1::new();
    hash.update(key);
    hash.update(GUID);
    let digest: [u8; 20] = hash.finalize().into();
    let mut answer = [b'='; ACCEPT_BYTES];
    for (four, three) in answer.chunks_mut(4).zip(digest.chunks(3)) {
        let byte = |at: usize| u32::from(three.get(at).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        // Bytes that are not there leave the sign that stands for them.
        for (place, shift) in four.iter_mut().zip([18, 12, 6, 0]).take(three.len() + 1) {
            *place = LETTERS.get((bits >> shift & 63) as usize).copied().unwrap_or(b'=');
        }
    }
    Some(answer)
}

fn value(letter: u8) -> Option<usize> {
    LETTERS.iter().position(|known| *known == letter)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_is_the_one_of_the_rfc() {
        assert_eq!(accept("dGhlIHNhbXBsZSBub25jZQ==").as_ref(), Some(b"s3pPLMBiTxaQ9kYGzzhZRbK+xOo="));
    }

    #[test]
    fn other_keys_are_refused() {
        for key in [
            "",
            "==",
            "dGhlIHNhbXBsZSBub25jZQ=",
            "dGhlIHNhbXBsZSBub25jZ===",
            "dGhlIHNhbXBsZSBub25jZR==",
            "dGhlIHNhbXBsZSBub25jZQAA",
            "dGhlIHNhbXBsZSBub25jZQA==",
            "dGhlIHNhbXBsZSBub25j*Q==",
        ] {
            assert_eq!(accept(key), None, "{key}");
        }
    }
}
