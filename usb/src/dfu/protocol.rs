//! Protocol parts common to machine and boot stage: descriptors, numbers, states.

/// Most bytes of firmware in one request: the limit of `usb-device` for a data stage.
pub const TRANSFER_BYTES: u16 = 256;

/// Interface class (DFU section 4.2.3): application specific, firmware upgrade.
pub const CLASS: u8 = 0xFE;
pub const SUBCLASS: u8 = 0x01;
/// Protocol of an interface in run-time mode, on a device that does something else.
pub const PROTOCOL_RUNTIME: u8 = 0x01;
/// Protocol of an interface in DFU mode, which takes firmware.
pub const PROTOCOL_DOWNLOAD: u8 = 0x02;

/// Type of the functional descriptor (DFU table 4.2).
pub const FUNCTIONAL: u8 = 0x21;
/// Attributes: can download, can upload, detaches from the bus by itself (bits 0, 1, 3). Bit 2 is clear: with
/// complete firmware the device waits for a reset of the bus, and then starts the firmware; dfu-util resets
/// automatically.
const ATTRIBUTES: u8 = 0b1011;
/// Time limit between detaching and reset of the bus, ms. The device detaches by itself, so this is the time
/// that detaching takes.
const DETACH_TIMEOUT_MS: u16 = 1_000;
/// Version of the specification, DFU 1.1.
const VERSION: u16 = 0x0110;

/// Returns the functional descriptor, without length and type.
pub fn functional() -> [u8; 7] {
    let [t0, t1] = DETACH_TIMEOUT_MS.to_le_bytes();
    let [s0, s1] = TRANSFER_BYTES.to_le_bytes();
    let [v0, v1] = VERSION.to_le_bytes();
    [ATTRIBUTES, t0, t1, s0, s1, v0, v1]
}

/// Codes of requests (DFU table 3.2).
pub mod request {
    pub const DETACH: u8 = 0;
    pub const DNLOAD: u8 = 1;
    pub const UPLOAD: u8 = 2;
    pub const GETSTATUS: u8 = 3;
    pub const CLRSTATUS: u8 = 4;
    pub const GETSTATE: u8 = 5;
    pub const ABORT: u8 = 6;
}

/// States (DFU section 6.1.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Run-time mode of the machine.
    AppIdle = 0,
    /// Detach was requested in run-time mode.
    AppDetach = 1,
    /// Waits for a request.
    Idle = 2,
    /// Holds a block, which is written after the next GETSTATUS.
    DownloadSync = 3,
    /// Block is being written.
    DownloadBusy = 4,
    /// Waits for the next block.
    DownloadIdle = 5,
    /// All blocks are written.
    ManifestSync = 6,
    /// Firmware is being checked.
    Manifest = 7,
    /// Firmware is good; a reset of the bus starts it.
    ManifestWaitReset = 8,
    /// Upload is in progress.
    UploadIdle = 9,
    /// Error that the host has not cleared yet.
    Error = 10,
}

/// Reason to refuse firmware (DFU section 6.1.2, bStatus).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// Firmware for another device.
    Target = 0x01,
    /// Firmware that fails a vendor's check.
    File = 0x02,
    /// The memory cannot be written.
    Write = 0x03,
    /// The memory cannot be erased.
    Erase = 0x04,
    /// The memory does not hold the written bytes.
    Verify = 0x07,
    /// Firmware larger than the memory.
    Address = 0x08,
    /// Firmware that ended prematurely.
    NotDone = 0x09,
    /// No firmware to read, or none that can run.
    Firmware = 0x0A,
    /// Vendor-specific reason, given by the string [`NO_COPY`] (`iString`).
    NoCopy = 0x0B,
    /// Any other kind of error.
    Unknown = 0x0E,
    /// Request that the state does not permit.
    StalledRequest = 0x0F,
}

/// String descriptor for refusing to overwrite the running firmware without another image as a fallback.
pub const NO_COPY: &str = "The card holds no firmware to come back to: firmware.previous";

/// Returns the answer to GETSTATUS (DFU section 6.1.2); `no_copy`: string index of [`NO_COPY`].
pub fn status(refused: Option<Refused>, poll_ms: u32, state: State, no_copy: u8) -> [u8; 6] {
    let [a, b, c, _] = poll_ms.to_le_bytes();
    let string = if refused == Some(Refused::NoCopy) { no_copy } else { 0 };
    [refused.map_or(0, |refused| refused as u8), a, b, c, state as u8, string]
}
