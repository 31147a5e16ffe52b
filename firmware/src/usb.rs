//! The board as a USB device for the machine: the connections of its functions, and its owner.
//!
//! The device belongs to the interrupt of its controller and to nobody else. The device is built in idle,
//! once the configuration is known, and handed over once. From then on idle leaves bytes in a ring, or makes
//! room in an inbox, and has the interrupt's task run.

use core::mem::MaybeUninit;
use core::ptr;
use core::sync::atomic::{AtomicBool, AtomicPtr, Ordering};

use base::sessions::{Inbox, Intake};
use bsp_prime::byte_ring::ByteRing;
use bsp_prime::sd::CardService;
use bsp_prime::time;
use bsp_prime::usb::{OtgBus, UsbError, UsbSocket};
use config::SystemConfig;
use rtic::Mutex;
use usb::{Composite, Detach, Functions, Guarded, Line, Presence, SerialNumber};

use crate::consoles::Console;
use crate::disk::CardMedium;
use crate::{executor, update};

/// Size of the ring to the host, bytes: the data of 3 ms of the bus, more than the executor is ever away
/// for.
const TO_HOST_BYTES: usize = 4096;

#[unsafe(link_section = ".d2ram")]
static TO_HOST: [ByteRing<TO_HOST_BYTES>; 2] = [const { ByteRing::new() }; 2];

/// Consoles at the socket, and whether the port of each has found no room in its inbox and must be told of
/// new room.
static WAIT_FOR_ROOM: [(Console, AtomicBool); 2] =
    [(Console::Usb0, AtomicBool::new(false)), (Console::Usb1, AtomicBool::new(false))];

/// USB device on its way from idle to its interrupt.
static HANDED_OVER: AtomicPtr<Device> = AtomicPtr::new(ptr::null_mut());

/// Whether the bus is silent: there is no computer, or it sleeps.
static IS_SILENT: AtomicBool = AtomicBool::new(true);

/// Handler of the computer's request for a firmware download (DFU detach).
pub struct Machine;

type Bus = Guarded<OtgBus>;

/// USB device with all its functions.
pub type Device = Composite<'static, Bus, ConsoleLine, CardMedium, Machine>;

/// Memory of the device and the data that it refers to. In SRAM1, as DTCM is for data that motion needs all
/// the time.
struct Place {
    bus: usb::UsbBusAllocator<Bus>,
    serial: SerialNumber,
    device: Device,
}

#[unsafe(link_section = ".d2ram")]
static mut PLACE: MaybeUninit<Place> = MaybeUninit::uninit();

/// Console at a serial port of USB.
pub struct ConsoleLine {
    console: Console,
    intake: Intake,
    to_host: &'static ByteRing<TO_HOST_BYTES>,
}

/// Returns the ring of a console's bytes for the host; `None` for one that is not at the socket.
fn ring(console: Console) -> Option<&'static ByteRing<TO_HOST_BYTES>> {
    match console {
        Console::Usb0 => Some(&TO_HOST[0]),
        Console::Usb1 => Some(&TO_HOST[1]),
        _ => None,
    }
}

impl ConsoleLine {
    fn new(console: Console) -> Option<Self> {
        ring(console).map(|to_host| Self { console, intake: Intake::new(), to_host })
    }

    fn inbox(&self) -> &'static Inbox {
        self.console.inbox()
    }

    /// Unsent output is for nobody, or for the previous user.
    fn drop_unsent(&self) {
        self.to_host.clear();
    }
}

impl Line for ConsoleLine {
    fn room(&self) -> usize {
        let room = self.inbox().room();
        if room < usb::PACKET_BYTES
            && let Some((_, waits)) = WAIT_FOR_ROOM.iter().find(|(console, _)| *console == self.console)
        {
            waits.store(true, Ordering::Relaxed);
        }
        room
    }

    fn receive(&mut self, bytes: &[u8]) {
        // The inbox has room for the bytes.
        let _taken = self.inbox().receive_all(&mut self.intake, bytes);
        executor::wake_for_session();
    }

    fn fetch(&mut self, into: &mut [u8]) -> usize {
        self.to_host.pop_into(into)
    }

    fn set_open(&mut self, open: bool) {
        self.drop_unsent();
        let inbox = self.inbox();
        if open {
            inbox.open(&mut self.intake);
        } else {
            inbox.set_open(false);
        }
        executor::wake_for_session();
    }

