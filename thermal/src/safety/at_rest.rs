//! Watch over a heater that is switched off: if it warms all the same, a MOSFET or a relay conducts.
//!
//! The temperature is compared with a floor: the lowest reading since the heater was switched off, which may
//! creep up a little, as with any part near a warm one. Rising [`MARGIN`] above the floor takes a heater. So
//! the rule needs no constants of the machine, and works whether the target is 0, far below the reading, or
//! the machine is halted.

use units::{Celsius, Micros};

use super::look::{HeatCause, Look};

/// Time between two comparisons of the reading.
const CHECK_PERIOD: Micros = Micros::from_seconds(1);
/// Number of comparisons in a row above the margin that is a fault: a loose plug makes jumps, not a course.
const CHECKS: u8 = 2;
/// Rise above the floor, C, that only a heater makes. A hand on a cold nozzle warms it by 15 degrees.
const MARGIN: f32 = 20.0;
/// Rise above the floor, C, that is a fault above `max_temp`, where no reading should be anyway.
const MARGIN_ABOVE_MAXIMUM: f32 = 5.0;
/// Time after switch-off in which the heater's stored heat moves into its sensor...
const SETTLING: Micros = Micros::from_seconds(60);
/// ...and additional rise, C, that this heat makes.
const OVERSHOOT: f32 = 10.0;
/// Greatest warming of a heater between two comparisons, degrees: a faster sensor was plugged in, or moved.
const JUMP: f32 = 30.0;
/// Rate at which a part warms in a room that warms, degrees a second.
const CREEP: f32 = 0.02;
/// Rate of warming beside another heater that is on, degrees a second: a nozzle parked over a hot bed, a bed
/// in a heated chamber.
const CREEP_BESIDE_ANOTHER: f32 = 0.1;

/// Allowed readings of a heater that is not heated.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rest {
    /// Time by which the stored heat has reached the sensor.
    settled: Micros,
    due: Micros,
    floor: f32,
    last: f32,
    above: u8,
}

/// The watch over a single heater.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct StuckOnWatch {
    driven: bool,
    rest: Option<Rest>,
}

impl StuckOnWatch {
    /// Takes a look at the heater. Fails when the reading has risen as only a heater makes it rise, and again
    /// after the next such rise.
    pub(super) fn check(&mut self, max: Celsius, look: &Look) -> Result<(), HeatCause> {
        self.rise(max, look).map_or(Ok(()), |rise| Err(HeatCause::StuckOn(rise)))
    }

