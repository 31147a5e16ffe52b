//! The path that the machine makes, as far as it is remembered: places with numbers that rise.
//!
//! Places between which the way is straight are left out, so that pages that ask four times a second keep up
//! with files of short moves.

use heapless::Deque;
use http::json::Writer;

/// Places that are remembered.
const PLACES: usize = 256;
/// Most places of an answer. Those that are overwritten while it is sent are not among its places.
const MOST: u32 = 160;
const SPARE: u32 = 32;
/// Places of a part of an answer: 24 times `[-5242.88,-5242.88,-5242.88,1],`.
pub const PART: u32 = 24;
/// Greatest distance of a place that is left out from the path that is told, mm.
const STRAIGHT: f32 = 0.02;
/// Unit in which places are kept, mm, and bits of a coordinate: 5.2 m each way.
const UNIT: f32 = 0.01;
const BITS: u32 = 20;

/// Place on the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// X, Y and Z in machine coordinates, mm.
    pub at: [f32; 3],
    /// Whether material is laid or cut on the way there.
    pub lays: bool,
}

/// A place in as few bits as can be: X, Y, Z and whether it lays.
#[derive(Clone, Copy, Debug)]
struct Packed(u64);

impl Packed {
    fn of(place: &Place) -> Self {
        let half = 1_i64 << (BITS - 1);
        let pack = |bits: u64, mm: &f32| {
            let units = (mm / UNIT + 0.5_f32.copysign(*mm)) as i64;
            bits << BITS | (units.clamp(-half, half - 1) + half) as u64
        };
        Self(place.at.iter().fold(u64::from(place.lays), pack))
    }

    fn place(self) -> Place {
        let half = 1_i64 << (BITS - 1);
        let at = |shift: u32| (((self.0 >> shift) & ((1 << BITS) - 1)) as i64 - half) as f32 * UNIT;
        Place { at: [at(2 * BITS), at(BITS), at(0)], lays: self.0 >> (3 * BITS) & 1 == 1 }
    }
}

/// Piece of the path for an answer: from this number to before that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    pub from: u32,
    pub to: u32,
    /// Whether places before `from` that were asked for are not remembered.
    pub is_lost: bool,
}

/// The path as far as it is remembered.
#[derive(Debug)]
pub struct Path {
    places: Deque<Packed, PLACES>,
    /// Number of the place that comes next.
    next: u32,
    /// Number up to which places have been told: they stay as they are.
    told: u32,
    /// The last two places, unrounded, the last one first.
    last: [Option<Place>; 2],
    /// Bound of how far places left out since the last but one may be from the path, mm.
    slack: f32,
    /// Whether the path is drawn by somebody.
    is_drawn: bool,
    /// Whether the way to the next place is not known.
    has_gap: bool,
}

impl Path {
    /// Makes a path of which nothing is known.
    #[must_use]
    pub const fn new() -> Self {
        Self { places: Deque::new(), next: 0, told: 0, last: [None; 2], slack: 0.0, is_drawn: false, has_gap: true }
    }

    /// Returns the number of the first place that is remembered.
    fn first(&self) -> u32 {
        self.next.wrapping_sub(self.places.len() as u32)
    }

    /// Begins anew, as a job does.
    pub fn begin(&mut self) {
        self.places.clear();
        (self.next, self.told, self.last, self.slack, self.has_gap) = (0, 0, [None; 2], 0.0, true);
    }

    /// Returns whether the path is wanted, or just is not any more; none while nobody has wanted it.
    /// `is_anybody_there`: whether somebody looks at the page.
    pub fn follows(&mut self, is_anybody_there: bool) -> Option<bool> {
        let was_drawn = self.is_drawn;
        self.is_drawn &= is_anybody_there;
        self.has_gap |= was_drawn != self.is_drawn;
        was_drawn.then_some(self.is_drawn)
    }

    /// Returns the piece of the path from this number on. From now on the path is wanted.
    pub fn since(&mut self, number: u32) -> Piece {
        self.is_drawn = true;
        let oldest = self.next.wrapping_sub((self.places.len() as u32).min(PLACES as u32 - SPARE));
        let is_lost = number < oldest || number > self.next;
        let from = if is_lost { oldest } else { number };
        let to = from.wrapping_add(MOST).min(self.next);
        self.told = self.told.max(to);
        Piece { from, to, is_lost }
    }

    /// Adds a place that the machine has come to.
    pub fn add(&mut self, place: Place) {
        let has_gap = core::mem::take(&mut self.has_gap);
        let place = Place { lays: place.lays && !has_gap, ..place };
        let [last, before] = self.last;
        if last.is_some_and(|last| distance(&last.at, &place.at, &place.at) < UNIT) {
            return;
        }
        if let (Some(before), Some(last)) = (before, last)
            && self.next.wrapping_sub(1) >= self.told
            && last.lays == place.lays
        {
            // What was left out before moves away from the path by no more than the place left out now.
            let slack = self.slack + distance(&last.at, &before.at, &place.at);
            if slack <= STRAIGHT {
                let _straight = self.places.pop_back();
                let _room = self.places.push_back(Packed::of(&place));
                (self.last[0], self.slack) = (Some(place), slack);
                return;
            }
        }
        if self.places.is_full() {
            let _oldest = self.places.pop_front();
        }
        let _room = self.places.push_back(Packed::of(&place));
        (self.next, self.last, self.slack) = (self.next.wrapping_add(1), [Some(place), last], 0.0);
    }

