//! Recent trajectory: a ring of stretches of constant jerk, for filters to look back on.
//!
//! Times are the low 64 bits of [`TickTime`], compared by wrapping differences: good for ten seconds either
//! way, and no stretch that a cursor still needs is older than a second or two.

use units::{MAX_AXES, PerAxis};

use crate::{
    convert::float_of_i64,
    path::{Curve, Path},
    ramp::Ramp,
    trajectory::{Piece, TickTime},
};

/// Greatest number of extruders: the auxiliary axes.
pub const MAX_EXTRUDERS: usize = 3;

/// Stretches kept, a power of two.
pub(super) const CAPACITY: usize = 128;
/// A stretch is cut after this long (0.25 s): polynomials of long times lose digits.
const LONGEST: u64 = 50_000_000 << 32;
/// Seconds in a unit of time.
const SECONDS_PER_UNIT: f64 = 1.0 / (units::STEP_CLOCK_HZ as f64 * 4_294_967_296.0);

/// A length of time that may be negative, in seconds.
pub(super) fn seconds(units: u64) -> f64 {
    float_of_i64(units as i64) * SECONDS_PER_UNIT
}

/// Whether time `a` is before time `b`; both within ten seconds.
pub(crate) fn is_before(a: u64, b: u64) -> bool {
    b.wrapping_sub(a) as i64 > 0
}

/// The earlier of two times.
pub(super) fn earlier(a: u64, b: u64) -> u64 {
    if is_before(b, a) { b } else { a }
}

/// The later of two times.
pub(super) fn later(a: u64, b: u64) -> u64 {
    if is_before(a, b) { b } else { a }
}

/// The low bits of a point in time.
fn low(time: TickTime) -> u64 {
    time.to_bits() as u64
}

/// A place in the history, so far behind the output.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cursor {
    /// Delay in units of [`TickTime`].
    pub delay: u64,
    /// Count of the stretch in the history.
    pub count: u32,
}

/// Curves kept; a stretch for which there is no room is straight ([`super::Filters::has_room_for`]).
const CURVES: usize = 16;

/// Origin of a stretch in the program: all it takes to begin again within it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source {
    /// Count of its block.
    pub block: u32,
    /// Start of the block, in machine space.
    pub origin: PerAxis<f64>,
    /// Path distance from the block's start to the beginning of the stretch, mm.
    pub base: f64,
    /// Ramp that the stretch is part of, and the seconds of that ramp that were over at its beginning.
    pub ramp: Option<(Ramp, f64)>,
}

/// Constant jerk along a path, until the next stretch begins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// Time of the beginning, low half.
    pub start: u64,
    /// Beginning of the stretch, without its curve.
    pub origin: PerAxis<f64>,
    /// Movement of each axis for a millimetre of path, without the curve.
    pub direction: PerAxis<f64>,
    /// Path speed at the beginning, mm/s.
    pub speed: f64,
    /// Path acceleration at the beginning, mm/s^2.
    pub acceleration: f64,
    /// Path jerk, mm/s^3.
    pub jerk: f64,
    /// Path distance along its curve at which the stretch begins, mm; `None` when it is straight.
    curved: Option<f64>,
    /// Count of the curves there were when it came, its own included, which is the last.
    curves: u32,
    /// First and second antiderivative of each extruder's advanced position less the reference, at the
    /// beginning.
    sums: [[f64; 2]; MAX_EXTRUDERS],
    /// Whether the stretch is part of one piece of the program: neither a rest, nor a chord in place of
    /// several pieces.
    has_source: bool,
    /// Origin in that piece. No `Option`, for an empty stretch must be all zero: then the history lies in
    /// memory that start-up clears, and not in flash.
    source: Source,
}

impl Stretch {
    const EMPTY: Self = Self {
        start: 0,
        origin: PerAxis([0.0; MAX_AXES]),
        direction: PerAxis([0.0; MAX_AXES]),
        speed: 0.0,
        acceleration: 0.0,
        jerk: 0.0,
        curved: None,
        curves: 0,
        sums: [[0.0; 2]; MAX_EXTRUDERS],
        has_source: false,
        source: Source { block: 0, origin: PerAxis([0.0; MAX_AXES]), base: 0.0, ramp: None },
    };

