//! Filters on the trajectory: input shapers for X, Y and Z, pressure advance for the extruders.
//!
//! The filters stand between the trajectory and the knots, on Cartesian axes, so they are right for every
//! kinematics. The trajectory runs ahead of the motors by the [`FilterConfig::latency`]; its recent course is
//! kept as a `history` of stretches of constant jerk. At output time t a shaped axis is the weighted sum of
//! its positions at t less the delay of each pulse ([`shaper`]); an extruder is its advanced position
//! averaged over a window ([`advance`]); any other axis is its position at t less the latency. All axes share
//! the latency, so nothing lags behind anything else at constant speed.
//!
//! Each delay has a cursor into the history, which only moves forward: the cost of a knot does not depend on
//! how long the history is. At each passage of a cursor from one stretch to the next, the output has a kink;
//! and a knot is put there: between two knots shaped axes are cubics of time at most, which a cubic matches
//! exactly, and extruders are quintics, which it matches to `T^4 / 384` times the change of acceleration over
//! a quarter of the smoothing time squared (1e-9 mm at most for real machines). Kinks closer than
//! [`LEAST_SPACING`] share a knot.
//!
//! Without a configured filter, or with filters switched off (homing), none of this runs and nothing is
//! delayed.

pub mod advance;
mod correction;
mod history;
pub mod shaper;
mod taking_back;

use units::{Axis, MAX_AXES, PerAxis};

pub use advance::PressureAdvance;
pub use history::MAX_EXTRUDERS;
pub(crate) use history::{History, Source, Stretch, is_before};
pub use shaper::{Pulse, Pulses, Shaper, ShaperKind};
pub(crate) use taking_back::{Place, moves};

use crate::{
    elsewhere::Elsewhere,
    greatest,
    path::Curve,
    trajectory::{Piece, TickTime, tick_time},
};
use advance::Window;
use correction::Corrections;
use history::{CAPACITY, Cursor};

/// The filters of a machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilterConfig {
    /// Input shapers of X, Y and Z.
    pub shapers: [Option<Shaper>; 3],
    /// Pressure advance of the extruders on A, B and C.
    pub advance: [Option<PressureAdvance>; MAX_EXTRUDERS],
}

impl FilterConfig {
    /// No filters: every axis as it is.
    pub const NONE: Self = Self { shapers: [None; 3], advance: [None; MAX_EXTRUDERS] };

    /// Pressure advance that does something: a factor of zero leaves an extruder as it is.
    fn advancing(&self) -> [Option<PressureAdvance>; MAX_EXTRUDERS] {
        self.advance.map(|advance| advance.filter(|advance| advance.factor > 0.0))
    }

    /// Returns the lag of the motors behind the trajectory, seconds: the farthest that any filter looks
    /// ahead.
    #[must_use]
    pub fn latency(&self) -> f64 {
        let shapers = self.shapers.iter().flatten().map(|shaper| shaper.pulses().shift());
        let windows = self.advancing().into_iter().flatten().map(|advance| 0.5 * advance.smooth_time);
        shapers.chain(windows).fold(0.0, greatest)
    }
}

/// Kinks closer together than this (2 us) share a knot: the error in time is below 0.15 of this times the
/// relative change of speed.
pub const LEAST_SPACING: u64 = 400 << 32;

/// Delays of three shapers, and that of the axes that have none.
const MAX_TAPS: usize = 3 * shaper::MAX_PULSES + 1;

/// A delay, and the weight that each axis gives it.
#[derive(Clone, Copy, Debug)]
struct Tap {
    cursor: Cursor,
    weights: [f64; MAX_AXES],
}

impl Tap {
    const NONE: Self = Self { cursor: Cursor { delay: 0, count: 0 }, weights: [0.0; MAX_AXES] };
}

/// The filters at work.
#[derive(Debug)]
pub(crate) struct Filters {
    history: Elsewhere<History>,
    taps: [Tap; MAX_TAPS],
    tap_count: usize,
    windows: [Option<Window>; MAX_EXTRUDERS],
    corrections: Corrections,
    /// Longest of the filters' delays.
    span: u64,
    /// At least one filter is configured.
    configured: bool,
    /// Filters are configured, but not to be used.
    pub bypassed: bool,
    /// Value that [`Self::bypassed`] takes at the next standstill.
    pub bypass_wanted: bool,
    /// Time up to which the output is settled.
    pub out: TickTime,
    /// Whether the output stands still with the trajectory.
    pub drained: bool,
    /// The piece of trajectory that the last stretch ends within, having lumped its beginning together with
    /// others.
    pub cut_piece: Option<Piece>,
    /// Whether the output has a kink at `out`, found by the knot that was not taken then.
    turned: bool,
    /// Output at `out`: place, and velocity just before.
    pub point: PerAxis<f64>,
    velocity: PerAxis<f64>,
}

