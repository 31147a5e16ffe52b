//! Objects that are left out of a print: the program follows their moves without making them. This module
//! computes the machine's way back to the first printed move.
//!
//! Filament is pushed and pulled back within an object too, and later lines depend on the state of
//! retraction. So the machine ends as far retracted as the file is then, regardless of the object's
//! extrusion. Retraction before the object equals the filament that the file pushes without motion before its
//! first printed line.

use heapless::Vec;
use units::{Axis, MmPerSecond, PerAxis, PowerLaw};

use crate::action::{Corner, Move, Rate, Shape};

/// State of an object that is left out, until the machine has returned to the print.
#[derive(Clone, Debug, Default)]
pub(crate) struct LeftOut {
    /// Whether lines of the object are still being read.
    lasts: bool,
    /// Whether the current block belongs to somebody other than the print.
    is_aside: bool,
    /// State of the waiting machine, since a move was left out.
    stays: Option<Stay>,
}

/// Position of the waiting machine, and the moves that have been left out.
#[derive(Clone, Debug)]
pub(crate) struct Stay {
    at: PerAxis<f64>,
    /// Position that the file assumes.
    believed: PerAxis<f64>,
    /// Whether a line of filament has been left out.
    has_printed: bool,
    /// Filament pushed or pulled back before that line, by extruder, mm.
    pushed: PerAxis<f64>,
    /// Greatest position of each extruder so far.
    furthest: PerAxis<f64>,
}

impl Stay {
    /// Creates the stay of a machine at this position, mm.
    pub fn new(at: PerAxis<f64>) -> Self {
        Self { at, believed: at, has_printed: false, pushed: PerAxis([0.0; units::MAX_AXES]), furthest: at }
    }

    /// Follows a left-out move to its end.
    pub fn follow(&mut self, to: &PerAxis<f64>, extruders: &[Axis]) {
        let from = core::mem::replace(&mut self.believed, *to);
        let has_way = Axis::PRIMARY.into_iter().any(|axis| from[axis] != to[axis]);
        for &axis in extruders {
            let pushed = to[axis] - from[axis];
            if has_way && pushed > 0.0 {
                self.has_printed = true;
            } else if !self.has_printed {
                // Counts filament that a wipe pulls back, too.
                self.pushed[axis] += pushed;
            }
            self.furthest[axis] = if to[axis] > self.furthest[axis] { to[axis] } else { self.furthest[axis] };
        }
    }

    /// Appends the left-out moves of `later` to those of this state.
    fn and_then(mut self, later: &Self) -> Self {
        for (pushed, more) in self.pushed.0.iter_mut().zip(later.pushed.0).filter(|_| !self.has_printed) {
            *pushed += more;
        }
        for (furthest, also) in self.furthest.0.iter_mut().zip(later.furthest.0) {
            *furthest = if also > *furthest { also } else { *furthest };
        }
        Self { believed: later.believed, has_printed: self.has_printed || later.has_printed, ..self }
    }

    /// Returns the position that the file assumes.
    pub const fn believed(&self) -> &PerAxis<f64> {
        &self.believed
    }

    /// Returns the extruder's position that matches the retraction of the file.
    fn due(&self, axis: Axis, believed: f64) -> f64 {
        let retracted = self.furthest[axis] - believed;
        let by = if self.has_printed { self.pushed[axis] - retracted } else { self.pushed[axis] };
        self.at[axis] + by
    }
}

impl LeftOut {
    /// Begins or ends the leaving out of moves.
    pub fn lasts(&mut self, yes: bool) {
        self.lasts = yes;
    }

    /// Sets whether the current block belongs to the print, rather than to somebody else.
    pub fn counts(&mut self, yes: bool) {
        self.is_aside = !yes;
    }

    /// Whether moves are neither left out nor to be made up for.
    pub const fn is_done(&self) -> bool {
        !self.lasts && self.stays.is_none()
    }

    /// Whether the object has ended and the current block belongs to the print.
    pub const fn has_ended(&self) -> bool {
        !self.lasts && !self.is_aside
    }

    /// Whether the machine waits at this position.
    pub fn stays_at(&self, position: &PerAxis<f64>) -> bool {
        self.stays.as_ref().is_some_and(|stay| stay.at == *position)
    }

    /// Ends the machine's wait and returns its position.
    pub fn take_place(&mut self) -> Option<PerAxis<f64>> {
        self.stays.take().map(|stay| stay.at)
    }

