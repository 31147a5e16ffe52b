//! spreadCycle settings computed for a motor: from the configured coil to the chip, and the result in words.

use base::ports::{ChopperFit, Coil, DriverFault};
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;
use tmc::stealth::{RegisterBus, StealthSettings};
use tmc::{BlankTime, Chopper, Driver, HysteresisDecrement, Regulated};
use units::Volts;

use crate::error::fault;
use crate::stealth::Outside;

/// Typical clock of the internal oscillator of a TMC2590 and of a TMC2660 (data sheets, "System clock").
const ON_BOARD_CLOCK_HZ: f32 = 15e6;
const BLANK_TIMES: [BlankTime; 4] =
    [BlankTime::Clocks16, BlankTime::Clocks24, BlankTime::Clocks36, BlankTime::Clocks54];

/// Fits the chopper of an on-board driver to a coil and its supply.
pub fn on_board<SPI: SpiDevice>(
    chip: &mut Driver<SPI>,
    coil: Coil,
    supply: Volts,
) -> Result<Option<ChopperFit>, DriverFault> {
    let now = *chip.registers();
    let blank_time = BLANK_TIMES.get(now.chopconf.tbl() as usize).copied().unwrap_or(BlankTime::Clocks54);
    let by = Regulated {
        supply,
        peak: chip.current(),
        cs: now.sgcsconf.cs() as u8,
        clock_hz: ON_BOARD_CLOCK_HZ,
        blank_clocks: blank_time.clocks(),
    };
    let Some(fit) = by.chopper(coil) else { return Ok(None) };
    let chopper = Chopper::SpreadCycle {
        off_time: fit.off_time,
        blank_time,
        hysteresis_start: fit.hysteresis_start,
        hysteresis_end: fit.hysteresis_end,
        decrement: HysteresisDecrement::Clocks16,
        random_off_time: now.chopconf.rndtf() == 1,
    };
    chip.set_chopper(chopper).map_err(fault)?;
    Ok(Some(fit))
}

impl<BUS: RegisterBus, E: OutputPin> Outside<BUS, E> {
    /// Fits the chopper of an external driver to a coil and its supply.
    pub(crate) fn fit_chopper(&mut self, coil: Coil, supply: Volts) -> Result<Option<ChopperFit>, DriverFault> {
        let (settings, current, kind) = (*self.chip.settings(), *self.chip.current(), self.chip.chip());
        let by = Regulated {
            supply,
            peak: current.actual,
            // The current scale of full scale counts, whether the scale or GLOBALSCALER makes the current
            // smaller.
            cs: current.cs,
            clock_hz: kind.clock_hz(),
            blank_clocks: kind.blank_clocks(settings.blank_time),
        };
        let Some(fit) = by.chopper(coil) else { return Ok(None) };
        let set = StealthSettings {
            off_time: fit.off_time,
            hysteresis_start: fit.hysteresis_start,
            hysteresis_end: fit.hysteresis_end,
            ..settings
        };
        self.chip.set(set).map_err(fault)?;
        Ok(Some(fit))
    }
}