/// Sum of two vectors.
fn sum([ax, ay, az]: [f64; 3], [bx, by, bz]: [f64; 3]) -> [f64; 3] {
    [ax + bx, ay + by, az + bz]
}

/// The output at the end of a segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Knot {
    /// Length of the segment, seconds.
    pub seconds: f64,
    /// Place and velocity (mm/s) at the beginning; there it may jump.
    pub start: PerAxis<f64>,
    pub entry: PerAxis<f64>,
    /// Place and velocity at the end.
    pub point: PerAxis<f64>,
    pub exit: PerAxis<f64>,
}

impl Filters {
    /// Creates filters that leave the trajectory as it is.
    pub const fn new(history: Elsewhere<History>) -> Self {
        Self {
            history,
            taps: [Tap::NONE; MAX_TAPS],
            tap_count: 0,
            windows: [None; MAX_EXTRUDERS],
            corrections: Corrections::NONE,
            span: 0,
            configured: false,
            bypassed: false,
            bypass_wanted: false,
            out: TickTime::ZERO,
            drained: true,
            cut_piece: None,
            turned: false,
            point: PerAxis([0.0; MAX_AXES]),
            velocity: PerAxis([0.0; MAX_AXES]),
        }
    }

    /// Whether the trajectory goes through here at all.
    pub const fn engaged(&self) -> bool {
        self.configured && !self.bypassed
    }

    /// Changes the filters. Call at rest, then [`Self::settle`].
    pub fn configure(&mut self, config: &FilterConfig) {
        let latency = config.latency();
        self.configured = latency > 0.0;
        self.tap_count = 0;
        for (axis, shaper) in config.shapers.iter().enumerate() {
            match shaper {
                Some(shaper) => self.add_shaper(axis, &shaper.pulses(), latency),
                None => self.add_tap(axis, latency, 1.0),
            }
        }
        for (index, advance) in config.advancing().into_iter().enumerate() {
            let axis = 3 + index;
            let window = advance.map(|advance| Window::new(axis, &advance, latency));
            if window.is_none() {
                self.add_tap(axis, latency, 1.0);
            }
            if let Some(slot) = self.windows.get_mut(index) {
                *slot = window;
            }
        }
        let factors = config.advancing().map(|advance| advance.map_or(0.0, |advance| advance.factor));
        self.history.configure(factors);
        self.corrections.configure(tick_time(latency).to_bits() as u64);
        self.span = self.cursors().map(|cursor| cursor.delay).fold(0, |longest, delay| longest.max(delay));
    }

    fn add_shaper(&mut self, axis: usize, pulses: &Pulses, latency: f64) {
        let first = latency - pulses.shift();
        for pulse in pulses.as_slice() {
            self.add_tap(axis, first + pulse.time, pulse.amplitude);
        }
    }

    /// Axes with the same delay share a tap.
    fn add_tap(&mut self, axis: usize, delay: f64, weight: f64) {
        let delay = tick_time(delay).to_bits() as u64;
        let known = self.taps.iter().take(self.tap_count).position(|tap| tap.cursor.delay == delay);
        let index = known.unwrap_or(self.tap_count);
        let Some(tap) = self.taps.get_mut(index) else { return };
        if known.is_none() {
            *tap = Tap { cursor: Cursor { delay, count: 0 }, ..Tap::NONE };
            self.tap_count += 1;
        }
        if let Some(slot) = tap.weights.get_mut(axis) {
            *slot = weight;
        }
    }

    fn cursors(&self) -> impl Iterator<Item = &Cursor> {
        let windows = self.windows.iter().flatten().flat_map(|window| window.cursors.iter());
        self.taps.iter().take(self.tap_count).map(|tap| &tap.cursor).chain(windows)
    }

    fn cursors_mut(&mut self) -> (&History, impl Iterator<Item = &mut Cursor>) {
        let windows = self.windows.iter_mut().flatten().flat_map(|window| window.cursors.iter_mut());
        (&*self.history, self.taps.iter_mut().take(self.tap_count).map(|tap| &mut tap.cursor).chain(windows))
    }

