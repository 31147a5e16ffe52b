//! Filament width sensor: the diameter from its inputs, the correction of the flow for it when the piece is
//! at the nozzle, and the check whether it can be printed with at all.
//!
//! The flow changes in the program, as with M221, by a factor for what is extruded along the path: a line
//! that is read now is laid at the extruder's commanded place, so the piece that will be at the nozzle then
//! is looked up, not the piece that is there now. Motion knows nothing of the correction.

use base::ports::SensorReading;
use config::{FilamentWidthConfig, Gauge, ThermistorInput};
use units::{Micros, Mm};

use super::delay_line::DelayLine;
use super::{DEBOUNCE, Trouble};

/// Raw units of full scale, the same as Klipper's, so that its calibrations hold.
const FULL_RAW: f64 = 10_000.0;
/// Voltage of full scale, V.
const FULL_VOLTS: f64 = 3.3;
/// Share of full scale at both ends within which an input is disconnected or shorted: a Hall sensor stays far
/// from them, and so does a sensor of a millimetre a volt.
const RAIL: f64 = 0.02;
/// Time without signal that makes a fault; a shorter one is noise, or a plug that is pushed in.
const FAULT_AFTER: Micros = Micros::from_millis(200);
/// Length of filament between two reports of the diameter, mm.
const LOG_EVERY: f64 = 10.0;

/// Fault: an input gives no signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoSignal {
    /// The input without signal.
    pub input: ThermistorInput,
    /// Reading of that input, ten-thousandths of full scale.
    pub raw: f64,
}

/// News to be reported once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WidthNews {
    /// An input gives no signal: the flow is not corrected.
    Lost(NoSignal),
    /// All inputs give a signal again.
    Back,
    /// Measured diameter, if the configuration asks for reports.
    Measured(Mm),
}

/// State of the width sensor.
#[derive(Clone, Debug)]
pub struct Width {
    /// Whether the sensor is switched off (M406).
    off: bool,
    line: DelayLine,
    /// Result of the last look.
    measured: Result<Mm, NoSignal>,
    /// Time since which the signal has been lost, and whether the loss was reported.
    lost: Option<(Micros, bool)>,
    /// Trouble that the last diameter shows, and the time since which it does.
    looks: (Option<Trouble>, Micros),
    /// Trouble that has lasted long enough to count.
    trouble: Option<Trouble>,
    /// Extruder position of the last report of a diameter, mm.
    said_at: f64,
}

impl Width {
    /// Creates the state of a sensor that has measured nothing, switched on if configured so.
    #[must_use]
    pub fn new(sensor: &FilamentWidthConfig) -> Self {
        Self {
            off: !sensor.enable,
            line: DelayLine::new(sensor.delay.0),
            measured: Err(NoSignal { input: ThermistorInput(0), raw: 0.0 }),
            lost: None,
            looks: (None, Micros(0)),
            trouble: None,
            said_at: f64::NEG_INFINITY,
        }
    }

