//! One chip in a person's terms. The driver keeps its settings, so that it can write all of them again after
//! the chip was without supply.

use super::StealthChip;
use super::bus::RegisterBus;
use super::current::{StealthCurrent, stealth_current};
use super::register::{self, Register, gstat, ioin};
use super::settings::{StealthSettings, range, scale, scaler};
use super::status::StealthStatus;
use crate::Error;
use crate::driver::Microsteps;
use units::Amps;

/// A chip with its settings.
#[derive(Debug)]
pub struct StealthDriver<BUS> {
    bus: BUS,
    chip: StealthChip,
    settings: StealthSettings,
    current: StealthCurrent,
    enabled: bool,
    /// A TMC2130 that was found reset, until it is set up again: reading has cleared its flag.
    was_reset: bool,
}

impl<BUS: RegisterBus> StealthDriver<BUS> {
    /// A driver with these settings, disabled, at the lowest current. Sends nothing.
    ///
    /// # Errors
    /// [`Error::Setting`] for what no chip can take.
    pub fn new(bus: BUS, chip: StealthChip, settings: StealthSettings) -> Result<Self, Error<BUS::Error>> {
        settings.check()?;
        let current = stealth_current(chip, settings.resistor, Amps(0.0), 0);
        Ok(Self { bus, chip, settings, current, enabled: false, was_reset: false })
    }

    /// Writes every register with the bridges off, clears what the chip has latched, and checks that a chip
    /// of this kind has taken it. Takes about 20 datagrams.
    ///
    /// # Errors
    /// Bus errors, [`Error::Absent`], [`Error::WrongAnswer`].
    pub fn start(&mut self) -> Result<(), Error<BUS::Error>> {
        self.enabled = false;
        for (register, word) in self.settings.words(self.chip, &self.current, false) {
            self.bus.write(register.address, word)?;
        }
        self.bus.write(register::GSTAT.address, gstat::ALL)?;
        let chopconf = self.settings.chopconf(self.chip, &self.current, false);
        let [_cleared, taken, inputs] =
            self.bus.read([register::GSTAT.address, register::CHOPCONF.address, register::IOIN.address])?;
        self.is_of_this_kind(inputs)?;
        self.was_reset = false;
        if taken == chopconf { Ok(()) } else { Err(Error::WrongAnswer(taken)) }
    }

    /// Asks for the chip's status. Takes four datagrams.
    ///
    /// # Errors
    /// Bus errors, [`Error::Absent`], [`Error::WrongAnswer`].
    pub fn status(&mut self) -> Result<StealthStatus, Error<BUS::Error>> {
        let addresses = [register::DRV_STATUS.address, register::GSTAT.address, register::IOIN.address];
        let [status, global, inputs] = self.bus.read(addresses)?;
        self.is_of_this_kind(inputs)?;
        let mut status = StealthStatus::decode(self.chip, status, global);
        if status.reset && !self.was_reset {
            status.reset = self.is_reset()?;
        }
        if self.chip == StealthChip::Tmc2130 {
            self.was_reset |= status.reset;
            status.reset = self.was_reset;
        }
        Ok(status)
    }

    /// Whether the reset flag was no disturbed bit: asked once more, or, where reading has cleared it, by
    /// CHOPCONF, which is 0 after a reset of a TMC2130.
    fn is_reset(&mut self) -> Result<bool, Error<BUS::Error>> {
        let addresses = [register::GSTAT.address, register::CHOPCONF.address, register::IOIN.address];
        let [global, chopconf, _] = self.bus.read(addresses)?;
        Ok(if self.chip == StealthChip::Tmc2130 { chopconf == 0 } else { gstat::RESET.get(global) == 1 })
    }

