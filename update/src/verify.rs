//! Whether an image is what its manifest says, in a file and in flash.

use crate::flash::{Flash, Layout};
use crate::manifest::{BOARD_MAGIC, Flaw, HASHED, MANIFEST_BYTES, Manifest};
use crate::policy::Policy;
use md5::{Digest as _, Md5};
use sha2::Sha256;

/// Bytes that are read at a time: a block of the card.
const CHUNK: usize = 512;

/// Bytes of the trailer of Smoothieware v2: board magic, then MD5 in hexadecimal digits of everything before
/// them.
pub(crate) const TRAILER: u32 = 40;

/// Source of bytes at places: a file, or an image in flash.
pub trait Bytes {
    /// Returns the number of bytes.
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
    /// Gives access to the image in this flash.
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
/// The flaw for which the image may not run.
pub fn check_flash<F: Flash>(flash: &mut F, layout: &Layout, policy: &Policy) -> Result<Manifest, Flaw> {
    let mut image = Image::new(flash, layout);
    let manifest = read_manifest(&mut image, 0, layout)?;
    let digest = hash(&mut image, manifest.length)?;
    judge(&manifest, &digest, policy)
}

/// The image in a file, if it may be installed: alone or behind a boot stage, as `make firmware` makes them;
/// with the trailer of Smoothieware v2 behind it, or without.
///
/// # Errors
/// The flaw for which the image may not be installed.
pub fn check_file(file: &mut impl Bytes, layout: &Layout, policy: &Policy) -> Result<Manifest, Flaw> {
    // Flaws that show at once come first: reading all of a large file takes long.
    let (at, manifest) = locate(file, layout)?;
    if file.length() > (at + manifest.length).saturating_add(TRAILER) {
        return Err(Flaw::Trailer);
    }
    let mut check = FileCheck::new(layout);
    let end = file.length();
    each_chunk(file, 0, end, |chunk| check.take(chunk))?;
    check.finish(policy)
}

/// Check of a file that comes piece after piece, from its beginning to its end.
#[derive(Clone)]
pub struct FileCheck<'l> {
    layout: &'l Layout,
    /// Bytes that have come.
    length: u32,
    /// Offset of the image in the file.
    at: u32,
    /// The first bytes from there on.
    head: [u8; MANIFEST_BYTES],
    /// Manifest in those first bytes, or its flaw, when all of them have come.
    found: Option<Result<Manifest, Flaw>>,
    sha: Sha256,
    md5: Md5,
    trailer: [u8; TRAILER as usize],
}

impl<'l> FileCheck<'l> {
    /// Begins a file of which nothing has come.
    #[must_use]
    pub fn new(layout: &'l Layout) -> Self {
        Self {
            layout,
            length: 0,
            at: 0,
            head: [0; MANIFEST_BYTES],
            found: None,
            sha: Sha256::new(),
            md5: Md5::new(),
            trailer: [0; TRAILER as usize],
        }
    }

    /// Takes the next piece.
    pub fn take(&mut self, piece: &[u8]) {
        let mut rest = piece;
        while !rest.is_empty() {
            // The piece ends at the next place where the meaning of the bytes changes.
            let end = self.end_of_part();
            let most = (end - self.length).min(rest.len() as u32) as usize;
            let (now, later) = rest.split_at(most);
            self.take_part(now);
            rest = later;
        }
    }

    /// Returns the image's offset, and its manifest or the flaw; `None` until that has come.
    pub(crate) const fn manifest(&self) -> Option<(u32, Result<Manifest, Flaw>)> {
        match self.found {
            Some(found) => Some((self.at, found)),
            None => None,
        }
    }

    /// The bytes of the manifest.
    pub(crate) const fn head(&self) -> &[u8; MANIFEST_BYTES] {
        &self.head
    }

    /// The whole file has come: the image in it, if it may be installed.
    ///
    /// # Errors
    /// The flaw for which the image may not be installed.
    pub fn finish(self, policy: &Policy) -> Result<Manifest, Flaw> {
        let manifest = match self.found {
            Some(found) => found?,
            None if self.at > 0 => return Err(Flaw::FromTheBeginning),
            None => return Err(Flaw::NoManifest),
        };
        let says = self.at + manifest.length;
        let digest = self.sha.finalize().into();
        match self.length.checked_sub(says) {
            None => return Err(Flaw::Truncated { is: self.length, says }),
            Some(0) => {}
            Some(TRAILER) => check_trailer(&self.trailer, self.md5)?,
            Some(_) => return Err(Flaw::Trailer),
        }
        judge(&manifest, &digest, policy)
    }

    fn end_of_part(&self) -> u32 {
        let head_end = self.at + MANIFEST_BYTES as u32;
        match &self.found {
            None if self.length < self.at => self.at,
            None => head_end,
            Some(Ok(manifest)) if self.length < self.at + manifest.length => self.at + manifest.length,
            _ => u32::MAX,
        }
    }

    fn take_part(&mut self, part: &[u8]) {
        let from = self.length;
        self.length += part.len() as u32;
        match &self.found {
            None => {
                self.md5.update(part);
                if from >= self.at {
                    let within = (from - self.at) as usize;
                    if let Some(place) = self.head.get_mut(within..within + part.len()) {
                        place.copy_from_slice(part);
                    }
                    if self.length == self.at + MANIFEST_BYTES as u32 {
                        self.look_at_head();
                    }
                }
            }
            Some(Ok(manifest)) if self.length <= self.at + manifest.length => {
                self.md5.update(part);
                self.sha.update(part);
            }
            Some(Ok(manifest)) => {
                let within = (from - self.at - manifest.length) as usize;
                let room = self.trailer.get_mut(within..).unwrap_or_default();
                for (place, byte) in room.iter_mut().zip(part) {
                    *place = *byte;
                }
            }
            Some(Err(_)) => {}
        }
    }

    fn look_at_head(&mut self) {
        match Manifest::parse(&self.head, self.layout) {
            // A boot stage is in front: the image is where it is in flash.
            Err(Flaw::FromTheBeginning) if self.at == 0 => self.at = self.layout.image(),
            Err(Flaw::NoManifest) if self.at > 0 => self.found = Some(Err(Flaw::FromTheBeginning)),
            found => {
                self.sha.update(self.head.get(..HASHED).unwrap_or_default());
                self.found = Some(found);
            }
        }
    }
}

/// Finds the image in a file, and its manifest. A file for the whole flash has a boot stage first, which is
/// passed over: the boot stage that runs is never replaced by one that it installs.
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

/// The digest of an image.
fn hash(bytes: &mut impl Bytes, length: u32) -> Result<[u8; 32], Flaw> {
    let mut sha = Sha256::new();
    let mut is_first = true;
    each_chunk(bytes, 0, length, |chunk| {
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

fn check_trailer(trailer: &[u8; TRAILER as usize], mut md5: Md5) -> Result<(), Flaw> {
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
