//! Driver of one stealthChop chip. The driver keeps its settings, so that it can write all of them again
//! after a loss of the chip's supply.

use super::bus::RegisterBus;
use super::current::{StealthCurrent, stealth_current};
use super::register::{self, Register, gstat, ioin};
use super::search::Search;
use super::settings::{StealthSettings, range, scale, scaler};
use super::status::StealthStatus;
use super::{LoadMeasurement, StealthChip};
use crate::Error;
use crate::driver::Microsteps;
use units::Amps;

/// Chip on its bus with its settings.
#[derive(Debug)]
pub struct StealthDriver<BUS> {
    pub(super) bus: BUS,
    pub(super) chip: StealthChip,
    pub(super) settings: StealthSettings,
    pub(super) current: StealthCurrent,
    enabled: bool,
    /// A TMC2130 that was found reset, until it is set up again: reading has cleared its flag.
    was_reset: bool,
    /// Search for a stall in progress.
    pub(super) search: Option<Search>,
    /// The restored settings have not reached the chip.
    pub(super) is_stale: bool,
}

impl<BUS: RegisterBus> StealthDriver<BUS> {
    /// Creates a driver with these settings, disabled, at the lowest current. Sends nothing.
    ///
    /// # Errors
    /// [`Error::Setting`] for what the chip cannot take.
    pub fn new(bus: BUS, chip: StealthChip, settings: StealthSettings) -> Result<Self, Error<BUS::Error>> {
        settings.check(chip)?;
        let current = stealth_current(chip, settings.resistor, Amps(0.0), 0);
        Ok(Self { bus, chip, settings, current, enabled: false, was_reset: false, search: None, is_stale: false })
    }

    /// Writes every register with the bridges off, clears the latched flags of the chip, and checks that a
    /// chip of this kind has taken all. Takes about 20 datagrams; without a chip, two.
    ///
    /// # Errors
    /// Bus errors, [`Error::Absent`], [`Error::WrongAnswer`].
    pub fn start(&mut self) -> Result<(), Error<BUS::Error>> {
        self.enabled = false;
        self.answers()?;
        for (register, word) in self.in_force().words(self.chip, &self.current, false) {
            self.bus.write(register.address, word)?;
        }
        self.bus.write(register::GSTAT.address, gstat::ALL)?;
        let chopconf = self.settings.chopconf(self.chip, &self.current, false);
        let addresses = [register::GSTAT.address, register::CHOPCONF.address, self.chip.inputs().address];
        let [_cleared, taken, inputs] = self.bus.read(addresses)?;
        self.is_of_this_kind(inputs)?;
        (self.was_reset, self.is_stale) = (false, false);
        if taken == chopconf { Ok(()) } else { Err(Error::WrongAnswer(taken)) }
    }

    /// Asks for the chip's status. Takes four datagrams.
    ///
    /// # Errors
    /// Bus errors, [`Error::Absent`], [`Error::WrongAnswer`].
    pub fn status(&mut self) -> Result<StealthStatus, Error<BUS::Error>> {
        let addresses = [register::DRV_STATUS.address, register::GSTAT.address, self.chip.inputs().address];
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

    /// Returns whether the reset flag was real rather than a disturbed bit: asked once more, or, if reading
    /// has cleared it, by CHOPCONF, which is 0 after a reset of a TMC2130.
    fn is_reset(&mut self) -> Result<bool, Error<BUS::Error>> {
        let addresses = [register::GSTAT.address, register::CHOPCONF.address, self.chip.inputs().address];
        let [global, chopconf, _] = self.bus.read(addresses)?;
        Ok(if self.chip == StealthChip::Tmc2130 { chopconf == 0 } else { gstat::RESET.get(global) == 1 })
    }

    /// Reads a register of the chip.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn read(&mut self, register: Register) -> Result<u32, Error<BUS::Error>> {
        let [value, inputs] = self.bus.read([register.address, self.chip.inputs().address])?;
        self.is_of_this_kind(inputs)?;
        Ok(value)
    }

