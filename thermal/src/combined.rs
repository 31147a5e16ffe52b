//! Sensors that combine others: all parts are read at the same moment and make a single temperature.

use config::{HeaterId, SensorKind};
use units::Celsius;

use crate::io::{MAX_HEATERS, SensorReadings};
use crate::sensor::{Sensor, SensorFault};

/// Rule that makes a temperature from several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// The hottest of the parts.
    Max,
    /// The coldest of the parts.
    Min,
    /// Mean of the parts.
    Mean,
    /// The first less the second.
    Difference,
}

impl Rule {
    /// Returns the rule of a kind of sensor; `None` if it measures by itself.
    #[must_use]
    pub const fn of(kind: SensorKind) -> Option<Self> {
        match kind {
            SensorKind::Max => Some(Self::Max),
            SensorKind::Min => Some(Self::Min),
            SensorKind::Mean => Some(Self::Mean),
            SensorKind::Difference => Some(Self::Difference),
            _ => None,
        }
    }

    /// Adds the next temperature to the result of those before it.
    fn fold(self, sofar: f32, next: f32) -> f32 {
        match self {
            Self::Max => sofar.max(next),
            Self::Min => sofar.min(next),
            Self::Mean => sofar + next,
            Self::Difference => sofar - next,
        }
    }
}

/// The parts of a combined sensor, in the order that is written.
pub type Parts = [Option<HeaterId>; MAX_HEATERS];

/// Returns the temperature of the sensor `id` of `all`; `sensor` gives the sensor of an element. All are read
/// from the same scan, so a combination is as old as its parts.
///
/// # Errors
/// The sensor's fault, or that of its first faulty part, by name.
pub fn read<T>(
    all: &[T],
    sensor: fn(&T) -> &Sensor,
    raw: &SensorReadings,
    id: HeaterId,
) -> Result<Celsius, SensorFault> {
    read_within(all, sensor, raw, id, MAX_HEATERS)
}

/// Limits combinations of combinations to this many `levels`. The checker lets no circle through; a circle
/// that came here would end as a fault.
fn read_within<T>(
    all: &[T],
    sensor: fn(&T) -> &Sensor,
    raw: &SensorReadings,
    id: HeaterId,
    levels: usize,
) -> Result<Celsius, SensorFault> {
    let (Some(own), Some(reading)) = (all.get(id.index()).map(sensor), raw.get(id.index())) else {
        return Err(SensorFault::SILENT);
    };
    let Sensor::Combined(rule, parts) = own else { return own.celsius(*reading) };
    let levels = levels.checked_sub(1).ok_or(SensorFault::SILENT)?;
    let (mut sofar, mut count) = (None, 0_u8);
    for part in parts.iter().flatten() {
        let Celsius(next) = read_within(all, sensor, raw, *part, levels).map_err(|fault| fault.of_part(*part))?;
        sofar = Some(sofar.map_or(next, |sofar| rule.fold(sofar, next)));
        count += 1;
    }
    let sum = sofar.ok_or(SensorFault::SILENT)?;
    Ok(Celsius(if *rule == Rule::Mean { sum / f32::from(count) } else { sum }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::SensorReading;
    use proptest::prelude::*;

    fn id(index: usize) -> HeaterId {
        HeaterId::all().nth(index).unwrap()
    }

    fn combined(rule: Rule, parts: &[usize]) -> Sensor {
        let mut places = [None; MAX_HEATERS];
        for (place, part) in places.iter_mut().zip(parts) {
            *place = Some(id(*part));
        }
        Sensor::Combined(rule, places)
    }

    fn readings(celsius: &[f32]) -> SensorReadings {
        let mut readings = SensorReadings::default();
        for (reading, celsius) in readings.iter_mut().zip(celsius) {
            *reading = SensorReading::MilliDegrees((celsius * 1e3) as i32);
        }
        readings
    }

    fn read(all: &[Sensor], raw: &SensorReadings, index: usize) -> Result<Celsius, SensorFault> {
        super::read(all, |sensor| sensor, raw, id(index))
    }

    proptest! {
        #[test]
        fn each_rule_is_what_its_name_says(a in -50_i16..400, b in -50_i16..400, c in -50_i16..400) {
            let [a, b, c] = [a, b, c].map(f32::from);
            let raw = readings(&[a, b, c]);
            for (rule, parts, expected) in [
                (Rule::Max, &[0, 1, 2][..], a.max(b).max(c)),
                (Rule::Min, &[0, 1, 2], a.min(b).min(c)),
                (Rule::Mean, &[0, 1, 2], (a + b + c) / 3.0),
                (Rule::Difference, &[0, 1], a - b),
                (Rule::Difference, &[1, 0], b - a),
            ] {
                let all = [Sensor::Degrees, Sensor::Degrees, Sensor::Degrees, combined(rule, parts)];
                let celsius = read(&all, &raw, 3).unwrap();
                prop_assert!((celsius.0 - expected).abs() < 1e-3, "{:?}: {}", rule, celsius);
            }
        }
    }

    #[test]
    fn a_combination_of_combinations_is_read_through() {
        let all = [combined(Rule::Difference, &[1, 2]), combined(Rule::Max, &[2, 3]), Sensor::Degrees, Sensor::Degrees];
        assert_eq!(read(&all, &readings(&[0.0, 0.0, 30.0, 70.0]), 0), Ok(Celsius(40.0)));
    }

    #[test]
    fn a_part_that_fails_makes_it_fail_by_name() {
        let all = [combined(Rule::Max, &[1]), combined(Rule::Mean, &[2, 3]), Sensor::Degrees, Sensor::Degrees];
        let mut raw = readings(&[0.0, 0.0, 30.0, 70.0]);
        raw[3] = SensorReading::Missing;
        let fault = read(&all, &raw, 0).unwrap_err();
        assert_eq!((fault.part(), fault.message()), (Some(id(3)), SensorFault::SILENT.message()));
    }

    #[test]
    fn a_circle_is_a_fault_and_no_endless_loop() {
        let all = [combined(Rule::Max, &[1, 1]), combined(Rule::Max, &[0, 0])];
        assert!(read(&all, &readings(&[1.0, 2.0]), 0).is_err());
    }
}
