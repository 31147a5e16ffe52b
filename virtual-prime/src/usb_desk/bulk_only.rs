//! A drive as a host sees it: mass storage, bulk-only transport 1.0.

use super::{Desk, Device, UsbError};
use usb_host::descriptors::BULK;
use usb_host::request::{CLASS_IN, CLASS_OUT};
use usb_host::transfer::{Direction, Endpoint, Outcome};

const GET_MAX_LUN: u8 = 0xFE;
const RESET: u8 = 0xFF;
const WRAPPER_BYTES: usize = 31;
const STATUS_BYTES: usize = 13;

/// Data phase of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Data<'a> {
    /// The command has no data phase.
    None,
    /// Data from the drive, up to so many bytes.
    In(usize),
    /// Data for the drive.
    Out(&'a [u8]),
}

/// Result of a command, bCSWStatus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The command was carried out.
    Passed,
    /// The command failed; REQUEST SENSE gives the reason.
    Failed,
    /// Host and drive are out of step (phase error).
    PhaseError,
}

/// Result of a command, with its data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Status from the status wrapper.
    pub status: Status,
    /// Bytes not moved, dCSWDataResidue.
    pub residue: u32,
    /// Data from the drive.
    pub data: Vec<u8>,
    /// Whether an endpoint was halted in between.
    pub halted: bool,
}

/// A drive of a device.
#[derive(Clone, Copy, Debug)]
pub struct BulkOnly {
    /// Number of the interface.
    pub interface: u8,
    /// Bulk IN endpoint, from the drive.
    pub input: Endpoint,
    /// Bulk OUT endpoint, to the drive.
    pub output: Endpoint,
    tag: u32,
}

impl BulkOnly {
    /// Finds the device's drive: SCSI commands over bulk-only transport.
    #[must_use]
    pub fn of(device: &Device) -> Option<Self> {
        let transport = device.configuration.interfaces.iter().find(|interface| interface.class == [8, 6, 0x50])?;
        let of = |direction| transport.endpoint(direction, BULK).map(|endpoint| endpoint.of(device.address));
        Some(Self { interface: transport.number, input: of(Direction::In)?, output: of(Direction::Out)?, tag: 0 })
    }

    /// Asks for the number of the last logical unit.
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn max_lun(&self, desk: &mut Desk<'_>) -> Result<u8, UsbError> {
        let answer = desk.ask(CLASS_IN, GET_MAX_LUN, 0, u16::from(self.interface), 1)?;
        answer.first().copied().ok_or_else(|| UsbError::Wrong("no number of units".into()))
    }

    /// Carries out reset recovery (section 5.3.4): the class's reset, and both halts cleared.
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn recover(&self, desk: &mut Desk<'_>) -> Result<(), UsbError> {
        desk.tell(CLASS_OUT, RESET, 0, u16::from(self.interface), &[])?;
        desk.clear_halt(self.input)?;
        desk.clear_halt(self.output)
    }

    /// Builds the command wrapper of a command block.
    #[must_use]
    pub fn wrapper(tag: u32, lun: u8, command: &[u8], data: Data<'_>) -> Vec<u8> {
        let (length, flags) = match data {
            Data::None => (0, 0),
            Data::In(length) => (length, 0x80),
            Data::Out(bytes) => (bytes.len(), 0),
        };
        let mut wrapper = b"USBC".to_vec();
        wrapper.extend(tag.to_le_bytes());
        wrapper.extend((length as u32).to_le_bytes());
        wrapper.extend([flags, lun, command.len() as u8]);
        wrapper.extend(command);
        wrapper.resize(WRAPPER_BYTES, 0);
        wrapper
    }

    /// Carries out a command block, with all three phases.
    ///
    /// # Errors
    /// A transfer ended otherwise than the transport allows, or the status is not one.
    pub fn command(
        &mut self,
        desk: &mut Desk<'_>,
        lun: u8,
        command: &[u8],
        data: Data<'_>,
    ) -> Result<Answer, UsbError> {
        self.tag = self.tag.wrapping_add(1);
        desk.write(self.output, &Self::wrapper(self.tag, lun, command, data))?;
        let mut halted = false;
        let mut came = Vec::new();
        match data {
            Data::None => {}
            Data::In(length) => match desk.read(self.input, length) {
                Ok(bytes) => came = bytes,
                Err(UsbError::Ended(Outcome::Stalled, bytes)) => {
                    (came, halted) = (bytes, true);
                    desk.clear_halt(self.input)?;
                }
                Err(other) => return Err(other),
            },
            Data::Out(bytes) => match desk.write(self.output, bytes) {
                Ok(()) => {}
                Err(error) if error.is_stall() => {
                    halted = true;
                    desk.clear_halt(self.output)?;
                }
                Err(other) => return Err(other),
            },
        }
        let (status, residue) = self.status(desk)?;
        Ok(Answer { status, residue, data: came, halted })
    }

    /// Reads the status wrapper; a halt before it is cleared, once (figure 2 of the transport).
    ///
    /// # Errors
    /// As [`Self::command`].
    pub fn status(&self, desk: &mut Desk<'_>) -> Result<(Status, u32), UsbError> {
        let bytes = match desk.read(self.input, STATUS_BYTES) {
            Err(error) if error.is_stall() => {
                desk.clear_halt(self.input)?;
                desk.read(self.input, STATUS_BYTES)?
            }
            other => other?,
        };
        let wrong = || UsbError::Wrong(format!("a command status {bytes:02x?} for tag {}", self.tag));
        let fields: [u8; STATUS_BYTES] = bytes.as_slice().try_into().map_err(|_| wrong())?;
        let word =
            |place: usize| u32::from_le_bytes([fields[place], fields[place + 1], fields[place + 2], fields[place + 3]]);
        if &fields[..4] != b"USBS" || word(4) != self.tag {
            return Err(wrong());
        }
        let status = match fields[12] {
            0 => Status::Passed,
            1 => Status::Failed,
            2 => Status::PhaseError,
            _ => return Err(wrong()),
        };
        Ok((status, word(8)))
    }
}