    /// Reads a register.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn read(&mut self, register: Register) -> Result<u32, Error<BUS::Error>> {
        let [value, inputs] = self.bus.read([register.address, register::IOIN.address])?;
        self.is_of_this_kind(inputs)?;
        Ok(value)
    }

    /// Switches the bridges on.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn enable(&mut self) -> Result<(), Error<BUS::Error>> {
        self.enabled = true;
        self.write_chopconf()
    }

    /// Switches the bridges off; the motor turns freely.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn disable(&mut self) -> Result<(), Error<BUS::Error>> {
        self.enabled = false;
        self.write_chopconf()
    }

    /// Whether the bridges were last told to be on.
    #[must_use]
    pub const fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Takes the peak coil current that [`Self::start`] will set; sends nothing.
    pub fn store_current(&mut self, peak: Amps) {
        self.current = stealth_current(self.chip, self.settings.resistor, peak, self.current.range);
    }

    /// Sets the peak coil current, at rest and in motion. The range of a TMC2240 only ever rises, so that a
    /// motor at rest keeps it.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn set_current(&mut self, peak: Amps) -> Result<StealthCurrent, Error<BUS::Error>> {
        let before = self.current;
        self.store_current(peak);
        self.write_current(before)?;
        Ok(self.current)
    }

    /// What is set.
    #[must_use]
    pub const fn current(&self) -> &StealthCurrent {
        &self.current
    }

    /// Sets the microsteps.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn set_microsteps(&mut self, microsteps: Microsteps) -> Result<(), Error<BUS::Error>> {
        self.settings.microsteps = microsteps;
        self.write_chopconf()
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &StealthSettings {
        &self.settings
    }

    /// Which chip this is.
    #[must_use]
    pub const fn chip(&self) -> StealthChip {
        self.chip
    }

    /// The registers that are set, with what they hold now.
    pub fn words(&self) -> impl Iterator<Item = (Register, u32)> + use<BUS> {
        self.settings.words(self.chip, &self.current, self.enabled)
    }

    /// Several registers make the current. In this order what flows between two writes is below the larger of
    /// the old and the new current: full scale falls before the scale rises, and rises after the scale has
    /// fallen.
    fn write_current(&mut self, before: StealthCurrent) -> Result<(), Error<BUS::Error>> {
        let full = |current: &StealthCurrent| {
            let of_range = self.chip.full_scale(self.settings.resistor, current.low_range, current.range);
            of_range.0 * f32::from(current.scaler)
        };
        let falls = full(&self.current) < full(&before);
        let scale = scale(&self.current);
        if !falls {
            self.bus.write(scale.0.address, scale.1)?;
        }
        if self.chip == StealthChip::Tmc2130 {
            self.bus
                .write(register::CHOPCONF.address, self.settings.chopconf(self.chip, &self.current, self.enabled))?;
        } else {
            self.write_full_scale(before)?;
        }
        if falls {
            self.bus.write(scale.0.address, scale.1)?;
        }
        self.answers()
    }

    /// A larger range needs a smaller scaler first.
    fn write_full_scale(&mut self, before: StealthCurrent) -> Result<(), Error<BUS::Error>> {
        let scaler = scaler(&self.current);
        self.bus.write(scaler.0.address, scaler.1)?;
        if self.current.range != before.range {
            let range = range(&self.current);
            self.bus.write(range.0.address, range.1)?;
        }
        Ok(())
    }

    fn write_chopconf(&mut self) -> Result<(), Error<BUS::Error>> {
        let word = self.settings.chopconf(self.chip, &self.current, self.enabled);
        self.bus.write(register::CHOPCONF.address, word)?;
        let taken = self.read(register::CHOPCONF)?;
        if taken == word { Ok(()) } else { Err(Error::WrongAnswer(taken)) }
    }

    /// A chip of this kind is there.
    fn answers(&mut self) -> Result<(), Error<BUS::Error>> {
        let [inputs] = self.bus.read([register::IOIN.address])?;
        self.is_of_this_kind(inputs)
    }

    fn is_of_this_kind(&self, inputs: u32) -> Result<(), Error<BUS::Error>> {
        if ioin::VERSION.get(inputs) == self.chip.version() { Ok(()) } else { Err(Error::WrongAnswer(inputs)) }
    }
}
