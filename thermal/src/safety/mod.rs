//! Heat safety: decides whether heating may go on, from raw readings and from the commands to the pins alone.
//!
//! Heat safety stands apart from control: with its own copies of the sensors' laws it reads the same raw
//! inputs itself, and counts at every modulation tick the heater pins that were on, so that a mistake in a
//! control law, a wrong duty or a forgotten target cannot hide anything from it. A fault closes the outputs
//! here ([`HeatSafety::pass`]), although control goes on asking for power, until a person releases the
//! machine.
//!
//! | law | fault that it finds | file |
//! |---|---|---|
//! | reading | open, shorted, outside `min_temp` to `max_temp`, changing too fast, jumping | `reading.rs` |
//! | response | driven, and does not warm; held, and sinks away from its target | `response.rs` |
//! | frozen | the reading stands although its heater is given another output | `frozen.rs` |
//! | course | the target is not reached in time, or left by more than `runaway_range` | `course.rs` |
//! | rest | warms although it is switched off | `at_rest.rs` |
//! | wiring | a heater warms another heater's sensor and not its own | `swapped.rs` |
//! | time | fully driven for too long, at one target for too long, driven without a target | `time.rs` |
//!
//! Every law takes a [`Look`] at a time and answers with a cause or not; none of the laws knows another.

mod at_rest;
mod course;
mod frozen;
mod look;
mod reading;
mod response;
mod swapped;
mod time;

use config::HeaterId;
use heapless::Vec;
use units::{Celsius, Micros};

use crate::combined::read as read_sensor;
use crate::io::{MAX_HEATERS, OutputLevels, SensorReadings, heater_bit};
use crate::sensor::{Sensor, SensorFault};
use at_rest::StuckOnWatch;
use course::Course;
use frozen::Frozen;
use look::Look;
use reading::ReadingLaw;
use response::Response;
use swapped::Warmed;
use time::Time;

pub use course::CourseLimits;
pub use look::{HeatCause, HeatFault, LOOK_PERIOD, OFF_BELOW};
pub use reading::ReadingLimits;
pub use response::ResponseLimits;
pub use time::TimeLimits;

/// The bits of all heaters.
const HEATERS: u32 = heater_bit(MAX_HEATERS) - 1;

/// Limits of a single heater. Zero switches off the checks that say so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafetyLimits {
    /// Whether the heater has an output; a sensor alone is not judged.
    pub heats: bool,
    /// Greatest share of full output for the heater, above 0 to 1.
    pub full_share: f32,
    /// Limits on the readings.
    pub reading: ReadingLimits,
    /// Limits on the response to being driven.
    pub response: ResponseLimits,
    /// Limits on the time to the target, and on the distance from it.
    pub course: CourseLimits,
    /// Limits on the time for which the heater is driven.
    pub time: TimeLimits,
}

/// The watch over a single heater.
#[derive(Clone, Debug)]
struct Watch {
    sensor: Sensor,
    limits: SafetyLimits,
    on_ticks: u32,
    reading: ReadingLaw,
    response: Response,
    frozen: Frozen,
    course: Course,
    rest: StuckOnWatch,
    time: Time,
    warmed: Warmed,
}

impl Watch {
    fn new(sensor: Sensor, limits: SafetyLimits) -> Self {
        Self {
            sensor,
            limits,
            on_ticks: 0,
            reading: ReadingLaw::default(),
            response: Response::default(),
            frozen: Frozen::default(),
            course: Course::default(),
            rest: StuckOnWatch::default(),
            time: Time::default(),
            warmed: Warmed::default(),
        }
    }

    /// Runs all laws, the others also after a law has failed: none loses its memory of the course.
    fn check(&mut self, look: &Look) -> Result<(), HeatCause> {
        let limits = &self.limits;
        let reading = self.reading.check(&limits.reading, look);
        let response = self.response.check(&limits.response, limits.full_share, look);
        let frozen = self.frozen.check(&limits.response, limits.full_share, look);
        let course = self.course.check(&limits.course, look);
        let rest = self.rest.check(limits.reading.max, look);
        let time = self.time.check(&limits.time, limits.full_share, look);
        reading.and(rest).and(response).and(frozen).and(course).and(time)
    }
}

/// The watch over all heaters of the machine.
#[derive(Debug, Default)]
pub struct HeatSafety {
    watches: Vec<Watch, MAX_HEATERS>,
    ticks: u32,
    due: Micros,
    tripped: bool,
}

impl HeatSafety {
    /// Creates a watch over no heater.
    #[must_use]
    pub const fn new() -> Self {
        Self { watches: Vec::new(), ticks: 0, due: Micros(0), tripped: false }
    }

    /// Adds the next temperature control, in the configuration's order. Returns false when there is no room.
    #[must_use]
    pub fn add(&mut self, sensor: Sensor, limits: SafetyLimits) -> bool {
        self.watches.push(Watch::new(sensor, limits)).is_ok()
    }

