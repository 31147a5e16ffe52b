//! OTG2 as a full-speed device controller, RM0399 rev 4 chapter 60 ("OTG_HS"), with the cable to the host.
//!
//! [`core::Core`] is the core with its registers and FIFOs, [`Controller`] the host; neither knows the
//! emulator. The file here puts the two of them on the bus.
//!
//! | behaviour | where it is written |
//! |---|---|
//! | the pull-up needs the 48 MHz, PHYSEL, PWRDWN, USB33DEN, the pins, a B session, SDIS = 0 | 60.6, 60.14 |
//! | CSRST stays set until the transceiver's clock runs | OTG_GRSTCTL; others on the H743 and H745 |
//! | a SETUP is always taken; it sets NAK both ways and clears STALL | 60.15, "SETUP transactions" |
//! | its stage ends with the next token: an entry for it, and STUP when that is popped | the same |
//! | of the receive FIFO 13 words are for SETUPs, two for each OUT endpoint, one for a NAK | 60.11.3 |
//! | an OUT transfer ends with PKTCNT = 0 or a short packet: NAK, an entry, then XFRC | 60.15 |
//! | the endpoint is disabled with that, unless it was enabled again before | the same; (1) |
//! | an OUT packet is taken with PKTCNT = 0, and ends the transfer | (1), which never write OTG_DOEPTSIZx |
//! | XFRSIZ of IN falls as packets enter the FIFO | OTG_DIEPTSIZx |
//! | DAD written in a control transfer counts after its status stage | 60.15, "SetAddress command" |
//! | a bus reset clears USBAEP and nothing else: neither DAD nor EPENA | OTG_DOEPCTLx, OTG_DCFG |
//! | idle for 3 ms: ESUSP; for 6 ms: USBSUSP and SUSPSTS | 60.6.3 |
//! | an OUT endpoint is disabled under the global OUT NAK alone | 60.15 |
//! | the ULPI's clock enabled for sleep: deaf while the processor sleeps | RCC_AHB1LPENR; (2) |
//!
//! (1) Drivers of others that are in use on this core, 3.30a. (2) What ChibiOS, TinyUSB and Mbed found on the
//! STM32H7.
//!
//! Left out: host mode, the core's DMA, isochronous endpoints, thresholds, LPM, battery charger detection,
//! HNP and SRP beyond their bits, and the wake-up line out of the Stop modes. Flushes and resets are over at
//! once. The manual leaves open whether a device's own remote wake-up raises WKUPINT (here it does not), and
//! what STSPHST in OTG_GRXSTSP marks (here it stays clear).

pub mod core;

mod access;
mod endpoint;
mod endpoints;
mod fifo;
mod interrupts;
mod line;
mod link;
mod registers;
mod tokens;

#[cfg(test)]
mod tests;

use rigless::device::{DeviceContext, ErasedDevice, Level, RegisterFile, RequestChange};
use rigless::soc::stm32h743::generated::otg1_hs_global;
use rigless::soc::{Layout, RegisterSpec, Width, Window};
use rigless::time::{EventId, VirtualNanos};

use self::core::{Core, Surroundings};
use usb_host::controller::Controller;

/// The instance of the global registers, to which clock, reset and interrupts are wired.
pub const GLOBAL: &str = "OTG2_HS_GLOBAL";
/// Base address of the core.
const BASE: u64 = 0x4008_0000;
/// Start of the window that has everything but the global registers.
const WINDOW: u32 = registers::HOST;
/// End of the core's block, with the debug window on the FIFOs' RAM.
const END: u32 = 0x4_0000;
/// OTG_FS_EP1_OUT, OTG_FS_EP1_IN, OTG_FS_WKUP and OTG_FS, RM0399 table of vectors.
const INTERRUPTS: [u16; 4] = [98, 99, 100, 101];

/// Place on the bus that is being called, of the core's two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Instance of the global registers.
    Global,
    /// Window with the other registers.
    Rest,
}

/// The core, the cable and the host.
#[derive(Debug)]
pub struct Otg {
    core: Core,
    host: Controller,
    place: Place,
    lines: [bool; 4],
    /// Instant of the next event that was scheduled.
    due: Option<u64>,
    /// Rate of the kernel clock.
    hz: u64,
    /// Register list that the bus assigned to the window.
    window_registers: &'static [RegisterSpec],
}

impl Default for Otg {
    fn default() -> Self {
        Self {
            core: Core::new(),
            host: Controller::default(),
            place: Place::Global,
            lines: [false; 4],
            due: None,
            hz: 0,
            window_registers: &[],
        }
    }
}

impl Otg {
    /// Creates the window over the core's registers that the emulator's table does not have.
    #[must_use]
    pub fn window() -> Window {
        let size = std::num::NonZeroU64::new(u64::from(END - WINDOW)).expect("a window of some size");
        let gate = rigless::soc::Gate::by("RCC", "AHB1ENR", "USB2OTGHSEN");
        Window::new("OTG2_HS", BASE + u64::from(WINDOW), size).raising(&INTERRUPTS).gated(gate)
    }

    /// Sets the empty register list that the bus has assigned to the window.
    pub const fn sit_in(&mut self, window_registers: &'static [RegisterSpec]) {
        self.window_registers = window_registers;
    }

    /// Sets the place at which the next call comes in.
    pub const fn face(&mut self, place: Place) -> &mut Self {
        self.place = place;
        self
    }