    /// Returns the stretch of a piece, and its curve.
    pub fn of(piece: &Piece) -> (Self, Curve) {
        let (path, is_line) = (&piece.path, piece.path.curve.is_line());
        let stretch = Self {
            start: low(piece.start),
            origin: Path::line(path.origin, path.direction).point(piece.base),
            direction: path.direction,
            speed: piece.speed,
            acceleration: piece.acceleration,
            jerk: piece.jerk,
            curved: if is_line { None } else { Some(piece.base) },
            ..Self::EMPTY
        };
        (stretch, path.curve)
    }

    /// Returns the straight stretch on which a piece begins.
    pub fn straight(piece: &Piece) -> (Self, Curve) {
        let line = Path::line(piece.point_after(0.0), piece.tangent_after(0.0));
        Self::of(&Piece { path: line, base: 0.0, ..*piece })
    }

    /// A stretch of standstill at `place`.
    pub fn rest(start: TickTime, place: PerAxis<f64>) -> (Self, Curve) {
        (Self { start: low(start), origin: place, ..Self::EMPTY }, Curve::Line)
    }

    /// Sets the stretch's origin in the program.
    pub fn from(self, source: Option<Source>) -> Self {
        Self { has_source: source.is_some(), source: source.unwrap_or(Self::EMPTY.source), ..self }
    }

    /// Returns the stretch's origin in the program, if it has one.
    pub fn source(&self) -> Option<Source> {
        self.has_source.then_some(self.source)
    }

    /// Whether nothing moves.
    pub fn is_rest(&self) -> bool {
        self.speed == 0.0 && self.acceleration == 0.0 && self.jerk == 0.0
    }

    /// Whether the stretch began so long before `time` that it should be cut.
    pub fn is_older_than(&self, time: TickTime) -> bool {
        low(time).wrapping_sub(self.start) > LONGEST
    }

    /// Path distance and speed at `time`.
    pub fn along(&self, time: u64) -> (f64, f64) {
        let t = seconds(time.wrapping_sub(self.start));
        let way = (self.speed + (0.5 * self.acceleration + self.jerk / 6.0 * t) * t) * t;
        (way, self.speed + (self.acceleration + 0.5 * self.jerk * t) * t)
    }

    /// Path acceleration at `time`.
    pub fn acceleration_at(&self, time: u64) -> f64 {
        self.acceleration + self.jerk * seconds(time.wrapping_sub(self.start))
    }

    /// Origin and direction of an axis.
    pub(super) fn axis(&self, axis: usize) -> (f64, f64) {
        (self.origin.0.get(axis).copied().unwrap_or_default(), self.direction.0.get(axis).copied().unwrap_or_default())
    }

    /// The factor of pressure advance that holds here: none unless filament is pushed while X or Y move.
    pub(super) fn factor(&self, axis: usize, factor: f64) -> f64 {
        let [x, y, ..] = self.direction.0;
        let moves = self.curved.is_some() || x != 0.0 || y != 0.0;
        if self.axis(axis).1 > 0.0 && moves { factor } else { 0.0 }
    }

    /// First and second antiderivative of an extruder's advanced position less `reference`, at `time`.
    pub(super) fn sums(&self, axis: usize, factor: f64, time: u64, reference: f64) -> [f64; 2] {
        let t = seconds(time.wrapping_sub(self.start));
        let (origin, direction) = self.axis(axis);
        let factor = self.factor(axis, factor);
        // The advanced position is c0 + c1 t + c2 t^2 + c3 t^3.
        let c0 = origin - reference + factor * (direction * self.speed);
        let c1 = direction * self.speed + factor * (direction * self.acceleration);
        let c2 = 0.5 * direction * (self.acceleration + factor * self.jerk);
        let c3 = direction * self.jerk / 6.0;
        let [once, twice] = self.sums.get(axis - 3).copied().unwrap_or_default();
        [
            once + t * (c0 + t * (c1 / 2.0 + t * (c2 / 3.0 + t * (c3 / 4.0)))),
            twice + t * (once + t * (c0 / 2.0 + t * (c1 / 6.0 + t * (c2 / 12.0 + t * (c3 / 20.0))))),
        ]
    }
}

