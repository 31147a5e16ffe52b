//! MAX31856, from its data sheet (19-7534 Rev 0): "Register Map" with its factory defaults, CR0 and CR1, the
//! formats of the temperatures, the fault status; table 1 for sensitivities; tCONV of "Electrical
//! Characteristics".
//!
//! Not modelled: thresholds and their fault bits, the cold junction's offset, one-shot conversions, voltage
//! mode. A thermocouple is as straight as its sensitivity says.

use super::{Access, Cursor, Terminals};
use crate::models::thermistor::Wiring;

const CR0: usize = 0x00;
const CR1: usize = 0x01;
const MASK: usize = 0x02;
const COLD_JUNCTION: usize = 0x0A;
const TEMPERATURE: usize = 0x0C;
const STATUS: usize = 0x0F;
/// Registers that can be written, 00h to 0Bh.
const WRITABLE: std::ops::Range<usize> = 0..0x0C;

/// Bits of CR0: continuous conversion; detection of an open thermocouple; 50 Hz.
const AUTOMATIC: u8 = 1 << 7;
const OPEN_DETECTION: u8 = 0b11 << 4;
const NOTCH_50_HZ: u8 = 1;
/// Bits of SR: TC range, OVUV, OPEN.
const TC_RANGE: u8 = 1 << 6;
const OVUV: u8 = 1 << 1;
const OPEN: u8 = 1;

/// Types of thermocouples, as CR1 numbers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are the meaning")]
pub enum Thermocouple {
    B,
    E,
    J,
    K,
    N,
    R,
    S,
    T,
}

/// Microvolts per degree of each type, and the degrees up to which it is linearised (table 1).
const TYPES: [(f64, f64); 8] = [
    (10.086, 1_820.0),
    (76.298, 1_000.0),
    (57.953, 1_200.0),
    (41.276, 1_372.0),
    (36.256, 1_300.0),
    (10.506, 1_768.0),
    (9.587, 1_768.0),
    (52.180, 400.0),
];

/// MAX31856 chip with its registers.
#[derive(Clone, Debug)]
pub struct Max31856 {
    connected: Thermocouple,
    registers: [u8; 16],
    cursor: Cursor,
    /// End of the first automatic conversion; none while the converter stands.
    ready_ns: Option<u64>,
}

impl Max31856 {
    /// Makes a chip at power-on.
    pub(super) fn new(connected: Thermocouple) -> Self {
        let mut registers = [0; 16];
        // Factory defaults: type K, all faults masked, and thresholds that never trip.
        (registers[CR1], registers[MASK]) = (0x03, 0xFF);
        (registers[3], registers[4], registers[5], registers[6]) = (0x7F, 0xC0, 0x7F, 0xFF);
        registers[7] = 0x80;
        Self { connected, registers, cursor: Cursor::default(), ready_ns: None }
    }

    /// Returns the registers.
    pub(super) const fn registers(&self) -> &[u8] {
        &self.registers
    }

    /// Lowers the select of the chip; a conversion that is due is made now.
    pub(super) fn select(&mut self, at_ns: u64, terminals: &Terminals) {
        self.cursor.select();
        if self.ready_ns.is_some_and(|ready_ns| at_ns >= ready_ns) {
            self.convert(terminals);
        }
    }

    fn convert(&mut self, terminals: &Terminals) {
        let (linearised, most) = TYPES[usize::from(self.registers[CR1] & 7)];
        let microvolts = (terminals.sensor_c - terminals.chip_c) * TYPES[self.connected as usize].0;
        let celsius = match terminals.wiring {
            Wiring::Sound => terminals.chip_c + microvolts / linearised,
            // A floating input, or one at a rail, gives no reliable reading.
            _ => terminals.chip_c,
        };
        let open = terminals.wiring == Wiring::Open && self.registers[CR0] & OPEN_DETECTION != 0;
        // The bias of 0.735 V holds the inputs inside; contact with ground or supply takes them out.
        let outside = matches!(terminals.wiring, Wiring::Shorted | Wiring::ToSupply);
        let bits = [(open, OPEN), (outside, OVUV), (celsius > most, TC_RANGE)];
        self.registers[STATUS] = bits.into_iter().filter(|(is_so, _)| *is_so).fold(0, |status, (_, bit)| status | bit);
        // 14 bits of 2^-6 C in 0Ah and 0Bh, 19 bits of 2^-7 C in 0Ch to 0Eh, both from the left.
        let cold = ((terminals.chip_c * 64.0).round() as i16) << 2;
        self.registers[COLD_JUNCTION..TEMPERATURE].copy_from_slice(&cold.to_be_bytes());
        let code = ((celsius.min(most) * 128.0).round() as i32) << 13;
        self.registers[TEMPERATURE..STATUS].copy_from_slice(&code.to_be_bytes()[..3]);
    }

    /// Exchanges a byte.
    pub(super) fn transfer(&mut self, mosi: u8) -> u8 {
        match self.cursor.next(mosi, 16) {
            Access::Read(at) => self.registers[at],
            Access::Write(at) if WRITABLE.contains(&at) => {
                self.registers[at] = mosi;
                0
            }
            Access::Write(_) | Access::Address => 0,
        }
    }

    /// A conversion begins when the frame that asks for it ends.
    pub(super) fn deselect(&mut self, at_ns: u64) {
        let automatic = self.registers[CR0] & AUTOMATIC != 0;
        if automatic && self.ready_ns.is_none() {
            let samples = 1_u64 << (self.registers[CR1] >> 4 & 7).min(4);
            let [first_ms, more_ms] = if self.registers[CR0] & NOTCH_50_HZ != 0 { [169, 40] } else { [143, 33] };
            self.ready_ns = Some(at_ns + (first_ms + more_ms * (samples - 1)) * 1_000_000);
        }
        if !automatic {
            self.ready_ns = None;
        }
    }
}
