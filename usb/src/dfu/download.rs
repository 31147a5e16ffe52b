//! The firmware download: the boot stage as a USB device.

use usb_device::Result;
use usb_device::bus::{InterfaceNumber, StringIndex};
use usb_device::class_prelude::{ControlIn, ControlOut, DescriptorWriter, UsbBus, UsbBusAllocator, UsbClass};
use usb_device::control::{Recipient, Request, RequestType};
use usb_device::descriptor::lang_id::LangID;
use usb_device::device::{DEFAULT_ALTERNATE_SETTING, UsbDevice, UsbDeviceState, UsbRev};

use super::protocol::{
    CLASS, FUNCTIONAL, NO_COPY, PROTOCOL_DOWNLOAD, Refused, SUBCLASS, State, TRANSFER_BYTES, functional, request,
    status,
};
use crate::composite;
use crate::identity::{DOWNLOAD_NAME, SerialNumber};
use crate::microsoft::MicrosoftOs;
use crate::standard::Standard;

/// Name of the only writable memory, for the host.
const MEMORY_NAME: &str = "Firmware image (make firmware)";

/// Destination of firmware. Methods may block for as long as the `_ms` methods say.
pub trait Firmware {
    /// Writes the next piece, of [`TRANSFER_BYTES`] at most; position 0 begins anew.
    ///
    /// # Errors
    /// When the piece is refused.
    fn write(&mut self, at: u32, piece: &[u8]) -> core::result::Result<(), Refused>;

    /// Returns the longest time for writing this piece, ms.
    fn write_ms(&self, at: u32, bytes: usize) -> u32;

    /// Checks the complete firmware.
    ///
    /// # Errors
    /// When the firmware is not good.
    fn finish(&mut self) -> core::result::Result<(), Refused>;

    /// Returns the longest time for the check, ms.
    fn finish_ms(&self) -> u32;

    /// Reads back the firmware; fewer bytes than asked for are the last ones.
    ///
    /// # Errors
    /// When there is nothing to read.
    fn read(&mut self, at: u32, into: &mut [u8]) -> core::result::Result<usize, Refused>;
}

/// Progress of work that starts as soon as the host has been told to wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Work {
    None,
    /// The answer to the host is being prepared.
    Answering,
    /// The controller holds the answer to the host.
    Announced,
    /// The host has received the answer.
    Due,
}

/// DFU interface in download mode.
struct Download<F> {
    interface: InterfaceNumber,
    name: StringIndex,
    no_copy: StringIndex,
    firmware: F,
    state: State,
    refused: Option<Refused>,
    work: Work,
    block: heapless::Vec<u8, { TRANSFER_BYTES as usize }>,
    /// Offset of the next byte to write or read.
    at: u32,
    /// Number of the next block.
    number: u16,
    /// Whether the bus was reset with the firmware complete.
    is_left: bool,
}

impl<F: Firmware> Download<F> {
    fn new<B: UsbBus>(bus: &UsbBusAllocator<B>, firmware: F) -> Self {
        Self {
            interface: bus.interface(),
            name: bus.string(),
            no_copy: bus.string(),
            firmware,
            state: State::Idle,
            refused: None,
            work: Work::None,
            block: heapless::Vec::new(),
            at: 0,
            number: 0,
            is_left: false,
        }
    }

    fn is_for_us(&self, request: &Request) -> bool {
        request.request_type == RequestType::Class
            && request.recipient == Recipient::Interface
            && request.index == u16::from(u8::from(self.interface))
    }

    fn refuse(&mut self, why: Refused) {
        self.state = State::Error;
        self.refused = Some(why);
        self.work = Work::None;
    }

    fn idle(&mut self) {
        self.state = State::Idle;
        self.refused = None;
        self.work = Work::None;
        self.block.clear();
        (self.at, self.number) = (0, 0);
    }

    /// DNLOAD: takes a block; returns false when the state does not permit it.
    fn download(&mut self, number: u16, piece: &[u8]) -> bool {
        match (self.state, piece.is_empty()) {
            (State::Idle, false) => (self.at, self.number) = (0, number),
            (State::DownloadIdle, false) if number == self.number => {}
            (State::DownloadIdle, true) => {
                self.state = State::ManifestSync;
                return true;
            }
            _ => return false,
        }
        self.block.clear();
        // Requests are never longer than the block's capacity.
        let _fits = self.block.extend_from_slice(piece);
        self.number = number.wrapping_add(1);
        self.state = State::DownloadSync;
        true
    }

    /// GETSTATUS: returns the status and begins the work announced by it.
    fn status(&mut self) -> [u8; 6] {
        let poll_ms = match self.state {
            State::DownloadSync | State::DownloadBusy => {
                self.state = State::DownloadBusy;
                self.announce();
                self.firmware.write_ms(self.at, self.block.len())
            }
            State::ManifestSync | State::Manifest => {
                self.state = State::Manifest;
                self.announce();
                self.firmware.finish_ms()
            }
            _ => 0,
        };
        status(self.refused, poll_ms, self.state, self.no_copy.into())
    }

    fn announce(&mut self) {
        if self.work == Work::None {
            self.work = Work::Answering;
        }
    }

    /// UPLOAD: returns the number of bytes read; `None` when the state does not permit it.
    fn upload(&mut self, into: &mut [u8]) -> Option<usize> {
        if !matches!(self.state, State::Idle | State::UploadIdle) {
            return None;
        }
        if self.state == State::Idle {
            self.at = 0;
        }
        match self.firmware.read(self.at, into) {
            Ok(count) => {
                self.at += count as u32;
                self.state = if count == into.len() { State::UploadIdle } else { State::Idle };
                Some(count)
            }
            Err(why) => {
                self.refuse(why);
                None
            }
        }
    }

