//! Whether an image is what its manifest says, in a file and in flash.

use crate::flash::{Flash, Layout};
use crate::manifest::{BOARD_MAGIC, Flaw, HASHED, MANIFEST_BYTES, Manifest};
use crate::policy::Policy;
use md5::Md5;
use sha2::{Digest, Sha256};

/// Bytes that are read at a time: a block of the card.
const CHUNK: usize = 512;

/// Bytes of the trailer of Smoothieware v2: board magic, then MD5 in hexadecimal digits of everything before
/// them.
pub(crate) const TRAILER: u32 = 40;

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
        if u64::from(at) + into.len() as u64 > u64::from(self.layout.image_bytes()) {
            return Err(Flaw::Unreadable);
        }
        self.flash.read_into(self.layout.image() + at, into).map_err(|_| Flaw::Unreadable)
    }
}

/// The image in flash, if it may run.
///
/// # Errors
/// Why it may not.
pub fn check_flash<F: Flash>(flash: &mut F, layout: &Layout, policy: &Policy) -> Result<Manifest, Flaw> {
    let mut image = Image::new(flash, layout);
    let manifest = read_manifest(&mut image, 0, layout)?;
    let digest = hash(&mut image, 0, manifest.length, |_| {})?;
    judge(&manifest, &digest, policy)
}

/// The image in a file, if it may be installed: alone or behind a boot stage, as `make firmware` makes them;
/// with the trailer of Smoothieware v2 behind it, or without.
///
/// # Errors
/// Why it may not.
pub fn check_file(file: &mut impl Bytes, layout: &Layout, policy: &Policy) -> Result<Manifest, Flaw> {
    let (at, manifest) = locate(file, layout)?;
    let is = file.length();
    let says = at.saturating_add(manifest.length);
    if is < says {
        return Err(Flaw::Truncated { is, says });
    }
    let mut md5 = Md5::new();
    each_chunk(file, 0, at, |chunk| md5.update(chunk))?;
    let digest = hash(file, at, manifest.length, |chunk| md5.update(chunk))?;
    match is - says {
        0 => {}
        TRAILER => check_trailer(file, says, md5)?,
        _ => return Err(Flaw::Trailer),
    }
    judge(&manifest, &digest, policy)
}

/// Where in a file the image begins, and its manifest. A file for the whole flash has a boot stage first,
/// which is passed over: the one that runs is never replaced by what it installs.
pub(crate) fn locate(file: &mut impl Bytes, layout: &Layout) -> Result<(u32, Manifest), Flaw> {
    match read_manifest(file, 0, layout) {
        Err(Flaw::FromTheBeginning) => match read_manifest(file, layout.image(), layout) {
            Err(Flaw::NoManifest) => Err(Flaw::FromTheBeginning),
            found => found.map(|manifest| (layout.image(), manifest)),
        },
        found => found.map(|manifest| (0, manifest)),
    }
}

fn judge(manifest: &Manifest, digest: &[u8; 32], policy: &Policy) -> Result<Manifest, Flaw> {
    if manifest.digest != *digest {
        return Err(Flaw::Digest);
    }
    policy.allows(manifest)?;
    Ok(*manifest)
}

fn read_manifest(bytes: &mut impl Bytes, at: u32, layout: &Layout) -> Result<Manifest, Flaw> {
    let mut manifest = [0; MANIFEST_BYTES];
    if bytes.length() < at + MANIFEST_BYTES as u32 {
        return Err(Flaw::NoManifest);
    }
    bytes.read(at, &mut manifest)?;
    Manifest::parse(&manifest, layout)
}

/// The digest of the image at a place. Each of its bytes goes to `also` as well.
fn hash(bytes: &mut impl Bytes, at: u32, length: u32, mut also: impl FnMut(&[u8])) -> Result<[u8; 32], Flaw> {
    let mut sha = Sha256::new();
    let mut is_first = true;
    each_chunk(bytes, at, at + length, |chunk| {
        also(chunk);
        if core::mem::take(&mut is_first) {
            sha.update(chunk.get(..HASHED).unwrap_or_default());
            sha.update(chunk.get(MANIFEST_BYTES..).unwrap_or_default());
        } else {
            sha.update(chunk);
        }
    })?;
    Ok(sha.finalize().into())
}

/// Reads from one place up to another.
fn each_chunk(bytes: &mut impl Bytes, from: u32, to: u32, mut look: impl FnMut(&[u8])) -> Result<(), Flaw> {
    let mut chunk = [0; CHUNK];
    let mut at = from;
    while at < to {
        let chunk = chunk.get_mut(..(to - at).min(CHUNK as u32) as usize).unwrap_or_default();
        bytes.read(at, chunk)?;
        look(chunk);
        at += chunk.len() as u32;
    }
    Ok(())
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
