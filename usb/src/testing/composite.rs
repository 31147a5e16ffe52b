//! The machine's device, connected to a simulated host.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use usb_device::bus::UsbBusAllocator;

use super::bus::Bus;
use super::card::Card;
use super::device::Device;
use super::host::Host;
use super::line::Memory;
use crate::{Composite, Detach, Functions, Guarded, SerialNumber};

/// Simulated machine, which decides whether the download may be entered.
#[derive(Clone, Default)]
pub struct Machine {
    /// Whether the machine moves or heats.
    pub is_busy: Arc<AtomicBool>,
    /// Number of requests to detach so far.
    pub asked: Arc<AtomicU32>,
}

impl Detach for Machine {
    fn detach(&mut self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed);
        !self.is_busy.load(Ordering::Relaxed)
    }
}

pub type Machines = Composite<'static, Guarded<Bus>, Memory, Card, Machine>;

impl Device for Machines {
    fn run(&mut self) {
        // Three runs are more than any transaction needs.
        for _ in 0..3 {
            let _more = Composite::run(self);
        }
    }
}

/// Optional functions of the device.
#[derive(Clone, Copy)]
pub struct Options {
    pub second: bool,
    pub disk: bool,
    pub download: bool,
}

impl Options {
    pub const ALL: Self = Self { second: true, disk: true, download: true };
}

/// Board that is connected to a host.
pub struct Board {
    pub host: Host<Machines>,
    pub lines: [Memory; 2],
    pub card: Card,
    pub machine: Machine,
}

impl Board {
    /// Connects a board without enumerating the device.
    pub fn new(options: Options) -> Self {
        let (bus, lines, card, machine) =
            (Bus::default(), [Memory::default(), Memory::default()], Card::new(64), Machine::default());
        let allocator = Box::leak(Box::new(UsbBusAllocator::new(Guarded::new(bus.clone()))));
        let serial = Box::leak(Box::new(SerialNumber::new([0x1234, 0xABCD, 0x5678_9ABC])));
        let [first, second] = lines.clone();
        let functions = Functions {
            first,
            second: options.second.then_some(second),
            disk: options.disk.then(|| card.clone()),
            detach: options.download.then(|| machine.clone()),
        };
        let device = Composite::new(allocator, |bus, endpoint| bus.bus().held(endpoint), serial, functions)
            .expect("the bus has the endpoints");
        Self { host: Host::new(bus, device), lines, card, machine }
    }

    /// Connects and enumerates a board with every function.
    pub fn enumerated() -> Self {
        let mut board = Self::new(Options::ALL);
        board.host.enumerate();
        board
    }
}