    /// Writes the places of a part of a piece, each `[x, y, z, kind]`. False if there are none.
    pub fn write(&self, piece: &Piece, part: u32, json: &mut Writer<'_, '_>) -> bool {
        let begin = piece.from.saturating_add(part.saturating_mul(PART));
        if begin >= piece.to {
            return false;
        }
        for number in begin..piece.to.min(begin.saturating_add(PART)) {
            let at = number.checked_sub(self.first());
            let Some(place) = at.and_then(|at| self.places.iter().nth(at as usize)) else { continue };
            let Place { at, lays } = place.place();
            json.begin_array();
            at.into_iter().for_each(|mm| json.float(f64::from(mm), 2));
            json.number(u64::from(lays));
            json.end_array();
        }
        true
    }
}

/// Writes the beginning of an answer with a piece of the path, up to its places.
pub fn begin(piece: &Piece, json: &mut Writer<'_, '_>) {
    json.begin_object();
    json.key("next");
    json.number(u64::from(piece.to));
    json.key("lost");
    json.bool(piece.is_lost);
    json.key("points");
    json.begin_array();
}

/// Returns the distance of a point from a straight way, mm.
fn distance(point: &[f32; 3], from: &[f32; 3], to: &[f32; 3]) -> f32 {
    let less = |a: &[f32; 3], b: &[f32; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let dot = |a: &[f32; 3], b: &[f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (way, there) = (less(to, from), less(point, from));
    let length_sq = dot(&way, &way);
    let share = if length_sq > 0.0 { (dot(&there, &way) / length_sq).clamp(0.0, 1.0) } else { 0.0 };
    let off = less(&there, &way.map(|mm| mm * share));
    libm::sqrtf(dot(&off, &off))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn add(path: &mut Path, x: f32, y: f32, lays: bool) {
        path.add(Place { at: [x, y, 0.25], lays });
    }

    /// Returns all that is told of a piece.
    fn told(path: &Path, piece: &Piece) -> Vec<Place> {
        let first = path.first();
        (piece.from..piece.to)
            .filter_map(|number| path.places.iter().nth((number - first) as usize).map(|one| one.place()))
            .collect()
    }

    #[test]
    fn places_are_kept_to_a_hundredth() {
        for at in [[0.0, -5242.88, 5242.87], [0.01, -0.01, 123.45]] {
            for lays in [false, true] {
                let place = Packed::of(&Place { at, lays }).place();
                assert!(place.at.iter().zip(at).all(|(one, other)| (one - other).abs() < 0.006), "{place:?}");
                assert_eq!(place.lays, lays);
            }
        }
        assert_eq!(Packed::of(&Place { at: [1e9, -1e9, 0.0], lays: false }).place().at[0], 5242.87);
    }

    #[test]
    fn straight_ways_are_told_as_one_and_corners_stay() {
        let mut path = Path::new();
        path.follows(true);
        add(&mut path, 0.0, 0.0, false);
        for number in 0..=100 {
            add(&mut path, number as f32 * 0.1, 0.0, true);
        }
        for number in 1..=100 {
            add(&mut path, 10.0, number as f32 * 0.1, true);
        }
        add(&mut path, 10.0, 20.0, false);
        let piece = path.since(0);
        let places: Vec<_> = told(&path, &piece).iter().map(|one| (one.at[0], one.at[1], one.lays)).collect();
        assert_eq!(places, [(0.0, 0.0, false), (10.0, 0.0, true), (10.0, 10.0, true), (10.0, 20.0, false)]);
    }

    #[test]
    fn a_circle_of_short_moves_stays_round() {
        let (mut path, radius) = (Path::new(), 20.0_f32);
        for number in 0..=3_600 {
            let angle = (number as f32 * 0.1).to_radians();
            add(&mut path, radius * angle.cos(), radius * angle.sin(), true);
        }
        let piece = path.since(0);
        let places = told(&path, &piece);
        assert!(!piece.is_lost && places.len() < 160, "{} places", places.len());
        for pair in places.windows(2) {
            let middle = [(pair[0].at[0] + pair[1].at[0]) / 2.0, (pair[0].at[1] + pair[1].at[1]) / 2.0];
            let off = radius - middle[0].hypot(middle[1]);
            assert!(off < STRAIGHT + 0.01, "{off} mm off the circle");
        }
    }

    #[test]
    fn what_was_told_stays_and_what_is_lost_is_said() {
        let mut path = Path::new();
        let zigzag = |path: &mut Path, from: u32, to: u32| {
            (from..to).for_each(|number| add(path, number as f32, (number % 2) as f32, true));
        };
        zigzag(&mut path, 0, 10);
        let piece = path.since(0);
        assert_eq!(piece, Piece { from: 0, to: 10, is_lost: false });
        let before = told(&path, &piece);
        // Straight on from what was told: a place of its own.
        add(&mut path, 10.0, 5.0, true);
        assert_eq!((path.since(10), told(&path, &piece)), (Piece { from: 10, to: 11, is_lost: false }, before));
        zigzag(&mut path, 11, 1_000);
        let piece = path.since(11);
        assert_eq!(piece, Piece { from: 1_000 - 224, to: 1_000 - 224 + MOST, is_lost: true });
        path.begin();
        assert_eq!(path.since(piece.to), Piece { from: 0, to: 0, is_lost: true }, "a new job begins at 0");
    }

    #[test]
    fn the_path_is_wanted_while_somebody_is_there_who_asked_for_it() {
        let mut path = Path::new();
        assert_eq!(path.follows(true), None);
        path.since(0);
        assert_eq!((path.follows(true), path.follows(true)), (Some(true), Some(true)));
        add(&mut path, 0.0, 0.0, true);
        assert_eq!((path.follows(false), path.follows(false)), (Some(false), None));
        path.since(0);
        path.follows(true);
        add(&mut path, 9.0, 9.0, true);
        let piece = path.since(0);
        assert!(told(&path, &piece).iter().all(|place| !place.lays), "nobody saw the way there");
    }
}
