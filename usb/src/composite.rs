//! The machine as a device: every function in one configuration.

use heapless::Vec;
use usb_device::Result;
use usb_device::UsbError;
use usb_device::class_prelude::{UsbBus, UsbBusAllocator, UsbClass};
use usb_device::device::{StringDescriptors, UsbDevice, UsbDeviceBuilder, UsbDeviceState, UsbRev, UsbVidPid};
use usb_device::endpoint::EndpointAddress;

use crate::cdc::{Line, Numbers, SerialPort};
use crate::dfu::{Detach, DfuRuntime};
use crate::identity::{MANUFACTURER, MILLIAMPERES, PRODUCT, PRODUCT_NAME, RELEASE, SerialNumber, VENDOR};
use crate::microsoft::MicrosoftOs;
use crate::standard::Standard;
use crate::storage::{MassStorage, Medium};

/// Names of the functions, which computers show.
const FIRST_PORT: &str = "Velvet console";
const SECOND_PORT: &str = "Velvet second console";
const DISK: &str = "Velvet SD card";
const DOWNLOAD: &str = "Velvet firmware download";

/// Capacity for all functions and the handlers before them.
const MAX_CLASSES: usize = 8;

/// Function that returns the number of the host's packets that the controller holds at an endpoint,
/// acknowledged but not fetched. Called between two polls of the bus.
pub type Held<B> = fn(&B, EndpointAddress) -> usize;

/// Connections of the functions; a function without a connection is left out.
pub struct Functions<L, M, D> {
    /// First serial port, which is always there.
    pub first: L,
    /// Second serial port, if any.
    pub second: Option<L>,
    /// Medium of the disk.
    pub disk: Option<M>,
    /// Machine's handler for entering the firmware download.
    pub detach: Option<D>,
}

/// Relation of the device to its host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// No host, as far as the silent bus tells.
    Silent,
    /// Host that has not configured the device.
    Attached,
    /// Host that uses the device.
    Configured,
}

/// Starts to build a device: class and identity that all our devices share. Endpoint 0 takes packets of 64
/// bytes. USB 2.1 announces a BOS descriptor (link power management ECN of USB 2.0), which Windows needs.
pub(crate) fn builder<'a, B: UsbBus>(
    bus: &'a UsbBusAllocator<B>,
    name: &'a str,
    serial: &'a SerialNumber,
    revision: UsbRev,
) -> Result<UsbDeviceBuilder<'a, B>> {
    let strings = StringDescriptors::default().manufacturer(MANUFACTURER).product(name).serial_number(serial.as_str());
    let builder = UsbDeviceBuilder::new(bus, UsbVidPid(VENDOR, PRODUCT));
    let builder = builder.max_packet_size_0(crate::PACKET_BYTES as u8).map_err(|_| UsbError::Unsupported)?;
    let builder = builder.max_power(MILLIAMPERES).map_err(|_| UsbError::Unsupported)?;
    let builder = builder.strings(&[strings]).map_err(|_| UsbError::Unsupported)?;
    Ok(builder.device_release(RELEASE).self_powered(true).usb_rev(revision))
}

/// Enables the bus, so that nothing can be added any more.
pub(crate) fn finish<B: UsbBus>(builder: UsbDeviceBuilder<'_, B>) -> UsbDevice<'_, B> {
    let mut device = builder.build();
    // GET_STATUS needs the flag set here; the builder sets it in the descriptor only.
    device.set_self_powered(true);
    device
}

/// The machine's device with all its functions.
pub struct Composite<'a, B: UsbBus, L, M, D> {
    device: UsbDevice<'a, B>,
    held: Held<B>,
    standard: Standard,
    microsoft: Option<MicrosoftOs>,
    first: SerialPort<'a, B, L>,
    second: Option<SerialPort<'a, B, L>>,
    disk: Option<MassStorage<'a, B, M>>,
    runtime: Option<DfuRuntime<D>>,
}

