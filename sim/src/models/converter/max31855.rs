//! MAX31855, from its data sheet (19-5793 Rev 5): tables 2 to 5 for the frame, "Thermal Characteristics"
//! for the times. The chip has no input: it shifts its frame out whatever it is sent.

use super::Terminals;
use crate::models::thermistor::Wiring;

/// Longest time from power-up to the first result, tCONV_PU.
const FIRST_NS: u64 = 200_000_000;

/// MAX31855 chip with its frame.
#[derive(Clone, Debug)]
pub struct Max31855 {
    ready_ns: u64,
    /// Bits that are still to be shifted out.
    frame: u32,
}

impl Max31855 {
    /// Makes a chip whose supply came at `at_ns`.
    pub(super) const fn new(at_ns: u64) -> Self {
        Self { ready_ns: at_ns + FIRST_NS, frame: 0 }
    }

    /// Starts a frame. Results are taken over only while the chip is not selected. The sensor's present
    /// temperature stands for that of the last conversion, up to 100 ms ago.
    pub(super) fn select(&mut self, at_ns: u64, terminals: &Terminals) {
        let code = |celsius: f64, per_degree: f64, bits: u32| {
            let limit = 2_f64.powi(bits as i32 - 1);
            let code = (celsius * per_degree).floor().clamp(-limit, limit - 1.0) as i32;
            code.cast_unsigned() & ((1 << bits) - 1)
        };
        // Table 4 and 5: 14 bits of a quarter, 12 bits of a sixteenth of a degree.
        let measured = code(terminals.sensor_c, 4.0, 14) << 18 | code(terminals.chip_c, 16.0, 12) << 4;
        // Table 2: D16 any fault, D2 SCV, D1 SCG, D0 OC.
        let fault = match terminals.wiring {
            Wiring::Sound => 0,
            Wiring::Open => 1 << 16 | 1,
            Wiring::Shorted => 1 << 16 | 1 << 1,
            Wiring::ToSupply => 1 << 16 | 1 << 2,
        };
        self.frame = if at_ns < self.ready_ns { 0 } else { measured | fault };
    }

    /// Returns the next byte of the reading.
    pub(super) fn transfer(&mut self) -> u8 {
        let byte = (self.frame >> 24) as u8;
        self.frame <<= 8;
        byte
    }
}
