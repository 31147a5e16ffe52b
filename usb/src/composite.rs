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

/// What the functions are called; computers show these names.
const FIRST_PORT: &str = "Velvet console";
const SECOND_PORT: &str = "Velvet second console";
const DISK: &str = "Velvet SD card";
const DOWNLOAD: &str = "Velvet firmware download";

/// More than all functions and what stands before them.
const MAX_CLASSES: usize = 8;

/// How many packets of the host the controller holds at an endpoint, acknowledged and not fetched. Between
/// two looks at the bus.
pub type Held<B> = fn(&B, EndpointAddress) -> usize;

/// What the functions are connected to; without, there is no such function.
pub struct Functions<L, M, D> {
    /// The first serial port, which is always there.
    pub first: L,
    /// The second serial port.
    pub second: Option<L>,
    /// The disk.
    pub disk: Option<M>,
    /// The way into the firmware download.
    pub detach: Option<D>,
}

/// How the device stands with its host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// There is none, as far as can be seen: it says nothing.
    Silent,
    /// There is one, which has not configured the device.
    Attached,
    /// It uses the device.
    Configured,
}

/// A device in the making: class and identity that all of ours share. Endpoint 0 takes packets of 64 bytes.
/// USB 2.1 means that there is a BOS descriptor (link power management ECN of USB 2.0), which is there for
/// Windows.
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

/// Enables the bus. Nothing can be added behind this.
pub(crate) fn finish<B: UsbBus>(builder: UsbDeviceBuilder<'_, B>) -> UsbDevice<'_, B> {
    let mut device = builder.build();
    // What GET_STATUS says; the descriptor alone has it from the builder.
    device.set_self_powered(true);
    device
}

/// The device.
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
    /// Connects to the bus. `serial`: [`SerialNumber::new`]. `held`: what the bus tells of itself.
    ///
    /// # Errors
    /// The bus does not have the endpoints.
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

    /// Handles one event of the bus, and moves what can be moved: whenever the controller interrupts, the
    /// lines have got room or bytes, or the medium has ended what it did. A bounded piece of work. True when
    /// some is left that nothing will announce: then it is to be called again.
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
        // There is room for all.
        let _fits = classes.push(standard);
        let _fits = classes.push(first);
        let _fits = second.as_mut().map(|second| classes.push(second));
        let _fits = disk.as_mut().map(|disk| classes.push(disk));
        let _fits = runtime.as_mut().map(|runtime| classes.push(runtime));
        let _fits = microsoft.as_mut().map(|microsoft| classes.push(microsoft));
        device.poll(&mut classes);
    }

    /// Whether there is a host.
    pub fn presence(&self) -> Presence {
        match self.device.state() {
            UsbDeviceState::Suspend => Presence::Silent,
            UsbDeviceState::Configured => Presence::Configured,
            _ => Presence::Attached,
        }
    }

    /// The first serial port.
    pub const fn first(&mut self) -> &mut SerialPort<'a, B, L> {
        &mut self.first
    }

    /// The second serial port.
    pub const fn second(&mut self) -> Option<&mut SerialPort<'a, B, L>> {
        self.second.as_mut()
    }

    /// The disk.
    pub const fn disk(&mut self) -> Option<&mut MassStorage<'a, B, M>> {
        self.disk.as_mut()
    }
}
