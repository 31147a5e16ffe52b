//! MAX31865, from its data sheet (19-6478 Rev 3): tables 1 and 2 for addresses and configuration, 4 and 5
//! for the ratio, 3 for the fault detection cycle, 6 for the thresholds, 7 for the fault status, 10 to 12
//! for the effect of a fault on bits and data.
//!
//! Not modelled: one-shot conversions, and the fault detection cycle in two steps.

use super::{Access, Cursor, Leads, Terminals};
use crate::models::thermistor::{Curve, Wiring};

const CONFIGURATION: usize = 0;
const RTD: usize = 1;
const HIGH: usize = 3;
const LOW: usize = 5;
const STATUS: usize = 7;
/// Bits of the configuration, table 2.
const BIAS_AND_AUTOMATIC: u8 = 0b11 << 6;
const CLEAR: u8 = 1 << 1;
/// Bits of table 3: the fault detection cycle with automatic delays, which wants the converter off
/// (100X010X).
const CYCLE: u8 = 0b11 << 2;
const AUTOMATIC_CYCLE: u8 = 0b01 << 2;
const WHEN_IT_MAY: u8 = 0b1110_1110;
const IT_MAY: u8 = 0b1000_0100;
/// Bits kept after writing the configuration: those of one-shot and clearing go back to zero at once, those
/// of fault detection at the end of the cycle.
const KEPT: u8 = 0b1101_0001;
/// Longest duration of the cycle ("Electrical Characteristics": 550 us, 600 us at most).
const CYCLE_NS: u64 = 600_000;
/// Duration of the 50 Hz filter's single conversion, which the first of many is ("Electrical
/// Characteristics").
const FIRST_NS: u64 = 66_000_000;
/// Greatest value of the 15 bits.
const FULL_SCALE: u16 = 0x7FFF;

/// MAX31865 chip with its registers.
#[derive(Clone, Debug)]
pub struct Max31865 {
    sensor: Curve,
    reference_ohms: f64,
    registers: [u8; 8],
    cursor: Cursor,
    /// End of the first automatic conversion; none while the converter stands.
    ready_ns: Option<u64>,
    /// End of the fault detection cycle, while one runs.
    cycle_ends_ns: Option<u64>,
}

impl Max31865 {
    /// Makes a chip at power-on.
    pub(super) fn new(sensor: Curve, reference_ohms: f64) -> Self {
        // Table 1: all zeros but the high threshold.
        let registers = [0, 0, 0, 0xFF, 0xFF, 0, 0, 0];
        Self { sensor, reference_ohms, registers, cursor: Cursor::default(), ready_ns: None, cycle_ends_ns: None }
    }

    /// Returns the registers.
    pub(super) const fn registers(&self) -> &[u8] {
        &self.registers
    }

    /// Lowers the select of the chip; a conversion that is due is made now.
    pub(super) fn select(&mut self, at_ns: u64, terminals: &Terminals) {
        self.cursor.select();
        if self.cycle_ends_ns.is_some_and(|ends_ns| at_ns >= ends_ns) {
            self.cycle_ends_ns = None;
            self.registers[CONFIGURATION] &= !CYCLE;
            self.detect(terminals);
        }
        if self.ready_ns.is_some_and(|ready_ns| at_ns >= ready_ns) {
            self.convert(terminals);
        }
    }

    /// Sets the faults that the cycle finds, tables 10 to 12: D5 no current flows, D4 RTDIN- low, D3
    /// something low.
    fn detect(&mut self, terminals: &Terminals) {
        let no_current = terminals.wiring == Wiring::Open || terminals.leads == Leads::ForceOpen;
        let minus_low = terminals.leads == Leads::MinusToGround;
        let low = minus_low || terminals.leads == Leads::PlusToGround;
        self.registers[STATUS] |= u8::from(no_current) << 5 | u8::from(minus_low) << 4 | u8::from(low) << 3;
        if self.registers[STATUS] != 0 {
            self.registers[RTD + 1] |= 1;
        }
    }

    fn convert(&mut self, terminals: &Terminals) {
        let last = u16::from_be_bytes([self.registers[RTD], self.registers[RTD + 1]]) >> 1;
        let ratio = match terminals.wiring {
            Wiring::Open => FULL_SCALE,
            Wiring::Shorted => 0,
            _ if terminals.leads == Leads::PlusToGround => 0,
            // The data sheet says "Indeterminate": at worst, the input's capacitor keeps a plausible value.
            _ if terminals.leads == Leads::ForceOpen => last,
            Wiring::Sound | Wiring::ToSupply => {
                let ratio = self.sensor.ohms(terminals.sensor_c) / self.reference_ohms;
                ((ratio * 32_768.0).round() as u16).min(FULL_SCALE)
            }
        };
        let threshold = |at: usize| u16::from_be_bytes([self.registers[at], self.registers[at + 1]]) >> 1;
        // Table 7: D7 high, D6 low, D2 over- or undervoltage. The bits stay set until they are cleared.
        let bits = u8::from(ratio >= threshold(HIGH)) << 7
            | u8::from(ratio <= threshold(LOW)) << 6
            | u8::from(terminals.wiring == Wiring::ToSupply) << 2;
        self.registers[STATUS] |= bits;
        let rtd = ratio << 1 | u16::from(self.registers[STATUS] != 0);
        self.registers[RTD..HIGH].copy_from_slice(&rtd.to_be_bytes());
    }

    /// Exchanges a byte.
    pub(super) fn transfer(&mut self, mosi: u8) -> u8 {
        match self.cursor.next(mosi, 8) {
            Access::Read(at) => self.registers[at],
            Access::Write(CONFIGURATION) => {
                if mosi & CLEAR != 0 && mosi & CYCLE == 0 {
                    self.registers[STATUS] = 0;
                }
                // Clearing and the cycle exclude each other (data sheet, "Fault Status Clear").
                let cycle = if mosi & WHEN_IT_MAY == IT_MAY { AUTOMATIC_CYCLE } else { 0 };
                self.registers[CONFIGURATION] = mosi & KEPT | cycle;
                0
            }
            Access::Write(at) if (HIGH..STATUS).contains(&at) => {
                self.registers[at] = mosi;
                0
            }
            Access::Write(_) | Access::Address => 0,
        }
    }

    /// A conversion begins when the frame that asks for it ends.
    pub(super) fn deselect(&mut self, at_ns: u64) {
        if self.registers[CONFIGURATION] & CYCLE == AUTOMATIC_CYCLE {
            self.cycle_ends_ns = self.cycle_ends_ns.or(Some(at_ns + CYCLE_NS));
        }
        let runs = self.registers[CONFIGURATION] & BIAS_AND_AUTOMATIC == BIAS_AND_AUTOMATIC;
        self.ready_ns = if runs { self.ready_ns.or(Some(at_ns + FIRST_NS)) } else { None };
    }
}
