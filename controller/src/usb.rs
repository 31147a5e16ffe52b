//! The board as a USB device for the host: one serial port, and the way into the firmware download.
//!
//! The device belongs to the interrupt of its controller; idle leaves bytes in a ring, or takes them out of
//! one, and has the interrupt's task run.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use bsp_prime::byte_ring::ByteRing;
use bsp_prime::usb::{OtgBus, UsbError, UsbSocket};
use usb::{
    Composite, Detach, Fault, Functions, Guarded, Half, Line, Medium, Progress, SerialNumber, State, UsbBusAllocator,
};

use crate::{update, wake};

/// Size of the ring from the host, bytes: more than it sends without an answer.
const FROM_HOST_BYTES: usize = 2048;
/// Size of the ring to the host, bytes: several times what answers take between two turns of idle.
const TO_HOST_BYTES: usize = 4096;

static FROM_HOST: ByteRing<FROM_HOST_BYTES> = ByteRing::new();
static TO_HOST: ByteRing<TO_HOST_BYTES> = ByteRing::new();
/// Whether a program has opened the port.
static IS_OPEN: AtomicBool = AtomicBool::new(false);
/// Whether the port has found no room for a packet, and must be told of new room.
static WAITS_FOR_ROOM: AtomicBool = AtomicBool::new(false);

type Bus = Guarded<OtgBus>;

/// USB device with all its functions.
pub type Device = Composite<'static, Bus, HostLine, NoDisk, Download>;

/// Memory of the device and what it refers to.
pub struct Place {
    bus: MaybeUninit<UsbBusAllocator<Bus>>,
    serial: MaybeUninit<SerialNumber>,
    device: MaybeUninit<Device>,
}

impl Place {
    /// Memory that holds nothing yet.
    pub const fn new() -> Self {
        Self { bus: MaybeUninit::uninit(), serial: MaybeUninit::uninit(), device: MaybeUninit::uninit() }
    }
}

/// Builds the device and connects it.
///
/// # Errors
/// The socket does not work.
pub fn connect(
    place: &'static mut Place,
    socket: UsbSocket,
    unique_id: [u32; 3],
) -> Result<&'static mut Device, &'static str> {
    let controller = socket.start().map_err(words)?;
    let Place { bus, serial, device } = place;
    let bus: &'static _ = bus.write(UsbBusAllocator::new(Guarded::new(controller)));
    let serial: &'static _ = serial.write(SerialNumber::new(unique_id));
    let functions = Functions { first: HostLine, second: None, disk: None, detach: Some(Download) };
    let built = Composite::new(bus, |bus, endpoint| bus.bus().held(endpoint), serial, functions);
    let device = device.write(built.map_err(|_| "the controller has no room for its endpoints")?);
    bsp_prime::usb::connect();
    Ok(device)
}

const fn words(error: UsbError) -> &'static str {
    match error {
        UsbError::NoSupply => "its 3.3 V are missing, check the board",
        UsbError::NoClock => "PLL3 does not make its 48 MHz, check the crystal",
        UsbError::NotReady => "its controller does not come out of reset, reset the board",
    }
}

/// Handles the interrupt: one event of the bus, and a few packets.
pub fn on_interrupt(device: &mut Device) {
    if device.run() {
        bsp_prime::usb::wake();
    }
}

/// Returns the ring of the host's bytes.
pub const fn from_host() -> &'static ByteRing<FROM_HOST_BYTES> {
    &FROM_HOST
}

/// Fetches a packet that has waited for room, if there is some now. Called when bytes have been taken.
pub fn look_for_room() {
    if WAITS_FOR_ROOM.load(Ordering::Relaxed) && FROM_HOST.room() >= usb::PACKET_BYTES {
        WAITS_FOR_ROOM.store(false, Ordering::Relaxed);
        bsp_prime::usb::wake();
    }
}

/// Returns how many bytes a write takes: any number, for nobody, while no program has opened the port.
pub fn room() -> usize {
    if IS_OPEN.load(Ordering::Relaxed) { TO_HOST.room() } else { usize::MAX }
}

/// Sends bytes to the host.
pub fn write(bytes: &[u8]) {
    if IS_OPEN.load(Ordering::Relaxed) && TO_HOST.push_some(bytes) > 0 {
        bsp_prime::usb::wake();
    }
}

/// Whether everything that was written has gone to the controller.
pub fn is_drained() -> bool {
    TO_HOST.is_empty()
}

/// The serial port's line, to the rings.
pub struct HostLine;

impl Line for HostLine {
    fn room(&self) -> usize {
        let room = FROM_HOST.room();
        if room < usb::PACKET_BYTES {
            WAITS_FOR_ROOM.store(true, Ordering::Relaxed);
        }
        room
    }

    fn receive(&mut self, bytes: &[u8]) {
        // There is room for the bytes.
        let _taken = FROM_HOST.push_some(bytes);
        wake::wake();
    }

    fn fetch(&mut self, into: &mut [u8]) -> usize {
        TO_HOST.pop_into(into)
    }

    /// Unsent bytes are for nobody, or for the program before.
    fn set_open(&mut self, open: bool) {
        TO_HOST.clear();
        IS_OPEN.store(open, Ordering::Relaxed);
    }

    fn come_back(&mut self) {
        self.set_open(true);
    }
}

/// Handler of the computer's request for a firmware download (DFU detach).
pub struct Download;

impl Detach for Download {
    fn detach(&mut self) -> bool {
        update::ask_for_download()
    }
}

/// The disk, which this device does not have.
pub enum NoDisk {}

impl Medium for NoDisk {
    const BUFFER_BLOCKS: u32 = 1;

    fn state(&self) -> State {
        match *self {}
    }

    fn begin_read(&mut self, _: u32, _: u32, _: Half) {
        match *self {}
    }

    fn begin_write(&mut self, _: u32, _: u32, _: Half) {
        match *self {}
    }

    fn progress(&mut self) -> Progress {
        Progress::Failed(Fault::Gone)
    }

    fn fetch(&self, _: Half, _: usize, _: &mut [u8]) {
        match *self {}
    }

    fn store(&mut self, _: Half, _: usize, _: &[u8]) {
        match *self {}
    }

    fn eject(&mut self) {
        match *self {}
    }
}
