//! Step test of a heater: rate of warming, rate of heat loss and delay of the sensor.
//!
//! The heater is switched fully on below and off above the target, so that the temperature swings around it
//! (the relay experiment of K. J. Astrom and T. Hagglund, Automatica 20, 1984), but the swings are not judged
//! by their height and length: those depend on the relay's own band as much as on the heater. The fitted
//! equation is dT/dt = R u(t - L) - k (T - air). R comes from the slope at the end of the first rise, when
//! all lags have died away; k from the slope of each fall; and L from where the two lines of a fall and of
//! the rise before it meet: L after the heater was switched off, whether from a dead time or from a lag of
//! the sensor.
//!
//! PID gains are those of AMIGO for a process that integrates (K. J. Astrom and T. Hagglund, "Revisiting
//! the Ziegler-Nichols step response method for PID control", J. Process Control 14, 2004), which any
//! heater is to its control: Kp = 0.45 / (R L), Ti = 8 L, Td = L / 2. Ziegler and Nichols' rule, which
//! Marlin and Klipper use, is meant to swing: it overshoots by several degrees.

use units::{Celsius, Duty, Micros};

/// The heater is switched off this far above the target: so heat safety, which knows the target alone, sees
/// swings around it.
const ABOVE: f32 = 4.0;
/// Degrees below the end of the first rise from which its slope is taken...
const RISE_WINDOW: f32 = 10.0;
/// ...and below the end of a later rise, which has less way.
const LATER_WINDOW: f32 = 5.0;
/// Fall below the switch-off temperature, C, after which the reading has certainly come back, noise or not.
const RETURNED: f32 = 0.5;
/// A fall ends at least this far below the target (first value, C), so that the next rise has left its turn
/// behind where its slope is taken; and at most this far below (second value), if its line is long enough.
const LOWEST: [f32; 2] = [3.0, 8.0];
/// Least and wanted end of a fall's line, in times from the switch-off to the return to the switch-off
/// temperature.
const FALL: [f32; 2] = [1.5, 2.0];
/// A fall's line begins at least this many times L after the switch-off: the lags must have died away.
const DIED_AWAY: f32 = 2.5;
/// Least number of readings for a line.
const LEAST_READINGS: f32 = 5.0;
/// Allowed spread of L: this share of the mean, and this many seconds.
const SPREAD: (f32, f32) = (0.5, 0.5);
/// Greatest share of the output for holding the target; a heater that needs more can do little else.
const WEAK: f32 = 0.85;

/// A line through readings, by least squares, kept as means so that f32 is enough.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Line {
    count: f32,
    second: f32,
    celsius: f32,
    spread: f32,
    product: f32,
}

impl Line {
    fn add(&mut self, second: f32, celsius: f32) {
        self.count += 1.0;
        let (by_second, by_celsius) = (second - self.second, celsius - self.celsius);
        self.second += by_second / self.count;
        self.celsius += by_celsius / self.count;
        self.spread += by_second * (second - self.second);
        self.product += by_second * (celsius - self.celsius);
    }

    /// Returns the slope, degrees a second.
    fn slope(&self) -> f32 {
        if self.spread > 0.0 { self.product / self.spread } else { 0.0 }
    }

    fn at(&self, second: f32) -> f32 {
        self.celsius + self.slope() * (second - self.second)
    }
}

/// PID gains, in Smoothieware's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// Proportional gain, output per degree.
    pub p: f32,
    /// Integral gain, per second.
    pub i: f32,
    /// Derivative gain, in seconds.
    pub d: f32,
}

/// Response of a heater, as found by the test.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Answer {
    /// Rate of warming at full output without losses, degrees a second.
    pub rise: f32,
    /// Loss in a second, as a share of the temperature above the air's.
    pub loss: f32,
    /// Delay of the sensor, s.
    pub late_s: f32,
    /// Share of full output that holds the target.
    pub holds: f32,
}

impl Answer {
    /// Returns PID gains for this response; see the head of the file.
    #[must_use]
    pub fn gains(&self, max: Duty) -> Gains {
        let per_step = self.rise / f32::from(max.0.max(1));
        let p = 0.45 / (per_step * self.late_s);
        Gains { p, i: p / (8.0 * self.late_s), d: p * self.late_s / 2.0 }
    }
}

/// Reason why a test found nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TestFailed {
    /// Lines that must rise or fall do not.
    NoLine,
    /// The swings give very different dead times.
    Unsteady,
    /// The heater can hardly hold the target.
    Weak,
}

