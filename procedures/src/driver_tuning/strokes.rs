//! Moves an axis at one speed and reads its motor's load meanwhile.

use base::failure::{Failure, Texts};
use base::ports::{DriverFault, MotorDrivers, StallSearch, Wake};
use config::EndstopStallConfig;
use motion::Mode;
use units::{Actuator, Axis, Micros, MmPerSecond};

use super::readings::Readings;
use crate::endstop_phase::PhaseHands;
use crate::homing;

/// Least number of readings of a stroke: noise cannot be judged from fewer.
const COUNT: u32 = 60;
/// Number of readings of the crawl, each of which takes a full step.
const CRAWLED: u32 = 24;
/// Time between two readings over SPI, s.
const PERIOD_S: f64 = 0.002;

/// The axis whose motor is measured, and its travel for that.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub axis: Axis,
    pub motor: Actuator,
    /// Ends of the travel, mm.
    pub ends: [f64; 2],
    /// Length of a full step, mm.
    pub full_step: f64,
    /// Acceleration, mm/s^2.
    pub acceleration: f64,
    /// Jerk, mm/s^3, if limited.
    pub jerk: Option<f64>,
}

impl Way {
    const fn count(&self, is_crawl: bool) -> u32 {
        if is_crawl { CRAWLED } else { COUNT }
    }

    /// Returns the time from a reading to the next at a speed, s: at least a full step's.
    fn period(&self, rate: f64) -> f64 {
        PERIOD_S.max(self.full_step / rate)
    }

    /// Returns the travel that a stroke at a speed needs, mm.
    pub fn needed(&self, rate: f64, is_crawl: bool) -> f64 {
        let ramp = EndstopStallConfig::run_up(rate, self.acceleration, self.jerk, 1.0 / self.full_step);
        2.0 * ramp + rate * self.period(rate) * f64::from(self.count(is_crawl) + 1)
    }

    /// Returns whether the travel is long enough for a speed.
    pub fn is_long_enough(&self, rate: f64) -> bool {
        self.needed(rate, false) <= self.ends[1] - self.ends[0]
    }
}

/// Sets the driver's current and threshold for the next stroke.
pub(super) fn set<'c>(hands: &mut impl PhaseHands<'c>, motor: Actuator, search: StallSearch) -> Result<(), Failure> {
    hands
        .drivers(|drivers| drivers.begin_stall_search(motor, search))
        .map_err(|fault| silent(hands.texts(), motor, fault))
}

pub(super) fn silent(texts: &Texts, motor: Actuator, fault: DriverFault) -> Failure {
    let why = match fault {
        DriverFault::External => "has no driver of this board",
        DriverFault::Silent | DriverFault::BadAnswer => "its driver does not answer",
        DriverFault::Reset => "its driver was without power",
        DriverFault::BadSetting => "its driver cannot be set so",
    };
    texts.refused(format_args!("{}: {why}", motor.name()))
}

/// Moves there and back at a speed; returns the driver's load readings while the speed is constant.
///
/// # Errors
/// When the machine halts, the person or host who asked wants the test to end, the driver does not answer, or
/// the driver or its motor is not sound.
pub(super) fn there_and_back<'c>(
    hands: &mut impl PhaseHands<'c>,
    way: &Way,
    rate: f64,
    is_crawl: bool,
) -> Result<Readings, Failure> {
    let mut readings = Readings::default();
    for _ in 0..2 {
        one_way(hands, way, rate, is_crawl, &mut readings)?;
        if hands.is_let_go() {
            return Err(Failure::refused(&"it was stopped: nothing was changed"));
        }
    }
    if readings.count() < way.count(is_crawl) {
        return Err(hands.texts().refused(format_args!(
            "at {rate:.1} mm/s there were {} readings only: the axis did not keep its speed",
            readings.count()
        )));
    }
    is_sound(hands, way.motor)?;
    Ok(readings)
}

fn one_way<'c>(
    hands: &mut impl PhaseHands<'c>,
    way: &Way,
    rate: f64,
    is_crawl: bool,
    readings: &mut Readings,
) -> Result<(), Failure> {
    let mut target = hands.position();
    let [least, most] = way.ends;
    let needed = way.needed(rate, is_crawl);
    let up = most - target[way.axis] > target[way.axis] - least;
    target[way.axis] =
        units::within(if up { target[way.axis] + needed } else { target[way.axis] - needed }, least, most);
    hands.go(target, MmPerSecond(rate), Mode::Feed)?;
    homing::steady(hands, way.full_step)?;
    let speed = hands.motion(|motion| motion.speed().0);
    let period = Micros((way.period(rate) * 1e6) as u64);
    let mut due = hands.now();
    loop {
        let (now, is_idle) = hands.motion(|motion| (motion.speed().0, motion.is_idle()));
        if is_idle || libm::fabs(now - speed) > 1e-3 * speed || libm::fabs(speed - rate) > 0.01 * rate {
            break;
        }
        if hands.now() >= due {
            due = due.plus(period);
            let reading = hands.drivers(|drivers| drivers.reserve(way.motor));
            readings.add(reading.map_err(|fault| silent(hands.texts(), way.motor, fault))?);
        }
        hands.wait(Wake::Any).unless_halted()?;
    }
    hands.standstill()
}

/// Refuses a driver that is hot or has an open coil: its load readings would be wrong.
fn is_sound<'c>(hands: &mut impl PhaseHands<'c>, motor: Actuator) -> Result<(), Failure> {
    let status = hands.drivers(|drivers| drivers.status(motor)).map_err(|fault| silent(hands.texts(), motor, fault))?;
    let name = motor.name();
    let why = if status.over_temperature || status.over_temperature_warning {
        "its driver is hot: let it cool, or lower the current"
    } else if status.short_a || status.short_b || status.supply_short_a || status.supply_short_b {
        "its driver reports a short circuit"
    } else {
        return Ok(());
    };
    Err(hands.texts().refused(format_args!("{name}: {why}")))
}