    /// Follows the move if it is left out; returns whether it is.
    pub fn follow(&mut self, from: PerAxis<f64>, to: &PerAxis<f64>, extruders: &[Axis]) -> bool {
        let is_left_out = self.lasts && !self.is_aside;
        if is_left_out {
            self.stays.get_or_insert_with(|| Stay::new(from)).follow(to, extruders);
        }
        is_left_out
    }

    /// Merges planned moves that are cancelled with the moves left out after them.
    pub fn stay(&mut self, earlier: Stay) {
        self.stays = Some(match self.stays.take() {
            Some(stay) => earlier.and_then(&stay),
            None => earlier,
        });
    }

    /// Returns the state of the waiting machine, since a move was left out.
    pub const fn stays(&self) -> Option<&Stay> {
        self.stays.as_ref()
    }
}

/// Parameters of the way back, beside its end.
#[derive(Clone, Debug)]
pub(crate) struct Manner<'e> {
    pub extruders: &'e [Axis],
    /// Extruder in use, and the rate of its retraction.
    pub pulls: Option<(Axis, MmPerSecond)>,
    pub travel: MmPerSecond,
}

impl Stay {
    /// Returns the way back to the file's next move, which leads to `target` and may be straight. `place` is
    /// the position that the file assumes; `must_arrive` means that more moves of the line follow.
    pub fn way_back(
        &self,
        place: &PerAxis<f64>,
        (target, is_straight): (&PerAxis<f64>, bool),
        must_arrive: bool,
        manner: &Manner<'_>,
    ) -> WayBack {
        let extruders = manner.extruders;
        let mut way = Way { at: self.at, moves: Vec::new(), travel: manner.travel };
        let due = manner.pulls.map(|(axis, rate)| (axis, self.due(axis, place[axis]), rate));
        if let Some((axis, due, rate)) = due.filter(|(axis, due, _)| due < &way.at[*axis]) {
            way.feed(axis, due, rate);
        }
        way.rise(place[Axis::Z]);
        let pushes = due.filter(|(axis, due, _)| due > &way.at[*axis]);
        // A straight travel move needs no way to its own beginning.
        let is_travel = is_straight && extruders.iter().all(|&axis| target[axis] == place[axis]);
        let arrives = pushes.is_some() || !is_travel || must_arrive;
        if arrives {
            way.over(place, extruders);
            if let Some((axis, due, rate)) = pushes {
                way.feed(axis, due, rate);
            }
        }
        let mut here = way.at;
        for &axis in extruders {
            here[axis] = place[axis];
        }
        WayBack { moves: way.moves, place: here, arrives }
    }
}

/// Way from the waiting machine to the file's next move.
#[derive(Clone, Debug)]
pub struct WayBack {
    /// Moves to be made in sequence.
    pub moves: Vec<Move, 5>,
    /// Position behind the moves, in the file's coordinates; only extruders may differ from the moves' end.
    pub place: PerAxis<f64>,
    /// Whether the moves reach the beginning of the file's next move; otherwise that move starts where they
    /// end.
    pub arrives: bool,
}

impl WayBack {
    /// Shifts the extruders' positions to the file's count at `at`, where the way begins. Returns the way,
    /// and the machine's position before the way.
    #[must_use]
    pub fn counted_anew(mut self, at: &PerAxis<f64>) -> (Self, PerAxis<f64>) {
        let end = self.moves.last().map_or(*at, |last| last.target);
        let mut from = *at;
        for axis in Axis::ALL {
            let by = self.place[axis] - end[axis];
            from[axis] += by;
            self.moves.iter_mut().for_each(|step| step.target[axis] += by);
        }
        (self, from)
    }
}

/// Builder of a way, move by move.
struct Way {
    at: PerAxis<f64>,
    moves: Vec<Move, 5>,
    travel: MmPerSecond,
}

impl Way {
    fn go(&mut self, to: PerAxis<f64>, rate: Rate) {
        if to != self.at {
            self.at = to;
            let shape = Shape::Line { names_xy: true };
            // There is room for all moves: filament twice, up, over, down.
            let _ = self.moves.push(Move {
                target: to,
                shape,
                rate,
                power: 0.0,
                power_law: PowerLaw::Off,
                corner: Corner::Sharp,
            });
        }
    }

    fn feed(&mut self, extruder: Axis, to: f64, rate: MmPerSecond) {
        let mut place = self.at;
        place[extruder] = to;
        self.go(place, Rate::Feed(rate));
    }

