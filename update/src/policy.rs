//! Policy of the board's owner, from `[update]` of the configuration: the images that may run on the board.

use crate::manifest::{Flaw, Manifest};
use ed25519_dalek::{Signature, VerifyingKey};

/// Prefix of the signed bytes, before the digest: no other use of the same key can be taken for firmware.
const PURPOSE: [u8; 15] = *b"velvet firmware";

/// The owner's policy. Without a key every image whose hash is right may run. With one, a signature by
/// another key is refused, and an image without any is a development image: it may run unless the board is
/// locked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Policy {
    /// The owner's Ed25519 public key.
    pub key: Option<[u8; 32]>,
    /// Whether only images signed with this key may run.
    pub is_locked: bool,
}

impl Policy {
    /// Whether an image may run.
    ///
    /// # Errors
    /// [`Flaw::Unsigned`] and [`Flaw::Signature`].
    pub fn allows(&self, manifest: &Manifest) -> Result<(), Flaw> {
        match (&self.key, &manifest.signature) {
            (None, _) => Ok(()),
            (Some(_), None) if self.is_locked => Err(Flaw::Unsigned),
            (Some(_), None) => Ok(()),
            (Some(key), Some(signature)) => verify(key, signature, &manifest.digest),
        }
    }

    /// Whether these 32 bytes are a public key.
    #[must_use]
    pub fn is_key(key: &[u8; 32]) -> bool {
        VerifyingKey::from_bytes(key).is_ok_and(|key| !key.is_weak())
    }
}

/// The bytes that a signature covers.
#[must_use]
pub fn signed(digest: &[u8; 32]) -> [u8; 47] {
    let mut bytes = [0; 47];
    let (purpose, rest) = bytes.split_at_mut(PURPOSE.len());
    purpose.copy_from_slice(&PURPOSE);
    rest.copy_from_slice(digest);
    bytes
}

fn verify(key: &[u8; 32], signature: &[u8; 64], digest: &[u8; 32]) -> Result<(), Flaw> {
    let key = VerifyingKey::from_bytes(key).map_err(|_| Flaw::Signature)?;
    key.verify_strict(&signed(digest), &Signature::from_bytes(signature)).map_err(|_| Flaw::Signature)
}