    fn rise(&mut self, max: Celsius, look: &Look) -> Option<Celsius> {
        let (now, driven) = (look.now, look.driven > 0.0);
        self.driven |= driven;
        // Without a reading there is nothing to compare with; the next reading begins anew.
        let Some(Celsius(reading)) = look.reading.filter(|_| !driven) else {
            self.rest = None;
            return None;
        };
        let was_driven = core::mem::take(&mut self.driven);
        let settled = if was_driven { now.plus(SETTLING) } else { now };
        let rest = self.rest.get_or_insert(Rest {
            settled,
            due: now.plus(CHECK_PERIOD),
            floor: reading,
            last: reading,
            above: 0,
        });
        if now < rest.due {
            return None;
        }
        rest.due = now.plus(CHECK_PERIOD);
        let jumped = reading - core::mem::replace(&mut rest.last, reading) > JUMP;
        if jumped {
            (rest.floor, rest.above) = (reading, 0);
            return None;
        }
        let creep = if look.another_on { CREEP_BESIDE_ANOTHER } else { CREEP };
        rest.floor += creep * CHECK_PERIOD.seconds() as f32;
        if reading < rest.floor {
            rest.floor = reading;
        }
        let margin = match now < rest.settled {
            true => MARGIN + OVERSHOOT,
            false if reading > max.0 => MARGIN_ABOVE_MAXIMUM,
            false => MARGIN,
        };
        let rise = reading - rest.floor;
        if rise <= margin {
            rest.above = 0;
            return None;
        }
        rest.above += 1;
        if rest.above < CHECKS {
            return None;
        }
        (rest.floor, rest.above) = (reading, 0);
        Some(Celsius(rise))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MAX: Celsius = Celsius(300.0);

    /// Looks at a course of temperatures ten times a second for some seconds; returns the time of the first
    /// report.
    fn first_report(seconds: u32, another_on: bool, course: impl Fn(f32) -> Option<f32>) -> Option<f32> {
        told_by(StuckOnWatch::default(), seconds, another_on, course)
    }

    /// Looks at such a course of a heater that was just switched off; returns the time of the first report.
    fn first_report_after_use(seconds: u32, course: impl Fn(f32) -> Option<f32>) -> Option<f32> {
        told_by(StuckOnWatch { driven: true, rest: None }, seconds, false, course)
    }

    fn told_by(
        mut watch: StuckOnWatch,
        seconds: u32,
        another_on: bool,
        course: impl Fn(f32) -> Option<f32>,
    ) -> Option<f32> {
        (0..seconds * 10).map(|tenth| tenth as f32 / 10.0).find(|second| {
            let now = Micros((f64::from(*second) * 1e6) as u64);
            let reading = course(*second).map(Celsius);
            let look = Look { now, reading, another_on, ..Look::default() };
            watch.check(MAX, &look).is_err()
        })
    }

    #[test]
    fn a_cold_hot_end_that_heats_is_told_within_fifteen_seconds() {
        let reported = first_report(60, false, |second| Some(22.0 + 3.0 * second));
        assert!(reported.is_some_and(|second| second <= 15.0), "{reported:?}");
    }

    #[test]
    fn a_bed_of_half_a_degree_a_second_is_told_within_seventy() {
        let reported = first_report(120, true, |second| Some(22.0 + 0.5 * second));
        assert!(reported.is_some_and(|second| second <= 70.0), "{reported:?}");
    }

    #[test]
    fn what_a_hot_heater_still_holds_a_hand_and_a_warm_bed_are_not_told() {
        // Switched off at 200 C after full power: 25 C more within seconds, then down.
        let overshoot =
            |second: f32| Some(if second < 10.0 { 200.0 + 2.5 * second } else { 225.0 - 0.5 * (second - 10.0) });
        assert_eq!(first_report_after_use(300, overshoot), None);
        // A hand warms the cold nozzle.
        let hand = |second: f32| Some(if second < 100.0 { 20.0 } else { (20.0 + 2.0 * (second - 100.0)).min(34.0) });
        assert_eq!(first_report(300, false, hand), None);
        // A nozzle parked over a bed of 100 C.
        let parked = |second: f32| Some(25.0 + 35.0 * (1.0 - (-second / 300.0).exp()));
        assert_eq!(first_report(3_600, true, parked), None);
    }

    #[test]
    fn a_loose_plug_makes_no_rise() {
        let flicker = |second: f32| match second as u32 % 7 {
            0 => None,
            3 | 4 => Some(150.0),
            _ => Some(22.0),
        };
        assert_eq!(first_report(600, false, flicker), None);
    }

    #[test]
    fn a_heater_that_goes_on_warming_is_told_again_and_again() {
        let mut watch = StuckOnWatch::default();
        let reported = (0..200_u64).filter(|second| {
            let (now, reading) = (Micros::from_seconds(*second), Some(Celsius(22.0 + *second as f32)));
            let look = Look { now, reading, ..Look::default() };
            watch.check(MAX, &look).is_err()
        });
        let reported: std::vec::Vec<u64> = reported.collect();
        assert!(reported.len() >= 7, "{reported:?}");
    }

    proptest! {
        /// From any start, a rise of a quarter of a degree a second is told within three minutes; with a
        /// driven heater never.
        #[test]
        fn every_steady_rise_is_told_and_a_driven_heater_never(
            start in 0.0..250.0_f32, rate in 0.25..10.0_f32, another_on: bool,
        ) {
            let reported = first_report_after_use(240, |second| Some(start + rate * second))
                .filter(|_| first_report(240, another_on, |second| Some(start + rate * second)).is_some());
            prop_assert!(reported.is_some_and(|second| second <= 62.0 + 22.0 / (rate - CREEP_BESIDE_ANOTHER)), "{reported:?}");
            let mut watch = StuckOnWatch::default();
            for second in 0..240_u64 {
                let reading = Some(Celsius(start + rate * second as f32));
                let now = Micros::from_seconds(second);
                let look = Look { now, reading, driven: 1.0, another_on, ..Look::default() };
                prop_assert_eq!(watch.check(MAX, &look), Ok(()));
            }
        }
    }
}
