//! Whether an image is what its manifest says, in a file and in flash.

use crate::flash::{Flash, Layout, WORD};
use crate::manifest::{BOARD_MAGIC, Flaw, HASHED, MANIFEST_BYTES, Manifest};
use crate::policy::Policy;
use md5::Md5;
use sha2::{Digest, Sha256};

/// Bytes that are read at a time: a block of the card.
const CHUNK: usize = 512;

/// Bytes of the trailer of Smoothieware v2: board magic, then MD5 in hexadecimal digits of everything before
/// them.
const TRAILER: u32 = 40;

/// Something with bytes at places: a file, or an image in flash.
pub trait Bytes {
    /// How many there are.
    fn length(&self) -> u32;

    /// Fills `into` from a place on.
    ///
    /// # Errors
    /// [`Flaw::Unreadable`], also where there are not so many.
    fn read(&mut self, at: u32, into: &mut [u8]) -> Result<(), Flaw>;
}

/// The bytes of the flash from the image's beginning on.
pub struct Image<'a, F> {
    flash: &'a mut F,
    layout: &'a Layout,
}

impl<'a, F: Flash> Image<'a, F> {
    /// Of the image in this flash.
    pub fn new(flash: &'a mut F, layout: &'a Layout) -> Self {
        Self { flash, layout }
    }
}

impl<F: Flash> Bytes for Image<'_, F> {
    fn length(&self) -> u32 {
        self.layout.image_bytes()
    }

    fn read(&mut self, at: u32, into: &mut [u8]) -> Result<(), Flaw> {
        let mut place = at;
        let mut rest = into;
        while !rest.is_empty() {
            let within = place as usize % WORD;
            if place >= self.layout.image_bytes() {
                return Err(Flaw::Unreadable);
            }
            let start = self.layout.image() + place - within as u32;
            let word = self.flash.read(start).map_err(|_| Flaw::Unreadable)?;
            let bytes = word.get(within..).unwrap_or_default();
            let (now, later) = rest.split_at_mut(bytes.len().min(rest.len()));
            now.copy_from_slice(&bytes[..now.len()]);
            place += now.len() as u32;
            rest = later;
        }
        Ok(())
    }
}

/// The image in flash, if it may run.
///
/// # Errors
/// Why it may not.
pub fn check_flash<F: Flash>(flash: &mut F, layout: &Layout, policy: &Policy) -> Result<Manifest, Flaw> {
    let mut image = Image::new(flash, layout);
    let manifest = read_manifest(&mut image, layout)?;
    let (digest, _) = hash(&mut image, manifest.length)?;
    judge(&manifest, &digest, policy)
}

/// The image in a file, if it may be installed: as `make firmware` makes it, or with the trailer of
/// Smoothieware v2 behind it.
///
/// # Errors
/// Why it may not.
pub fn check_file(file: &mut impl Bytes, layout: &Layout, policy: &Policy) -> Result<Manifest, Flaw> {
    let manifest = read_manifest(file, layout)?;
    let is = file.length();
    let says = manifest.length;
    if is < says {
        return Err(Flaw::Truncated { is, says });
    }
    let (digest, md5) = hash(file, says)?;
    match is - says {
        0 => {}
        TRAILER => check_trailer(file, says, md5)?,
        _ => return Err(Flaw::Trailer),
    }
    judge(&manifest, &digest, policy)
}

fn judge(manifest: &Manifest, digest: &[u8; 32], policy: &Policy) -> Result<Manifest, Flaw> {
    if manifest.digest != *digest {
        return Err(Flaw::Digest);
    }
    policy.allows(manifest)?;
    Ok(*manifest)
}

fn read_manifest(bytes: &mut impl Bytes, layout: &Layout) -> Result<Manifest, Flaw> {
    let mut manifest = [0; MANIFEST_BYTES];
    if bytes.length() < MANIFEST_BYTES as u32 {
        return Err(Flaw::NoManifest);
    }
    bytes.read(0, &mut manifest)?;
    Manifest::parse(&manifest, layout)
}

/// The digest of an image, and the MD5 of all its bytes as far as it has got.
fn hash(bytes: &mut impl Bytes, length: u32) -> Result<([u8; 32], Md5), Flaw> {
    let mut sha = Sha256::new();
    let mut md5 = Md5::new();
    let mut chunk = [0; CHUNK];
    let mut at = 0;
    while at < length {
        let chunk = chunk.get_mut(..(length - at).min(CHUNK as u32) as usize).unwrap_or_default();
        bytes.read(at, chunk)?;
        md5.update(&*chunk);
        if at == 0 {
            sha.update(chunk.get(..HASHED).unwrap_or_default());
            sha.update(chunk.get(MANIFEST_BYTES..).unwrap_or_default());
        } else {
            sha.update(&*chunk);
        }
        at += chunk.len() as u32;
    }
    Ok((sha.finalize().into(), md5))
}

fn check_trailer(file: &mut impl Bytes, at: u32, mut md5: Md5) -> Result<(), Flaw> {
    let mut trailer = [0; TRAILER as usize];
    file.read(at, &mut trailer)?;
    let (magic, digits) = trailer.split_at(8);
    if magic != BOARD_MAGIC.to_le_bytes() {
        return Err(Flaw::OtherBoard);
    }
    md5.update(magic);
    let sum: [u8; 16] = md5.finalize().into();
    let matches = sum.iter().zip(digits.chunks_exact(2)).all(|(byte, digits)| hexadecimal(digits) == Some(*byte));
    if matches { Ok(()) } else { Err(Flaw::Md5) }
}

fn hexadecimal(digits: &[u8]) -> Option<u8> {
    u8::from_str_radix(core::str::from_utf8(digits).ok()?, 16).ok()
}
