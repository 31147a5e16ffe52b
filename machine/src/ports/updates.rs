//! The firmware that runs, and the way to another one.

/// Why a file is no firmware for this board, or a key none; for a person.
pub type Flaw = heapless::String<120, u8>;

/// How the firmware that runs came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrival {
    /// It has run before.
    #[default]
    Known,
    /// A debug probe, or the chip's own loader, put it there.
    Probe,
    /// It is new, and this is its so many-th start without having confirmed itself.
    Trial {
        /// It came over USB, not from a card.
        by_usb: bool,
        /// Which start.
        start: u8,
        /// After so many the previous firmware is put back.
        of: u8,
    },
    /// The previous firmware is back, because the new one failed.
    FellBack(FailedBy),
}

/// How new firmware failed last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailedBy {
    /// The watchdog reset the board.
    Watchdog,
    /// It ended itself.
    Itself,
    /// It was reset, or the power went, before it had run for long enough.
    Early,
}

/// What is known of the firmware that runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Running {
    /// How it came to.
    pub arrival: Arrival,
    /// Why what was asked for last was not installed.
    pub refused: Option<&'static str>,
}

/// Which image of firmware it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FirmwareId {
    /// Its bytes.
    pub length: u32,
    /// The first half of its digest.
    pub digest: [u8; 16],
}

/// What a file holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Firmware {
    /// Which image it is.
    pub id: FirmwareId,
    /// Its version.
    pub version: heapless::String<40, u8>,
    /// It is what runs.
    pub runs: bool,
    /// It was tried, and the previous one put back.
    pub has_failed: bool,
    /// It was asked for last, and could not be installed.
    pub was_refused: bool,
}

/// Updates. A board that cannot be updated leaves all of it out.
pub trait Updates {
    /// How the firmware came to run.
    fn running(&mut self) -> Running {
        Running::default()
    }

    /// The firmware does well: it stays. Once, some seconds after the start.
    fn confirm(&mut self) {}

    /// Whose firmware may be installed: with a key only what is signed with it or not at all, locked only
    /// what is signed.
    ///
    /// # Errors
    /// The key is none; nothing is changed then.
    fn set_policy(&mut self, _key: Option<&[u8; 32]>, _is_locked: bool) -> Result<(), Flaw> {
        Ok(())
    }

    /// Bytes of the firmware that runs; 0 where it cannot be copied.
    fn image_bytes(&mut self) -> u32 {
        0
    }

    /// Reads from there on. False where the flash does not give them.
    fn read_image(&mut self, _at: u32, _into: &mut [u8]) -> bool {
        false
    }

    /// A file is looked at from here on; then come its bytes, then [`end_look`](Self::end_look).
    fn begin_look(&mut self) {}

    /// The next bytes of it.
    fn look(&mut self, _piece: &[u8]) {}

    /// All have come: the firmware in it, when it may be installed.
    ///
    /// # Errors
    /// Why it may not.
    fn end_look(&mut self) -> Result<Firmware, Flaw> {
        let mut why = Flaw::new();
        // It fits.
        let _ = why.push_str("this board cannot be updated");
        Err(why)
    }

    /// Has the next start install this image from `flashme.bin`. False where that cannot be written
    /// down.
    fn ask_for_install(&mut self, _image: FirmwareId) -> bool {
        false
    }

    /// Has the next start wait for firmware over USB. False where the board has no such thing.
    fn ask_for_download(&mut self) -> bool {
        false
    }

    /// Whether a host on USB has asked for that since the last call; and whether one may from now on.
    fn take_download_request(&mut self, _may: bool) -> bool {
        false
    }
}
