//! Sealing of a linked image: its length and digest go into its manifest, a signature if there is a key, and
//! for the card the trailer of Smoothieware v2 behind it. All of it repeats exactly.

use crate::flash::Layout;
use crate::manifest::{BOARD_MAGIC, DIGEST, Flaw, HASHED, LENGTH, MANIFEST_BYTES, Manifest, SIGNATURE, put};
use crate::policy::signed;
use crate::verify::TRAILER;
use ed25519_dalek::{Signer, SigningKey};
use md5::{Digest as _, Md5};
use sha2::Sha256;

/// Seals an image, whether or not it was sealed before: whole flash words with a manifest in front. `key` is
/// the secret half of an Ed25519 key.
///
/// # Errors
/// The image has no manifest of this layout, or a length that no image has.
pub fn seal(image: &mut [u8], layout: &Layout, key: Option<&[u8; 32]>) -> Result<Manifest, Flaw> {
    let length = u32::try_from(image.len()).map_err(|_| Flaw::Length(u32::MAX))?;
    let (manifest, rest) = image.split_first_chunk_mut::<MANIFEST_BYTES>().ok_or(Flaw::NoManifest)?;
    put(manifest, LENGTH, &length.to_le_bytes());
    let digest: [u8; 32] = Sha256::new().chain_update(&manifest[..HASHED]).chain_update(rest).finalize().into();
    put(manifest, DIGEST, &digest);
    let signature = key.map_or([0; 64], |key| SigningKey::from_bytes(key).sign(&signed(&digest)).to_bytes());
    put(manifest, SIGNATURE, &signature);
    Manifest::parse(manifest, layout)
}

/// Signs the image in a file, alone or behind a boot stage, with the trailer of Smoothieware v2 or without;
/// the trailer is made anew.
///
/// # Errors
/// The file has no image of this layout, or is not whole; it may have been changed then.
pub fn sign_file(file: &mut [u8], layout: &Layout, key: &[u8; 32]) -> Result<Manifest, Flaw> {
    let at = [0, layout.image() as usize].into_iter().find(|at| {
        file.get(*at..).and_then(|rest| rest.first_chunk()).is_some_and(|head| Manifest::parse(head, layout).is_ok())
    });
    let at = at.ok_or_else(|| {
        let head = file.first_chunk().map(|head| Manifest::parse(head, layout));
        head.and_then(Result::err).unwrap_or(Flaw::NoManifest)
    })?;
    let head = file.get(at..).and_then(|rest| rest.first_chunk()).ok_or(Flaw::NoManifest)?;
    let length = Manifest::parse(head, layout)?.length as usize;
    let (is, says) = (file.len() as u32, (at + length) as u32);
    let image = file.get_mut(at..at + length).ok_or(Flaw::Truncated { is, says })?;
    let before = Manifest::parse(image.first_chunk().ok_or(Flaw::NoManifest)?, layout)?;
    let manifest = seal(image, layout, Some(key))?;
    if manifest.digest != before.digest {
        // A signature vouches for the sealed image, so an image that a bad copy has changed is not signed.
        return Err(Flaw::Digest);
    }
    let (whole, rest) = file.split_at_mut(at + length);
    match rest.len() {
        0 => {}
        length if length == TRAILER as usize => rest.copy_from_slice(&trailer(whole)),
        _ => return Err(Flaw::Trailer),
    }
    Ok(manifest)
}

/// The public half of an Ed25519 key.
#[must_use]
pub fn public_key(secret: &[u8; 32]) -> [u8; 32] {
    SigningKey::from_bytes(secret).verifying_key().to_bytes()
}

/// Returns the trailer that Smoothieware v2 wants behind an image in a file: board magic, and the MD5 of all
/// before it in hexadecimal digits.
#[must_use]
pub fn trailer(image: &[u8]) -> [u8; TRAILER as usize] {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let mut trailer = [0; TRAILER as usize];
    let (magic, digits) = trailer.split_at_mut(8);
    magic.copy_from_slice(&BOARD_MAGIC.to_le_bytes());
    let sum = Md5::new().chain_update(image).chain_update(&*magic).finalize();
    for (pair, byte) in digits.chunks_exact_mut(2).zip(sum) {
        pair.copy_from_slice(&[DIGITS[usize::from(byte >> 4)], DIGITS[usize::from(byte & 15)]]);
    }
    trailer
}