impl TestFailed {
    /// Returns the reason as a text for people.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::NoLine => "its readings do not follow the heater: noise, or readings_per_second is too low",
            Self::Unsteady => "each swing is another: a loose sensor, a fan that comes and goes, or a supply that sags",
            Self::Weak => "it needs more than 85 % of its output to hold that: ask for less, or insulate it",
        }
    }
}

/// State of a step test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepTest {
    max: Duty,
    /// Number of swings wanted, and counted.
    swings: (u8, u8),
    air: f32,
    on: bool,
    /// Seconds since the heater was switched last.
    seconds: f32,
    line: Line,
    /// Temperature and slope at the end of the last rise.
    rose: (f32, f32),
    /// Temperature of the slope of the first rise, and that slope.
    first: Option<(f32, f32)>,
    /// Seconds from the switch-off to the return to the switch-off temperature.
    returned: Option<f32>,
    /// Sums over the swings, and the bounds of L.
    loss: f32,
    late: f32,
    late_bounds: (f32, f32),
    failed: Option<TestFailed>,
}

impl StepTest {
    /// Creates a test of this many swings, in air of this temperature. The test begins below its target.
    #[must_use]
    pub fn new(max: Duty, swings: u8, air: Celsius) -> Self {
        Self {
            max,
            swings: (swings.max(1), 0),
            air: air.0,
            on: true,
            seconds: 0.0,
            line: Line::default(),
            rose: (0.0, 0.0),
            first: None,
            returned: None,
            loss: 0.0,
            late: 0.0,
            late_bounds: (f32::MAX, 0.0),
            failed: None,
        }
    }

    /// Returns the numbers of swings counted and wanted.
    #[must_use]
    pub const fn progress(&self) -> (u8, u8) {
        (self.swings.1, self.swings.0)
    }

    /// Returns the response at the target, once enough swings were counted.
    ///
    /// # Errors
    /// When the response is none that a heater can have.
    #[must_use]
    pub fn answer(&self, target: Celsius) -> Option<Result<Answer, TestFailed>> {
        if let Some(why) = self.failed {
            return Some(Err(why));
        }
        let (wanted, counted) = self.swings;
        let (at, slope) = self.first.filter(|_| counted >= wanted)?;
        let [loss, late_s] = [self.loss, self.late].map(|sum| sum / f32::from(counted));
        let (least, most) = self.late_bounds;
        if most - least > SPREAD.0 * late_s + SPREAD.1 {
            return Some(Err(TestFailed::Unsteady));
        }
        let rise = slope + loss * (at - self.air);
        let holds = loss * (target.0 - self.air) / rise;
        Some(if holds > WEAK { Err(TestFailed::Weak) } else { Ok(Answer { rise, loss, late_s, holds }) })
    }

    pub(super) fn update(&mut self, target: Celsius, reading: Celsius, period: Micros) -> Duty {
        if self.failed.is_some() {
            return Duty::OFF;
        }
        self.seconds += period.seconds() as f32;
        if self.on {
            self.rise(target.0, reading.0);
        } else {
            self.fall(target.0, reading.0, period.seconds() as f32);
        }
        if self.on { self.max } else { Duty::OFF }
    }

    fn rise(&mut self, target: f32, reading: f32) {
        let end = target + ABOVE;
        let window = if self.first.is_none() { RISE_WINDOW } else { LATER_WINDOW };
        if reading > end - window {
            self.line.add(self.seconds, reading);
        }
        if reading < end {
            return;
        }
        let (slope, at) = (self.line.slope(), self.line.celsius);
        if self.line.count < LEAST_READINGS || slope <= 0.0 {
            self.failed = Some(TestFailed::NoLine);
        }
        self.first.get_or_insert((at, slope));
        self.rose = (self.line.at(self.seconds), slope);
        self.switch(false);
    }

    fn fall(&mut self, target: f32, reading: f32, period_s: f32) {
        let Some(returned) = self.returned else {
            if reading < target + ABOVE - RETURNED {
                self.returned = Some(self.seconds);
            }
            return;
        };
        let [least, enough] = FALL.map(|share| self.seconds >= share * returned);
        if !enough || self.line.count < LEAST_READINGS {
            self.line.add(self.seconds, reading);
        }
        let [low, lowest] = LOWEST.map(|below| reading < target - below);
        if !(least && low && (enough || lowest)) || self.line.count < LEAST_READINGS {
            return;
        }
        let above = self.line.celsius - self.air;
        let loss = -self.line.slope() / above;
        if above <= 0.0 || loss <= 0.0 {
            self.failed = Some(TestFailed::NoLine);
            return;
        }
        // The temperature is followed back along the curve to the switch-off.
        let began = self.air + above * libm::expf(loss * self.line.second);
        let (ended, rose) = self.rose;
        let late = (began - ended) / (rose + loss * (began - self.air));
        let late = late.max(2.0 * period_s);
        if returned < DIED_AWAY * late && !lowest {
            // The lags had not died away: a new line begins here.
            (self.returned, self.line) = (Some(self.seconds), Line::default());
            return;
        }
        self.loss += loss;
        self.late += late;
        self.late_bounds = (self.late_bounds.0.min(late), self.late_bounds.1.max(late));
        self.swings.1 = self.swings.1.saturating_add(u8::from(self.swings.1 < self.swings.0));
        self.switch(true);
    }

