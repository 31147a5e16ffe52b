//! The STM32H745's power controller: the H743's, with the SMPS converter's supply configurations.
//!
//! RM0399 rev 4, section 7.4.1 and table 32 ("Supply configuration control"): the low byte of PWR_CR3 selects
//! how the core is fed, once after power-on. The board wires one of them, direct SMPS supply: the coil on
//! VLXSMPS feeds VCAP, and the LDO's input hangs on the 1.2 V it would have to make, so with the LDO selected
//! the core voltage is never reached. The emulated H743 knows the LDO and the bypass alone; it is told of "a
//! regulator that settles" for the configuration that works here and of its own illegal combination for those
//! that do not.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32h743::generated::pwr::Register;
use rigless::soc::stm32h743::peripherals::pwr::Pwr;
use rigless::time::EventId;

/// PWR_CR3 bits 5..0: SDLEVEL, SDEXTHP, SDEN, LDOEN, BYPASS.
const SUPPLY_BITS: u64 = 0x3F;
/// Supply bits for direct SMPS supply: SDEN alone.
const DIRECT_SMPS: u64 = 0b00_0100;
/// Reset value of PWR_CR3 at power-on, RM0399 section 7.8.4: SMPS and LDO enabled.
const CR3_RESET: u64 = 0x46;
/// LDOEN of the H743: a regulator that settles.
const H743_LDO: u64 = 0b010;
/// LDOEN and BYPASS: the combination the H743 model refuses, after which the voltage never becomes valid.
const H743_ILLEGAL: u64 = 0b011;
/// USB33DEN switches the detector of the USB supply on; USB33RDY says that the supply is there, as both of
/// its pins are on the board's 3.3 V.
const USB33DEN: u64 = 1 << 24;
const USB33RDY: u64 = 1 << 26;
const NOT_WIRED: &str =
    "RM0399 table 32: the board is wired for direct SMPS supply (SDEN alone); with this one VCORE is never valid";

/// The power controller's state.
#[derive(Debug, Default)]
pub struct PrimePwr {
    /// The emulator's model, which does everything but the supply byte.
    pub inner: Pwr,
    /// The supply bits as first written after power-on.
    supply: Option<u64>,
}

impl Device for PrimePwr {
    type Register = Register;

    fn read(&mut self, register: Register, file: &mut RegisterFile, context: &mut DeviceContext<'_>) -> Option<u64> {
        self.inner.read(register, file, context);
        (register == Register::Cr3).then(|| {
            let supply = self.supply.unwrap_or(CR3_RESET & SUPPLY_BITS);
            let held = file.get(Register::Cr3) & !(SUPPLY_BITS | USB33RDY);
            held | supply | if held & USB33DEN != 0 { USB33RDY } else { 0 }
        })
    }

    fn steady(&self, register: Register, file: &RegisterFile) -> bool {
        self.inner.steady(register, file)
    }

    fn write(&mut self, register: Register, value: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if register == Register::Cr3 && self.supply.is_none() {
            let supply = value & SUPPLY_BITS;
            self.supply = Some(supply);
            let translated = if supply == DIRECT_SMPS { H743_LDO } else { H743_ILLEGAL };
            if supply != DIRECT_SMPS {
                context.tell("CR3", NOT_WIRED);
            }
            file.set(Register::Cr3, (value & !SUPPLY_BITS) | translated);
        }
        self.inner.write(register, value, file, context);
    }

    fn on_event(&mut self, event: EventId, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.inner.on_event(event, file, context);
    }

    fn reset(&mut self) {
        Device::reset(&mut self.inner);
    }
}
