//! Settings of a stealthChop driver, and the register words made of them.

use super::current::StealthCurrent;
use super::register::{self, Register, chopconf, coolconf, drv_conf, gconf, ihold_irun, wire};
use super::{LONGEST_STEP_TIME, LoadMeasurement, StealthChip};
use crate::chopper::{BlankTime, Chopper, CoolStep, HysteresisDecrement, SettingError, in_range};
use crate::driver::Microsteps;
use units::Ohms;

/// Time of each step down to IHOLD and the delay before the first step, as after power-up. Both have no
/// effect, as IHOLD equals IRUN.
const HOLD_DELAY: u32 = 6;
const POWER_DOWN: u32 = 10;
/// Passive fast decay time, as after power-up.
const FAST_DECAY: u32 = 4;
/// SENDDELAY, see [`wire::SENDDELAY`].
const SEND_DELAY: u32 = 2;
/// Most registers that are set.
const MOST_WORDS: usize = 13;

/// Settings of a chip, apart from its current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StealthSettings {
    /// The sense resistor, or the reference resistor of a TMC2240.
    pub resistor: Ohms,
    /// Microsteps per full step.
    pub microsteps: Microsteps,
    /// The chip makes 256 microsteps of each step by time.
    pub interpolation: bool,
    /// Highest speed of stealthChop, as a step time (see [`super::step_time`]), 0 at any speed; `None`:
    /// spreadCycle at any speed.
    pub stealth_threshold: Option<u32>,
    /// Off time of spreadCycle, 1 to 15: the slow decay phase.
    pub off_time: u8,
    /// spreadCycle: comparator blanking, of which a TMC2208 or TMC2209 makes 16, 24, 32 or 40 clocks.
    pub blank_time: BlankTime,
    /// Hysteresis start of spreadCycle, 1 to 8.
    pub hysteresis_start: u8,
    /// Hysteresis end of spreadCycle, -3 to 12; the sum with the start at most 16.
    pub hysteresis_end: i8,
    /// Threshold of the stall detection, see [`LoadMeasurement`].
    pub stall_threshold: i16,
    /// Filter of stallGuard2: measures over four full steps.
    pub stall_filter: bool,
    /// DIAG0 and DIAG1 signal a stall; that of a TMC2209 always does.
    pub stall_output: bool,
    /// Least speed of the load measurement, as a step time (see [`super::step_time`]); `None`: at any speed.
    pub load_from: Option<u32>,
    /// Load-dependent current (coolStep).
    pub cool_step: Option<CoolStep>,
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
            stall_threshold: 0,
            stall_filter: false,
            stall_output: false,
            load_from: None,
            cool_step: None,
        }
    }

    /// Checks that the chip can take the settings.
    ///
    /// # Errors
    /// The setting, and its allowed values.
    pub fn check(&self, chip: StealthChip) -> Result<(), SettingError> {
        let is_resistor = self.resistor.0 > 0.0 && self.resistor.0.is_finite();
        in_range("sense or reference resistor", "above 0 Ohm", is_resistor)?;
        let measures = chip.load() != LoadMeasurement::None;
        in_range("load measurement", "off in a TMC2208", measures || !self.stall_output && self.cool_step.is_none())?;
        let allowed = if chip.load() == LoadMeasurement::StallGuard4 { "0 to 255" } else { "-64 to 63" };
        in_range("stallGuard threshold", allowed, chip.load().thresholds().contains(&self.stall_threshold))?;
        self.cool_step.map_or(Ok(()), |cool_step| cool_step.register().map(drop))?;
        self.chopper().map(drop)
    }

    /// Returns the chopper's bits of CHOPCONF.
    fn chopper(&self) -> Result<u32, SettingError> {
        let chopper = Chopper::SpreadCycle {
            off_time: self.off_time,
            blank_time: self.blank_time,
            hysteresis_start: self.hysteresis_start,
            hysteresis_end: self.hysteresis_end,
            // Without bits in these chips: fast decay time and mode, which spreadCycle does not use.
            decrement: HysteresisDecrement::Clocks16,
            random_off_time: false,
        };
        Ok(chopper.register()?.word() & chopconf::CHOPPER)
    }

    /// Returns CHOPCONF, with the bridges on or off. An invalid chopper leaves them off.
    pub(super) fn chopconf(&self, chip: StealthChip, current: &StealthCurrent, enabled: bool) -> u32 {
        let word = self.chopper().unwrap_or(0);
        let word = chopconf::MRES.put(word, self.microsteps as u32);
        let word = chopconf::INTPOL.put(word, u32::from(self.interpolation));
        let word = if chip.has_global_scaler() {
            chopconf::TPFD.put(word, FAST_DECAY)
        } else {
            chopconf::VSENSE.put(word, u32::from(current.low_range))
        };
        if enabled { word } else { chopconf::TOFF.put(word, 0) }
    }

    /// Returns the word of GCONF.
    fn gconf(&self, chip: StealthChip) -> u32 {
        if chip.is_on_wire() {
            let word = wire::gconf::EN_SPREADCYCLE.put(0, u32::from(self.stealth_threshold.is_none()));
            return [wire::gconf::PDN_DISABLE, wire::gconf::MSTEP_REG_SELECT, wire::gconf::MULTISTEP_FILT]
                .into_iter()
                .fold(word, |word, field| field.put(word, 1));
        }
        let word = gconf::EN_PWM_MODE.put(0, u32::from(self.stealth_threshold.is_some()));
        let word = gconf::DIAG0_STALL.put(word, u32::from(self.stall_output));
        let word = gconf::DIAG1_STALL.put(word, u32::from(self.stall_output));
        if chip == StealthChip::Tmc2130 { word } else { gconf::MULTISTEP_FILT.put(word, 1) }
    }

    /// Returns the words of the load measurement: least speed, coolStep, and threshold.
    pub(super) fn load_words(&self, chip: StealthChip) -> [Option<(Register, u32)>; 3] {
        let is_used = self.stall_output || self.cool_step.is_some();
        let from = if is_used { self.load_from.unwrap_or(LONGEST_STEP_TIME) } else { 0 };
        let cool_step = self.cool_step.and_then(|cool_step| cool_step.register().ok());
        let cool_step = cool_step.map_or(0, |register| register.word() & coolconf::COOL_STEP);
        match chip.load() {
            LoadMeasurement::None => [None; 3],
            LoadMeasurement::StallGuard2 => {
                // Two's complement of seven bits.
                let threshold = self.stall_threshold.cast_unsigned() & 0x7F;
                let word = coolconf::SGT.put(cool_step, u32::from(threshold));
                let word = coolconf::SFILT.put(word, u32::from(self.stall_filter));
                [Some((register::TCOOLTHRS, from)), Some((register::COOLCONF, word)), None]
            }
            LoadMeasurement::StallGuard4 => [
                Some((register::TCOOLTHRS, from)),
                Some((wire::COOLCONF, cool_step)),
                Some((wire::SGTHRS, u32::from(self.stall_threshold.cast_unsigned()))),
            ],
        }
    }

    /// Returns the words that select the chopper and the speed up to which it is used.
    pub(super) fn mode_words(&self, chip: StealthChip) -> [(Register, u32); 2] {
        [(register::GCONF, self.gconf(chip)), (register::TPWMTHRS, self.stealth_threshold.unwrap_or(0))]
    }

    /// Returns all register words in the order in which they are written: CHOPCONF, as given, comes first.
    pub(super) fn words(
        &self,
        chip: StealthChip,
        current: &StealthCurrent,
        enabled: bool,
    ) -> impl Iterator<Item = (Register, u32)> + use<> {
        let [gconf, pwm_threshold] = self.mode_words(chip);
        let [load_from, load, threshold] = self.load_words(chip);
        let words: [Option<(Register, u32)>; MOST_WORDS] = [
            // Set before any chip answers on a line that others hear.
            chip.is_on_wire().then(|| (wire::SLAVECONF, wire::SENDDELAY.put(0, SEND_DELAY))),
            Some((register::CHOPCONF, self.chopconf(chip, current, enabled))),
            Some(gconf),
            (chip == StealthChip::Tmc2240).then(|| range(current)),
            chip.has_global_scaler().then(|| scaler(current)),
            Some(scale(current)),
            Some((register::TPOWERDOWN, POWER_DOWN)),
            Some(pwm_threshold),
            load_from,
            (!chip.is_on_wire()).then_some((register::THIGH, 0)),
            load,
            threshold,
            Some((register::PWMCONF, chip.pwmconf())),
        ];
        words.into_iter().flatten()
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
