//! Device firmware upgrade 1.1, with ST's extension DfuSe (UM0424, AN3156).

use super::{Desk, Device, UsbError};
use usb_host::request::{CLASS_IN, CLASS_OUT};

const DETACH: u8 = 0;
const DNLOAD: u8 = 1;
const UPLOAD: u8 = 2;
const GETSTATUS: u8 = 3;
const CLRSTATUS: u8 = 4;
const GETSTATE: u8 = 5;
const ABORT: u8 = 6;

/// States of the DFU interface, bState.
pub mod state {
    /// The application runs (appIDLE).
    pub const APP_IDLE: u8 = 0;
    /// The application waits for a bus reset (appDETACH).
    pub const APP_DETACH: u8 = 1;
    /// The device waits for a request (dfuIDLE).
    pub const IDLE: u8 = 2;
    /// A block has come (dfuDNLOAD-SYNC).
    pub const DOWNLOAD_SYNC: u8 = 3;
    /// A block is being written (dfuDNBUSY).
    pub const DOWNLOAD_BUSY: u8 = 4;
    /// The device waits for the next block (dfuDNLOAD-IDLE).
    pub const DOWNLOAD_IDLE: u8 = 5;
    /// All blocks have come (dfuMANIFEST-SYNC).
    pub const MANIFEST_SYNC: u8 = 6;
    /// The downloaded image is being made valid (dfuMANIFEST).
    pub const MANIFEST: u8 = 7;
    /// The device waits for a reset (dfuMANIFEST-WAIT-RESET).
    pub const MANIFEST_WAIT_RESET: u8 = 8;
    /// The host is reading back (dfuUPLOAD-IDLE).
    pub const UPLOAD_IDLE: u8 = 9;
    /// An error has occurred (dfuERROR).
    pub const ERROR: u8 = 10;
}

/// The answer to GETSTATUS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// bStatus, where 0 is OK.
    pub status: u8,
    /// Time to wait until the next question (bwPollTimeout), milliseconds.
    pub poll_ms: u32,
    /// State of the interface, bState.
    pub state: u8,
}

/// The functional descriptor, section 4.1.3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Functional {
    /// Capabilities from bmAttributes: download, upload, manifestation tolerant, will detach.
    pub attributes: u8,
    /// Detach time-out (wDetachTimeout), milliseconds.
    pub detach_ms: u16,
    /// Greatest block size (wTransferSize), bytes.
    pub transfer: u16,
    /// DFU release (bcdDFUVersion): 0x0110, or 0x011A for DfuSe.
    pub version: u16,
}

/// A DFU interface of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dfu {
    /// Number of the interface.
    pub interface: u8,
    /// Protocol of the interface (bInterfaceProtocol): 1 at run time, 2 in DFU mode.
    pub protocol: u8,
    /// Functional descriptor with the interface's abilities.
    pub functional: Functional,
}

impl Dfu {
    /// Returns the device's DFU interface.
    #[must_use]
    pub fn of(device: &Device) -> Option<Self> {
        let interface = device.configuration.of_class(0xFE, 1).next()?;
        let functional = interface.extra.iter().find_map(|extra| match *extra.as_slice() {
            [9, 0x21, attributes, d0, d1, t0, t1, v0, v1] => Some(Functional {
                attributes,
                detach_ms: u16::from_le_bytes([d0, d1]),
                transfer: u16::from_le_bytes([t0, t1]),
                version: u16::from_le_bytes([v0, v1]),
            }),
            _ => None,
        })?;
        Some(Self { interface: interface.number, protocol: interface.class[2], functional })
    }

    fn tell(&self, desk: &mut Desk<'_>, request: u8, value: u16, data: &[u8]) -> Result<(), UsbError> {
        desk.tell(CLASS_OUT, request, value, u16::from(self.interface), data)
    }

    /// Asks the application to return in DFU mode, within so many milliseconds.
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn detach(&self, desk: &mut Desk<'_>, timeout_ms: u16) -> Result<(), UsbError> {
        self.tell(desk, DETACH, timeout_ms, &[])
    }

    /// Asks for the status (GETSTATUS).
    ///
    /// # Errors
    /// As [`Desk::control`], or the answer is none.
    pub fn status(&self, desk: &mut Desk<'_>) -> Result<Status, UsbError> {
        let bytes = desk.ask(CLASS_IN, GETSTATUS, 0, u16::from(self.interface), 6)?;
        let &[status, p0, p1, p2, state, _] = bytes.as_slice() else {
            return Err(UsbError::Wrong(format!("a status of {} bytes", bytes.len())));
        };
        Ok(Status { status, poll_ms: u32::from_le_bytes([p0, p1, p2, 0]), state })
    }

    /// Asks for the state (GETSTATE).
    ///
    /// # Errors
    /// As [`Desk::control`], or the answer is none.
    pub fn state(&self, desk: &mut Desk<'_>) -> Result<u8, UsbError> {
        let bytes = desk.ask(CLASS_IN, GETSTATE, 0, u16::from(self.interface), 1)?;
        bytes.first().copied().ok_or_else(|| UsbError::Wrong("no state".into()))
    }

    /// Leaves the error state (CLRSTATUS).
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn clear(&self, desk: &mut Desk<'_>) -> Result<(), UsbError> {
        self.tell(desk, CLRSTATUS, 0, &[])
    }

    /// Returns to idle (ABORT).
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn abort(&self, desk: &mut Desk<'_>) -> Result<(), UsbError> {
        self.tell(desk, ABORT, 0, &[])
    }

    /// Sends a block without asking for the status.
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn send_block(&self, desk: &mut Desk<'_>, number: u16, data: &[u8]) -> Result<(), UsbError> {
        self.tell(desk, DNLOAD, number, data)
    }

    /// Sends a block and waits until it is dealt with. Returns the status then.
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn download(&self, desk: &mut Desk<'_>, number: u16, data: &[u8]) -> Result<Status, UsbError> {
        self.send_block(desk, number, data)?;
        loop {
            let status = self.status(desk)?;
            if !matches!(status.state, state::DOWNLOAD_BUSY | state::DOWNLOAD_SYNC | state::MANIFEST) {
                return Ok(status);
            }
            desk.pass_ms(u64::from(status.poll_ms.max(1)))?;
        }
    }

    /// Reads a block of the firmware back.
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn upload(&self, desk: &mut Desk<'_>, number: u16, length: u16) -> Result<Vec<u8>, UsbError> {
        desk.ask(CLASS_IN, UPLOAD, number, u16::from(self.interface), length)
    }

    /// Sets the address that the next block is for (DfuSe).
    ///
    /// # Errors
    /// As [`Self::download`].
    pub fn set_address(&self, desk: &mut Desk<'_>, address: u32) -> Result<Status, UsbError> {
        self.download(desk, 0, &Self::command(0x21, address))
    }

    /// Erases the sector with this address (DfuSe).
    ///
    /// # Errors
    /// As [`Self::download`].
    pub fn erase(&self, desk: &mut Desk<'_>, address: u32) -> Result<Status, UsbError> {
        self.download(desk, 0, &Self::command(0x41, address))
    }

    fn command(code: u8, address: u32) -> Vec<u8> {
        let mut command = vec![code];
        command.extend(address.to_le_bytes());
        command
    }

    /// Ends a download, so that the downloaded image is started: a block without data, and the question after
    /// it.
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn leave(&self, desk: &mut Desk<'_>, number: u16) -> Result<Status, UsbError> {
        self.send_block(desk, number, &[])?;
        self.status(desk)
    }
}
