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
struct Stay {
    at: PerAxis<f64>,
    /// Where the file believes it is.
    believed: PerAxis<f64>,
    /// A line of filament has been left out.
    has_printed: bool,
    /// Pushed before that, by extruder, mm.
    pushed: PerAxis<f64>,
    /// The furthest that extruders have been.
    furthest: PerAxis<f64>,
}

impl Stay {
    fn new(at: PerAxis<f64>) -> Self {
        Self { at, believed: at, has_printed: false, pushed: PerAxis([0.0; units::MAX_AXES]), furthest: at }
    }

    /// A move that is left out.
    fn follow(&mut self, to: &PerAxis<f64>, extruders: &[Axis]) {
        let from = core::mem::replace(&mut self.believed, *to);
        let has_way = Axis::PRIMARY.into_iter().any(|axis| from[axis] != to[axis]);
        for &axis in extruders {
            let pushed = to[axis] - from[axis];
            if has_way && pushed > 0.0 {
                self.has_printed = true;
            } else if !has_way && !self.has_printed {
                self.pushed[axis] += pushed;
            }
            self.furthest[axis] = if to[axis] > self.furthest[axis] { to[axis] } else { self.furthest[axis] };
        }
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

    /// The way to where the file goes on with this move. `place`: where the file believes it is before it;
    /// `pulls`: the extruder in use, and the rate of its retraction; `must_arrive`: more of its line
    /// follows.
    pub fn way_back(
        &self,
        place: &PerAxis<f64>,
        request: &Move,
        must_arrive: bool,
        extruders: &[Axis],
        pulls: Option<(Axis, MmPerSecond)>,
        travel: MmPerSecond,
    ) -> Option<WayBack> {
        let stay = self.stays.as_ref()?;
        let mut way = Way { at: stay.at, moves: Vec::new(), travel };
        let due = pulls.map(|(axis, rate)| (axis, stay.due(axis, place[axis]), rate));
        if let Some((axis, due, rate)) = due.filter(|(axis, due, _)| due < &way.at[*axis]) {
            way.feed(axis, due, rate);
        }
        way.rise(place[Axis::Z]);
        let pushes = due.filter(|(axis, due, _)| due > &way.at[*axis]);
        // A straight way without filament needs none to where it begins.
        let is_travel = matches!(request.shape, Shape::Line { .. })
            && extruders.iter().all(|&axis| request.target[axis] == place[axis]);
        if pushes.is_some() || !is_travel || must_arrive {
            way.over(place, extruders);
            if let Some((axis, due, rate)) = pushes {
                way.feed(axis, due, rate);
            }
        }
        let mut here = way.at;
        for &axis in extruders {
            here[axis] = place[axis];
        }
        Some(WayBack { moves: way.moves, place: here })
    }
}

/// The way from where the machine has stayed to where the file goes on.
#[derive(Clone, Debug)]
pub struct WayBack {
    /// Moves from where it is, one behind the other.
    pub moves: Vec<Move, 5>,
    /// Where it then is, as the file counts: only extruders differ from where the moves lead.
    pub place: PerAxis<f64>,
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
