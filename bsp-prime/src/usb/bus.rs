//! The USB core as a bus of `usb-device` (RM0399 chapter 60, "OTG_HS programming model").

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering};

use usb_device::bus::{PollResult, UsbBus};
use usb_device::endpoint::{EndpointAddress, EndpointType};
use usb_device::{Result, UsbDirection, UsbError};

use super::endpoints::{ENDPOINTS, State};
use super::power;
use super::registers::endpoint::{STALL, STUP, XFRC};
use super::registers::event::{CMOD, ENUMDNE, IEPINT, OEPINT, RXFLVL, USBRST, USBSUSP, WKUPINT};
use super::registers::{self, modify, read, write};
use crate::wait;

/// GUSBCFG: turn-around time at full speed with an AHB clock from 32 MHz on (RM0399 chapter 60, table of
/// TRDT).
const TURNAROUND: u32 = 0x6 << 10;
/// GUSBCFG: the full-speed transceiver; device whatever the ID pin says, which is not connected.
const PHYSEL: u32 = 1 << 6;
const FDMOD: u32 = 1 << 30;
/// Time for the core to change to the forced mode (GUSBCFG: 25 ms).
const MODE_LIMIT_US: u32 = 50_000;
/// Limit of a reset or flush, which takes a few clocks of the transceiver.
const CORE_LIMIT_US: u32 = 1_000;
/// Bits of the register GRSTCTL.
const CSRST: u32 = 1 << 0;
const AHBIDL: u32 = 1 << 31;

/// Brings the core from its reset to a device that is not connected (RM0399 chapter 60, "Core
/// initialization", "Device initialization").
pub(super) fn prepare() -> core::result::Result<(), power::UsbError> {
    let failed = |_| power::UsbError::NotReady;
    let is_idle = || read(registers::GRSTCTL) & AHBIDL != 0;
    wait::until(CORE_LIMIT_US, is_idle).map_err(failed)?;
    modify(registers::GUSBCFG, 0, PHYSEL);
    modify(registers::GRSTCTL, 0, CSRST);
    wait::until(CORE_LIMIT_US, || read(registers::GRSTCTL) & CSRST == 0).map_err(failed)?;
    wait::until(CORE_LIMIT_US, is_idle).map_err(failed)?;
    write(registers::GUSBCFG, PHYSEL | FDMOD | TURNAROUND);
    // GCCFG: PWRDWN switches the transceiver on; VBDEN stays off, nothing senses the bus voltage.
    write(registers::GCCFG, 1 << 16);
    // GOTGCTL: BVALOEN and BVALOVAL, a session whatever is sensed.
    modify(registers::GOTGCTL, 0, 0b11 << 6);
    write(registers::PCGCCTL, 0);
    wait::until(MODE_LIMIT_US, || read(registers::GINTSTS) & CMOD == 0).map_err(failed)?;
    // DCTL: SDIS, not connected. DCFG: full speed by the internal transceiver.
    modify(registers::DCTL, 0, 1 << 1);
    write(registers::DCFG, 0b11);
    write(registers::DIEPMSK, XFRC);
    write(registers::DOEPMSK, XFRC | STUP);
    write(registers::GINTSTS, u32::MAX);
    write(registers::GINTMSK, USBRST | ENUMDNE | USBSUSP | WKUPINT | RXFLVL | IEPINT | OEPINT);
    Ok(())
}

/// Running USB core as a bus.
pub struct OtgBus {
    state: UnsafeCell<State>,
    is_in_use: AtomicBool,
}

// SAFETY: the state is reached through `with` alone, which lets one in at a time.
unsafe impl Sync for OtgBus {}

impl OtgBus {
    pub(super) const fn new() -> Self {
        Self { state: UnsafeCell::new(State::new()), is_in_use: AtomicBool::new(false) }
    }

    /// Packets of the host that an endpoint holds, acknowledged and not fetched.
    pub fn held(&self, endpoint: EndpointAddress) -> usize {
        self.with(|state| state.held(endpoint.index())).unwrap_or(0)
    }

    /// Runs `action` on the state. `None` if the state is in use: by an interrupt that would use the device
    /// while it interrupts its one user, which does not happen.
    fn with<R>(&self, action: impl FnOnce(&mut State) -> R) -> Option<R> {
        if self.is_in_use.swap(true, Ordering::Acquire) {
            return None;
        }
        // SAFETY: the flag was clear, so there is no other reference; it is cleared when this one has ended.
        let result = action(unsafe { &mut *self.state.get() });
        self.is_in_use.store(false, Ordering::Release);
        Some(result)
    }
}

impl UsbBus for OtgBus {
    // DCFG.DAD counts from behind the status stage of the request that sets it (RM0399 chapter 60,
    // "SetAddress").
    const QUIRK_SET_ADDRESS_BEFORE_STATUS: bool = true;

    fn alloc_ep(
        &mut self,
        direction: UsbDirection,
        address: Option<EndpointAddress>,
        type_of: EndpointType,
        packet: u16,
        _: u8,
    ) -> Result<EndpointAddress> {
        let address = address.ok_or(UsbError::Unsupported)?;
        self.state.get_mut().add(direction, address, type_of, packet)?;
        Ok(address)
    }

    /// Does nothing: [`super::start`] has prepared the core, and [`super::connect`] connects it.
    fn enable(&mut self) {}

    fn reset(&self) {
        self.with(State::configure);
    }

    fn set_device_address(&self, address: u8) {
        modify(registers::DCFG, 0x7F << 4, u32::from(address) << 4);
    }

    // Called for answers to requests and for packets of data: a call is a twentieth of a run of the latter.
    #[inline]
    fn write(&self, endpoint: EndpointAddress, packet: &[u8]) -> Result<usize> {
        if !endpoint.is_in() {
            return Err(UsbError::InvalidEndpoint);
        }
        self.with(|state| state.send(endpoint.index(), packet)).unwrap_or(Err(UsbError::WouldBlock))
    }

    fn read(&self, endpoint: EndpointAddress, into: &mut [u8]) -> Result<usize> {
        if endpoint.is_in() {
            return Err(UsbError::InvalidEndpoint);
        }
        self.with(|state| state.fetch(endpoint.index(), into)).unwrap_or(Err(UsbError::WouldBlock))
    }

    fn set_stalled(&self, endpoint: EndpointAddress, stalled: bool) {
        self.with(|state| state.halt(endpoint, stalled));
    }

    fn is_stalled(&self, endpoint: EndpointAddress) -> bool {
        let number = endpoint.index();
        if number >= ENDPOINTS {
            return true;
        }
        let at = if endpoint.is_in() { registers::diepctl(number) } else { registers::doepctl(number) };
        read(at) & STALL != 0
    }

    fn suspend(&self) {}

    fn resume(&self) {}

    fn poll(&self) -> PollResult {
        self.with(State::poll).unwrap_or(PollResult::None)
    }
}