/// The ring. Stretches are counted from the beginning of time (wrapping).
#[derive(Debug)]
pub(crate) struct History {
    stretches: [Stretch; CAPACITY],
    /// Count of the oldest stretch since everything before was forgotten.
    first: u32,
    /// Count of the newest stretch.
    newest: u32,
    /// The curves of stretches that have one.
    curves: [Curve; CURVES],
    /// Factors of pressure advance; zero where there is none.
    factors: [f64; MAX_EXTRUDERS],
    /// Positions that the sums are relative to, and since when.
    references: [f64; MAX_EXTRUDERS],
    since: u64,
}

impl History {
    /// Creates a history of rest.
    pub const fn new() -> Self {
        Self {
            stretches: [Stretch::EMPTY; CAPACITY],
            first: 0,
            newest: 0,
            curves: [Curve::Line; CURVES],
            factors: [0.0; MAX_EXTRUDERS],
            references: [0.0; MAX_EXTRUDERS],
            since: 0,
        }
    }

    /// Sets the factors of pressure advance.
    pub fn configure(&mut self, factors: [f64; MAX_EXTRUDERS]) {
        self.factors = factors;
    }

    /// Returns the stretch of this count.
    pub fn stretch(&self, count: u32) -> &Stretch {
        // The remainder is always in range: the check disappears.
        &self.stretches[count as usize % CAPACITY]
    }

    fn stretch_mut(&mut self, count: u32) -> &mut Stretch {
        &mut self.stretches[count as usize % CAPACITY]
    }

    /// Returns the newest stretch.
    pub fn newest(&self) -> &Stretch {
        self.stretch(self.newest)
    }

    /// Replaces the newest stretch by a straight one with the same beginning.
    pub fn amend(&mut self, stretch: Stretch) {
        let newest = self.stretch_mut(self.newest);
        *newest = Stretch { sums: newest.sums, curves: newest.curves, ..stretch };
    }

    /// Returns the curve's addition to X, Y and Z `way` mm after the beginning of a stretch, and to the
    /// direction there.
    pub fn bent(&self, stretch: &Stretch, way: f64) -> Option<([f64; 3], [f64; 3])> {
        let s = stretch.curved? + way;
        // The remainder is always in range: the check disappears.
        let curve = &self.curves[stretch.curves as usize % CURVES];
        Some((curve.offset(s), curve.slope(s)))
    }

    /// Whether a stretch with this curve can be kept. `oldest` is the count of the oldest that anything still
    /// looks at.
    pub fn has_room_for(&self, curve: &Curve, oldest: u32) -> bool {
        let newest = self.newest().curves;
        let used = newest.wrapping_sub(self.stretch(oldest).curves) as usize;
        curve.is_line() || self.is_newest(curve) || used + 1 < CURVES
    }

    fn is_newest(&self, curve: &Curve) -> bool {
        self.curves[self.newest().curves as usize % CURVES] == *curve
    }

    /// Returns the number of newer stretches.
    pub fn age(&self, count: u32) -> u32 {
        self.newest.wrapping_sub(count)
    }

    /// Position that the sums of this axis are relative to.
    pub fn reference(&self, axis: usize) -> f64 {
        self.references.get(axis - 3).copied().unwrap_or_default()
    }

    /// Forgets everything but this. Gives its count.
    pub fn restart(&mut self, stretch: Stretch) -> u32 {
        let [_, _, _, references @ ..] = stretch.origin.0;
        self.references = references;
        self.since = stretch.start;
        *self.stretch_mut(self.newest) = stretch;
        self.first = self.newest;
        self.newest
    }