    fn rise(&mut self, z: f64) {
        let mut place = self.at;
        if z > place[Axis::Z] {
            place[Axis::Z] = z;
            self.go(place, Rate::Rapid(self.travel));
        }
    }

    /// Appends moves to this position, with the descent last; extruders stay.
    fn over(&mut self, to: &PerAxis<f64>, extruders: &[Axis]) {
        let mut place = *to;
        for &axis in extruders {
            place[axis] = self.at[axis];
        }
        let mut above = place;
        above[Axis::Z] = self.at[Axis::Z];
        self.go(above, Rate::Rapid(self.travel));
        self.go(place, Rate::Rapid(self.travel));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const E: Axis = Axis::A;

    fn at(x: f64, z: f64, e: f64) -> PerAxis<f64> {
        let mut place = PerAxis([0.0; units::MAX_AXES]);
        (place[Axis::X], place[Axis::Z], place[E]) = (x, z, e);
        place
    }

    fn stay(places: &[PerAxis<f64>]) -> Stay {
        let mut stay = Stay::new(places[0]);
        for place in &places[1..] {
            stay.follow(place, &[E]);
        }
        stay
    }

    #[test]
    fn the_machine_is_as_far_retracted_as_the_file_is() {
        // The file arrives retracted by 1, and the object ends retracted by 3.
        let stay =
            stay(&[at(0.0, 0.2, 9.0), at(5.0, 0.2, 9.0), at(5.0, 0.2, 10.0), at(50.0, 0.2, 14.0), at(50.0, 0.2, 11.0)]);
        assert_eq!(stay.due(E, 11.0), 7.0, "two more are pulled back");
    }

    #[test]
    fn what_is_not_printed_changes_retraction_alone() {
        let stay = stay(&[at(0.0, 0.2, 9.0), at(5.0, 0.2, 9.0), at(5.0, 0.2, 8.0)]);
        assert_eq!(stay.due(E, 8.0), 8.0);
    }

    #[test]
    fn what_a_wipe_would_have_pulled_back_is_pulled_back() {
        // The print stopped in the middle of a wipe: half of 2 mm has been pulled back.
        let stay = stay(&[at(50.0, 0.2, 13.5), at(45.0, 0.2, 13.0), at(45.0, 0.2, 12.0)]);
        assert_eq!(stay.due(E, 12.0), 12.0);
    }

    #[test]
    fn what_is_missed_in_two_parts_is_missed_as_one() {
        let places: std::vec::Vec<_> = [
            (0.0, 9.0),
            (5.0, 9.0),
            (5.0, 10.0),
            (50.0, 14.0),
            (50.0, 11.0),
            (70.0, 11.0),
            (70.0, 14.0),
            (90.0, 20.0),
            (90.0, 18.0),
        ]
        .into_iter()
        .map(|(x, e)| at(x, 0.2, e))
        .collect();
        let whole = stay(&places);
        for split in 0..places.len() {
            let both = stay(&places[..=split]).and_then(&stay(&places[split..]));
            assert_eq!((both.due(E, 18.0), both.believed), (whole.due(E, 18.0), whole.believed), "{split}");
        }
    }

    #[test]
    fn a_way_counted_anew_ends_where_the_file_believes() {
        let stay = stay(&[at(0.0, 0.2, 9.0), at(50.0, 0.2, 14.0), at(50.0, 0.2, 12.0)]);
        let manner = Manner { extruders: &[E], pulls: Some((E, MmPerSecond(30.0))), travel: MmPerSecond(100.0) };
        let next = at(60.0, 0.2, 14.0);
        let (way, from) = stay.way_back(stay.believed(), (&next, true), false, &manner).counted_anew(&stay.at);
        assert_eq!((from[E], way.moves.last().unwrap().target), (14.0, at(50.0, 0.2, 12.0)));
        assert!(way.arrives && way.place == at(50.0, 0.2, 12.0), "{way:?}");
    }

    #[test]
    fn a_way_goes_up_first_and_down_last() {
        let mut way = Way { at: at(0.0, 1.0, 5.0), moves: Vec::new(), travel: MmPerSecond(100.0) };
        way.rise(0.5);
        way.over(&at(10.0, 0.5, 77.0), &[E]);
        let places: std::vec::Vec<_> = way.moves.iter().map(|step| step.target).collect();
        assert_eq!(places, [at(10.0, 1.0, 5.0), at(10.0, 0.5, 5.0)]);
        way.rise(3.0);
        assert_eq!(way.moves.last().unwrap().target, at(10.0, 3.0, 5.0));
    }
}