    /// Returns whether the sensor acts.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        !self.off
    }

    /// M405, M406: switches the sensor; earlier measurements count no more.
    pub fn switch(&mut self, sensor: &FilamentWidthConfig, on: bool) {
        *self = Self { off: !(on && sensor.enable), ..Self::new(sensor) };
    }

    /// Forgets earlier measurements, for another filament or the same at another place.
    pub fn forget(&mut self, sensor: &FilamentWidthConfig) {
        self.line = DelayLine::new(sensor.delay.0);
        self.said_at = f64::NEG_INFINITY;
    }

    /// Takes the readings, a hundred times a second. `pushed` is the distance that the extruder has pushed,
    /// mm.
    pub fn look(
        &mut self,
        sensor: &FilamentWidthConfig,
        readings: [SensorReading; 2],
        pushed: f64,
        now: Micros,
    ) -> Option<WidthNews> {
        self.measured = raw(sensor, readings).map(|raw| diameter(sensor, raw));
        self.line.add(pushed, self.measured.ok().map(|diameter| diameter.0));
        self.judge(sensor, now);
        match self.measured {
            Err(why) => self.lose(why, now),
            Ok(_) if self.lost.take().is_some_and(|(_, was_said)| was_said) => Some(WidthNews::Back),
            Ok(diameter) if sensor.log && (pushed - self.said_at).abs() >= LOG_EVERY => {
                self.said_at = pushed;
                Some(WidthNews::Measured(diameter))
            }
            Ok(_) => None,
        }
    }

    fn lose(&mut self, why: NoSignal, now: Micros) -> Option<WidthNews> {
        let (since, was_said) = self.lost.get_or_insert((now, false));
        let is_new = !*was_said && now.since(*since) >= FAULT_AFTER;
        *was_said |= is_new;
        is_new.then_some(WidthNews::Lost(why))
    }

    /// Updates the trouble from the diameter; without a signal the last trouble stays.
    fn judge(&mut self, sensor: &FilamentWidthConfig, now: Micros) {
        let Ok(diameter) = self.measured else { return };
        let is_too_thick = sensor.max_diameter > Mm(0.0) && diameter > sensor.max_diameter;
        let looks = match diameter < sensor.min_diameter {
            true => Some(Trouble::TooThin),
            false => is_too_thick.then_some(Trouble::TooThick),
        };
        if looks != self.looks.0 {
            self.looks = (looks, now);
        }
        if now.since(self.looks.1) >= DEBOUNCE {
            self.trouble = looks;
        }
    }

    /// Returns the reason why the filament cannot be printed with, if any.
    #[must_use]
    pub fn trouble(&self) -> Option<Trouble> {
        self.trouble.filter(|_| !self.off)
    }

    /// Returns the filament's diameter at the sensor.
    ///
    /// # Errors
    /// When an input gives no signal.
    pub const fn measured(&self) -> Result<Mm, NoSignal> {
        self.measured
    }

    /// Returns whether the filament's diameter is still unknown for the moment when the extruder will have
    /// pushed to `pushed`, mm: the piece that will be at the nozzle then has not come to the sensor.
    #[must_use]
    pub fn is_to_come(&self, sensor: &FilamentWidthConfig, pushed: f64) -> bool {
        !self.off && sensor.correct_flow && self.line.is_to_come(pushed - sensor.delay.0)
    }

    /// Returns the flow factor for the moment when the extruder will have pushed to `pushed`, mm, for an E
    /// that is meant for filament of this diameter. The factor is 1 if the diameter is unknown or
    /// implausible.
    #[must_use]
    pub fn factor(&self, sensor: &FilamentWidthConfig, pushed: f64, meant: Mm) -> f64 {
        if self.off || !sensor.correct_flow {
            return 1.0;
        }
        let measured = self.line.diameter(pushed - sensor.delay.0, sensor.measured_at_once);
        let is_believed = |diameter: &f64| {
            (diameter - sensor.nominal.0).abs() <= sensor.max_difference.0 && *diameter > sensor.nominal.0 / 2.0
        };
        measured.filter(is_believed).map_or(1.0, |diameter| (meant.0 / diameter) * (meant.0 / diameter))
    }
}

/// Returns the reading of an input, ten-thousandths of full scale.
#[must_use]
pub fn raw_of(reading: SensorReading) -> f64 {
    match reading {
        SensorReading::Counts(counts) => f64::from(counts) / f64::from(u16::MAX) * FULL_RAW,
        _ => 0.0,
    }
}

/// Returns the sum of all inputs' readings, ten-thousandths of full scale.
fn raw(sensor: &FilamentWidthConfig, readings: [SensorReading; 2]) -> Result<f64, NoSignal> {
    let mut sum = 0.0;
    for (place, input) in sensor.live_inputs() {
        let raw = readings.get(place).copied().map_or(0.0, raw_of);
        if !(RAIL * FULL_RAW..=(1.0 - RAIL) * FULL_RAW).contains(&raw) {
            return Err(NoSignal { input, raw });
        }
        sum += raw;
    }
    Ok(sum)
}

