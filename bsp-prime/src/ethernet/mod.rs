//! Ethernet: the controller (MAC, queues, DMA) in RMII mode with the PHY behind it, as a device for
//! `smoltcp`.
//!
//! A single owner polls the controller; nothing here waits. [`Ethernet::supervise`] moves the reset and the
//! management frames on, watches the link, and starts and stops the MAC with it. Frames are lent to the
//! stack in the buffers that the DMA has written or will read. The interrupt ([`on_interrupt`]) masks
//! itself: it comes once, and again only after the owner has found no more frames, so a flood costs no more
//! interrupts than it has turns.
//!
//! The HAL's driver is one of an older `smoltcp`, hangs without the PHY's clock, receives no multicast and
//! knows one speed.

use core::sync::atomic::{AtomicBool, Ordering};

use smoltcp::phy::{ChecksumCapabilities, Device, DeviceCapabilities, Medium};
use smoltcp::time::Instant;
use stm32h7xx_hal::pac;
use units::Micros;

mod budget;
mod mac;
mod management;
mod rings;

pub use drivers::lan8720::{Duplex, Fault, Link, LinkMode, Speed};
pub use rings::{Outgoing, Received};

use budget::Budget;
use mac::Registers;
use management::Management;
use rings::{FRAME_BYTES, RECEIVE, ReceiveRing, SendRing};

/// Limit of the software reset, after which the PHY's clock is missed. The reset goes on: should the clock
/// come later, it ends.
const RESET_LIMIT: Micros = Micros::from_millis(500);
/// Limits of the last frame, which takes 1.2 ms at 10 Mbit/s without collisions, and of a flush.
const STOP_LIMIT: Micros = Micros::from_millis(20);

/// The link of a sender that is connected to its own receiver.
const LOOP: Link = Link { speed: Speed::Hundred, duplex: Duplex::Full, is_negotiated: false };

/// The controller has masked its interrupts.
static IS_SILENT: AtomicBool = AtomicBool::new(false);
/// The DMA has stopped at an address that it cannot reach.
static HAS_FAILED: AtomicBool = AtomicBool::new(false);

/// The Ethernet controller before its start.
pub struct Parts(Registers);

impl Parts {
    pub(crate) const fn new(mac: pac::ETHERNET_MAC, mtl: pac::ETHERNET_MTL, dma: pac::ETHERNET_DMA) -> Self {
        Self(Registers { mac, mtl, dma })
    }
}

/// Reason why there is no network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EthernetError {
    /// The chip does not select RMII.
    NoRmii,
    /// The PHY's clock of 50 MHz does not arrive.
    NoClock,
    /// Something is wrong with the PHY.
    Phy(Fault),
}

impl EthernetError {
    /// Returns the message for the user.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::NoRmii => "the Ethernet controller cannot be connected to its pins: switch the board off and on",
            Self::NoClock => "the Ethernet PHY gives no clock: check its supply, its crystal and REF_CLK (PA1)",
            Self::Phy(fault) => fault.message(),
        }
    }
}

/// Traffic since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Frames received.
    pub received: u32,
    /// Bytes of these, without check sequences.
    pub received_bytes: u64,
    /// Frames sent.
    pub sent: u32,
    /// Bytes of these, without check sequences.
    pub sent_bytes: u64,
    /// Frames dropped that were too long, damaged or had wrong checksums.
    pub damaged: u32,
    /// Frames with a wrong check sequence: a bad cable, or ends that disagree about the duplex mode. At 10
    /// Mbit/s the controller errs now and then (`rings.rs`), and the frame is taken.
    pub check_errors: u32,
    /// Frames lost because all buffers were full.
    pub missed: u32,
    /// Frames to groups dropped because there were too many.
    pub too_many: u32,
    /// Frames that could not be sent.
    pub unsent: u32,
    /// Restarts after an error of the DMA.
    pub restarts: u32,
}

