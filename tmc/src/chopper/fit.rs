//! spreadCycle settings computed for a motor and its supply, by the equations of the data sheets ("Chopper
//! Operation", "spreadCycle": TOFF and hysteresis start; the same in all chips).
//!
//! A chopper cycle is: on, slow decay, fast decay, slow decay. At 25 kHz, inaudible, with half of the cycle
//! spent in the two slow decays, one of them takes `t_off` = 10 us. While the comparator is blanked the
//! current rises by `V t_blank / L` whatever the target is, and in two slow decays it falls by `2 R I t_off /
//! L`. A hysteresis below the sum of both cannot be regulated: the chopper skips cycles audibly. The
//! hysteresis is counted in 512ths of the amplitude at full scale, of which the sine table uses 248 of 256,
//! and eight of them are always present:
//!
//! ```text
//! start + end >= 0.5 + (rise + fall) * 2 * 248 * (CS + 1) / 32 / I - 8
//! ```
//!
//! The blanking time is an input: it covers the ringing after a switching event, which does not depend on
//! coil and supply.

use units::{Amps, ChopperFit, Coil, Volts};

/// Supply, target current and chip settings under which a coil is driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regulated {
    /// Motor supply voltage.
    pub supply: Volts,
    /// Peak coil current.
    pub peak: Amps,
    /// Current scale `CS` (`IRUN`) for that peak current, 0 to 31.
    pub cs: u8,
    /// Clock of the chip, Hz.
    pub clock_hz: f32,
    /// Blanking time, in chip clocks.
    pub blank_clocks: u8,
}

/// Chopper frequency above the audible range, Hz.
const CYCLES_HZ: f32 = 25_000.0;
/// Share of one slow decay in a chopper cycle: the two together take half of it.
const SLOW_DECAY: f32 = 0.25;
/// Chip clocks of `TOFF` n: 24 + 32 n.
const OFF_LEAST_CLOCKS: f32 = 24.0;
const OFF_CLOCKS: f32 = 32.0;
/// Range of `TOFF`: 1 is left out, as it needs a longer blanking time.
const OFF_TIMES: [f32; 2] = [2.0, 15.0];
/// Range of `HSTRT` + 1; greatest sum of hysteresis start and end; least end.
const STARTS: [i32; 2] = [1, 8];
const MOST_HYSTERESIS: i32 = 15;
const LEAST_END: i32 = -3;

