//! Chopper and coolStep settings under the names of the datasheet, range-checked and packed into register
//! fields.

use crate::register::{ChopConf, SmartEn};

mod fit;
pub use fit::Regulated;

/// A setting the chip cannot take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SettingError {
    /// Name of the setting, as in the documentation.
    pub setting: &'static str,
    /// Allowed values, to be read after "must be".
    pub must_be: &'static str,
}

impl core::fmt::Display for SettingError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} must be {}", self.setting, self.must_be)
    }
}

/// Time after a switching event in which the current comparator is ignored, in chip clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum BlankTime {
    Clocks16,
    Clocks24,
    Clocks36,
    Clocks54,
}

impl BlankTime {
    /// Converts from a number of chip clocks; only the four values of the chip.
    #[must_use]
    pub const fn from_clocks(clocks: u8) -> Option<Self> {
        Some(match clocks {
            16 => Self::Clocks16,
            24 => Self::Clocks24,
            36 => Self::Clocks36,
            54 => Self::Clocks54,
            _ => return None,
        })
    }

    /// Returns the time in chip clocks.
    #[must_use]
    pub const fn clocks(self) -> u8 {
        match self {
            Self::Clocks16 => 16,
            Self::Clocks24 => 24,
            Self::Clocks36 => 36,
            Self::Clocks54 => 54,
        }
    }
}

/// Time between two steps by which the hysteresis shrinks during the decay, in chip clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum HysteresisDecrement {
    Clocks16,
    Clocks32,
    Clocks48,
    Clocks64,
}

/// Method of coil current regulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chopper {
    /// Cycle-by-cycle regulation with hysteresis: quiet and exact.
    SpreadCycle {
        /// Slow decay phase, 24 + 32 n clocks. 1 to 15.
        off_time: u8,
        /// Blanking time of the comparator.
        blank_time: BlankTime,
        /// Amount added to `hysteresis_end` at the start of the decay. 1 to 8.
        hysteresis_start: u8,
        /// Hysteresis at its end, in 1/512 of full current. -3 to 12.
        hysteresis_end: i8,
        /// Time of one step down from the start to the end.
        decrement: HysteresisDecrement,
        /// Vary the off time a little at random, to spread audible tones.
        random_off_time: bool,
    },
    /// Fixed off time with a fast decay part: the classic chopper.
    ConstantOffTime {
        /// Slow decay phase, 24 + 32 n clocks. 1 to 15.
        off_time: u8,
        /// Blanking time of the comparator.
        blank_time: BlankTime,
        /// Fast decay phase, 32 n clocks. 0 to 15.
        fast_decay: u8,
        /// Added to the sine wave, in 1/512 of full current. -3 to 12.
        sine_offset: i8,
        /// Whether reaching the target current ends the fast decay before its time.
        comparator_ends_decay: bool,
        /// Vary the off time a little at random, to spread audible tones.
        random_off_time: bool,
    },
}

impl Chopper {
    /// Default of a Smoothieboard v2: spreadCycle, off time 5, blank 54, hysteresis start 5, end 0, fastest
    /// decrement.
    pub const DEFAULT: Self = Self::SpreadCycle {
        off_time: 5,
        blank_time: BlankTime::Clocks54,
        hysteresis_start: 5,
        hysteresis_end: 0,
        decrement: HysteresisDecrement::Clocks16,
        random_off_time: false,
    };

    /// Returns the register value, off time included (TMC2590 datasheet section 7.6).
    pub(crate) fn register(self) -> Result<ChopConf, SettingError> {
        match self {
            Self::SpreadCycle {
                off_time,
                blank_time,
                hysteresis_start,
                hysteresis_end,
                decrement,
                random_off_time,
            } => {
                in_range("hysteresis start", "1 to 8", (1..=8).contains(&hysteresis_start))?;
                let end = offset_by_3("hysteresis end", hysteresis_end)?;
                let total = i16::from(hysteresis_start) + i16::from(hysteresis_end);
                in_range("hysteresis start + end", "at most 15", total <= 15)?;
                Ok(common(off_time, blank_time, random_off_time)?
                    .with_hstrt(u32::from(hysteresis_start) - 1)
                    .with_hend(end)
                    .with_hdec(decrement as u32))
            }
            Self::ConstantOffTime {
                off_time,
                blank_time,
                fast_decay,
                sine_offset,
                comparator_ends_decay,
                random_off_time,
            } => {
                in_range("fast decay time", "0 to 15", fast_decay <= 15)?;
                let fast_decay = u32::from(fast_decay);
                Ok(common(off_time, blank_time, random_off_time)?
                    .with_chm(1)
                    .with_hstrt(fast_decay & 0b111)
                    .with_hdec(fast_decay >> 3 | u32::from(!comparator_ends_decay) << 1)
                    .with_hend(offset_by_3("sine offset", sine_offset)?))
            }
        }
    }
}

fn common(off_time: u8, blank_time: BlankTime, random_off_time: bool) -> Result<ChopConf, SettingError> {
    in_range("off time", "1 to 15", (1..=15).contains(&off_time))?;
    let blank_suffices = off_time > 1 || blank_time != BlankTime::Clocks16;
    in_range("blank time", "at least 24 clocks when the off time is 1", blank_suffices)?;
    Ok(ChopConf::RESET
        .with_toff(u32::from(off_time))
        .with_tbl(blank_time as u32)
        .with_rndtf(u32::from(random_off_time)))
}

