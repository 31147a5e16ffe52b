//! Objects that are left out of a print: their moves are followed, and not made. What the machine has to do
//! before it goes on with what is printed is worked out here.
//!
//! Filament is pushed and pulled back within an object too, and what follows counts on it. So the machine
//! ends as far retracted as the file then is, whatever the object would have used. How far the file was
//! retracted before is what it pushes without a way before its first line of filament.

use heapless::Vec;
use units::{Axis, MmPerSecond, PerAxis};

use crate::action::{Corner, Move, Rate, Shape};

/// An object that is left out, or has been, and the machine has not gone on since.
#[derive(Clone, Debug, Default)]
pub(crate) struct LeftOut {
    /// Its lines are read still.
    lasts: bool,
    /// The block that is read is none of the print's.
    is_aside: bool,
    /// Where the machine has stayed, since something was left out.
    stays: Option<Stay>,
}

/// Where the machine stays, and what it misses.
#[derive(Clone, Debug)]
pub(crate) struct Stay {
    at: PerAxis<f64>,
    /// Where the file believes it is.
    believed: PerAxis<f64>,
    /// A line of filament has been left out.
    has_printed: bool,
    /// Pushed or pulled back before that, by extruder, mm.
    pushed: PerAxis<f64>,
    /// The furthest that extruders have been.
    furthest: PerAxis<f64>,
}

impl Stay {
    pub fn new(at: PerAxis<f64>) -> Self {
        Self { at, believed: at, has_printed: false, pushed: PerAxis([0.0; units::MAX_AXES]), furthest: at }
    }

    /// A move that is left out.
    pub fn follow(&mut self, to: &PerAxis<f64>, extruders: &[Axis]) {
        let from = core::mem::replace(&mut self.believed, *to);
        let has_way = Axis::PRIMARY.into_iter().any(|axis| from[axis] != to[axis]);
        for &axis in extruders {
            let pushed = to[axis] - from[axis];
            if has_way && pushed > 0.0 {
                self.has_printed = true;
            } else if !self.has_printed {
                // What a wipe pulls back, too.
                self.pushed[axis] += pushed;
            }
            self.furthest[axis] = if to[axis] > self.furthest[axis] { to[axis] } else { self.furthest[axis] };
        }
    }

    /// As if what `later` misses had been missed behind this.
    fn and_then(mut self, later: &Self) -> Self {
        for (pushed, more) in self.pushed.0.iter_mut().zip(later.pushed.0).filter(|_| !self.has_printed) {
            *pushed += more;
        }
        for (furthest, also) in self.furthest.0.iter_mut().zip(later.furthest.0) {
            *furthest = if also > *furthest { also } else { *furthest };
        }
        Self { believed: later.believed, has_printed: self.has_printed || later.has_printed, ..self }
    }

    /// Where the file believes the machine is.
    pub const fn believed(&self) -> &PerAxis<f64> {
        &self.believed
    }

    /// Where an extruder has to be, for the file to be as far retracted as it believes.
    fn due(&self, axis: Axis, believed: f64) -> f64 {
        let retracted = self.furthest[axis] - believed;
        let by = if self.has_printed { self.pushed[axis] - retracted } else { self.pushed[axis] };
        self.at[axis] + by
    }
}

impl LeftOut {
    /// It begins, or ends.
    pub fn lasts(&mut self, yes: bool) {
        self.lasts = yes;
    }

    /// The block that is read is of the print, or somebody else moves the machine.
    pub fn counts(&mut self, yes: bool) {
        self.is_aside = !yes;
    }

    /// Whether nothing is left out, nor to be made up for.
    pub const fn is_done(&self) -> bool {
        !self.lasts && self.stays.is_none()
    }

    /// Whether the print goes on.
    pub const fn has_ended(&self) -> bool {
        !self.lasts && !self.is_aside
    }

    /// Whether the machine has stayed there.
    pub fn stays_at(&self, position: &PerAxis<f64>) -> bool {
        self.stays.as_ref().is_some_and(|stay| stay.at == *position)
    }

    /// Where the machine has stayed, when it counts no more.
    pub fn take_place(&mut self) -> Option<PerAxis<f64>> {
        self.stays.take().map(|stay| stay.at)
    }

    /// Whether this move, from where the program was, is left out.
    pub fn follow(&mut self, from: PerAxis<f64>, to: &PerAxis<f64>, extruders: &[Axis]) -> bool {
        let is_left_out = self.lasts && !self.is_aside;
        if is_left_out {
            self.stays.get_or_insert_with(|| Stay::new(from)).follow(to, extruders);
        }
        is_left_out
    }

    /// Moves that were planned are not made: the machine stays there, and what was left out behind them
    /// still is.
    pub fn stay(&mut self, earlier: Stay) {
        self.stays = Some(match self.stays.take() {
            Some(stay) => earlier.and_then(&stay),
            None => earlier,
        });
    }

    /// Where the machine has stayed, since something was left out.
    pub const fn stays(&self) -> Option<&Stay> {
        self.stays.as_ref()
    }
}

/// What a way back depends on beside where it leads.
#[derive(Clone, Debug)]
pub(crate) struct Manner<'e> {
    pub extruders: &'e [Axis],
    /// The extruder in use, and the rate of its retraction.
    pub pulls: Option<(Axis, MmPerSecond)>,
    pub travel: MmPerSecond,
}

impl Stay {
    /// The way to where the file goes on, with a move that `is_straight` and leads to `target`. `place`:
    /// where the file believes it is before it; `must_arrive`: more of its line follows.
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
        // A straight way without filament needs none to where it begins.
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

/// The way from where the machine has stayed to where the file goes on.
#[derive(Clone, Debug)]
pub struct WayBack {
    /// Moves from where it is, one behind the other.
    pub moves: Vec<Move, 5>,
    /// Where it then is, as the file counts: only extruders differ from where the moves lead.
    pub place: PerAxis<f64>,
    /// It leads to where the file's next move begins; else that move itself leads from its end to its own.
    pub arrives: bool,
}

impl WayBack {
    /// The same with extruders counted as the file does from its beginning on, which is `at`, and where the
    /// machine then is before it.
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

/// A way in pieces.
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
            // There is room: filament twice, up, over, down.
            let _ = self.moves.push(Move { target: to, shape, rate, power: 0.0, corner: Corner::Sharp });
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

    /// To this place, and down last; extruders stay.
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
        // It comes retracted by 1, and the object ends retracted by 3.
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
        // Stopped in the middle of a wipe: half a millimetre of two has been pulled back.
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
