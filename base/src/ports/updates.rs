//! Firmware updates: the firmware that runs, and the way to another one.

/// Reason for a person why a file is no firmware for this board, or a key is invalid.
pub type Flaw = heapless::String<120, u8>;

/// History of the running firmware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Arrival {
    /// The firmware has run before.
    #[default]
    Known,
    /// A debug probe, or the chip's own loader, put the firmware there.
    Probe,
    /// The firmware is new, and has not confirmed itself yet.
    Trial {
        /// Whether it came over USB, not from a card.
        by_usb: bool,
        /// Number of this start, from the first.
        start: u8,
        /// Starts after which the previous firmware is put back.
        of: u8,
    },
    /// The previous firmware is back, because the new one failed.
    FellBack(FailedBy),
}

/// Failure of new firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailedBy {
    /// The watchdog reset the board.
    Watchdog,
    /// The firmware ended itself.
    Itself,
    /// The firmware was reset, or the power went, before it had run for long enough.
    Early,
}

/// State of the running firmware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Running {
    /// History of the running firmware.
    pub arrival: Arrival,
    /// Reason why the last requested image was not installed.
    pub refused: Option<&'static str>,
}

/// Identity of a firmware image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FirmwareId {
    /// Length of the image in bytes.
    pub length: u32,
    /// First half of the image's digest.
    pub digest: [u8; 16],
}

/// Firmware found in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Firmware {
    /// Identity of the image.
    pub id: FirmwareId,
    /// Version of the firmware.
    pub version: heapless::String<40, u8>,
    /// Whether this firmware is the running one.
    pub runs: bool,
    /// Whether it was tried, and the previous one put back.
    pub has_failed: bool,
    /// Whether it was requested last, and could not be installed.
    pub was_refused: bool,
}

/// Access to updates. A board that cannot be updated leaves all of it out.
pub trait Updates {
    /// Returns the history of the running firmware.
    fn running(&mut self) -> Running {
        Running::default()
    }

    /// Confirms that the firmware does well, so that it stays. Once, some seconds after the start.
    fn confirm(&mut self) {}

    /// Sets the firmware that may be installed: with a key only images signed with it or not at all, locked
    /// only signed ones.
    ///
    /// # Errors
    /// When the key is invalid; nothing is changed then.
    fn set_policy(&mut self, _key: Option<&[u8; 32]>, _is_locked: bool) -> Result<(), Flaw> {
        Ok(())
    }

    /// Returns the length of the running firmware; 0 where it cannot be copied.
    fn image_bytes(&mut self) -> u32 {
        0
    }

    /// Reads the image from offset `_at` on. False where the flash does not give the bytes.
    fn read_image(&mut self, _at: u32, _into: &mut [u8]) -> bool {
        false
    }

    /// Begins to look at a file; its bytes follow, then [`end_look`](Self::end_look).
    fn begin_look(&mut self) {}

    /// Takes the next bytes of the file.
    fn look(&mut self, _piece: &[u8]) {}

    /// Ends the look at a file, and returns its firmware, when it may be installed.
    ///
    /// # Errors
    /// The reason why it may not.
    fn end_look(&mut self) -> Result<Firmware, Flaw> {
        let mut why = Flaw::new();
        // The message fits the buffer.
        let _ = why.push_str("this board cannot be updated");
        Err(why)
    }

    /// Has the next start install this image from `flashme.bin`. False where that cannot be written down.
    fn ask_for_install(&mut self, _image: FirmwareId) -> bool {
        false
    }

    /// Has the next start wait for firmware over USB. False where the board has no such thing.
    fn ask_for_download(&mut self) -> bool {
        false
    }

    /// Returns whether a host on USB has asked for a download since the last call; `_may` allows or forbids
    /// further requests.
    fn take_download_request(&mut self, _may: bool) -> bool {
        false
    }
}