impl Regulated {
    /// Computes the chopper for a coil; `None` if the supply cannot drive the current through the
    /// resistance, or if a figure is not positive and finite.
    #[must_use]
    pub fn chopper(self, coil: Coil) -> Option<ChopperFit> {
        let figures = [coil.resistance.0, coil.henries, self.supply.0, self.peak.0, self.clock_hz];
        let are_figures = figures.into_iter().all(|figure| figure > 0.0 && figure.is_finite());
        if !are_figures || self.peak.0 * coil.resistance.0 >= self.supply.0 {
            return None;
        }
        let exact = (SLOW_DECAY / CYCLES_HZ * self.clock_hz - OFF_LEAST_CLOCKS) / OFF_CLOCKS;
        let [least, most] = OFF_TIMES;
        let off_time = units::within(exact + 0.5, least, most) as u8;
        let off_s = (OFF_LEAST_CLOCKS + OFF_CLOCKS * f32::from(off_time)) / self.clock_hz;
        let blank_s = f32::from(self.blank_clocks) / self.clock_hz;
        let rise = self.supply.0 * blank_s / coil.henries;
        let fall = coil.resistance.0 * self.peak.0 * 2.0 * off_s / coil.henries;
        let needed = 0.5 + (rise + fall) * 2.0 * 248.0 * (f32::from(self.cs) + 1.0) / 32.0 / self.peak.0 - 8.0;
        // Rounds up, as less hysteresis would not regulate; a float to integer cast saturates.
        let rounded = needed as i32;
        let whole = (rounded + i32::from(needed > rounded as f32)).clamp(STARTS[0] + LEAST_END, MOST_HYSTERESIS);
        // The start gets as much as possible and shrinks to the end: finer at the zero crossing.
        let start = whole.clamp(STARTS[0], STARTS[1]);
        Some(ChopperFit {
            off_time,
            blank_clocks: self.blank_clocks,
            hysteresis_start: start as u8,
            hysteresis_end: (whole - start) as i8,
            needed,
            off_s,
            blank_s,
            rise: Amps(rise),
            fall: Amps(fall),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use units::Ohms;

    const USUAL: Regulated =
        Regulated { supply: Volts(24.0), peak: Amps(1.41), cs: 19, clock_hz: 12e6, blank_clocks: 18 };
    const COIL: Coil = Coil { resistance: Ohms(4.5), henries: 7.5e-3 };

    /// Worked out by hand: 24 V * 1.5 us / 7.5 mH = 4.8 mA; 10 us are 120 clocks, (120 - 24) / 32 = 3; 4.5
    /// Ohm * 1.41 A * 2 * 10 us / 7.5 mH = 16.9 mA; 0.5 + 21.7 mA * 496 * 20 / 32 / 1.41 A - 8 = -2.73.
    #[test]
    fn the_equations_worked_out_by_hand() {
        let fit = USUAL.chopper(COIL).expect("a chopper");
        assert_eq!(fit.off_time, 3);
        assert!((fit.off_s - 10e-6).abs() < 1e-9 && (fit.blank_s - 1.5e-6).abs() < 1e-9);
        assert!((fit.rise.0 - 4.8e-3).abs() < 1e-5, "{}", fit.rise);
        assert!((fit.fall.0 - 16.92e-3).abs() < 1e-5, "{}", fit.fall);
        assert!((fit.needed - -2.726).abs() < 0.01, "{}", fit.needed);
        assert_eq!((fit.hysteresis_start, fit.hysteresis_end), (1, -3), "the least there is");
        // 1.8 mH, 1.2 Ohm, 2 A at full scale of a TMC2590's 15 MHz, 54 clocks: 150 clocks, (150 - 24) / 32 =
        // 3.9.
        let coil = Coil { resistance: Ohms(1.2), henries: 1.8e-3 };
        let by = Regulated { peak: Amps(2.0), cs: 31, clock_hz: 15e6, blank_clocks: 54, ..USUAL };
        let fit = by.chopper(coil).expect("a chopper");
        assert_eq!(fit.off_time, 4);
        // 24 V * 3.6 us / 1.8 mH = 48 mA; 1.2 Ohm * 2 A * 2 * 10.13 us / 1.8 mH = 27 mA; 0.5 + 75 mA * 496 /
        // 2 A
        // - 8 = 11.1.
        assert!((fit.rise.0 - 0.048).abs() < 1e-5 && (fit.fall.0 - 0.027_02).abs() < 1e-4);
        assert_eq!((fit.hysteresis_start, fit.hysteresis_end), (8, 4), "{}", fit.needed);
    }

    #[test]
    fn what_cannot_be_is_none() {
        assert_eq!(Regulated { supply: Volts(6.0), ..USUAL }.chopper(COIL), None, "6.3 V across the coil alone");
        assert_eq!(USUAL.chopper(Coil { henries: 0.0, ..COIL }), None);
        assert_eq!(USUAL.chopper(Coil { resistance: Ohms(f32::NAN), ..COIL }), None);
    }

    proptest! {
        /// A chip accepts the fit for any motor, and half the inductance never needs less hysteresis.
        #[test]
        fn a_chip_takes_it(
            ohms in 0.1_f32..40.0, millihenries in 0.2_f32..60.0, amps in 0.1_f32..6.0, volts in 9.0_f32..30.0,
            cs in 0_u8..32, clocks in prop::sample::select(vec![16_u8, 24, 36, 54]),
        ) {
            let by = Regulated { supply: Volts(volts), peak: Amps(amps), cs, clock_hz: 15e6, blank_clocks: clocks };
            let coil = Coil { resistance: Ohms(ohms), henries: millihenries * 1e-3 };
            if let Some(fit) = by.chopper(coil) {
                let chopper = crate::Chopper::SpreadCycle {
                    off_time: fit.off_time,
                    blank_time: crate::BlankTime::from_clocks(clocks).unwrap(),
                    hysteresis_start: fit.hysteresis_start,
                    hysteresis_end: fit.hysteresis_end,
                    decrement: crate::HysteresisDecrement::Clocks16,
                    random_off_time: false,
                };
                prop_assert!(chopper.register().is_ok(), "{fit:?}");
                let total = i32::from(fit.hysteresis_start) + i32::from(fit.hysteresis_end);
                prop_assert!(f64::from(total) >= f64::from(fit.needed) || total == MOST_HYSTERESIS);
                let other = by.chopper(Coil { henries: coil.henries / 2.0, ..coil }).unwrap();
                prop_assert!(other.needed >= fit.needed);
            }
        }
    }
}
