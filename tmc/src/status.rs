//! The 20-bit answer to every write. TMC2590 datasheet section 7.10, TMC2660 section 6.10.

use crate::register::Field;

/// Selection of the reading in bits 19 to 10 of the answer (`RDSEL`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReadSelect {
    /// Position in the sine table.
    #[default]
    Microstep = 0,
    /// Load value of stallGuard2.
    StallGuard = 1,
    /// Top half of the stallGuard2 value and the coolStep current.
    StallGuardAndCurrent = 2,
    /// All detectors. TMC2590 only.
    Diagnostics = 3,
}

impl ReadSelect {
    pub(crate) const fn from_code(code: u32) -> Self {
        match code & 0b11 {
            0 => Self::Microstep,
            1 => Self::StallGuard,
            2 => Self::StallGuardAndCurrent,
            _ => Self::Diagnostics,
        }
    }
}

/// Range of the chip temperature, by its four detectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the names are the meaning, in degrees Celsius")]
pub enum Temperature {
    Below100,
    Above100,
    Above120,
    Above136,
    Above150,
}

/// The detectors one by one. TMC2590 only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Diagnostics {
    /// Motor supply below 7 V.
    pub undervoltage: bool,
    /// The ENN input is high: bridges held off from outside.
    pub enable_input_off: bool,
    /// Coil B shorted to supply.
    pub short_to_supply_b: bool,
    /// Coil B shorted to ground.
    pub short_to_ground_b: bool,
    /// Coil A shorted to supply.
    pub short_to_supply_a: bool,
    /// Coil A shorted to ground.
    pub short_to_ground_a: bool,
    /// Range of the chip temperature.
    pub temperature: Temperature,
}

/// Bits 19 to 10 of the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// Position in the sine table of coil A, 0 to 1023 for four full steps.
    Microstep(u16),
    /// stallGuard2 value, 0 (stalled) to 1023 (no load).
    StallGuard(u16),
    /// stallGuard2 value in steps of 32, and coolStep's current scale (0 to 31).
    StallGuardAndCurrent {
        /// Load value, 0 to 992.
        stall_guard: u16,
        /// Current scale, 0 to 31.
        current_scale: u8,
    },
    /// Results of all detectors.
    Diagnostics(Diagnostics),
}

/// Decoded answer of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// The stallGuard2 threshold is reached.
    pub stall: bool,
    /// The chip is too hot and has shut its bridges.
    pub over_temperature: bool,
    /// The chip is getting too hot.
    pub over_temperature_warning: bool,
    /// Coil A is shorted; bridges are shut until disabled and enabled again.
    pub short_a: bool,
    /// Coil B is shorted.
    pub short_b: bool,
    /// Coil A seems not connected. True at slow motion only; at standstill or at speed the chip may be wrong.
    pub open_load_a: bool,
    /// Coil B seems not connected.
    pub open_load_b: bool,
    /// No step for 2^20 chip clocks (about 70 ms).
    pub standstill: bool,
    /// Reading selected by `RDSEL`.
    pub reading: Reading,
    /// The 20 bits as they came.
    pub raw: u32,
}

const READING: Field = Field { name: "reading", lsb: 10, width: 10 };
/// Unused bits that tell the answer's format: %11 with all detectors, else %00.
const FORMAT: Field = Field { name: "format", lsb: 8, width: 2 };

impl Status {
    /// Decodes a 20-bit answer, `select` being the reading that the chip was set to show. Returns `None` for
    /// an answer of another format.
    #[must_use]
    pub fn decode(raw: u32, select: ReadSelect) -> Option<Self> {
        let format = if select == ReadSelect::Diagnostics { 0b11 } else { 0b00 };
        if FORMAT.get(raw) != format {
            return None;
        }
        let bit = |bit: u32| raw >> bit & 1 == 1;
        let reading = READING.get(raw) as u16;
        Some(Self {
            stall: bit(0),
            over_temperature: bit(1),
            over_temperature_warning: bit(2),
            short_a: bit(3),
            short_b: bit(4),
            open_load_a: bit(5),
            open_load_b: bit(6),
            standstill: bit(7),
            reading: match select {
                ReadSelect::Microstep => Reading::Microstep(reading),
                ReadSelect::StallGuard => Reading::StallGuard(reading),
                ReadSelect::StallGuardAndCurrent => Reading::StallGuardAndCurrent {
                    stall_guard: reading & !0b1_1111,
                    current_scale: (reading & 0b1_1111) as u8,
                },
                ReadSelect::Diagnostics => Reading::Diagnostics(Diagnostics {
                    undervoltage: bit(19),
                    enable_input_off: bit(18),
                    short_to_supply_b: bit(17),
                    short_to_ground_b: bit(16),
                    short_to_supply_a: bit(15),
                    short_to_ground_a: bit(14),
                    temperature: match (bit(13), bit(12), bit(11), bit(10)) {
                        (true, ..) => Temperature::Above150,
                        (_, true, ..) => Temperature::Above136,
                        (_, _, true, _) => Temperature::Above120,
                        (_, _, _, true) => Temperature::Above100,
                        _ => Temperature::Below100,
                    },
                }),
            },
            raw,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn an_answer_is_decoded_exactly_when_its_format_bits_fit(raw in 0_u32..1 << 20, code in 0_u32..4) {
            let select = ReadSelect::from_code(code);
            let fits = (raw >> 8 & 0b11 == 0b11) == (code == 3) && matches!(raw >> 8 & 0b11, 0b00 | 0b11);
            prop_assert_eq!(Status::decode(raw, select).is_some(), fits);
        }
    }

    #[test]
    fn each_flag_is_its_own_bit() {
        let flags = |raw| {
            let s = Status::decode(raw, ReadSelect::Microstep).unwrap();
            [
                s.stall,
                s.over_temperature,
                s.over_temperature_warning,
                s.short_a,
                s.short_b,
                s.open_load_a,
                s.open_load_b,
                s.standstill,
            ]
        };
        for bit in 0..8 {
            let mut expected = [false; 8];
            expected[bit] = true;
            assert_eq!(flags(1 << bit), expected);
        }
    }

    #[test]
    fn readings_follow_the_selection() {
        let raw = 0b10_1010_1011 << 10;
        let of = |select| Status::decode(raw, select).unwrap().reading;
        assert_eq!(of(ReadSelect::Microstep), Reading::Microstep(683));
        assert_eq!(of(ReadSelect::StallGuard), Reading::StallGuard(683));
        let both = Reading::StallGuardAndCurrent { stall_guard: 672, current_scale: 11 };
        assert_eq!(of(ReadSelect::StallGuardAndCurrent), both);
        let Reading::Diagnostics(all) = Status::decode(raw | 0x300, ReadSelect::Diagnostics).unwrap().reading else {
            panic!("asked for diagnostics")
        };
        assert!(all.undervoltage && !all.enable_input_off && all.short_to_supply_b && !all.short_to_ground_b);
        assert_eq!(all.temperature, Temperature::Above150);
    }
}
