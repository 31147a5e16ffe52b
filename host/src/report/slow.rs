//! The slow parts of a run: places of short moves far below their feed, and stops that nothing asked for.

use serde::Serialize;

use super::follow::Followed;
use super::program::Program;
use super::spent::{Placed, events_at};
use super::times::Odometer;

/// Row of moves that went far slower than their feed.
#[derive(Clone, Debug, Serialize)]
pub struct SlowPlace {
    /// First line of the row, from 1.
    pub line: u32,
    /// Last line of the row, from 1.
    pub last: u32,
    /// Text of the first line.
    pub text: String,
    /// Number of moves in the row.
    pub moves: usize,
    /// Beginning of the row, seconds.
    pub from: f64,
    /// End of the row, seconds.
    pub to: f64,
    /// Length of the moves, mm.
    pub length: f64,
    /// Time beyond the least that the feeds and the machine's limits ask, seconds.
    pub lost: f64,
    /// Mean speed, mm/s.
    pub speed: f64,
    /// Mean speed asked, mm/s.
    pub asked: f64,
    /// Layer of the first move.
    pub layer: u32,
    /// The slicer's feature of the first move.
    pub feature: String,
    /// Place of the row, mm.
    pub at: [f64; 3],
}

/// Stop in a row of moves for which nothing in the program asks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Starved {
    /// Time of the stop, seconds.
    pub at: f64,
    /// Length of the stand, seconds; 0 if the machine braked to rest and went on at once.
    pub stood: f64,
    /// Line of the move that came too late, if known.
    pub line: Option<u32>,
}

/// Share of the asked speed below which a move is slow.
const SLOW_SHARE: f64 = 0.5;
/// Greatest number of places reported.
const MOST_PLACES: usize = 12;
/// Speed at a corner below which the machine rests, mm/s, if it was this many times faster this long before
/// and after.
const REST_MM_PER_S: f64 = 2.0;
const TIMES_FASTER: f64 = 5.0;
const BESIDE_S: f64 = 0.03;
/// Cosine of the turn, over the length below, up to which a path asks for no rest.
const STRAIGHT_COS: f64 = 0.94;
const STRAIGHT_MM: f64 = 0.3;

/// Move of the program as it was made.
struct Made {
    corner: usize,
    from_s: f64,
    to_s: f64,
    length: f64,
    /// Speed that the feed and the machine's limits allow.
    asked: f64,
}

impl Made {
    fn lost(&self) -> f64 {
        self.to_s - self.from_s - self.length / self.asked
    }
}

/// Returns the slowest places of the work, ordered by lost time, greatest first. `limits` are the machine's
/// greatest speeds along X, Y, Z.
pub fn places(program: &Program, followed: &Followed, stands: &[Placed], limits: [f64; 3]) -> Vec<SlowPlace> {
    let mut rows: Vec<Vec<Made>> = Vec::new();
    let mut stands = stands.iter().peekable();
    let mut goes_on = false;
    // In a job that feeds filament, moves without filament only join the work: their ramps are told as a
    // sum.
    let feeds = program.corners.iter().any(|corner| corner.extrudes);
    for corner in 1..program.corners.len() {
        let (from, to) = (&program.corners[corner - 1], &program.corners[corner]);
        let (from_s, mut to_s) = (followed.passed_s[corner - 1], followed.passed_s[corner]);
        let is_aside = followed.aside.iter().any(|aside| aside.from_s < to_s && from_s < aside.to_s);
        let is_seen = from_s.is_finite() && to_s > from_s;
        if to.is_homed || !is_seen || is_aside {
            goes_on = false;
            continue;
        }
        while stands.next_if(|placed| placed.stand.to_s <= from_s).is_some() {}
        // The machine stood at the move's end, or on its way: that time is no slow motion.
        let stood = stands.peek().map(|placed| placed.stand).filter(|stand| stand.from_s < to_s);
        to_s -= stood.map_or(0.0, |stand| stand.to_s - stand.from_s);
        let way: [f64; 3] = std::array::from_fn(|axis| to.at[axis] - from.at[axis]);
        let length = way.iter().map(|mm| mm * mm).sum::<f64>().sqrt();
        let most = way.iter().zip(limits).map(|(mm, limit)| limit * length / mm.abs()).fold(to.asked, f64::min);
        let made = Made { corner, from_s, to_s, length, asked: most };
        let is_work = to.extrudes || !feeds;
        let is_slow = is_work && most > 0.0 && length < SLOW_SHARE * most * (to_s - from_s);
        match rows.last_mut() {
            Some(row) if is_slow && goes_on => row.push(made),
            _ if is_slow => rows.push(vec![made]),
            _ => {}
        }
        goes_on = is_slow && stood.is_none() && events_at(program, corner).next().is_none();
    }
    let mut places: Vec<_> = rows.iter().map(|row| place(program, row)).collect();
    places.sort_by(|a, b| b.lost.total_cmp(&a.lost));
    places.truncate(MOST_PLACES);
    for place in &mut places {
        place.text = program.line(place.line);
    }
    places
}