    /// Changes the sensor of a heater (M305).
    pub fn set_sensor(&mut self, heater: HeaterId, sensor: Sensor) {
        if let Some(watch) = self.watches.get_mut(heater.index()) {
            let limits = watch.limits;
            *watch = Watch::new(sensor, limits);
        }
    }

    /// Changes the highest temperature of a heater (M143).
    pub fn set_maximum(&mut self, heater: HeaterId, max: Celsius) {
        if let Some(watch) = self.watches.get_mut(heater.index()) {
            watch.limits.reading.max = max;
        }
    }

    /// Changes the ceiling of a heater's output, as a share of full output (M301 Y).
    pub fn set_full_share(&mut self, heater: HeaterId, full_share: f32) {
        if let Some(watch) = self.watches.get_mut(heater.index()) {
            watch.limits.full_share = full_share;
        }
    }

    /// Counts the pins that are on, and lets through the allowed outputs: after a fault no heater and no
    /// supply. Call at every modulation tick with the outputs that control asks for.
    #[inline]
    pub fn pass(&mut self, asked: OutputLevels) -> OutputLevels {
        let passed = if self.tripped { OutputLevels { on: asked.on & !HEATERS, fets_enabled: false } } else { asked };
        self.ticks += 1;
        for (index, watch) in self.watches.iter_mut().enumerate() {
            watch.on_ticks += u32::from(passed.on & heater_bit(index) != 0);
        }
        passed
    }

    /// Looks at every heater when a look is due; returns the first fault found. A fault closes the outputs
    /// until [`Self::release`].
    pub fn look(
        &mut self,
        now: Micros,
        readings: &SensorReadings,
        target: impl Fn(usize) -> Celsius,
    ) -> Option<HeatFault> {
        if now < self.due {
            return None;
        }
        self.due = now.plus(LOOK_PERIOD);
        self.look_at_heaters(now, readings, target)
    }

    /// Looks at the heaters, twenty times a second. A function of its own in the image, so that the ledger
    /// can tell its cost.
    #[inline(never)]
    fn look_at_heaters(
        &mut self,
        now: Micros,
        readings: &SensorReadings,
        target: impl Fn(usize) -> Celsius,
    ) -> Option<HeatFault> {
        let ticks = core::mem::take(&mut self.ticks).max(1) as f32;
        let mut found = None;
        // A sensor that combines others is read through the copies that are here.
        let mut read = [Err(SensorFault::SILENT); MAX_HEATERS];
        for (id, read) in HeaterId::all().zip(&mut read) {
            *read = read_sensor(&self.watches, |watch| &watch.sensor, readings, id);
        }
        let is_on = |(index, _): &(usize, _)| target(*index) > OFF_BELOW;
        let (mut on, mut warmest) = (0, Celsius(f32::MIN));
        for (_, read) in read.iter().take(self.watches.len()).enumerate().filter(is_on) {
            on += 1;
            warmest = read.map_or(warmest, |read| if read > warmest { read } else { warmest });
        }
        for ((id, watch), read) in HeaterId::all().zip(&mut self.watches).zip(read) {
            let driven = core::mem::take(&mut watch.on_ticks) as f32 / ticks;
            let target = target(id.index());
            let another_on = on > usize::from(target > OFF_BELOW);
            let beside_warmer = read.is_ok_and(|read| warmest > read);
            let look = Look { now, reading: read.ok(), fault: read.err(), target, driven, another_on, beside_warmer };
            watch.warmed.note(&look, on == 0, watch.limits.full_share);
            if watch.limits.heats
                && let Err(cause) = watch.check(&look)
            {
                found.get_or_insert(HeatFault { heater: id, cause });
            }
        }
        // A heater that warms the wrong sensor also does not warm its own, and seems stuck on there: wiring
        // explains both faults, so it goes first.
        let found = self.swapped().or(found);
        self.tripped |= found.is_some();
        found
    }

    fn swapped(&self) -> Option<HeatFault> {
        let heating = || HeaterId::all().zip(&self.watches).filter(|(_, watch)| watch.limits.heats);
        heating().find_map(|(heater, watch)| {
            let warms =
                |(other, watched): &(HeaterId, &Watch)| *other != heater && watch.warmed.instead(&watched.warmed);
            heating().find(warms).map(|(other, _)| HeatFault { heater, cause: HeatCause::Swapped(other) })
        })
    }

    /// Closes the outputs for a reason outside heat safety.
    pub const fn trip(&mut self) {
        self.tripped = true;
    }

    /// Opens the outputs to control again, after a person has seen the fault.
    pub fn release(&mut self) {
        self.tripped = false;
        for watch in &mut self.watches {
            watch.warmed = Warmed::default();
        }
    }
}

#[cfg(test)]
mod tests;
