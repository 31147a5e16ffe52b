//! Conversion of amperes to the current scale. TMC2590 datasheet section 7.8 (`CS`) and 7.9 (`VSENSE`),
//! TMC2660 sections 6.8 and 6.9: peak current = (`CS` + 1) / 32 * full-scale sense voltage / sense resistor.

use crate::Chip;
use units::{Amps, Ohms, Volts};

/// Steps of the current scale.
const SCALE_STEPS: f32 = 32.0;
/// Least current scale for the high range: below half scale the sense voltage is small against the
/// comparator's offset, and the lower range is finer.
const LOWEST_GOOD_CS: u8 = 16;
const HIGHEST_CS: u8 = 31;

/// Match between the requested current and the possible one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurrentFit {
    /// Current scale in the chip's good range.
    Good,
    /// Current so small for this sense resistor that microsteps lose accuracy; a larger resistor would help.
    Coarse,
    /// Current above the limit of the chip with this sense resistor; set to that limit.
    Limited,
}

/// Current as the two register fields of the chip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurrentSetting {
    /// `CS`, 0 to 31.
    pub cs: u8,
    /// `VSENSE`: the lower full-scale voltage.
    pub low_range: bool,
    /// Peak current that these fields give.
    pub actual: Amps,
    /// Match with the requested current.
    pub fit: CurrentFit,
}

impl CurrentSetting {
    /// Returns the setting of a current scale (0 to 31) and a sense voltage range.
    #[must_use]
    pub fn new(chip: Chip, sense_resistor: Ohms, cs: u8, low_range: bool) -> Self {
        let fit = if cs < LOWEST_GOOD_CS { CurrentFit::Coarse } else { CurrentFit::Good };
        Self { cs, low_range, actual: chip.current(sense_resistor, cs, low_range), fit }
    }
}

impl Chip {
    /// Returns the sense voltage at full scale, in the high and in the low range (`VSENSE` 0 and 1).
    #[must_use]
    pub const fn full_scale(self, low_range: bool) -> Volts {
        match (self, low_range) {
            (Self::Tmc2590, false) => Volts(0.325),
            (Self::Tmc2590, true) => Volts(0.173),
            (Self::Tmc2660, false) => Volts(0.310),
            (Self::Tmc2660, true) => Volts(0.165),
        }
    }

    /// Returns the peak current of a scale and range.
    #[must_use]
    pub fn current(self, sense_resistor: Ohms, cs: u8, low_range: bool) -> Amps {
        Amps((f32::from(cs) + 1.0) / SCALE_STEPS * self.full_scale(low_range).0 / sense_resistor.0)
    }
}

/// Returns the nearest setting to a peak current: the high range if it fills at least half of the scale, else
/// the low range.
#[must_use]
pub fn current_setting(chip: Chip, sense_resistor: Ohms, peak: Amps) -> CurrentSetting {
    let exact = |low_range| SCALE_STEPS * sense_resistor.0 * peak.0 / chip.full_scale(low_range).0 - 1.0;
    let low_range = nearest(exact(false)) < LOWEST_GOOD_CS;
    let exact = exact(low_range);
    let mut setting = CurrentSetting::new(chip, sense_resistor, nearest(exact), low_range);
    if exact >= f32::from(HIGHEST_CS) + 0.5 {
        setting.fit = CurrentFit::Limited;
    }
    setting
}

fn nearest(exact: f32) -> u8 {
    // A float to integer cast saturates, and turns NaN into 0.
    ((exact + 0.5) as u8).min(HIGHEST_CS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_typical_motor_lands_where_the_formula_says() {
        // 32 * 0.05 * 3.5 / 0.325 - 1 = 16.2
        let setting = current_setting(Chip::Tmc2590, Ohms(0.05), Amps(3.5));
        assert_eq!((setting.cs, setting.low_range, setting.fit), (16, false, CurrentFit::Good));
        // 32 * 0.05 * 1.5 / 0.325 - 1 = 6.4, so the low range: 32 * 0.05 * 1.5 / 0.173 - 1 = 12.9
        let setting = current_setting(Chip::Tmc2590, Ohms(0.05), Amps(1.5));
        assert_eq!((setting.cs, setting.low_range, setting.fit), (13, true, CurrentFit::Coarse));
        let setting = current_setting(Chip::Tmc2660, Ohms(0.1), Amps(9.0));
        assert_eq!((setting.cs, setting.fit), (31, CurrentFit::Limited));
        assert!((setting.actual.0 - 3.1).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn the_actual_current_is_within_half_a_scale_step(
            milliamps in 0.0_f32..4_000.0,
            milliohms in 40.0_f32..150.0,
            new_chip: bool,
        ) {
            let chip = if new_chip { Chip::Tmc2590 } else { Chip::Tmc2660 };
            let (sense, asked) = (Ohms(milliohms / 1e3), Amps(milliamps / 1e3));
            let setting = current_setting(chip, sense, asked);
            let step = chip.current(sense, 0, setting.low_range);
            if setting.fit == CurrentFit::Limited {
                prop_assert!(setting.actual < asked);
            } else {
                let error = setting.actual.0 - asked.0;
                let floor = asked.0 < step.0 * 0.5; // The scale has no zero.
                prop_assert!(error.abs() <= step.0 * 0.501 || floor, "{} for {}", setting.actual, asked);
            }
        }

        #[test]
        fn asking_for_more_never_gives_less(first in 0.0_f32..6.0, second in 0.0_f32..6.0) {
            let of = |amps| current_setting(Chip::Tmc2590, Ohms(0.05), Amps(amps)).actual.0;
            let (low, high) = if first < second { (first, second) } else { (second, first) };
            // The switch between ranges may cost at most half a step of the coarser one.
            prop_assert!(of(low) <= of(high) + 0.5 * 0.325 / 32.0 / 0.05 + 1e-5);
        }

        #[test]
        fn nonsense_gives_a_setting_and_never_a_panic(resistor: f32, amps: f32) {
            prop_assert!(current_setting(Chip::Tmc2660, Ohms(resistor), Amps(amps)).cs <= 31);
        }
    }
}