fn place(program: &Program, row: &[Made]) -> SlowPlace {
    let (first, last) = (&row[0], &row[row.len() - 1]);
    let corner = &program.corners[first.corner];
    let sum = |of: fn(&Made) -> f64| row.iter().map(of).sum::<f64>();
    let (length, seconds) = (sum(|made| made.length), sum(|made| made.to_s - made.from_s));
    let feature = (corner.label.feature as usize).checked_sub(1).and_then(|place| program.features.get(place));
    SlowPlace {
        line: corner.line,
        last: program.corners[last.corner].line,
        text: String::new(),
        moves: row.len(),
        from: first.from_s,
        to: last.to_s,
        length,
        lost: sum(Made::lost),
        speed: length / seconds,
        asked: length / sum(|made| made.length / made.asked),
        layer: corner.label.layer,
        feature: feature.cloned().unwrap_or_default(),
        at: corner.at,
    }
}

/// Returns every stop that nothing asks for, in order.
pub fn starved(program: &Program, followed: &Followed, stands: &[Placed], odometer: &Odometer<'_>) -> Vec<Starved> {
    let stood = stands.iter().filter(|placed| placed.is_unasked).map(|placed| {
        let after = placed.corner.and_then(|corner| program.corners.get(corner + 1));
        let stand = placed.stand;
        Starved { at: stand.from_s, stood: stand.to_s - stand.from_s, line: after.map(|corner| corner.line) }
    });
    let mut found: Vec<Starved> = stood.collect();
    let is_stand = |at_s: f64| {
        let next = stands.partition_point(|placed| placed.stand.to_s + BESIDE_S < at_s);
        stands.get(next).is_some_and(|placed| placed.stand.from_s - BESIDE_S < at_s)
    };
    for corner in 1..program.corners.len().saturating_sub(1) {
        let at_s = followed.passed_s[corner];
        if rests(program, odometer, corner, at_s) && !is_stand(at_s) {
            found.push(Starved { at: at_s, stood: 0.0, line: Some(program.corners[corner + 1].line) });
        }
    }
    found.sort_by(|a, b| a.at.total_cmp(&b.at));
    found
}

/// Returns whether the machine brakes to rest at a corner through which the path goes straight on.
fn rests(program: &Program, odometer: &Odometer<'_>, corner: usize, at_s: f64) -> bool {
    const HALF_S: f64 = 0.002;
    let [at, after] = [corner, corner + 1].map(|corner| &program.corners[corner]);
    let speed = |at_s: f64| odometer.length(at_s - HALF_S, at_s + HALF_S) / (2.0 * HALF_S);
    let is_one_row = !at.is_homed && !after.is_homed && at.extrudes == after.extrudes;
    if !at_s.is_finite() || !is_one_row || events_at(program, corner).next().is_some() {
        return false;
    }
    let slow = speed(at_s);
    if slow > REST_MM_PER_S || at.asked.min(after.asked) < TIMES_FASTER * REST_MM_PER_S {
        return false;
    }
    let fast = TIMES_FASTER * slow.max(0.5 * REST_MM_PER_S);
    speed(at_s - BESIDE_S) > fast && speed(at_s + BESIDE_S) > fast && goes_straight(program, corner)
}

fn goes_straight(program: &Program, corner: usize) -> bool {
    let here = program.corners[corner].at;
    let apart = |other: &[f64; 3]| (0..3).map(|axis| (other[axis] - here[axis]).powi(2)).sum::<f64>().sqrt();
    let far = |at: &&[f64; 3]| apart(at) >= STRAIGHT_MM;
    let before = program.corners[..corner].iter().rev().map(|corner| &corner.at).find(far);
    let after = program.corners[corner + 1..].iter().map(|corner| &corner.at).find(far);
    let (Some(before), Some(after)) = (before, after) else { return false };
    let inner: f64 = (0..3).map(|axis| (here[axis] - before[axis]) * (after[axis] - here[axis])).sum();
    inner > STRAIGHT_COS * apart(before) * apart(after)
}