/// State of the MAC.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Resetting(Micros),
    Stopped,
    Running(Link),
    /// The DMA ends its last frame.
    Stopping(Micros),
    /// The queue throws away what was not sent.
    Flushing(Micros),
}

/// The Ethernet controller, running.
pub struct Ethernet {
    registers: Registers,
    receive: ReceiveRing,
    send: SendRing,
    management: Management,
    budget: Budget,
    stage: Stage,
    address: [u8; 6],
    link_mode: LinkMode,
    has_clock: bool,
    loops: bool,
    missed: u32,
    restarts: u32,
}

impl Ethernet {
    /// Connects the controller to its pins and begins its reset, for [`Self::supervise`] to go on with.
    ///
    /// # Errors
    /// [`EthernetError::NoRmii`]. Others are found later: [`Self::fault`].
    pub fn start(parts: Parts, address: [u8; 6], link: LinkMode) -> Result<Self, EthernetError> {
        let Parts(registers) = parts;
        if !registers.begin() {
            return Err(EthernetError::NoRmii);
        }
        Ok(Self {
            registers,
            receive: ReceiveRing::new(),
            send: SendRing::new(),
            management: Management::new(link),
            budget: Budget::new(),
            stage: Stage::Resetting(crate::time::now()),
            address,
            link_mode: link,
            has_clock: true,
            loops: false,
            missed: 0,
            restarts: 0,
        })
    }

    /// Moves everything on that goes on by itself: to be called at every turn, and cheap. Returns the link,
    /// once the MAC runs with it.
    pub fn supervise(&mut self, now: Micros) -> Option<Link> {
        if HAS_FAILED.load(Ordering::Relaxed) && HAS_FAILED.swap(false, Ordering::AcqRel) {
            self.restart(now);
        }
        if !self.move_on(now) {
            return None;
        }
        self.management.poll(&self.registers.mac, now);
        let link = if self.loops { Some(LOOP) } else { self.management.link() };
        match (self.stage, link) {
            (Stage::Stopped, Some(link)) => {
                self.send.restart();
                self.registers.start(link, self.loops);
                self.send.is_open = true;
                self.stage = Stage::Running(link);
            }
            (Stage::Running(present), link) if link != Some(present) => {
                self.send.is_open = false;
                self.registers.stop();
                // Frames that would have been waited for are not sent any more.
                self.listen(mac::RECEIVED);
                self.stage = Stage::Stopping(now);
            }
            _ => {}
        }
        if self.receive.took {
            self.receive.took = false;
            self.missed = self.missed.wrapping_add(self.registers.take_missed());
        }
        self.listen_again();
        match self.stage {
            Stage::Running(link) => Some(link),
            _ => None,
        }
    }

    /// Moves the reset on, or the stop. False during the reset.
    fn move_on(&mut self, now: Micros) -> bool {
        let registers = &self.registers;
        match self.stage {
            Stage::Resetting(since) => {
                if registers.is_resetting() {
                    self.has_clock &= now.since(since) <= RESET_LIMIT;
                    return false;
                }
                self.has_clock = true;
                self.receive.restart();
                self.send.restart();
                registers.set_up(self.address);
                self.stage = Stage::Stopped;
            }
            Stage::Stopping(since) if registers.has_stopped() || now.since(since) > STOP_LIMIT => {
                registers.flush();
                self.stage = Stage::Flushing(now);
            }
            Stage::Flushing(since) if !registers.is_flushing() || now.since(since) > STOP_LIMIT => {
                registers.rest();
                self.stage = Stage::Stopped;
            }
            _ => {}
        }
        true
    }

    /// Begins again after an error of the DMA.
    fn restart(&mut self, now: Micros) {
        self.restarts = self.restarts.wrapping_add(1);
        self.send.is_open = false;
        self.management = Management::new(self.link_mode);
        self.registers.reset();
        self.stage = Stage::Resetting(now);
    }