    /// Switches the bridges on.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn enable(&mut self) -> Result<(), Error<BUS::Error>> {
        if self.is_stale {
            self.start()?;
        }
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

    /// Returns whether the bridges were last switched on.
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

    /// Returns the current that is set.
    #[must_use]
    pub const fn current(&self) -> &StealthCurrent {
        &self.current
    }

    /// Sets the microsteps per full step.
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn set_microsteps(&mut self, microsteps: Microsteps) -> Result<(), Error<BUS::Error>> {
        self.settings.microsteps = microsteps;
        self.write_chopconf()
    }

    /// Sets the differences of these settings to those in force: the chopper, the load measurement, the speed
    /// up to which stealthChop drives. The motor must stand still.
    ///
    /// # Errors
    /// [`Error::Setting`] for what the chip cannot take, and nothing is sent; else as [`Self::status`].
    pub fn set(&mut self, settings: StealthSettings) -> Result<(), Error<BUS::Error>> {
        settings.check(self.chip)?;
        self.settings = settings;
        self.write_mode_and_load()?;
        self.write_chopconf()
    }

    /// Reads the load reserve of the motor: 0 for a stall, to 1023. A TMC2209's reading is counted from its
    /// threshold on, and doubled to the range of the others.
    ///
    /// # Errors
    /// As [`Self::status`]; [`Error::Setting`] for a chip that measures none.
    pub fn reserve(&mut self) -> Result<u16, Error<BUS::Error>> {
        match self.chip.load() {
            LoadMeasurement::StallGuard2 => Ok(self.status()?.stall_guard),
            LoadMeasurement::StallGuard4 => {
                let reading = self.read(register::wire::SG_RESULT)? as u16;
                let stall = 2 * self.in_force().stall_threshold.cast_unsigned();
                Ok((2 * reading.saturating_sub(stall)).min(1023))
            }
            LoadMeasurement::None => Err(crate::chopper::no_load_measurement().into()),
        }
    }

    /// Returns the settings of the driver.
    #[must_use]
    pub const fn settings(&self) -> &StealthSettings {
        &self.settings
    }

    /// Returns the type of the chip.
    #[must_use]
    pub const fn chip(&self) -> StealthChip {
        self.chip
    }

    /// Returns the registers that are set, with their present values.
    pub fn words(&self) -> impl Iterator<Item = (Register, u32)> + use<BUS> {
        self.in_force().words(self.chip, &self.current, self.enabled)
    }

    /// Writes the registers that make the current. In this order the current between two writes is below the
    /// larger of the old and the new one: full scale falls before the scale rises, and rises after the scale
    /// has fallen.
    pub(super) fn write_current(&mut self, before: StealthCurrent) -> Result<(), Error<BUS::Error>> {
        let full = |current: &StealthCurrent| {
            let of_range = self.chip.full_scale(self.settings.resistor, current.low_range, current.range);
            of_range.0 * f32::from(current.scaler)
        };
        let falls = full(&self.current) < full(&before);
        let scale = scale(&self.current);
        if !falls {
            self.bus.write(scale.0.address, scale.1)?;
        }
        if self.chip.has_global_scaler() {
            self.write_full_scale(before)?;
        } else {
            self.bus
                .write(register::CHOPCONF.address, self.settings.chopconf(self.chip, &self.current, self.enabled))?;
        }
        if falls {
            self.bus.write(scale.0.address, scale.1)?;
        }
        self.answers()
    }

    /// Writes the full scale: a larger range needs a smaller scaler first.
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

    /// Checks that a chip of this kind answers.
    fn answers(&mut self) -> Result<(), Error<BUS::Error>> {
        let [inputs] = self.bus.read([self.chip.inputs().address])?;
        self.is_of_this_kind(inputs)
    }

    fn is_of_this_kind(&self, inputs: u32) -> Result<(), Error<BUS::Error>> {
        if ioin::VERSION.get(inputs) == self.chip.version() { Ok(()) } else { Err(Error::WrongAnswer(inputs)) }
    }
}
