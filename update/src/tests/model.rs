//! A flash that can lose its power at any operation, a card, and images.

use crate::flash::{ERASED, Failed, Flash, Layout, Sector, Unreadable, WORD, Word};
use crate::manifest::{Flaw, MANIFEST_BYTES};
use crate::verify::Bytes;
use crate::{Card, Ended, Manifest, Next, seal, settle, trailer};
use ed25519_dalek::SigningKey;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

/// Sectors of 2 KiB rather than 128: one for the boot stage, five for the image, one for the log.
pub const SMALL: Layout =
    Layout { address: 0x0800_0000, sector_bytes: 2048, first: Sector(1), sectors: 5, log: Sector(6) };

/// State of the operation during which the power fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// The operation has not begun.
    Before,
    /// A word is torn; some words of a sector are erased, some are torn, the rest is as it was.
    Within,
    /// The operation is complete, and nothing after it.
    After,
}

/// Content of a flash from its beginning on; words are torn, erased or programmed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chip {
    words: Vec<Option<Word>>,
    /// Erases and programmed words so far.
    pub operations: usize,
    /// During which one the power fails.
    pub cut: Option<(usize, Cut)>,
    /// Words that do not take what is programmed.
    pub bad: Vec<u32>,
}

struct PowerFailure;

impl Chip {
    pub fn new() -> Self {
        let words = 7 * SMALL.sector_bytes as usize / WORD;
        Self { words: vec![Some(ERASED); words], operations: 0, cut: None, bad: Vec::new() }
    }

    /// A chip with this image, as a debug probe puts it there.
    pub fn with(image: &[u8]) -> Self {
        let mut chip = Self::new();
        chip.flash(image);
        chip
    }

    /// A debug probe puts this image there.
    pub fn flash(&mut self, image: &[u8]) {
        let first = SMALL.image() as usize / WORD;
        for (place, bytes) in image.chunks(WORD).enumerate() {
            self.words[first + place] = Some(bytes.try_into().expect("whole words"));
        }
    }

    /// The image area as far as an image of this length goes.
    pub fn image(&self, length: usize) -> Vec<u8> {
        let first = SMALL.image() as usize / WORD;
        let words = self.words[first..first + length / WORD].iter();
        words.flat_map(|word| word.unwrap_or([0xee; WORD])).collect()
    }

    fn step(&mut self, mut operation: impl FnMut(&mut Self, bool)) {
        self.operations += 1;
        match self.cut {
            Some((at, kind)) if at == self.operations => {
                match kind {
                    Cut::Before => {}
                    Cut::Within => operation(self, true),
                    Cut::After => operation(self, false),
                }
                resume_unwind(Box::new(PowerFailure));
            }
            _ => operation(self, false),
        }
    }
}

impl Flash for Chip {
    fn read(&mut self, at: u32) -> Result<Word, Unreadable> {
        self.words[at as usize / WORD].ok_or(Unreadable)
    }

    fn program(&mut self, at: u32, word: &Word) -> Result<(), Failed> {
        if self.bad.contains(&at) {
            self.operations += 1;
            return Err(Failed);
        }
        self.step(|chip, torn| {
            let place = &mut chip.words[at as usize / WORD];
            assert_eq!(*place, Some(ERASED), "a word is programmed once, at {at:#x}");
            *place = if torn { None } else { Some(*word) };
        });
        Ok(())
    }

    fn erase(&mut self, sector: Sector) -> Result<(), Failed> {
        assert_ne!(sector, Sector(0), "the boot stage is never touched");
        self.step(|chip, torn| {
            let words = SMALL.sector_bytes as usize / WORD;
            for place in 0..words {
                let word = &mut chip.words[sector.0 as usize * words + place];
                match (torn, place % 3) {
                    (false, _) | (true, 0) => *word = Some(ERASED),
                    (true, 1) => *word = None,
                    _ => {}
                }
            }
        });
        Ok(())
    }
}

/// Files by name. A file is read up to `ends_at` bytes, where the card is pulled out.
#[derive(Clone, Default)]
pub struct Files {
    pub files: BTreeMap<String, Vec<u8>>,
    pub ends_at: Option<u32>,
}

pub struct File<'f> {
    bytes: &'f [u8],
    ends_at: u32,
}

impl Files {
    pub fn with(files: &[(&str, &[u8])]) -> Self {
        let files = files.iter().map(|(name, bytes)| ((*name).to_string(), bytes.to_vec())).collect();
        Self { files, ends_at: None }
    }
}

impl Card for Files {
    type File<'c> = File<'c>;

    fn open(&mut self, name: &str) -> Option<File<'_>> {
        let bytes = self.files.get(name)?;
        Some(File { bytes, ends_at: self.ends_at.unwrap_or(u32::MAX) })
    }
}

impl Bytes for File<'_> {
    fn length(&self) -> u32 {
        self.bytes.len() as u32
    }

    fn read(&mut self, at: u32, into: &mut [u8]) -> Result<(), Flaw> {
        let end = at + into.len() as u32;
        let bytes = self.bytes.get(at as usize..end as usize).filter(|_| end <= self.ends_at);
        into.copy_from_slice(bytes.ok_or(Flaw::Unreadable)?);
        Ok(())
    }
}

/// An image as the linker leaves it, of so many bytes, different for each `seed`.
pub fn linked(seed: u8, length: u32) -> Vec<u8> {
    let mut bytes: Vec<u8> = (0..length).map(|place| (place as u8).wrapping_mul(31) ^ seed).collect();
    bytes[..MANIFEST_BYTES].copy_from_slice(&Manifest::draft("0.1.0", &SMALL));
    bytes
}

pub fn image(seed: u8, length: u32) -> Vec<u8> {
    let mut bytes = linked(seed, length);
    seal(&mut bytes, &SMALL, None).expect("an image");
    bytes
}

pub fn owner() -> SigningKey {
    SigningKey::from_bytes(&[7; 32])
}

pub fn sign(mut image: Vec<u8>, key: &SigningKey) -> Vec<u8> {
    seal(&mut image, &SMALL, Some(&key.to_bytes())).expect("an image");
    image
}

pub fn with_trailer(mut image: Vec<u8>) -> Vec<u8> {
    image.extend(trailer(&image));
    image
}

/// A file for the whole flash: something that begins with a vector table, and the image where it is in flash.
pub fn for_the_whole_flash(image: &[u8]) -> Vec<u8> {
    let mut bytes = vec![0x55; SMALL.image() as usize];
    bytes[..8].copy_from_slice(&[0x00, 0x00, 0x02, 0x20, 0x91, 0x02, 0x00, 0x08]);
    bytes.extend(image);
    bytes
}

/// A start of the boot stage; `None` when the power failed.
pub fn start(chip: &mut Chip, card: &mut Files) -> Option<Next> {
    let run = catch_unwind(AssertUnwindSafe(|| settle(chip, card, &SMALL, Ended::Watchdog)));
    match run {
        Ok(next) => Some(next),
        Err(why) if why.is::<PowerFailure>() => None,
        Err(why) => resume_unwind(why),
    }
}
