//! A serial port as a host sees it: the communications class, abstract control model (CDC 1.2, PSTN 1.2).

use super::{Desk, Device, UsbError};
use usb_host::descriptors::{BULK, INTERRUPT};
use usb_host::request::{CLASS_IN, CLASS_OUT};
use usb_host::transfer::{Direction, Endpoint, Request, TransferId};

const SET_LINE_CODING: u8 = 0x20;
const GET_LINE_CODING: u8 = 0x21;
const SET_CONTROL_LINE_STATE: u8 = 0x22;
/// Notifications of the communications interface.
const SERIAL_STATE: u8 = 0x20;

/// Rate and format of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineCoding {
    /// Bit rate in bits per second.
    pub rate: u32,
    /// Stop bits: 0 is one, 1 one and a half, 2 two.
    pub stop: u8,
    /// Parity: 0 is none, 1 odd, 2 even, 3 mark, 4 space.
    pub parity: u8,
    /// Data bits, 5 to 8, or 16.
    pub bits: u8,
}

/// A serial port of a device.
#[derive(Clone, Copy, Debug)]
pub struct Serial {
    /// Number of the communications interface.
    pub interface: u8,
    /// Bulk IN endpoint, from the device.
    pub input: Endpoint,
    /// Bulk OUT endpoint, to the device.
    pub output: Endpoint,
    /// Interrupt endpoint for notifications.
    pub notify: Option<Endpoint>,
}

impl Serial {
    /// Finds the serial ports of a device, in order. The data interface is the one that the union descriptor
    /// names.
    #[must_use]
    pub fn all(device: &Device) -> Vec<Self> {
        let port = |control: &usb_host::descriptors::Interface| {
            let union = control.extra.iter().find(|extra| extra.get(1..3) == Some(&[0x24, 6]))?;
            let data = device.configuration.interface(*union.get(4)?)?;
            let of = |direction| data.endpoint(direction, BULK).map(|endpoint| endpoint.of(device.address));
            let notify = control.endpoint(Direction::In, INTERRUPT).map(|endpoint| endpoint.of(device.address));
            Some(Self { interface: control.number, input: of(Direction::In)?, output: of(Direction::Out)?, notify })
        };
        device.configuration.of_class(2, 2).filter_map(port).collect()
    }

    /// Sets rate and format.
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn set_line_coding(&self, desk: &mut Desk<'_>, line: LineCoding) -> Result<(), UsbError> {
        let mut bytes = line.rate.to_le_bytes().to_vec();
        bytes.extend([line.stop, line.parity, line.bits]);
        desk.tell(CLASS_OUT, SET_LINE_CODING, 0, u16::from(self.interface), &bytes)
    }

    /// Asks for rate and format of the line.
    ///
    /// # Errors
    /// As [`Desk::control`], or the answer is none.
    pub fn line_coding(&self, desk: &mut Desk<'_>) -> Result<LineCoding, UsbError> {
        let bytes = desk.ask(CLASS_IN, GET_LINE_CODING, 0, u16::from(self.interface), 7)?;
        let &[r0, r1, r2, r3, stop, parity, bits] = bytes.as_slice() else {
            return Err(UsbError::Wrong(format!("a line coding of {} bytes", bytes.len())));
        };
        Ok(LineCoding { rate: u32::from_le_bytes([r0, r1, r2, r3]), stop, parity, bits })
    }

    /// Sets DTR and RTS: a program has opened the port, or closed it.
    ///
    /// # Errors
    /// As [`Desk::control`].
    pub fn set_lines(&self, desk: &mut Desk<'_>, dtr: bool, rts: bool) -> Result<(), UsbError> {
        let value = u16::from(dtr) | u16::from(rts) << 1;
        desk.tell(CLASS_OUT, SET_CONTROL_LINE_STATE, value, u16::from(self.interface), &[])
    }

    /// Sends bytes and waits until the device has all of them.
    ///
    /// # Errors
    /// As [`Desk::write`].
    pub fn write(&self, desk: &mut Desk<'_>, bytes: &[u8]) -> Result<(), UsbError> {
        desk.write(self.output, bytes)
    }

    /// Submits a read of the device's next bytes.
    pub fn listen(&self, desk: &mut Desk<'_>, most: usize) -> Option<TransferId> {
        desk.submit(self.input, Request::In(most))
    }

    /// Reads until so many bytes have come.
    ///
    /// # Errors
    /// As [`Desk::read`].
    pub fn read_exact(&self, desk: &mut Desk<'_>, count: usize) -> Result<Vec<u8>, UsbError> {
        let mut all = Vec::new();
        while all.len() < count {
            all.extend(desk.read(self.input, 512)?);
        }
        Ok(all)
    }

    /// Reads until `words` have come. Returns everything up to there, and any bytes that came with it.
    ///
    /// # Errors
    /// As [`Desk::read`].
    pub fn read_until(&self, desk: &mut Desk<'_>, words: &[u8]) -> Result<Vec<u8>, UsbError> {
        let mut all: Vec<u8> = Vec::new();
        while !all.windows(words.len()).any(|part| part == words) {
            all.extend(desk.read(self.input, 512)?);
        }
        Ok(all)
    }

    /// Waits for the state of the lines (PSTN 1.2, 6.5.4).
    ///
    /// # Errors
    /// As [`Desk::read`], or it is another notification.
    pub fn serial_state(&self, desk: &mut Desk<'_>) -> Result<u16, UsbError> {
        let notify = self.notify.ok_or_else(|| UsbError::Wrong("no notifications".into()))?;
        let bytes = desk.read(notify, 16)?;
        match bytes.as_slice() {
            &[CLASS_IN, SERIAL_STATE, 0, 0, _, 0, 2, 0, s0, s1] => Ok(u16::from_le_bytes([s0, s1])),
            other => Err(UsbError::Wrong(format!("a notification {other:02x?}"))),
        }
    }
}
