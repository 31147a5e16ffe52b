//! The commands that a host sends to a drive: SPC-4 and SBC-3, as far as a memory card has them.

use super::bulk_only::{Answer, BulkOnly, Data, Status};
use super::{Desk, UsbError};

/// Sense data of a failed command: sense key, additional code and qualifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sense {
    /// Sense key: 0 no sense, 2 not ready, 3 medium, 5 illegal request, 6 unit attention, 7 data protect.
    pub key: u8,
    /// Additional sense code (ASC).
    pub code: u8,
    /// Additional sense code qualifier (ASCQ).
    pub qualifier: u8,
}

/// Answer of a drive to INQUIRY.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Inquiry {
    /// Peripheral device type, where 0 is a disk.
    pub kind: u8,
    /// Whether the medium can be taken out.
    pub removable: bool,
    /// Vendor in eight characters.
    pub vendor: String,
    /// Product in sixteen characters.
    pub product: String,
    /// Revision in four characters.
    pub revision: String,
}

/// A logical unit of a drive.
#[derive(Debug)]
pub struct Disk {
    /// Transport of the commands.
    pub transport: BulkOnly,
    /// Number of the logical unit.
    pub lun: u8,
}

impl Disk {
    /// Carries out a command that has to pass.
    ///
    /// # Errors
    /// As [`BulkOnly::command`], or it failed; with its sense then.
    pub fn expect(&mut self, desk: &mut Desk<'_>, command: &[u8], data: Data<'_>) -> Result<Answer, UsbError> {
        let answer = self.transport.command(desk, self.lun, command, data)?;
        if answer.status == Status::Passed {
            return Ok(answer);
        }
        let sense = self.request_sense(desk)?;
        Err(UsbError::Wrong(format!("command {:#04x} ended {:?}: {sense:02x?}", command[0], answer.status)))
    }

    /// Asks with INQUIRY for the drive's identification.
    ///
    /// # Errors
    /// As [`Self::expect`].
    pub fn inquiry(&mut self, desk: &mut Desk<'_>) -> Result<Inquiry, UsbError> {
        let data = self.expect(desk, &[0x12, 0, 0, 0, 36, 0], Data::In(36))?.data;
        let text = |range: std::ops::Range<usize>| {
            data.get(range).map(|bytes| String::from_utf8_lossy(bytes).trim_end().to_owned()).unwrap_or_default()
        };
        let &[kind, removable, ..] = data.as_slice() else { return Err(UsbError::Wrong("an empty inquiry".into())) };
        Ok(Inquiry {
            kind: kind & 0x1F,
            removable: removable & 0x80 != 0,
            vendor: text(8..16),
            product: text(16..32),
            revision: text(32..36),
        })
    }

    /// Tests whether the unit is ready (TEST UNIT READY). Returns the sense data if not.
    ///
    /// # Errors
    /// As [`BulkOnly::command`].
    pub fn ready(&mut self, desk: &mut Desk<'_>) -> Result<Result<(), Sense>, UsbError> {
        let answer = self.transport.command(desk, self.lun, &[0; 6], Data::None)?;
        if answer.status == Status::Passed { Ok(Ok(())) } else { Ok(Err(self.request_sense(desk)?)) }
    }

    /// Asks for the sense data (REQUEST SENSE).
    ///
    /// # Errors
    /// As [`BulkOnly::command`], or the answer is none.
    pub fn request_sense(&mut self, desk: &mut Desk<'_>) -> Result<Sense, UsbError> {
        let answer = self.transport.command(desk, self.lun, &[0x03, 0, 0, 0, 18, 0], Data::In(18))?;
        match answer.data.get(..14) {
            Some(data) if data[0] & 0x7F == 0x70 => {
                Ok(Sense { key: data[2] & 0xF, code: data[12], qualifier: data[13] })
            }
            _ => Err(UsbError::Wrong(format!("no sense: {:02x?}", answer.data))),
        }
    }

    /// Asks for the capacity, READ CAPACITY (10): blocks, and bytes of each.
    ///
    /// # Errors
    /// As [`Self::expect`].
    pub fn capacity(&mut self, desk: &mut Desk<'_>) -> Result<(u64, u32), UsbError> {
        let data = self.expect(desk, &[0x25, 0, 0, 0, 0, 0, 0, 0, 0, 0], Data::In(8))?.data;
        let &[b0, b1, b2, b3, s0, s1, s2, s3] = data.as_slice() else {
            return Err(UsbError::Wrong(format!("a capacity of {} bytes", data.len())));
        };
        let last = u32::from_be_bytes([b0, b1, b2, b3]);
        Ok((u64::from(last) + 1, u32::from_be_bytes([s0, s1, s2, s3])))
    }

    /// Reads blocks of 512 bytes, READ (10).
    ///
    /// # Errors
    /// As [`Self::expect`].
    pub fn read(&mut self, desk: &mut Desk<'_>, block: u32, count: u16) -> Result<Vec<u8>, UsbError> {
        let command = Self::transfer(0x28, block, count);
        self.expect(desk, &command, Data::In(usize::from(count) * 512)).map(|answer| answer.data)
    }

    /// Writes blocks of 512 bytes, WRITE (10).
    ///
    /// # Errors
    /// As [`Self::expect`].
    pub fn write(&mut self, desk: &mut Desk<'_>, block: u32, data: &[u8]) -> Result<(), UsbError> {
        let command = Self::transfer(0x2A, block, (data.len() / 512) as u16);
        self.expect(desk, &command, Data::Out(data)).map(drop)
    }

    const fn transfer(code: u8, block: u32, count: u16) -> [u8; 10] {
        let ([b0, b1, b2, b3], [c0, c1]) = (block.to_be_bytes(), count.to_be_bytes());
        [code, 0, b0, b1, b2, b3, 0, c0, c1, 0]
    }

    /// Asks with MODE SENSE (6) whether the medium is write-protected.
    ///
    /// # Errors
    /// As [`Self::expect`].
    pub fn is_protected(&mut self, desk: &mut Desk<'_>) -> Result<bool, UsbError> {
        let data = self.expect(desk, &[0x1A, 0, 0x3F, 0, 192, 0], Data::In(192))?.data;
        data.get(2).map(|parameter| parameter & 0x80 != 0).ok_or_else(|| UsbError::Wrong("no mode header".into()))
    }

    /// Ejects the medium, or loads it (START STOP UNIT with LOEJ).
    ///
    /// # Errors
    /// As [`Self::expect`].
    pub fn load(&mut self, desk: &mut Desk<'_>, load: bool) -> Result<(), UsbError> {
        self.expect(desk, &[0x1B, 0, 0, 0, 2 | u8::from(load), 0], Data::None).map(drop)
    }

    /// Prevents or allows the removal of the medium.
    ///
    /// # Errors
    /// As [`Self::expect`].
    pub fn prevent_removal(&mut self, desk: &mut Desk<'_>, prevent: bool) -> Result<(), UsbError> {
        self.expect(desk, &[0x1E, 0, 0, 0, u8::from(prevent), 0], Data::None).map(drop)
    }

    /// Flushes the drive's cache, SYNCHRONIZE CACHE (10).
    ///
    /// # Errors
    /// As [`Self::expect`].
    pub fn synchronize(&mut self, desk: &mut Desk<'_>) -> Result<(), UsbError> {
        self.expect(desk, &[0x35, 0, 0, 0, 0, 0, 0, 0, 0, 0], Data::None).map(drop)
    }
}
