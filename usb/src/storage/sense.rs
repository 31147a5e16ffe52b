//! SCSI sense data, the reason why a command failed (SPC-4 section 4.5, annex D).

use super::medium::Fault;

/// Sense key, additional sense code and its qualifier.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sense {
    /// Sense key, the kind of error.
    pub key: u8,
    /// Additional sense code, and its qualifier.
    pub code: [u8; 2],
}

/// Bytes of sense data in the fixed format (SPC-4 table 53).
pub const SENSE_BYTES: usize = 18;

impl Sense {
    const fn new(key: u8, code: u8, qualifier: u8) -> Self {
        Self { key, code: [code, qualifier] }
    }

    /// No error to report.
    pub const NONE: Self = Self::new(0x0, 0x00, 0x00);
    /// Not ready: there is no medium.
    pub const NO_MEDIUM: Self = Self::new(0x2, 0x3A, 0x00);
    /// Medium error: written data may be missing on the medium.
    pub const WRITE_FAULT: Self = Self::new(0x3, 0x03, 0x00);
    /// Medium error: a block cannot be read.
    pub const READ_ERROR: Self = Self::new(0x3, 0x11, 0x00);
    /// Hardware error: the card does not answer.
    pub const NO_ANSWER: Self = Self::new(0x4, 0x08, 0x01);
    /// Illegal request: no such command.
    pub const NO_SUCH_COMMAND: Self = Self::new(0x5, 0x20, 0x00);
    /// Illegal request: a block behind the end.
    pub const OUT_OF_RANGE: Self = Self::new(0x5, 0x21, 0x00);
    /// Illegal request: a field of the command has an unsupported value.
    pub const BAD_FIELD: Self = Self::new(0x5, 0x24, 0x00);
    /// Illegal request: no such unit.
    pub const NO_SUCH_UNIT: Self = Self::new(0x5, 0x25, 0x00);
    /// Illegal request: the host itself has forbidden removal of the medium.
    pub const REMOVAL_PREVENTED: Self = Self::new(0x5, 0x53, 0x02);
    /// Unit attention: the medium may have been exchanged.
    pub const MEDIUM_CHANGED: Self = Self::new(0x6, 0x28, 0x00);
    /// Data protect: the medium is write-protected.
    pub const READ_ONLY: Self = Self::new(0x7, 0x27, 0x00);

    /// Returns sense data in the fixed format (SPC-4 section 4.5.3).
    pub const fn data(self) -> [u8; SENSE_BYTES] {
        let [code, qualifier] = self.code;
        // Byte 0 means current error; 10 more bytes follow the first 8.
        [0x70, 0, self.key, 0, 0, 0, 0, 10, 0, 0, 0, 0, code, qualifier, 0, 0, 0, 0]
    }
}

impl From<Fault> for Sense {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Gone => Self::NO_MEDIUM,
            Fault::ReadOnly => Self::READ_ONLY,
            Fault::Unreadable => Self::READ_ERROR,
            Fault::NotWritten => Self::WRITE_FAULT,
            Fault::Silent => Self::NO_ANSWER,
        }
    }
}