    fn switch(&mut self, on: bool) {
        self.on = on;
        self.seconds = 0.0;
        self.line = Line::default();
        self.returned = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PERIOD: Micros = Micros::from_millis(50);

    /// A block that warms by `rise` a second, loses a share `loss` a second, and a sensor that follows it.
    fn found(rise: f32, loss: f32, lag: f32, dead: usize, noise: f32, target: f32) -> Result<Answer, TestFailed> {
        let air = 22.0;
        let (mut block, mut sensor) = (air, air);
        let mut pipe = std::collections::VecDeque::from(std::vec![0.0; dead]);
        let mut test = StepTest::new(Duty::FULL, 3, Celsius(air));
        let mut chance = 1_u32;
        for _ in 0..20 * 3_600 {
            chance = chance.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let read = sensor + ((chance >> 8) as f32 / (1 << 24) as f32 - 0.5) * 2.0 * noise;
            let duty = test.update(Celsius(target), Celsius(read), PERIOD);
            if let Some(found) = test.answer(Celsius(target)) {
                return found;
            }
            pipe.push_back(f32::from(duty.0) / 255.0);
            let drive = pipe.pop_front().unwrap_or_default();
            block += (drive * rise - (block - air) * loss) * 0.05;
            sensor += (block - sensor) / lag * 0.05;
        }
        panic!("it does not end")
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn what_is_found_is_what_there_is(
            rise in 0.3..7.0_f32, holds in 0.15..0.6_f32, lag in 0.8..8.0_f32, dead in 0_usize..40, noise in 0.0..0.15_f32,
        ) {
            // Swings of more than 25 C would make heat safety stop the heater.
            prop_assume!(rise * (lag + dead as f32 * 0.05) < 15.0);
            let target = 120.0;
            let loss = rise * holds / (target - 22.0);
            let late = lag + dead as f32 * 0.05;
            let answer = found(rise, loss, lag, dead, noise, target).expect("an answer");
            prop_assert!((answer.rise / rise - 1.0).abs() < 0.12, "{} of {}", answer.rise, rise);
            prop_assert!((answer.holds / holds - 1.0).abs() < 0.2, "{} of {}", answer.holds, holds);
            prop_assert!((answer.late_s - late).abs() < 0.25 * late + 0.2, "{} of {}", answer.late_s, late);
        }
    }

    #[test]
    fn a_heater_that_can_hardly_hold_the_target_is_told() {
        // The heater holds 100 C above the air with nine tenths of its output.
        assert_eq!(found(2.0, 2.0 * 0.9 / 100.0, 1.0, 0, 0.0, 122.0), Err(TestFailed::Weak));
        assert!(found(2.0, 2.0 * 0.7 / 100.0, 1.0, 0, 0.0, 122.0).is_ok());
    }

    #[test]
    fn a_sensor_that_does_not_follow_is_told() {
        let mut test = StepTest::new(Duty::FULL, 3, Celsius(22.0));
        // The reading jumps over the whole window: no line.
        for reading in [20.0, 80.0, 100.0, 125.0] {
            test.update(Celsius(100.0), Celsius(reading), PERIOD);
        }
        assert_eq!(test.answer(Celsius(100.0)), Some(Err(TestFailed::NoLine)));
        assert_eq!(test.update(Celsius(100.0), Celsius(50.0), PERIOD), Duty::OFF);
    }

    #[test]
    fn gains_do_not_depend_on_how_far_the_output_goes() {
        // At half the output the same heater warms half as fast.
        let whole = Answer { rise: 4.0, loss: 0.01, late_s: 3.0, holds: 0.4 };
        let half = Answer { rise: 2.0, ..whole };
        let (of_whole, of_half) = (whole.gains(Duty(200)), half.gains(Duty(100)));
        assert_eq!(of_whole, of_half);
        // The gain is 0.45 of a step's rise over the delay.
        assert!((of_whole.p - 0.45 / (4.0 / 200.0 * 3.0)).abs() < 1e-4, "{of_whole:?}");
        assert!((of_whole.i - of_whole.p / 24.0).abs() < 1e-5 && (of_whole.d - of_whole.p * 1.5).abs() < 1e-4);
    }
}