/// Adds 3, as the chip stores -3 to 12 as 0 to 15.
fn offset_by_3(setting: &'static str, value: i8) -> Result<u32, SettingError> {
    in_range(setting, "-3 to 12", (-3..=12).contains(&value))?;
    Ok((i32::from(value) + 3).unsigned_abs())
}

pub(crate) fn in_range(setting: &'static str, must_be: &'static str, holds: bool) -> Result<(), SettingError> {
    if holds { Ok(()) } else { Err(SettingError { setting, must_be }) }
}

/// Returns the error for a load reading asked of a chip that has no load measurement.
pub(crate) const fn no_load_measurement() -> SettingError {
    SettingError { setting: "load measurement", must_be: "asked of a chip that has one" }
}

/// Load-dependent current (coolStep), as register codes of TMC2590 datasheet section 7.7.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoolStep {
    /// Current rises when the stallGuard2 value is below 32 n. 1 to 15.
    pub lower_threshold: u8,
    /// Current falls when the stallGuard2 value is at or above 32 (lower + n + 1). 0 to 15.
    pub threshold_width: u8,
    /// Current steps up per low reading: 1, 2, 4, 8 as 0 to 3.
    pub increment: u8,
    /// High readings per step down: 32, 8, 2, 1 as 0 to 3.
    pub decrement: u8,
    /// Fall to a quarter of the set current rather than half.
    pub quarter_current: bool,
}

impl CoolStep {
    pub(crate) fn register(self) -> Result<SmartEn, SettingError> {
        in_range("coolStep lower threshold", "1 to 15", (1..=15).contains(&self.lower_threshold))?;
        in_range("coolStep threshold width", "0 to 15", self.threshold_width <= 15)?;
        in_range("coolStep increment", "0 to 3", self.increment <= 3)?;
        in_range("coolStep decrement", "0 to 3", self.decrement <= 3)?;
        Ok(SmartEn::RESET
            .with_semin(u32::from(self.lower_threshold))
            .with_semax(u32::from(self.threshold_width))
            .with_seup(u32::from(self.increment))
            .with_sedn(u32::from(self.decrement))
            .with_seimin(u32::from(self.quarter_current)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_default_is_what_a_smoothieboard_loads() {
        let register = Chopper::DEFAULT.register().unwrap();
        assert_eq!((register.toff(), register.tbl(), register.hstrt(), register.hend()), (5, 3, 4, 3));
        assert_eq!((register.chm(), register.hdec(), register.rndtf()), (0, 0, 0));
    }

    proptest! {
        #[test]
        fn a_chopper_is_refused_or_says_in_the_register_what_was_asked(
            off_time: u8, start: u8, end: i8, blank in prop::sample::select(vec![16_u8, 24, 36, 54]),
        ) {
            let blank_time = BlankTime::from_clocks(blank).unwrap();
            let chopper = Chopper::SpreadCycle {
                off_time, blank_time, hysteresis_start: start, hysteresis_end: end,
                decrement: HysteresisDecrement::Clocks32, random_off_time: true,
            };
            if let Ok(register) = chopper.register() {
                prop_assert_eq!(register.toff(), u32::from(off_time));
                prop_assert_eq!(register.hstrt() + 1, u32::from(start));
                prop_assert_eq!(register.hend() as i32 - 3, i32::from(end));
                prop_assert_eq!(register.rndtf(), 1);
                prop_assert_eq!(blank_time.clocks(), blank);
                prop_assert!(off_time != 0, "an off time of 0 would switch the motor off");
            } else {
                prop_assert!(!(2..=15).contains(&off_time) || !(1..=8).contains(&start)
                    || !(-3..=12).contains(&end) || i16::from(start) + i16::from(end) > 15);
            }
        }

        #[test]
        fn fast_decay_time_is_split_over_its_two_fields(fast_decay in 0_u8..=15, comparator: bool) {
            let register = Chopper::ConstantOffTime {
                off_time: 7, blank_time: BlankTime::Clocks54, fast_decay, sine_offset: 1,
                comparator_ends_decay: comparator, random_off_time: false,
            }.register().unwrap();
            prop_assert_eq!((register.hdec() & 1) << 3 | register.hstrt(), u32::from(fast_decay));
            prop_assert_eq!(register.hdec() >> 1 == 0, comparator);
            prop_assert_eq!((register.chm(), register.hend()), (1, 4));
        }
    }

    #[test]
    fn the_shortest_off_time_needs_a_longer_blank_time() {
        let with_blank = |blank_time| Chopper::SpreadCycle {
            off_time: 1,
            blank_time,
            hysteresis_start: 1,
            hysteresis_end: 0,
            decrement: HysteresisDecrement::Clocks16,
            random_off_time: false,
        };
        assert_eq!(with_blank(BlankTime::Clocks16).register().unwrap_err().setting, "blank time");
        assert!(with_blank(BlankTime::Clocks24).register().is_ok());
    }

    #[test]
    fn coolstep_refuses_what_its_fields_cannot_hold() {
        let good =
            CoolStep { lower_threshold: 5, threshold_width: 2, increment: 1, decrement: 3, quarter_current: true };
        let register = good.register().unwrap();
        assert_eq!((register.semin(), register.semax(), register.seup()), (5, 2, 1));
        assert_eq!((register.sedn(), register.seimin()), (3, 1));
        assert!(CoolStep { lower_threshold: 0, ..good }.register().is_err());
        assert!(CoolStep { increment: 4, ..good }.register().is_err());
    }
}