    /// Sets the core's surroundings, of which the emulator tells the clock itself.
    pub fn look_around(&mut self, around: Surroundings) {
        self.core.look_around(Surroundings { kernel_hz: self.hz, ..around });
    }

    /// Whether a cable is plugged in.
    #[must_use]
    pub fn is_plugged(&self) -> bool {
        self.host.port() != usb_host::controller::Port::Unplugged
    }

    /// Follows a sleep of the processor in the last millisecond, however short.
    pub fn processor_slept(&mut self, context: &mut DeviceContext<'_>) {
        self.core.processor_slept(context.now().0);
        self.follow(context);
    }

    /// Runs `work` with the host and the core at this instant.
    pub fn with_host<R>(
        &mut self,
        context: &mut DeviceContext<'_>,
        work: impl FnOnce(&mut Controller, &mut Core, u64) -> R,
    ) -> R {
        let done = work(&mut self.host, &mut self.core, context.now().0);
        self.follow(context);
        done
    }

    /// Follows a change of the core: steps of the host, interrupts, the next event, and complaints.
    pub fn follow(&mut self, context: &mut DeviceContext<'_>) {
        let now_ns = context.now().0;
        self.core.advance(now_ns);
        self.host.run(now_ns, &mut self.core);
        for finding in self.core.take_findings() {
            context.tell(finding.register, finding.reason);
        }
        let lines = self.core.lines();
        for (position, (line, raised)) in self.lines.iter_mut().zip(lines).enumerate() {
            if std::mem::replace(line, raised) != raised {
                context.interrupt(position, Level::from(raised));
            }
        }
        let next = [self.core.next_change(), self.host.next()].into_iter().flatten().min();
        if let Some(at) = next.filter(|_| next != self.due) {
            context.schedule(VirtualNanos(at));
        }
        self.due = next;
    }

    /// Schedules events again after a reset of the part, which has dropped them.
    pub fn restarted(&mut self, context: &mut DeviceContext<'_>) {
        self.due = None;
        self.follow(context);
    }

    fn read_word(&mut self, offset: u32, context: &mut DeviceContext<'_>) -> u32 {
        let value = self.core.read(context.now().0, offset);
        self.follow(context);
        value
    }

    fn write_word(&mut self, offset: u32, value: u32, context: &mut DeviceContext<'_>) {
        self.core.write(context.now().0, offset, value);
        self.follow(context);
    }
}

fn offset_of(row: usize) -> u32 {
    otg1_hs_global::Register::from_index(row).map_or(0, |register| register.spec().offset)
}

impl ErasedDevice for Otg {
    fn layout(&self) -> &'static [RegisterSpec] {
        match self.place {
            Place::Global => otg1_hs_global::Register::REGISTERS,
            Place::Rest => self.window_registers,
        }
    }

    fn read(&mut self, row: usize, _: &mut RegisterFile, context: &mut DeviceContext<'_>) -> Option<u64> {
        Some(u64::from(self.read_word(offset_of(row), context)))
    }

    fn peek(&self, row: usize, _: &RegisterFile, _: VirtualNanos) -> Option<u64> {
        Some(u64::from(self.core.peek(offset_of(row))))
    }

    /// Whether a read changes nothing: true but for the register that pops the receive FIFO.
    fn steady(&self, row: usize, _: &RegisterFile) -> bool {
        offset_of(row) != registers::GRXSTSP
    }

    fn write(&mut self, row: usize, value: u64, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.write_word(offset_of(row), value as u32, context);
    }

    fn on_event(&mut self, _: EventId, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.due = None;
        self.follow(context);
    }

    fn on_request(&mut self, _: RequestChange, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn hears(&self, _: &'static str, _: usize) -> bool {
        false
    }

    fn on_clock(&mut self, hz: u64, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.hz = hz;
        self.core.set_clock(hz);
        self.follow(context);
    }

    fn poll(&mut self, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    /// Resets the core with the part. The host and the cable notice that the pull-up goes.
    fn reset(&mut self) {
        self.core.reset();
        self.lines = [false; 4];
        self.due = None;
    }

    fn reset_line(&mut self, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.reset();
        self.follow(context);
    }

    fn on_access(&mut self, _: u64, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn on_refused(&mut self, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn read_window(&mut self, offset: u64, width: Width, context: &mut DeviceContext<'_>) -> u64 {
        let offset = WINDOW + offset as u32;
        if width == Width::W32 {
            return u64::from(self.read_word(offset, context));
        }
        context.tell("block", "RM0399 section 60.14: registers and FIFOs are accessed by words");
        u64::from(self.read_word(offset & !3, context)) >> (8 * (offset & 3))
    }

    fn write_window(&mut self, offset: u64, width: Width, value: u64, context: &mut DeviceContext<'_>) {
        let offset = WINDOW + offset as u32;
        if width != Width::W32 {
            context.tell("block", "RM0399 section 60.14: registers and FIFOs are accessed by words");
        }
        self.write_word(offset & !3, value as u32, context);
    }

    fn peek_window(&self, offset: u64, width: Width, _: VirtualNanos) -> Option<u64> {
        let offset = WINDOW + offset as u32;
        let word = u64::from(self.core.peek(offset & !3));
        (width != Width::W64).then_some(word >> (8 * (offset & 3)))
    }
}
