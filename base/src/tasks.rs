//! Bodies of the periodic tasks, shared: the board's tasks and the host runner call them with the same
//! periods.
//!
//! | task | period | body |
//! |---|---|---|
//! | heat and slow outputs | [`HEAT_PERIOD_US`] | [`HeatTask::run`] |
//! | step feed | as [`FeedTask::wait`] says | [`FeedTask::run`] |
//! | drivers and supplies | [`CONTROLS_PER_SLOW`] control ticks | [`crate::supervisor::Supervisor::tick`] |
//! | executor | whenever nothing else runs | `machine::run` |

use core::sync::atomic::{AtomicU32, Ordering};

use motion::queue::StepQueue;
use motion::{Access, FeedSchedule, Latch, Mark, StepFeed, feed_schedule};
use thermal::{HeatControl, MODULATION_HZ};
use units::{Micros, Ticks};

use crate::ports::{OutputLevels, SensorReading, SensorReadings};

/// Time between two runs of the heat task: a tick of the modulators.
pub const HEAT_PERIOD_US: u32 = 1_000_000 / MODULATION_HZ;
/// Time between two runs of the step feed by period, and the longest between two on demand.
pub const FEED_PERIOD_US: u32 = (feed_schedule::PERIOD.nanoseconds() / 1_000) as u32;
/// Modulation ticks between two control ticks: 100 Hz.
pub const TICKS_PER_CONTROL: u32 = MODULATION_HZ / 100;
/// Control ticks in a row without a conversion after which the scan stands: 50 ms, in which it makes over
/// three hundred conversions.
const SCAN_STANDS: u8 = 5;
/// Control ticks between two runs of the slow watch: 10 Hz.
pub const CONTROLS_PER_SLOW: u32 = 10;

/// Progress of the motors, from the feed to the heat task, which changes outputs that ride on motion. Lives
/// in a `static`.
#[derive(Debug, Default)]
pub struct ReachedMark(AtomicU32);

impl ReachedMark {
    /// Starts without any mark.
    #[must_use]
    pub const fn new() -> Self {
        Self(AtomicU32::new(0))
    }

    /// Sets the mark. True when it is another one. For the feed, the only writer.
    fn set(&self, mark: Mark) -> bool {
        let is_new = self.0.load(Ordering::Relaxed) != mark.0;
        self.0.store(mark.0, Ordering::Release);
        is_new
    }

    fn get(&self) -> Mark {
        Mark(self.0.load(Ordering::Acquire))
    }
}

/// Pins and sensors of the heat task.
pub trait HeatIo {
    /// Returns the latest sensor readings.
    fn readings(&mut self) -> SensorReadings;

    /// Returns a number that changes with every conversion of the scan: the same for long means that the
    /// converter stands, and readings are old.
    fn scan_position(&mut self) -> u32;

    /// Returns the latest readings of the filament width sensor.
    fn filament_width(&mut self) -> [SensorReading; 2];

    /// Returns the levels of the inputs of tachometers, a bit for each fan of the configuration.
    fn tachometers(&mut self) -> u8;

    /// Writes the outputs whose level changes.
    fn apply(&mut self, levels: OutputLevels);

    /// Sets a switch on a hardware timer, by its place in the configuration's list, 0 to 1.
    fn set_pwm(&mut self, switch: usize, duty: f32);
}

/// Work that is due after a run of the heat task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Due {
    /// Whether heat control ran, and so is alive.
    pub controlled: bool,
    /// Whether the slow watch is to run.
    pub slow: bool,
}

/// Counter of the heat task's runs.
#[derive(Clone, Copy, Debug, Default)]
pub struct HeatTask {
    ticks: u32,
    controls: u32,
    scan: Scan,
}

/// Watch over the converter of the thermistors.
#[derive(Clone, Copy, Debug, Default)]
struct Scan {
    position: u32,
    same: u8,
}

impl Scan {
    /// Compares the scan's position with the last one; true once it has stood for [`SCAN_STANDS`].
    fn stands(&mut self, position: u32) -> bool {
        self.same = if position == self.position { self.same.saturating_add(1) } else { 0 };
        self.position = position;
        self.same >= SCAN_STANDS
    }
}

/// Makes a reading that was scanned before the converter stood a missing one.
fn forget_old(reading: &mut SensorReading) {
    if matches!(reading, SensorReading::Counts(_)) {
        *reading = SensorReading::Missing;
    }
}

impl HeatTask {
    /// Starts before the first run.
    #[must_use]
    pub const fn new() -> Self {
        Self { ticks: 0, controls: 0, scan: Scan { position: 0, same: 0 } }
    }

    /// Does one run: outputs whose place on the path has been reached, control when due, a tick of the
    /// modulators.
    pub fn run(&mut self, now: Micros, reached: &ReachedMark, heat: &mut HeatControl, io: &mut impl HeatIo) -> Due {
        heat.reach(reached.get());
        heat.count_pulses(io.tachometers());
        self.ticks += 1;
        let mut due = Due::default();
        if self.ticks >= TICKS_PER_CONTROL {
            self.ticks = 0;
            due.controlled = true;
            let mut readings = io.readings();
            if self.scan.stands(io.scan_position()) {
                readings.iter_mut().for_each(forget_old);
            }
            heat.tick(now, &readings);
            heat.set_filament_width(io.filament_width());
            self.controls += 1;
            if self.controls >= CONTROLS_PER_SLOW {
                self.controls = 0;
                due.slow = true;
            }
        }
        write(heat, io);
        due
    }

    /// Does a run between two others, because a change must not wait for the next run: no time has passed.
    pub fn run_early(&self, reached: &ReachedMark, heat: &mut HeatControl, io: &mut impl HeatIo) {
        heat.reach(reached.get());
        write(heat, io);
    }
}

fn write(heat: &mut HeatControl, io: &mut impl HeatIo) {
    io.apply(heat.modulation_tick());
    while let Some((switch, duty)) = heat.take_pwm_change() {
        io.set_pwm(switch, duty);
    }
}

/// Step feed, which reports the motors' progress.
#[derive(Debug)]
pub struct FeedTask {
    feed: StepFeed,
}

impl Default for FeedTask {
    fn default() -> Self {
        Self::new(FeedSchedule::ByPeriod, || {})
    }
}

impl FeedTask {
    /// Starts before the first run. `wake` has the step interrupt look at its queue.
    #[must_use]
    pub const fn new(schedule: FeedSchedule, wake: fn()) -> Self {
        Self { feed: StepFeed::new(schedule, wake) }
    }

    /// Returns the time from `now`, the end of a run, to the next run.
    #[must_use]
    pub fn wait(&self, now: Ticks) -> Ticks {
        self.feed.wait(now)
    }

    /// Whether motion is being written.
    #[must_use]
    pub const fn is_moving(&self) -> bool {
        self.feed.is_moving()
    }

    /// Does one run. The caller then makes sure that the step timer is armed; and when true is returned, that
    /// the heat task runs, since outputs may wait for the motors' present place.
    pub fn run(
        &mut self,
        now: Ticks,
        motion: &mut impl Access,
        queue: &StepQueue,
        latch: &Latch,
        reached: &ReachedMark,
    ) -> bool {
        reached.set(self.feed.run(now, motion, queue, latch).mark)
    }
}