/// Returns the diameter for this raw reading.
fn diameter(sensor: &FilamentWidthConfig, raw: f64) -> Mm {
    if sensor.mm_per_volt > 0.0 {
        return Mm(raw / FULL_RAW * FULL_VOLTS * sensor.mm_per_volt);
    }
    let [Gauge { raw: first_raw, diameter: first }, Gauge { raw: second_raw, diameter: second }] = sensor.gauges;
    let slope = (second.0 - first.0) / (second_raw - first_raw);
    Mm((first.0 + (raw - first_raw) * slope).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSOR: FilamentWidthConfig = FilamentWidthConfig {
        enable: true,
        inputs: [Some(ThermistorInput(4)), Some(ThermistorInput(5))],
        gauges: [Gauge { raw: 9_500.0, diameter: Mm(1.5) }, Gauge { raw: 10_500.0, diameter: Mm(2.0) }],
        mm_per_volt: 0.0,
        nominal: Mm(1.75),
        max_difference: Mm(0.2),
        delay: Mm(50.0),
        min_diameter: Mm(1.0),
        max_diameter: Mm(1.9),
        correct_flow: true,
        measured_at_once: true,
        tool: units::ToolId(0),
        log: false,
    };

    fn counts(raw: f64) -> SensorReading {
        SensorReading::Counts((raw / FULL_RAW * 65_535.0).round() as u16)
    }

    fn after(sensor: &FilamentWidthConfig, readings: [SensorReading; 2]) -> (Width, std::vec::Vec<WidthNews>) {
        let mut width = Width::new(sensor);
        let look = |look: u64| width.look(sensor, readings, look as f64 * 0.05, Micros(look * 10_000));
        let news = (1..=100).filter_map(look).collect();
        (width, news)
    }

    #[test]
    fn two_hall_sensors_are_added_up_and_calibrated_by_two_gauges() {
        let (width, news) = after(&SENSOR, [counts(4_900.0), counts(5_300.0)]);
        assert!((width.measured().unwrap().0 - 1.85).abs() < 1e-3 && news.is_empty());
        let factor = width.factor(&SENSOR, 5.0, Mm(1.75));
        assert!((factor - (1.75 / 1.85_f64).powi(2)).abs() < 1e-4, "{factor}");
        assert_eq!(width.trouble(), None);
    }

    #[test]
    fn a_voltage_can_be_the_diameter() {
        let volts = FilamentWidthConfig { mm_per_volt: 1.0, inputs: [SENSOR.inputs[0], None], ..SENSOR };
        let (width, _) = after(&volts, [counts(1.6 / 3.3 * 10_000.0), SensorReading::Missing]);
        assert!((width.measured().unwrap().0 - 1.6).abs() < 1e-3);
    }

    #[test]
    fn what_cannot_be_is_fed_as_nominal_and_what_cannot_be_printed_is_trouble() {
        for (raw, trouble) in
            [(10_450.0, Some(Trouble::TooThick)), (10_000.0, None), (9_400.0, None), (8_400.0, Some(Trouble::TooThin))]
        {
            let (width, _) = after(&SENSOR, [counts(raw / 2.0); 2]);
            assert_eq!(width.trouble(), trouble, "{raw}");
            let is_near = (raw - 10_000.0_f64).abs() < 400.0;
            assert!(is_near || width.factor(&SENSOR, 5.0, Mm(1.75)) == 1.0, "{raw}");
        }
    }

    #[test]
    fn an_input_without_a_signal_is_told_once_and_corrects_nothing() {
        for lost in [counts(0.0), counts(10_000.0), SensorReading::Missing] {
            let (mut width, news) = after(&SENSOR, [counts(5_000.0), lost]);
            let [WidthNews::Lost(why)] = news[..] else { panic!("{news:?}") };
            assert_eq!(why.input, ThermistorInput(5));
            assert_eq!((width.factor(&SENSOR, 5.0, Mm(1.75)), width.trouble()), (1.0, None));
            let back = width.look(&SENSOR, [counts(5_000.0); 2], 6.0, Micros(2_000_000));
            assert_eq!(back, Some(WidthNews::Back));
        }
    }

    #[test]
    fn switched_off_it_neither_corrects_nor_suspends() {
        let (mut width, _) = after(&SENSOR, [counts(4_800.0), counts(4_900.0)]);
        assert!(width.factor(&SENSOR, 5.0, Mm(1.75)) > 1.0);
        width.switch(&SENSOR, false);
        width.look(&SENSOR, [counts(4_000.0); 2], 6.0, Micros(3_000_000));
        width.look(&SENSOR, [counts(4_000.0); 2], 6.0, Micros(4_000_000));
        assert_eq!((width.factor(&SENSOR, 5.0, Mm(1.75)), width.trouble()), (1.0, None));
    }
}
