//! A driver's settings in a person's terms, and the register words that they make.

use super::StealthChip;
use super::current::StealthCurrent;
use super::register::{self, Register, chopconf, drv_conf, gconf, ihold_irun};
use crate::chopper::{BlankTime, Chopper, HysteresisDecrement, SettingError, in_range};
use crate::driver::Microsteps;
use units::Ohms;

/// How long the chip takes for each step down to IHOLD, and what it waits before, as after power-up. IHOLD is
/// IRUN, so they change nothing.
const HOLD_DELAY: u32 = 6;
const POWER_DOWN: u32 = 10;
/// Passive fast decay time, as after power-up.
const FAST_DECAY: u32 = 4;

/// How a chip is set up; its current comes beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StealthSettings {
    /// The sense resistor, or the reference resistor of a TMC2240.
    pub resistor: Ohms,
    /// Microsteps per full step.
    pub microsteps: Microsteps,
    /// The chip makes 256 microsteps of each step by time.
    pub interpolation: bool,
    /// Up to this speed stealthChop, as [`super::step_time`] counts; none: spreadCycle at any speed.
    pub stealth_threshold: Option<u32>,
    /// spreadCycle: slow decay phase, 1 to 15.
    pub off_time: u8,
    /// spreadCycle: comparator blanking.
    pub blank_time: BlankTime,
    /// spreadCycle: 1 to 8.
    pub hysteresis_start: u8,
    /// spreadCycle: -3 to 12; the sum with the start at most 16.
    pub hysteresis_end: i8,
}

impl StealthSettings {
    /// The settings of the datasheets' example for a start ("Initialization example": CHOPCONF 000100C3),
    /// with 16 microsteps.
    #[must_use]
    pub const fn new(resistor: Ohms) -> Self {
        Self {
            resistor,
            microsteps: Microsteps::M16,
            interpolation: false,
            stealth_threshold: None,
            off_time: 3,
            blank_time: BlankTime::Clocks36,
            hysteresis_start: 5,
            hysteresis_end: -2,
        }
    }

    /// What no chip can take.
    ///
    /// # Errors
    /// The setting, and what it must be.
    pub fn check(&self) -> Result<(), SettingError> {
        let is_resistor = self.resistor.0 > 0.0 && self.resistor.0.is_finite();
        in_range("sense or reference resistor", "above 0 Ohm", is_resistor)?;
        self.chopper().map(drop)
    }

    /// The chopper's bits of CHOPCONF.
    fn chopper(&self) -> Result<u32, SettingError> {
        let chopper = Chopper::SpreadCycle {
            off_time: self.off_time,
            blank_time: self.blank_time,
            hysteresis_start: self.hysteresis_start,
            hysteresis_end: self.hysteresis_end,
            // No bits of these chips: fast decay time and mode, which spreadCycle does not use.
            decrement: HysteresisDecrement::Clocks16,
            random_off_time: false,
        };
        Ok(chopper.register()?.word() & chopconf::CHOPPER)
    }

    /// CHOPCONF, with the bridges on or off. A chopper that cannot be leaves them off.
    pub(super) fn chopconf(&self, chip: StealthChip, current: &StealthCurrent, enabled: bool) -> u32 {
        let word = self.chopper().unwrap_or(0);
        let word = chopconf::MRES.put(word, self.microsteps as u32);
        let word = chopconf::INTPOL.put(word, u32::from(self.interpolation));
        let word = if chip == StealthChip::Tmc2130 {
            chopconf::VSENSE.put(word, u32::from(current.low_range))
        } else {
            chopconf::TPFD.put(word, FAST_DECAY)
        };
        if enabled { word } else { chopconf::TOFF.put(word, 0) }
    }

    /// GCONF.
    pub(super) fn gconf(&self, chip: StealthChip) -> u32 {
        let word = gconf::EN_PWM_MODE.put(0, u32::from(self.stealth_threshold.is_some()));
        if chip == StealthChip::Tmc2130 { word } else { gconf::MULTISTEP_FILT.put(word, 1) }
    }

    /// Every register that is set, in the order in which it is written: CHOPCONF, as given, comes first.
    pub(super) fn words(
        &self,
        chip: StealthChip,
        current: &StealthCurrent,
        enabled: bool,
    ) -> impl Iterator<Item = (Register, u32)> + use<> {
        [
            Some((register::CHOPCONF, self.chopconf(chip, current, enabled))),
            Some((register::GCONF, self.gconf(chip))),
            (chip == StealthChip::Tmc2240).then(|| range(current)),
            chip.has_global_scaler().then(|| scaler(current)),
            Some(scale(current)),
            Some((register::TPOWERDOWN, POWER_DOWN)),
            Some((register::TPWMTHRS, self.stealth_threshold.unwrap_or(0))),
            Some((register::TCOOLTHRS, 0)),
            Some((register::THIGH, 0)),
            Some((register::COOLCONF, 0)),
            Some((register::PWMCONF, chip.pwmconf())),
        ]
        .into_iter()
        .flatten()
    }
}

/// DRV_CONF of a TMC2240: the range, with the gentlest slopes, as after power-up.
pub(super) fn range(current: &StealthCurrent) -> (Register, u32) {
    (register::DRV_CONF, drv_conf::CURRENT_RANGE.put(0, u32::from(current.range)))
}

/// GLOBALSCALER: 0 stands for 256.
pub(super) fn scaler(current: &StealthCurrent) -> (Register, u32) {
    (register::GLOBALSCALER, u32::from(current.scaler) & 0xFF)
}

/// IHOLD_IRUN. The machine knows better than the chip when its motors rest, so both are alike.
pub(super) fn scale(current: &StealthCurrent) -> (Register, u32) {
    let cs = u32::from(current.cs);
    let word = ihold_irun::IHOLDDELAY.put(ihold_irun::IRUN.put(ihold_irun::IHOLD.put(0, cs), cs), HOLD_DELAY);
    (register::IHOLD_IRUN, word)
}