    /// Lets the controller interrupt for frames again, if it does not and none is there. Its flag is cleared
    /// before the look, and may be of frames that were taken since: it would wake the owner for nothing.
    fn listen_again(&self) {
        if IS_SILENT.load(Ordering::Relaxed) && !self.receive.has_frame() {
            self.registers.forget(mac::RECEIVED);
            if !self.receive.has_frame() {
                self.listen(mac::RECEIVED);
            }
        }
    }

    /// Whether there is room for a frame; otherwise the controller interrupts once there is.
    fn has_room(&self) -> bool {
        if self.send.has_room() {
            return true;
        }
        self.registers.forget(mac::SENT);
        let has_room = self.send.has_room();
        if !has_room {
            self.listen(mac::SENT);
        }
        has_room
    }

    fn listen(&self, flag: u32) {
        IS_SILENT.store(false, Ordering::Release);
        self.registers.listen(flag);
    }

    /// Connects the sender to the receiver within the controller. For tests, which then need no cable: of the
    /// PHY only its clock.
    pub fn loop_back(&mut self) {
        self.loops = true;
    }

    /// Whether a frame can be taken: the owner should not rest. A frame without room for an answer waits, and
    /// the interrupt comes once there is room.
    #[must_use]
    pub fn has_work(&self) -> bool {
        !matches!(self.stage, Stage::Resetting(_)) && self.receive.has_frame() && self.send.has_room()
    }

    /// Returns the reason why there can be no link. Without a reason and a link, no cable is plugged in, or
    /// its other end is off.
    #[must_use]
    pub fn fault(&self) -> Option<EthernetError> {
        if self.has_clock { self.management.fault().map(EthernetError::Phy) } else { Some(EthernetError::NoClock) }
    }

    /// Returns the traffic since the start.
    #[must_use]
    pub fn counters(&self) -> Counters {
        let is_resetting = matches!(self.stage, Stage::Resetting(_));
        Counters {
            received: self.receive.frames,
            received_bytes: self.receive.bytes,
            sent: self.send.frames,
            sent_bytes: self.send.bytes,
            damaged: self.receive.damaged,
            check_errors: if is_resetting { 0 } else { self.registers.check_errors() },
            missed: self.missed,
            too_many: self.budget.dropped(),
            unsent: self.send.failed,
            restarts: self.restarts,
        }
    }
}

impl Device for Ethernet {
    type RxToken<'a> = Received<'a>;
    type TxToken<'a> = Outgoing<'a>;

    /// The next frame, if there is room for an answer.
    fn receive(&mut self, now: Instant) -> Option<(Received<'_>, Outgoing<'_>)> {
        if matches!(self.stage, Stage::Resetting(_)) {
            return None;
        }
        if !self.has_room() {
            return None;
        }
        let (budget, now_ms) = (&mut self.budget, now.total_millis());
        let Some(length) = self.receive.next_length(|| !budget.take(now_ms)) else {
            self.listen_again();
            return None;
        };
        Some((self.receive.take(length), self.send.room()?))
    }

    fn transmit(&mut self, _: Instant) -> Option<Outgoing<'_>> {
        if self.has_room() { self.send.room() } else { None }
    }

    fn capabilities(&self) -> DeviceCapabilities {
        let mut capabilities = DeviceCapabilities::default();
        capabilities.medium = Medium::Ethernet;
        capabilities.max_transmission_unit = FRAME_BYTES;
        capabilities.max_burst_size = Some(RECEIVE);
        // The controller verifies and inserts all of them.
        capabilities.checksum = ChecksumCapabilities::ignored();
        capabilities
    }
}

/// The body of the interrupt ETH: clears and masks. Whoever polls the device is to be woken behind it.
pub fn on_interrupt() {
    let flags = mac::silence();
    if flags & mac::BUS_ERROR != 0 {
        HAS_FAILED.store(true, Ordering::Release);
    }
    IS_SILENT.store(true, Ordering::Release);
}
