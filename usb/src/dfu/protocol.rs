//! What machine and boot stage share: descriptors, numbers, states.

/// Bytes of firmware in one request at most: what `usb-device` takes in a data stage.
pub const TRANSFER_BYTES: u16 = 256;

/// Interface class (DFU section 4.2.3): application specific, firmware upgrade.
pub const CLASS: u8 = 0xFE;
pub const SUBCLASS: u8 = 0x01;
/// The interface of a device that does something else.
pub const PROTOCOL_RUNTIME: u8 = 0x01;
/// The interface of a device that takes firmware.
pub const PROTOCOL_DOWNLOAD: u8 = 0x02;

/// The functional descriptor's type (DFU table 4.2).
pub const FUNCTIONAL: u8 = 0x21;
/// It takes firmware, gives it, and leaves the bus by itself when it is asked to detach (bits 0, 1, 3). Bit 2
/// is clear: with the firmware whole it waits for a reset of the bus, and starts it then; dfu-util resets by
/// itself.
const ATTRIBUTES: u8 = 0b1011;
/// How long a host has between detaching and resetting the bus, ms. As the device detaches by itself, it is
/// the time that this takes.
const DETACH_TIMEOUT_MS: u16 = 1_000;
/// DFU 1.1.
const VERSION: u16 = 0x0110;

/// The functional descriptor, behind length and type.
pub fn functional() -> [u8; 7] {
    let [t0, t1] = DETACH_TIMEOUT_MS.to_le_bytes();
    let [s0, s1] = TRANSFER_BYTES.to_le_bytes();
    let [v0, v1] = VERSION.to_le_bytes();
    [ATTRIBUTES, t0, t1, s0, s1, v0, v1]
}

/// Requests (DFU table 3.2).
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
    /// The machine runs.
    AppIdle = 0,
    /// It has been asked to detach.
    AppDetach = 1,
    /// Waits for a request.
    Idle = 2,
    /// Has a block, which it takes when it is asked how it is.
    DownloadSync = 3,
    /// Takes a block.
    DownloadBusy = 4,
    /// Waits for the next block.
    DownloadIdle = 5,
    /// Has every block.
    ManifestSync = 6,
    /// Looks at what it has got.
    Manifest = 7,
    /// Has found it good: a reset of the bus starts it.
    ManifestWaitReset = 8,
    /// Gives its firmware.
    UploadIdle = 9,
    /// Something failed, until the host has seen it.
    Error = 10,
}

/// Why firmware was refused (DFU section 6.1.2, bStatus).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// It is not for this device.
    Target = 0x01,
    /// It fails a check of its maker.
    File = 0x02,
    /// The memory cannot be written.
    Write = 0x03,
    /// The memory cannot be erased.
    Erase = 0x04,
    /// The memory does not hold what was written.
    Verify = 0x07,
    /// There is more than there is room for.
    Address = 0x08,
    /// It ended before it was whole.
    NotDone = 0x09,
    /// There is none that could be given, or what there is cannot run.
    Firmware = 0x0A,
    /// What a string of the device says (`iString`): [`NO_COPY`].
    NoCopy = 0x0B,
    /// Anything else.
    Unknown = 0x0E,
    /// A request that the state does not allow.
    StalledRequest = 0x0F,
}

/// In the words of a string descriptor: what runs is not given up without another image to come back to.
pub const NO_COPY: &str = "The card holds no firmware to come back to: firmware.previous";

/// The answer to GETSTATUS (DFU section 6.1.2); `no_copy`: the index of that string.
pub fn status(refused: Option<Refused>, poll_ms: u32, state: State, no_copy: u8) -> [u8; 6] {
    let [a, b, c, _] = poll_ms.to_le_bytes();
    let string = if refused == Some(Refused::NoCopy) { no_copy } else { 0 };
    [refused.map_or(0, |refused| refused as u8), a, b, c, state as u8, string]
}
