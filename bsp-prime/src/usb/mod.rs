//! The USB socket: OTG2 as a full-speed device on PA11 and PA12, behind `usb-device`'s bus trait.
//!
//! The core is driven by its FIFOs, without its DMA. The owner of the device calls it only from the interrupt
//! OTG_FS; nothing here masks an interrupt, waits for long, or runs longer than it takes to move a few
//! packets. `synopsys-usb-otg`, which the HAL brings, masks every interrupt while it moves a packet, and
//! leaves a packet that nobody fetches at the head of the common FIFO, where it stops every endpoint: see
//! docs/dependencies.md.
//!
//! Each endpoint from the host has buffers for two packets. While one is free the endpoint takes packets,
//! else it answers NAK; so a port whose bytes nobody fetches stops alone. The cable is not seen: PA9, which
//! senses the bus voltage on other boards, is an end switch here. So the session is always valid (B-valid
//! override), and a cable that is pulled out is a bus that has fallen silent.

mod bus;
mod endpoints;
mod power;
mod registers;

pub use bus::OtgBus;
pub use power::UsbError;

use registers::{DCTL, GAHBCFG, modify};
use stm32h7xx_hal::pac;

/// USB core before its set-up.
pub struct UsbSocket {
    _global: pac::OTG2_HS_GLOBAL,
    _device: pac::OTG2_HS_DEVICE,
    _power: pac::OTG2_HS_PWRCLK,
}

/// DCTL: SDIS, not connected.
const DISCONNECTED: u32 = 1 << 1;
/// GAHBCFG: GINT, the core may interrupt.
const MAY_INTERRUPT: u32 = 1 << 0;

impl UsbSocket {
    pub(crate) const fn new(
        global: pac::OTG2_HS_GLOBAL,
        device: pac::OTG2_HS_DEVICE,
        power: pac::OTG2_HS_PWRCLK,
    ) -> Self {
        Self { _global: global, _device: device, _power: power }
    }

    /// Prepares the core; it is not connected. Takes some 25 ms, at worst 55.
    ///
    /// # Errors
    /// Supply, clock or core do not come up.
    pub fn start(self) -> Result<OtgBus, UsbError> {
        power::prepare()?;
        bus::prepare()?;
        Ok(OtgBus::new())
    }
}

/// Connects the device to the host. From now on the interrupt comes.
pub fn connect() {
    modify(GAHBCFG, 0, MAY_INTERRUPT);
    modify(DCTL, DISCONNECTED, 0);
}

/// Pends the interrupt: there are bytes to send, or room for bytes, or the medium has finished.
pub fn wake() {
    cortex_m::peripheral::NVIC::pend(pac::Interrupt::OTG_FS);
}