    fn work(&mut self) {
        if self.work != Work::Due {
            return;
        }
        self.work = Work::None;
        let done = match self.state {
            State::DownloadBusy => self.firmware.write(self.at, &self.block).map(|()| State::DownloadIdle),
            State::Manifest => self.firmware.finish().map(|()| State::ManifestWaitReset),
            other => Ok(other),
        };
        match done {
            Ok(state) => {
                self.at += self.block.len() as u32;
                self.block.clear();
                self.state = state;
            }
            Err(why) => self.refuse(why),
        }
    }
}

impl<B: UsbBus, F: Firmware> UsbClass<B> for Download<F> {
    fn get_configuration_descriptors(&self, writer: &mut DescriptorWriter<'_>) -> Result<()> {
        let (interface, name) = (self.interface, Some(self.name));
        writer.interface_alt(interface, DEFAULT_ALTERNATE_SETTING, CLASS, SUBCLASS, PROTOCOL_DOWNLOAD, name)?;
        writer.write(FUNCTIONAL, &functional())
    }

    fn get_string(&self, index: StringIndex, _: LangID) -> Option<&str> {
        match index {
            index if index == self.name => Some(MEMORY_NAME),
            index if index == self.no_copy => Some(NO_COPY),
            _ => None,
        }
    }

    fn reset(&mut self) {
        self.is_left |= self.state == State::ManifestWaitReset;
        self.idle();
    }

    fn poll(&mut self) {
        // Called after each event: after the request itself, and when its answer has been sent.
        self.work = match self.work {
            Work::Answering => Work::Announced,
            Work::Announced => Work::Due,
            work => work,
        };
    }

    fn control_in(&mut self, transfer: ControlIn<'_, '_, '_, B>) {
        let request = *transfer.request();
        if !self.is_for_us(&request) {
            return;
        }
        // The transfer waits for an answer, and these fit its buffer.
        let _ = match request.request {
            request::GETSTATUS => {
                let status = self.status();
                transfer.accept_with(&status)
            }
            request::GETSTATE => transfer.accept_with(&[self.state as u8]),
            request::UPLOAD => {
                let mut bytes = [0; TRANSFER_BYTES as usize];
                let wanted = bytes.get_mut(..request.length.into()).filter(|wanted| !wanted.is_empty());
                match wanted.and_then(|wanted| self.upload(wanted)) {
                    Some(count) => transfer.accept_with(bytes.get(..count).unwrap_or_default()),
                    None => {
                        self.refused.is_none().then(|| self.refuse(Refused::StalledRequest));
                        transfer.reject()
                    }
                }
            }
            _ => transfer.reject(),
        };
    }

    fn control_out(&mut self, transfer: ControlOut<'_, '_, '_, B>) {
        let request = *transfer.request();
        if !self.is_for_us(&request) {
            return;
        }
        let is_idle = matches!(
            self.state,
            State::Idle | State::DownloadSync | State::DownloadIdle | State::ManifestSync | State::UploadIdle
        );
        let accepted = match request.request {
            request::DNLOAD => self.download(request.value, transfer.data()),
            request::ABORT if is_idle => {
                self.idle();
                true
            }
            request::CLRSTATUS if self.state == State::Error => {
                self.idle();
                true
            }
            _ => false,
        };
        if accepted {
            // The transfer waits for an answer, so accepting cannot fail.
            let _ = transfer.accept();
        } else {
            self.refuse(Refused::StalledRequest);
            let _ = transfer.reject();
        }
    }
}

/// The boot stage as a device, with the download as its only function.
pub struct DownloadDevice<'a, B: UsbBus, F> {
    device: UsbDevice<'a, B>,
    standard: Standard,
    microsoft: MicrosoftOs,
    download: Download<F>,
}

impl<'a, B: UsbBus, F: Firmware> DownloadDevice<'a, B, F> {
    /// Connects to the bus. `serial`: [`SerialNumber::for_download`].
    ///
    /// # Errors
    /// When the bus lacks the resources.
    pub fn new(bus: &'a UsbBusAllocator<B>, serial: &'a SerialNumber, firmware: F) -> Result<Self> {
        let download = Download::new(bus, firmware);
        let device = composite::builder(bus, DOWNLOAD_NAME, serial, UsbRev::Usb210)?;
        let mut standard = Standard::default();
        standard.add(1, 0, 0);
        Ok(Self { device: composite::finish(device), standard, microsoft: MicrosoftOs::for_device(), download })
    }

    /// Handles one event of the bus. Call after each interrupt of the controller, or continuously.
    pub fn run(&mut self) {
        self.device.poll(&mut [&mut self.standard, &mut self.microsoft, &mut self.download]);
    }

    /// Erases and writes as announced to the host. Call between two runs, in a context that may block for so
    /// long.
    pub fn work(&mut self) {
        self.download.work();
    }

    /// Whether the host has handed over good firmware and wants it started.
    pub const fn is_left(&self) -> bool {
        self.download.is_left
    }

    /// Whether a host is downloading or reading firmware, so that the boot stage must not be left.
    pub fn is_in_use(&self) -> bool {
        self.is_addressed() && !matches!(self.download.state, State::Idle | State::Error | State::ManifestWaitReset)
    }

    /// Whether a host is present: the device has an address, and the bus is active.
    pub fn is_addressed(&self) -> bool {
        matches!(self.device.state(), UsbDeviceState::Addressed | UsbDeviceState::Configured)
    }

    /// Whether the firmware is complete and good, so that a missing reset of the bus need not be waited for.
    pub fn is_whole(&self) -> bool {
        self.download.state == State::ManifestWaitReset
    }

    /// Returns the destination of the firmware.
    pub const fn firmware(&mut self) -> &mut F {
        &mut self.download.firmware
    }
}