    fn come_back(&mut self) {
        self.drop_unsent();
        self.inbox().open_again(&mut self.intake);
        executor::wake_for_session();
    }
}

/// Marks the consoles at the socket as unused. Call before there are sessions.
pub fn begin() {
    [Console::Usb0, Console::Usb1].into_iter().for_each(|console| console.inbox().set_open(false));
}

/// Builds the device and connects it. Call once: there is one socket.
///
/// # Errors
/// The socket does not work.
pub fn connect(socket: UsbSocket, unique_id: [u32; 3], system: &SystemConfig) -> Result<(), &'static str> {
    let controller = socket.start().map_err(words)?;
    let refused = "the controller has no room for its endpoints";
    let functions = Functions {
        first: ConsoleLine::new(Console::Usb0).ok_or(refused)?,
        second: if system.second_usb_serial_enable { ConsoleLine::new(Console::Usb1) } else { None },
        disk: system.msc_enable.then(CardMedium::new),
        detach: system.dfu_enable.then_some(Machine),
    };
    let place = (&raw mut PLACE).cast::<Place>();
    // SAFETY: the one socket was taken, so this runs once, and nothing else refers to the place. Each field
    // is written before it is referred to, the device last, which refers to the two others; those stay as
    // they are for ever.
    let device = unsafe {
        (&raw mut (*place).bus).write(usb::UsbBusAllocator::new(Guarded::new(controller)));
        (&raw mut (*place).serial).write(SerialNumber::new(unique_id));
        let (bus, serial) = (&(*place).bus, &(*place).serial);
        let device = &raw mut (*place).device;
        device.write(
            Composite::new(bus, |bus, endpoint| bus.bus().held(endpoint), serial, functions).map_err(|_| refused)?,
        );
        device
    };
    HANDED_OVER.store(device, Ordering::Release);
    bsp_prime::usb::connect();
    Ok(())
}

const fn words(error: UsbError) -> &'static str {
    match error {
        UsbError::NoSupply => "its 3.3 V are missing, check the board",
        UsbError::NoClock => "PLL3 does not make its 48 MHz, check the crystal",
        UsbError::NotReady => "its controller does not come out of reset, reset the board",
    }
}

/// Handles the interrupt: one event of the bus, and a few packets.
pub fn on_interrupt(device: &mut Option<&'static mut Device>, card: &mut impl Mutex<T = &'static mut CardService>) {
    if device.is_none() {
        let handed_over = HANDED_OVER.swap(ptr::null_mut(), Ordering::Acquire);
        // SAFETY: null, or the one device, which lives for ever in its place; whoever stored it has kept no
        // reference, and the swap gives it to one taker.
        *device = unsafe { handed_over.as_mut() };
    }
    let Some(device) = device else { return };
    if let Some(disk) = device.disk() {
        card.lock(|card| disk.medium().look(card));
    }
    let has_more = device.run();
    IS_SILENT.store(device.presence() == Presence::Silent, Ordering::Relaxed);
    if let Some(medium) = device.disk().map(usb::MassStorage::medium).filter(|medium| medium.wants_card()) {
        card.lock(|card| medium.begin(card, time::now().0));
    }
    if has_more {
        bsp_prime::usb::wake();
    }
}

/// Has the device run if what its disk wanted of the card has ended. Called by the code that advances the
/// card.
pub fn tell_disk(card: &CardService) {
    if card.has_lent_news() {
        bsp_prime::usb::wake();
    }
}

/// Returns whether the bus is silent.
pub fn is_silent() -> bool {
    IS_SILENT.load(Ordering::Relaxed)
}

/// Takes bytes for the host at the other end of a console: as many as fit, all if no host listens. `None` for
/// a console that is not at the socket.
pub fn write(console: Console, bytes: &[u8]) -> Option<usize> {
    let ring = ring(console)?;
    if !console.inbox().is_open() {
        return Some(bytes.len());
    }
    let count = ring.push_some(bytes);
    if count > 0 {
        bsp_prime::usb::wake();
    }
    Some(count)
}

/// Fetches packets that have waited for room, if there is some now. Called when the machine has taken bytes.
pub fn look_for_room() {
    for (console, waits) in &WAIT_FOR_ROOM {
        if waits.load(Ordering::Relaxed) && console.inbox().room() >= usb::PACKET_BYTES {
            waits.store(false, Ordering::Relaxed);
            bsp_prime::usb::wake();
        }
    }
}

impl Detach for Machine {
    fn detach(&mut self) -> bool {
        update::ask_for_download()
    }
}