    /// Settles the filters as if the machine had always stood at `place`.
    pub fn settle(&mut self, place: PerAxis<f64>, at: TickTime) {
        let count = self.history.restart(Stretch::rest(at, place).0);
        let (_, cursors) = self.cursors_mut();
        for cursor in cursors {
            cursor.count = count;
        }
        self.out = at;
        self.drained = true;
        self.cut_piece = None;
        self.turned = false;
        self.corrections.clear();
        self.point = place;
        self.velocity = PerAxis([0.0; MAX_AXES]);
    }

    /// Appends a stretch to the trajectory. Stretches come in order of time.
    pub fn push(&mut self, (stretch, curve): (Stretch, Curve), source: Option<Source>) {
        let oldest = self.oldest();
        self.history.push(stretch.from(source), &curve, oldest);
    }

    /// Count of the oldest stretch that is still looked at.
    fn oldest(&self) -> Option<u32> {
        self.cursors().map(|cursor| cursor.count).reduce(|a, b| if (b.wrapping_sub(a) as i32) < 0 { b } else { a })
    }

    /// Whether a stretch along this curve can be kept.
    pub fn has_room_for(&self, curve: &Curve) -> bool {
        self.oldest().is_none_or(|oldest| self.history.has_room_for(curve, oldest))
    }

    /// The newest stretch of trajectory.
    pub fn newest(&self) -> &Stretch {
        self.history.newest()
    }

    /// Replaces the newest stretch by a straight one with the same beginning. Only before any output from it.
    pub fn amend(&mut self, (stretch, _): (Stretch, Curve)) {
        self.history.amend(stretch);
    }

    /// Returns the least duration of a stretch, seconds: zero unless the history is half full. From then on
    /// stretches this long fit twice into the rest of it, whatever comes.
    pub fn least_stretch(&self) -> f64 {
        let oldest = self.cursors().map(|cursor| self.history.age(cursor.count)).fold(0, |a, b| a.max(b));
        if (oldest as usize) < CAPACITY / 2 { 0.0 } else { history::seconds(self.span) / (CAPACITY / 4) as f64 }
    }

    /// Returns the time for which a trajectory at rest must still be followed until the output is at rest
    /// too; zero when it is.
    pub fn still_to_drain(&self) -> TickTime {
        // The rest may begin a sliver after the output's end.
        let rested = (self.out.to_bits() as u64).wrapping_sub(self.newest().start) as i64;
        let left = (self.span as i64).saturating_sub(rested);
        let left = left.max(self.corrections.left(self.out.to_bits() as u64).unwrap_or(0) as i64);
        TickTime::from_bits(if left > 0 { left as u128 } else { 0 })
    }

    /// Returns the least and the greatest delay with which X, Y and Z follow the trajectory.
    #[inline(never)]
    pub fn primary_delays(&self) -> (u64, u64) {
        let is_primary = |tap: &&Tap| Axis::PRIMARY.into_iter().any(|axis| tap.weights[axis as usize] != 0.0);
        let taps = self.taps.iter().take(self.tap_count).filter(is_primary);
        taps.fold((u64::MAX, 0), |(least, most), tap| (least.min(tap.cursor.delay), most.max(tap.cursor.delay)))
    }

    /// Returns the place of X, Y and Z at a time of the trajectory, and a direction: of the path there, or
    /// the sum of those before and behind a corner. `None` when the time is too long ago.
    pub fn way_at(&self, time: u64) -> Option<([f64; 3], [f64; 3])> {
        let (newest, count) = self.history.extent();
        let age = (0..count).find(|age| !is_before(time, self.history.stretch(newest.wrapping_sub(*age)).start))?;
        let stretch = self.history.stretch(newest.wrapping_sub(age));
        let (place, mut direction) = self.way_along(stretch, time);
        if stretch.start == time && age + 1 < count {
            let before = self.history.stretch(newest.wrapping_sub(age + 1));
            direction = sum(direction, self.way_along(before, time).1);
        }
        Some((place, direction))
    }

    /// Returns the place of X, Y and Z at a time in a stretch, and the direction of the path, if any.
    fn way_along(&self, stretch: &Stretch, time: u64) -> ([f64; 3], [f64; 3]) {
        let way = stretch.along(time).0;
        let place = Axis::PRIMARY.map(|axis| stretch.origin[axis] + stretch.direction[axis] * way);
        if stretch.is_rest() {
            return (place, [0.0; 3]);
        }
        let (offset, slope) = self.history.bent(stretch, way).unwrap_or_default();
        (sum(place, offset), sum(Axis::PRIMARY.map(|axis| stretch.direction[axis]), slope))
    }

    /// Shifts everything in time.
    pub fn shift(&mut self, by: TickTime) {
        self.out += by;
        self.history.shift(by.to_bits() as u64);
        self.corrections.shift(by.to_bits() as u64);
        if let Some(piece) = &mut self.cut_piece {
            piece.start += by;
        }
    }

