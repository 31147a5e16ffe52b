//! Taking trajectory back: the part that no axis has used yet.
//!
//! Each axis uses the trajectory with its own delay: a shaped one looks ahead by its shift, so it is the
//! latency less that behind the trajectory's head; one without a filter is the whole latency behind. The part
//! that no *moving* axis has used may be replaced: an axis that stood still over the part it used would have
//! done the same with the new one, as long as that keeps it still.
//!
//! An extruder with pressure advance that moves along with X, Y or Z does not hold them up: its output goes
//! over to that of the new trajectory ([`super::correction`]).

use units::MAX_AXES;

use super::{
    Filters,
    history::{Source, Stretch, earlier, is_before, later, seconds},
};
use crate::{path::Path, ramp::Ramp};

/// Axes that move by less than this for a millimetre of path stand still: their movement during one latency
/// is no step.
const STILL: f64 = 1e-9;
/// Movement by a curve, mm, up to which an axis stands still.
const STILL_CURVE: f64 = 1e-9;

/// Place at which the trajectory can be begun anew.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Trajectory time of the place.
    pub time: u64,
    /// Count of the stretch that will be the newest.
    newest: u32,
    /// Origin of the stretch that goes on from there.
    pub source: Source,
    /// Path distance from the beginning of the block, mm.
    pub travelled: f64,
    /// Path speed, mm/s.
    pub speed: f64,
    /// Seconds since the stretch began.
    pub elapsed: f64,
    /// The way of the block.
    pub path: Path,
}

impl Place {
    /// The ramp under way, and how many seconds of it are over.
    pub fn ramp(&self) -> Option<(Ramp, f64)> {
        let (ramp, before) = self.source.ramp?;
        let elapsed = before + self.elapsed;
        // `Run` leaves out phases of a nanosecond.
        if elapsed < ramp.duration() - 1e-9 { Some((ramp, elapsed)) } else { None }
    }
}

impl Filters {
    /// Returns the time from which on the trajectory may be replaced, as far as that is of any use; `head` is
    /// its end. All axes count that are set in `careful` even where they stand still.
    pub fn unused_from(&self, head: u64, careful: [bool; MAX_AXES]) -> u64 {
        let used = self.used_until();
        // Going back farther would let nobody feel the change sooner.
        let mut from = used.iter().copied().reduce(earlier).unwrap_or(head);
        for (used, careful) in used.into_iter().zip(careful) {
            from = if careful { later(from, used) } else { from };
        }
        let (newest, count) = self.history.extent();
        let mut known = careful;
        let mut end = head;
        for age in 0..count {
            let stretch = self.history.stretch(newest.wrapping_sub(age));
            if !is_before(from, end) {
                break;
            }
            if !stretch.is_rest() {
                let moves = self.moves(stretch);
                let [x, y, z, ..] = moves;
                for (axis, known) in known.iter_mut().enumerate() {
                    let yields = (x || y || z) && self.is_advanced(axis);
                    let used = used.get(axis).copied().unwrap_or(from);
                    if !*known && !yields && moves.get(axis) == Some(&true) && is_before(stretch.start, used) {
                        *known = true;
                        from = later(from, earlier(used, end));
                    }
                }
            }
            end = stretch.start;
        }
        earlier(from, head)
    }

    /// Returns for each axis the time up to which it has used the trajectory.
    pub fn used_until(&self) -> [u64; MAX_AXES] {
        let now = self.out.to_bits() as u64;
        let mut used = [now; MAX_AXES];
        for (axis, used) in used.iter_mut().enumerate() {
            let taps =
                self.taps.iter().take(self.tap_count).filter(|tap| tap.weights.get(axis).is_some_and(|w| *w != 0.0));
            let window = self.windows.iter().flatten().filter(|window| window.axis == axis);
            let delays = taps.map(|tap| &tap.cursor).chain(window.flat_map(|window| window.cursors.first()));
            if let Some(delay) = delays.map(|cursor| cursor.delay).min() {
                *used = now.wrapping_sub(delay);
            }
        }
        used
    }

    /// Whether an axis is an extruder with pressure advance.
    pub fn is_advanced(&self, axis: usize) -> bool {
        self.windows.iter().flatten().any(|window| window.axis == axis)
    }

    /// Returns the axes that move in a stretch that is no rest.
    fn moves(&self, stretch: &Stretch) -> [bool; MAX_AXES] {
        let path = Path { origin: stretch.origin, direction: stretch.direction, curve: self.history.curve_of(stretch) };
        moves(&path)
    }

    /// The first place from `time` on, before `head`, at which the trajectory can be begun anew; `known` says
    /// which sources can.
    pub fn place_from(&self, time: u64, head: u64, known: impl Fn(&Source, f64) -> bool) -> Option<Place> {
        let (newest, count) = self.history.extent();
        // The search begins at the oldest stretch that may matter: stretches are in order of time.
        let oldest = (0..count).rev().find(|age| {
            let end = if *age == 0 { head } else { self.history.stretch(newest.wrapping_sub(age - 1)).start };
            is_before(time.wrapping_add(super::LEAST_SPACING), end)
        })?;
        for age in (0..=oldest).rev() {
            let number = newest.wrapping_sub(age);
            let stretch = self.history.stretch(number);
            let Some(source) = stretch.source() else { continue };
            let within = is_before(stretch.start, time);
            let begin = later(stretch.start, time);
            // A beginning at the stretch's own start leaves nothing of the stretch; the very first must stay.
            let (way, speed) = stretch.along(begin);
            let travelled = source.base + way;
            if (!within && age + 1 >= count) || !known(&source, travelled) {
                continue;
            }
            let path =
                Path { origin: source.origin, direction: stretch.direction, curve: self.history.curve_of(stretch) };
            let elapsed = seconds(begin.wrapping_sub(stretch.start));
            let newest = if within { number } else { number.wrapping_sub(1) };
            return Some(Place { time: begin, newest, source, travelled, speed, elapsed, path });
        }
        None
    }

    /// Forgets the trajectory behind this place. The new trajectory must be settled as far as the old one was
    /// before any more is put out.
    pub fn take_back(&mut self, place: &Place) {
        let newest = place.newest;
        self.history.truncate(newest);
        let (_, cursors) = self.cursors_mut();
        for cursor in cursors {
            if cursor.count.wrapping_sub(newest) as i32 > 0 {
                cursor.count = newest;
            }
        }
        self.cut_piece = None;
        self.drained = false;
        self.corrections.want();
    }
}

/// Returns the axes that move along a path.
pub(crate) fn moves(path: &Path) -> [bool; MAX_AXES] {
    let mut moves = path.direction.0.map(|part| libm::fabs(part) > STILL);
    for (moves, bends) in moves.iter_mut().zip(path.curve.moves(STILL_CURVE)) {
        *moves |= bends;
    }
    moves
}
