//! The sensor of the filament's width: from its inputs to a diameter, to what that makes of the flow when the
//! piece is at the nozzle, and to whether it can be printed with at all.
//!
//! The flow changes in the program, where M221 does, by a factor for what is extruded along the path: a line
//! that is read now is laid at the extruder's commanded place, so the piece that will be at the nozzle then
//! is looked up, not the one that is there now. Motion knows nothing of it.

use config::{FilamentWidthConfig, Gauge, ThermistorInput};
use units::{Micros, Mm};

use super::delay_line::DelayLine;
use super::{DEBOUNCE, Trouble};
use crate::ports::SensorReading;

/// Raw units of full scale, as Klipper counts them, so that its calibrations hold.
const FULL_RAW: f64 = 10_000.0;
/// Volts of full scale.
const FULL_VOLTS: f64 = 3.3;
/// Nearer to its ends than this share of full scale an input is not connected, or shorted: a Hall sensor
/// stays far from them, and so does one of a millimetre a volt.
const RAIL: f64 = 0.02;
/// An input that is away for less is noise, or a plug that is pushed in.
const FAULT_AFTER: Micros = Micros::from_millis(200);
/// Filament between two diameters that are said, mm.
const LOG_EVERY: f64 = 10.0;

/// An input gives no signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoSignal {
    /// Which.
    pub input: ThermistorInput,
    /// What it reads, ten-thousandths of full scale.
    pub raw: f64,
}

/// What is to be said, once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WidthNews {
    /// It gives no signal: the flow is not corrected.
    Lost(NoSignal),
    /// It gives one again.
    Back,
    /// So thick it is: where that is asked for.
    Measured(Mm),
}

/// The sensor.
#[derive(Clone, Debug)]
pub struct Width {
    /// M405.
    off: bool,
    line: DelayLine,
    /// The last look's.
    measured: Result<Mm, NoSignal>,
    /// Since when it has been lost, and whether that was said.
    lost: Option<(Micros, bool)>,
    /// What it looks like, and since when.
    looks: (Option<Trouble>, Micros),
    /// The same, for long enough.
    trouble: Option<Trouble>,
    /// Where a diameter was said last, mm.
    said_at: f64,
}

impl Width {
    /// Switched on, nothing measured.
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

    /// Whether it acts.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        !self.off
    }

    /// M405, M406: what was measured before counts no more.
    pub fn switch(&mut self, sensor: &FilamentWidthConfig, on: bool) {
        *self = Self { off: !(on && sensor.enable), ..Self::new(sensor) };
    }

    /// Another filament, or the same at another place: what was measured counts no more.
    pub fn forget(&mut self, sensor: &FilamentWidthConfig) {
        self.line = DelayLine::new(sensor.delay.0);
        self.said_at = f64::NEG_INFINITY;
    }

    /// Looks, a hundred times a second. `pushed`: how far the extruder has pushed, mm.
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

    /// What no signal says nothing of, is as it was.
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

    /// Why nothing can be printed with it, if so.
    #[must_use]
    pub fn trouble(&self) -> Option<Trouble> {
        self.trouble.filter(|_| !self.off)
    }

    /// How thick it is at the sensor.
    ///
    /// # Errors
    /// When an input gives no signal.
    pub const fn measured(&self) -> Result<Mm, NoSignal> {
        self.measured
    }

    /// Whether what is extruded once the extruder has pushed so far, mm, cannot be known yet: the piece that
    /// will be at the nozzle then has not come to the sensor.
    #[must_use]
    pub fn is_to_come(&self, sensor: &FilamentWidthConfig, pushed: f64) -> bool {
        !self.off && sensor.correct_flow && self.line.is_to_come(pushed - sensor.delay.0)
    }

    /// The factor of what is extruded once the extruder has pushed so far, mm, for an E that is meant for
    /// filament of this diameter. 1 where nothing is known, or what is known is not believed.
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

/// What one input reads, ten-thousandths of full scale.
#[must_use]
pub fn raw_of(reading: SensorReading) -> f64 {
    match reading {
        SensorReading::Counts(counts) => f64::from(counts) / f64::from(u16::MAX) * FULL_RAW,
        _ => 0.0,
    }
}

/// What all inputs read together.
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

/// The diameter that this means.
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