    /// Count of the newest stretch, and how many there are.
    pub fn extent(&self) -> (u32, u32) {
        let all = self.age(self.first);
        (self.newest, 1 + if all < CAPACITY as u32 { all } else { CAPACITY as u32 - 1 })
    }

    /// The curve of a stretch.
    pub fn curve_of(&self, stretch: &Stretch) -> Curve {
        match stretch.curved {
            // The remainder is always in range: the check disappears.
            Some(_) => self.curves[stretch.curves as usize % CURVES],
            None => Curve::Line,
        }
    }

    /// Forgets what is newer than this stretch.
    pub fn truncate(&mut self, newest: u32) {
        self.newest = newest;
    }

    /// Appends a stretch. `oldest` is the count of the oldest that anything still looks at.
    pub fn push(&mut self, stretch: Stretch, curve: &Curve, oldest: Option<u32>) {
        let mut stretch = stretch;
        stretch.curves = self.newest().curves;
        if stretch.curved.is_some() && !self.is_newest(curve) {
            stretch.curves = stretch.curves.wrapping_add(1);
            self.curves[stretch.curves as usize % CURVES] = *curve;
        }
        for (index, factor) in self.factors.into_iter().enumerate() {
            if factor > 0.0 {
                let axis = 3 + index;
                let sums = self.newest().sums(axis, factor, stretch.start, self.reference(axis));
                if let Some(slot) = stretch.sums.get_mut(index) {
                    *slot = sums;
                }
            }
        }
        self.newest = self.newest.wrapping_add(1);
        *self.stretch_mut(self.newest) = stretch;
        if stretch.start.wrapping_sub(self.since) > LONGEST {
            self.rebase(oldest.unwrap_or(self.newest));
        }
    }

    /// Makes the sums relative to the oldest stretch in use, so that they stay small and exact. Sums may
    /// differ by what is linear in time (and by the reference's own share): a second difference does not see
    /// it.
    fn rebase(&mut self, oldest: u32) {
        let oldest =
            if self.age(oldest) as usize >= CAPACITY { self.newest.wrapping_sub(CAPACITY as u32 - 1) } else { oldest };
        let base = *self.stretch(oldest);
        self.since = base.start;
        for (index, factor) in self.factors.into_iter().enumerate() {
            let (Some(reference), Some([once, twice])) = (self.references.get_mut(index), base.sums.get(index)) else {
                continue;
            };
            if factor <= 0.0 {
                continue;
            }
            let moved = base.axis(3 + index).0 - *reference;
            *reference += moved;
            let mut count = oldest;
            loop {
                let stretch = self.stretch_mut(count);
                let t = seconds(stretch.start.wrapping_sub(base.start));
                if let Some(sums) = stretch.sums.get_mut(index) {
                    let [own_once, own_twice] = *sums;
                    *sums = [own_once - (once + moved * t), own_twice - (twice + t * (once + 0.5 * moved * t))];
                }
                if count == self.newest {
                    break;
                }
                count = count.wrapping_add(1);
            }
        }
    }

    /// Begin of the stretch after this one.
    pub fn next_start(&self, count: u32) -> Option<u64> {
        if count == self.newest { None } else { Some(self.stretch(count.wrapping_add(1)).start) }
    }

    /// Moves a cursor on to the stretch that `time` is in; at a boundary to the later one if `onto`. True if
    /// it moved.
    pub fn pass(&self, count: &mut u32, time: u64, onto: bool) -> bool {
        let before = *count;
        // Should the ring have run over, the oldest there is.
        if self.age(*count) as usize >= CAPACITY {
            *count = self.newest.wrapping_sub(CAPACITY as u32 - 1);
        }
        while let Some(next) = self.next_start(*count) {
            let past = time.wrapping_sub(next) as i64;
            if past < 0 || (past == 0 && !onto) {
                break;
            }
            *count = count.wrapping_add(1);
        }
        *count != before
    }

    /// Shifts everything in time.
    pub fn shift(&mut self, by: u64) {
        self.since = self.since.wrapping_add(by);
        for stretch in &mut self.stretches {
            stretch.start = stretch.start.wrapping_add(by);
        }
    }
}