    /// Moves on to the next knot, `longest` seconds on at most, not beyond `settled`, up to where the
    /// trajectory is known. `None` when that would be later than `latest`.
    pub fn advance(&mut self, longest: f64, settled: TickTime, latest: TickTime) -> Option<Knot> {
        let now = self.out.to_bits() as u64;
        let mut room = settled.saturating_sub(self.out).min(tick_time(longest)).to_bits() as u64;
        let mut nearest = u64::MAX;
        let mut turned = self.turned;
        let (history, cursors) = self.cursors_mut();
        for cursor in cursors {
            turned |= history.pass(&mut cursor.count, now.wrapping_sub(cursor.delay), true);
            if let Some(next) = history.next_start(cursor.count) {
                nearest = nearest.min(next.wrapping_add(cursor.delay).wrapping_sub(now));
            }
        }
        let output = (&self.point, &self.velocity);
        turned |= self.corrections.begin(now, (&*self.history, &self.windows), output);
        let nearest = nearest.min(self.corrections.left(now).unwrap_or(u64::MAX));
        room = room.min(nearest.max(LEAST_SPACING));
        let out = self.out + TickTime::from_bits(u128::from(room));
        if out > latest {
            // The cursors have passed into their next stretches, and will not do so again.
            self.turned = turned;
            return None;
        }
        self.turned = false;
        let start = self.point;
        let entry = if turned { self.output(now).1 } else { self.velocity };
        let end = now.wrapping_add(room);
        let (history, cursors) = self.cursors_mut();
        for cursor in cursors {
            history.pass(&mut cursor.count, end.wrapping_sub(cursor.delay), false);
        }
        let (point, exit) = self.output(end);
        self.corrections.end(end);
        self.out = out;
        self.point = point;
        self.velocity = exit;
        Some(Knot { seconds: history::seconds(room), start, entry, point, exit })
    }

    /// Place and velocity at `time`, each cursor's stretch taken as it is.
    fn output(&self, time: u64) -> (PerAxis<f64>, PerAxis<f64>) {
        // Sums of differences from a nearby place: at rest they are zero, and the output is exact.
        let near = self.taps.first().map_or(self.point, |tap| self.history.stretch(tap.cursor.count).origin);
        let (mut point, mut velocity) = (near, PerAxis([0.0; MAX_AXES]));
        for tap in self.taps.iter().take(self.tap_count) {
            let stretch = self.history.stretch(tap.cursor.count);
            let (way, speed) = stretch.along(time.wrapping_sub(tap.cursor.delay));
            for axis in Axis::ALL {
                let weight = tap.weights[axis as usize];
                if weight != 0.0 {
                    point[axis] += weight * (stretch.origin[axis] - near[axis] + stretch.direction[axis] * way);
                    velocity[axis] += weight * (stretch.direction[axis] * speed);
                }
            }
            let Some((offset, slope)) = self.history.bent(stretch, way) else { continue };
            for (axis, (offset, slope)) in Axis::PRIMARY.into_iter().zip(offset.into_iter().zip(slope)) {
                let weight = tap.weights[axis as usize];
                point[axis] += weight * offset;
                velocity[axis] += weight * (slope * speed);
            }
        }
        let history = &*self.history;
        for window in self.windows.iter().flatten() {
            let (mut place, mut rate) = window.output(history, time);
            if let Some((ahead, faster)) = self.corrections.at(window.axis, time) {
                (place, rate) = (place + ahead, rate + faster);
            }
            if let (Some(p), Some(v)) = (point.0.get_mut(window.axis), velocity.0.get_mut(window.axis)) {
                (*p, *v) = (place, rate);
            }
        }
        (point, velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rest_that_begins_just_after_the_output_has_yet_to_drain() {
        let shaper = Shaper { kind: ShaperKind::Zv, frequency: 50.0, damping: 0.0 };
        let mut filters = Filters::new(std::boxed::Box::new(History::new()));
        filters.configure(&FilterConfig { shapers: [Some(shaper), None, None], ..FilterConfig::NONE });
        let start = tick_time(1.0);
        filters.settle(PerAxis::default(), start);
        filters.push(Stretch::rest(start + TickTime::from_bits(1), PerAxis::default()), None);
        let whole = filters.still_to_drain();
        assert_eq!(whole.to_bits(), u128::from(filters.span) + 1, "a shaper's length from the rest on");
        filters.out += whole;
        assert_eq!(filters.still_to_drain(), TickTime::ZERO);
    }
}
