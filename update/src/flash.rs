//! The flash of the chip as updates see it (RM0399 section 4: sectors of 128 KiB, programmed in words of 32
//! bytes, once each).

/// Bytes of a flash word, the least that can be programmed.
pub const WORD: usize = 32;

/// Bytes of a flash word.
pub type Word = [u8; WORD];

/// Content of an erased flash word.
pub const ERASED: Word = [0xff; WORD];

/// A flash word whose two-bit error correction gave up: the power failed while it was programmed or erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unreadable;

/// The flash did not take an erase or a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

/// A sector's number, from the beginning of the flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sector(pub u32);

/// Reading, erasing and programming. Places are bytes from the beginning of the flash, multiples of [`WORD`].
pub trait Flash {
    /// The word at a place.
    ///
    /// # Errors
    /// The word was torn by a power failure.
    fn read(&mut self, at: u32) -> Result<Word, Unreadable>;

    /// Fills `into` from a place on, which need not be a multiple of [`WORD`].
    ///
    /// # Errors
    /// A word of the range was torn.
    fn read_into(&mut self, at: u32, into: &mut [u8]) -> Result<(), Unreadable> {
        let mut at = at;
        let mut rest = into;
        while !rest.is_empty() {
            let within = at as usize % WORD;
            let word = self.read(at - within as u32)?;
            let bytes = word.get(within..).unwrap_or_default();
            let (now, later) = rest.split_at_mut(bytes.len().min(rest.len()));
            now.copy_from_slice(bytes.get(..now.len()).unwrap_or_default());
            at += now.len() as u32;
            rest = later;
        }
        Ok(())
    }

    /// Programs an erased word.
    ///
    /// # Errors
    /// The flash reports a failure, or reads back as something else.
    fn program(&mut self, at: u32, word: &Word) -> Result<(), Failed>;

    /// Erases a sector to [`ERASED`] words.
    ///
    /// # Errors
    /// The flash reports a failure.
    fn erase(&mut self, sector: Sector) -> Result<(), Failed>;

    /// Feeds a running watchdog before a file is looked at, which may take a second or two.
    fn feed_watchdog(&mut self) {}
}

/// Layout of the flash: boot stage, image and log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Address of the flash's beginning in the processor's address space.
    pub address: u32,
    /// Bytes of a sector.
    pub sector_bytes: u32,
    /// The first sector of the image; the boot stage has those before.
    pub first: Sector,
    /// Sectors for the image.
    pub sectors: u32,
    /// The sector of the log.
    pub log: Sector,
}

/// Bytes at the end of the image's last sector that no image may have: a copy of the owner's policy, for as
/// long as it takes to empty the log. An install that comes so far erases it: the log has the policy by then.
pub const POLICY_BYTES: u32 = 1024;

/// The STM32H745 with 2 MiB: 128 KiB for the boot stage, 1791 KiB for the image, 1 KiB for a copy of the
/// policy, 128 KiB for the log.
pub const PRIME: Layout =
    Layout { address: 0x0800_0000, sector_bytes: 0x2_0000, first: Sector(1), sectors: 14, log: Sector(15) };

impl Layout {
    /// Returns the beginning of the image, from the beginning of the flash.
    #[must_use]
    pub const fn image(&self) -> u32 {
        self.first.0 * self.sector_bytes
    }

    /// The address that an image is linked for.
    #[must_use]
    pub const fn image_address(&self) -> u32 {
        self.address + self.image()
    }

    /// Returns the length of the longest image, bytes.
    #[must_use]
    pub const fn image_bytes(&self) -> u32 {
        self.sectors * self.sector_bytes - POLICY_BYTES
    }

    /// Returns the beginning of the policy's copy, from the beginning of the flash.
    #[must_use]
    pub const fn policy_at(&self) -> u32 {
        self.image() + self.image_bytes()
    }

    /// Returns the beginning of the log, from the beginning of the flash.
    #[must_use]
    pub const fn log_at(&self) -> u32 {
        self.log.0 * self.sector_bytes
    }
}