impl<'a, B: UsbBus, L: Line, M: Medium, D: Detach> Composite<'a, B, L, M, D> {
    /// Connects to the bus. `serial`: [`SerialNumber::new`]. `held`: reports packets that the controller
    /// holds.
    ///
    /// # Errors
    /// When the bus lacks the endpoints.
    pub fn new(
        bus: &'a UsbBusAllocator<B>,
        held: Held<B>,
        serial: &'a SerialNumber,
        functions: Functions<L, M, D>,
    ) -> Result<Self> {
        let Functions { first, second, disk, detach } = functions;
        let first = SerialPort::new(bus, Numbers::FIRST, FIRST_PORT, first)?;
        let second = second.map(|line| SerialPort::new(bus, Numbers::SECOND, SECOND_PORT, line)).transpose()?;
        let disk = disk.map(|medium| MassStorage::new(bus, DISK, serial.clone(), medium)).transpose()?;
        let runtime = detach.map(|machine| DfuRuntime::new(bus, DOWNLOAD, machine));
        let microsoft = runtime.as_ref().map(|runtime| MicrosoftOs::for_function(runtime.interface()));
        let mut standard = Standard::default();
        standard.add(2, 1 << 1, 1 << 1 | 1 << 2);
        if second.is_some() {
            standard.add(2, 1 << 2, 1 << 3 | 1 << 4);
        }
        if disk.is_some() {
            standard.add(1, 1 << 3, 1 << 5);
        }
        if runtime.is_some() {
            standard.add(1, 0, 0);
        }
        let revision = if microsoft.is_some() { UsbRev::Usb210 } else { UsbRev::Usb200 };
        let device = finish(builder(bus, PRODUCT_NAME, serial, revision)?.composite_with_iads());
        Ok(Self { device, held, standard, microsoft, first, second, disk, runtime })
    }

    /// Handles one event of the bus and moves data as far as possible, in a bounded piece of work. Call after
    /// each interrupt of the controller, and when lines have room or bytes, or the medium has finished.
    /// Returns true when work remains that no event will announce, so that another call is needed.
    pub fn run(&mut self) -> bool {
        self.poll();
        let suspended = self.device.state() == UsbDeviceState::Suspend;
        let mut has_more = false;
        for port in [Some(&mut self.first), self.second.as_mut()].into_iter().flatten() {
            port.set_suspended(suspended);
            has_more |= port.run((self.held)(self.device.bus(), port.from_host()));
        }
        self.disk.as_mut().is_some_and(MassStorage::run) || has_more
    }

    fn poll(&mut self) {
        let Self { device, standard, microsoft, first, second, disk, runtime, .. } = self;
        let mut classes: Vec<&mut dyn UsbClass<B>, MAX_CLASSES> = Vec::new();
        // The list has room for all classes.
        let _fits = classes.push(standard);
        let _fits = classes.push(first);
        let _fits = second.as_mut().map(|second| classes.push(second));
        let _fits = disk.as_mut().map(|disk| classes.push(disk));
        let _fits = runtime.as_mut().map(|runtime| classes.push(runtime));
        let _fits = microsoft.as_mut().map(|microsoft| classes.push(microsoft));
        device.poll(&mut classes);
    }

    /// Returns whether there is a host.
    pub fn presence(&self) -> Presence {
        match self.device.state() {
            UsbDeviceState::Suspend => Presence::Silent,
            UsbDeviceState::Configured => Presence::Configured,
            _ => Presence::Attached,
        }
    }

    /// Returns the first serial port.
    pub const fn first(&mut self) -> &mut SerialPort<'a, B, L> {
        &mut self.first
    }

    /// Returns the second serial port.
    pub const fn second(&mut self) -> Option<&mut SerialPort<'a, B, L>> {
        self.second.as_mut()
    }

    /// Returns the disk function.
    pub const fn disk(&mut self) -> Option<&mut MassStorage<'a, B, M>> {
        self.disk.as_mut()
    }
}
