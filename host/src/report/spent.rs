//! The use of every moment of a run, and the line of the program it belongs to.
//!
//! Standing and moving are told by the step edges alone. The purpose of a stand, and the line of a motion,
//! are found by laying the executed path along the program ([`super::follow`]).

use serde::Serialize;
use units::Actuator;

use super::edges::{Executed, Stand};
use super::follow::Followed;
use super::marks::Label;
use super::path::{Kind as Moves, Samples};
use super::program::{Event, EventKind, Program};

/// Kind of use of a run's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Moves that feed filament, or cut.
    Print,
    /// Moves that neither feed filament nor cut.
    Travel,
    /// Filament moves and the tool stands.
    Filament,
    /// Homing, probing, parking: motion that is no move of the program.
    Own,
    /// Waits for a temperature.
    Heating,
    /// Waits for a time, G4.
    Dwell,
    /// Waits for a person.
    Pause,
    /// Stands for another reason, or none.
    Standing,
}

impl Kind {
    /// All kinds, in the order in which they are shown.
    pub const ALL: [Self; 8] =
        [Self::Print, Self::Travel, Self::Filament, Self::Own, Self::Heating, Self::Dwell, Self::Pause, Self::Standing];

    /// Returns the kind's name in words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Print => "print moves",
            Self::Travel => "travel",
            Self::Filament => "filament only",
            Self::Own => "homing, probing, parking",
            Self::Heating => "heating",
            Self::Dwell => "dwell",
            Self::Pause => "pause",
            Self::Standing => "standing still",
        }
    }
}

/// Stretch of time with one use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Beginning of the span, seconds.
    pub from_s: f64,
    /// End of the span, seconds.
    pub to_s: f64,
    /// Kind of use of the time.
    pub kind: Kind,
    /// Line of the program, if known.
    pub line: Option<u32>,
    /// Layer, feature and object of that line.
    pub label: Label,
}

/// Stand of the machine, and its place on the program's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Times of the stand.
    pub stand: Stand,
    /// Corner at which the machine stood.
    pub corner: Option<usize>,
    /// The machine stood between two moves, or on one, and the program has nothing to wait for there.
    pub is_unasked: bool,
}

/// Use of a part of a stand, its line, and the layer, feature and object of that line.
type Owned = (Kind, (Option<u32>, Label));

/// Run whose time is accounted for.
pub struct Course<'a> {
    /// Length of the run, seconds.
    pub end_s: f64,
    /// Step edges of the run.
    pub executed: &'a Executed,
    /// Executed path of the run.
    pub samples: &'a Samples,
    /// Program of the run, and the times at which its corners were passed.
    pub program: Option<(&'a Program, Followed)>,
    /// Motors that move filament.
    pub filament: Vec<Actuator>,
}

/// Distance within which a stand is at a corner, mm.
const AT_CORNER_MM: f64 = 0.06;
/// Number of corners considered around the last one passed.
const AROUND: usize = 6;
/// Time before the next move, seconds, at which the machine surely is in the stand that ends homing.
const AFTER_HOMING_S: f64 = 0.1;
/// Least stand that is longer than those of homing between its moves, seconds.
const HOMING_STANDS_S: f64 = 1.0;
/// Longest time between edges of moving filament.
const FILAMENT_GAP_NS: u64 = 20_000_000;
/// Longest time for braking before filament moves and for setting off behind it, seconds.
const AROUND_FILAMENT_S: f64 = 0.04;

impl Course<'_> {
    /// Returns the times in which the machine stood, with their places on the path; corners at which it
    /// stood are passed at the stand's end.
    pub fn place_stands(&mut self) -> Vec<Placed> {
        let stands = self.executed.stands(self.end_s);
        let Some((program, followed)) = &mut self.program else {
            return stands.into_iter().map(|stand| Placed { stand, corner: None, is_unasked: false }).collect();
        };
        let count = stands.len();
        let mut placed = Vec::new();
        let known: Vec<usize> =
            (0..program.corners.len()).filter(|corner| followed.passed_s[*corner].is_finite()).collect();
        for (index, stand) in stands.into_iter().enumerate() {
            let middle = 0.5 * (stand.from_s + stand.to_s);
            let passed = known.partition_point(|corner| followed.passed_s[*corner] <= middle);
            let reader = passed.checked_sub(1).map_or(0, |last| known[last]);
            let corner = match index {
                0 => Some(0),
                _ => corner_of(program, followed, self.samples, reader, stand),
            };
            if let Some(corner) = corner.filter(|corner| !followed.passed_s[*corner].is_nan()) {
                let (before, after) = followed.passed_s.split_at_mut(corner);
                let early = before.iter_mut().rev().take_while(|time| **time > stand.from_s);
                early.for_each(|time| *time = stand.from_s);
                after.iter_mut().take_while(|time| **time < stand.to_s).for_each(|time| *time = stand.to_s);
            }
            let is_aside = followed.aside.iter().any(|aside| aside.from_s < middle && middle < aside.to_s);
            let asks = corner.is_some_and(|corner| events_at(program, corner).next().is_some());
            let at_edge = index == 0 || index + 1 == count || corner.is_some_and(|corner| is_end(program, corner));
            placed.push(Placed { stand, corner, is_unasked: !is_aside && !asks && !at_edge });
        }
        placed
    }

    /// Returns all spans, from the first moment to the last, without gaps.
    pub fn spans(&self, stands: &[Placed]) -> Vec<Span> {
        let mut spans = Vec::new();
        let owners = self.owners();
        let mut next = 0;
        for (index, placed) in stands.iter().enumerate() {
            self.stand(placed, index + 1 == stands.len(), &mut spans);
            let to_s = stands.get(index + 1).map_or(self.end_s, |next| next.stand.from_s);
            self.motion(&owners, &mut next, placed.stand.to_s, to_s, &mut spans);
        }
        spans.retain(|span: &Span| span.to_s > span.from_s);
        spans
    }

    /// Returns the piece of the program on which the machine is from each time on, in order; `Err` is no
    /// piece, and whether the machine is lost.
    fn owners(&self) -> Vec<(f64, Result<usize, bool>)> {
        let Some((program, followed)) = &self.program else { return vec![(0.0, Err(true))] };
        let count = program.corners.len();
        let begins = (1..count).filter(|piece| !program.corners[*piece].is_homed);
        let pieces = begins.map(|piece| (followed.passed_s[piece - 1], Ok(piece)));
        let mut owners: Vec<_> = pieces.filter(|(time, _)| time.is_finite()).collect();
        for aside in &followed.aside {
            owners.retain(|(time, _)| *time < aside.from_s || *time >= aside.to_s);
            owners.push((aside.from_s, Err(aside.is_lost)));
            let is_piece = program.corners.get(aside.then).is_some_and(|corner| !corner.is_homed);
            owners.push((aside.to_s, if is_piece { Ok(aside.then) } else { Err(false) }));
        }
        owners.sort_by(|a, b| a.0.total_cmp(&b.0));
        owners
    }

    /// Adds the spans of a stretch without stands.
    fn motion(
        &self,
        owners: &[(f64, Result<usize, bool>)],
        next: &mut usize,
        from_s: f64,
        to_s: f64,
        spans: &mut Vec<Span>,
    ) {
        let mut at_s = from_s;
        while at_s < to_s {
            while owners.get(*next).is_some_and(|(time, _)| *time <= at_s) {
                *next += 1;
            }
            let until_s = owners.get(*next).map_or(to_s, |(time, _)| time.min(to_s));
            let owner = next.checked_sub(1).map_or(Err(false), |last| owners[last].1);
            match (owner, &self.program) {
                (Ok(piece), Some((program, _))) => {
                    let corner = program.corners[piece];
                    // On a machine that feeds no filament every move is work.
                    let works = corner.extrudes || self.filament.is_empty();
                    let kind = if works { Kind::Print } else { Kind::Travel };
                    let (line, label) = (Some(corner.line), corner.label);
                    spans.push(Span { from_s: at_s, to_s: until_s, kind, line, label });
                }
                (Err(true), _) | (Ok(_), None) => self.untold(at_s, until_s, spans),
                (Err(false), _) => {
                    let label = Label::default();
                    spans.push(Span { from_s: at_s, to_s: until_s, kind: Kind::Own, line: None, label });
                }
            }
            at_s = until_s;
        }
    }

    /// Adds motion of no known line: moving filament or its absence tells the kind.
    fn untold(&self, from_s: f64, to_s: f64, spans: &mut Vec<Span>) {
        let period_s = self.samples.period_s;
        let mut at_s = from_s;
        while at_s < to_s {
            let sample = (at_s / period_s + 1e-6) as usize;
            let until_s = ((sample + 1) as f64 * period_s).min(to_s);
            let works = self.samples.moves(sample, !self.filament.is_empty()) == Moves::Work;
            let kind = if works { Kind::Print } else { Kind::Travel };
            match spans.last_mut().filter(|last| last.line.is_none() && last.kind == kind && last.to_s >= at_s) {
                Some(last) => last.to_s = until_s,
                None => spans.push(Span { from_s: at_s, to_s: until_s, kind, line: None, label: Label::default() }),
            }
            at_s = until_s;
        }
    }

    /// Adds the spans of a stand.
    fn stand(&self, placed: &Placed, is_last: bool, spans: &mut Vec<Span>) {
        let Stand { from_s, to_s } = placed.stand;
        let events = self.events_of(placed, is_last);
        let of = |wanted: fn(&EventKind) -> bool| events.iter().find(|event| wanted(&event.kind)).copied();
        let owner = |event: Option<&Event>| match (event.or(events.first()), &self.program, placed.corner) {
            (Some(event), ..) => (Some(event.line), event.label),
            (None, Some((program, _)), Some(corner)) => {
                let after = program.corners.get(corner + 1).unwrap_or(&program.corners[corner]);
                (Some(after.line), after.label)
            }
            _ => (None, Label::default()),
        };
        let fed = of(|kind| *kind == EventKind::Filament);
        let dwell: f64 =
            events.iter().map(|event| if let EventKind::Dwell(seconds) = event.kind { seconds } else { 0.0 }).sum();
        let paused = of(|kind| *kind == EventKind::Pause).map(|event| (Kind::Pause, event));
        let heated = of(|kind| *kind == EventKind::Heat).map(|event| (Kind::Heating, event));
        let moving = self.filament_moves(from_s, to_s);
        let still = to_s - from_s - moving.iter().map(|(from, to)| to - from).sum::<f64>();
        let rest = match paused.or(heated) {
            Some((kind, event)) => (kind, owner(Some(&event))),
            None if self.is_aside(placed) => (Kind::Own, (None, Label::default())),
            None if !moving.is_empty() && still < AROUND_FILAMENT_S * moving.len() as f64 => {
                (Kind::Filament, owner(fed.as_ref()))
            }
            None => (Kind::Standing, owner(None)),
        };
        let dwelled = (Kind::Dwell, owner(of(|kind| matches!(kind, EventKind::Dwell(_))).as_ref()));
        let mut dwell_s = if is_last && self.program.is_none() { 0.0 } else { dwell };
        let mut push = |from_s: f64, to_s: f64, (kind, (line, label)): Owned| {
            spans.push(Span { from_s, to_s, kind, line, label });
        };
        let mut free = |from_s: f64, to_s: f64, push: &mut dyn FnMut(f64, f64, Owned)| {
            let until_s = to_s.min(from_s + dwell_s);
            dwell_s -= until_s - from_s;
            push(from_s, until_s, dwelled);
            push(until_s, to_s, rest);
        };
        let mut at_s = from_s;
        for (from, to) in moving {
            free(at_s, from, &mut push);
            push(from, to, (Kind::Filament, owner(fed.as_ref())));
            at_s = to;
        }
        free(at_s, to_s, &mut push);
    }

    fn is_aside(&self, placed: &Placed) -> bool {
        let Some((_, followed)) = &self.program else { return false };
        let middle = 0.5 * (placed.stand.from_s + placed.stand.to_s);
        let is_in = |aside: &super::follow::Aside| !aside.is_lost && aside.from_s < middle && middle < aside.to_s;
        placed.corner.is_none() && followed.aside.iter().any(|aside| is_in(aside) && aside.to_s < self.end_s)
    }

    /// Returns the events of the program during a stand.
    fn events_of(&self, placed: &Placed, is_last: bool) -> Vec<Event> {
        let Some((program, followed)) = &self.program else { return Vec::new() };
        let count = program.corners.len();
        let homed = (1..count).find(|corner| program.corners[*corner].is_homed);
        let before_homing = homed.filter(|_| followed.passed_s[0].is_nan());
        let begins_s = before_homing.map_or(0.0, |homed| followed.passed_s[homed]);
        let Stand { from_s, to_s } = placed.stand;
        let middle = 0.5 * (from_s + to_s);
        let aside = followed.aside.iter().find(|aside| aside.from_s < middle && middle < aside.to_s);
        let is_before_homing = to_s < begins_s && to_s - from_s > HOMING_STANDS_S;
        match placed.corner {
            // No place is known before homing: a wait of that part is in this stand or in another.
            _ if is_before_homing || placed.corner == Some(0) && before_homing.is_some() => {
                let until = before_homing.unwrap_or(count);
                let waits = |event: &&Event| event.at < until && !matches!(event.kind, EventKind::Home);
                program.events.iter().filter(waits).copied().collect()
            }
            Some(corner) => events_at(program, corner).copied().collect(),
            None if is_last => events_at(program, count - 1).copied().collect(),
            // The machine has parked, and will go on from this corner.
            None => match aside.and_then(|aside| aside.then.checked_sub(1)) {
                Some(corner) if corner < count && !program.corners[corner].is_homed => {
                    events_at(program, corner).copied().collect()
                }
                _ => Vec::new(),
            },
        }
    }

    /// Returns the times in which filament moved during a stand, seconds.
    fn filament_moves(&self, from_s: f64, to_s: f64) -> Vec<(f64, f64)> {
        let [from_ns, to_ns] = [from_s, to_s].map(|seconds| (seconds * 1e9).round() as u64);
        let mut moves: Vec<(u64, u64)> = Vec::new();
        for motor in &self.filament {
            moves.extend(self.executed.tracks[*motor as usize].moved(from_ns, to_ns, FILAMENT_GAP_NS));
        }
        moves.sort_unstable();
        let mut joined: Vec<(u64, u64)> = Vec::new();
        for (from, to) in moves {
            match joined.last_mut() {
                Some(last) if from <= last.1 => last.1 = last.1.max(to),
                _ => joined.push((from, to)),
            }
        }
        joined.into_iter().map(|(from, to)| ((from as f64 * 1e-9).max(from_s), (to as f64 * 1e-9).min(to_s))).collect()
    }
}

/// Returns the events at a corner.
pub fn events_at(program: &Program, corner: usize) -> impl Iterator<Item = &Event> {
    let first = program.events.partition_point(|event| event.at < corner);
    program.events[first..].iter().take_while(move |event| event.at == corner)
}

/// Returns whether nothing leads to this corner, or nothing from it.
fn is_end(program: &Program, corner: usize) -> bool {
    let after = program.corners.get(corner + 1);
    corner == 0 || program.corners[corner].is_homed || after.is_none_or(|after| after.is_homed)
}

/// Returns the corner at which the machine stands; `last` is the last one that was passed.
fn corner_of(program: &Program, followed: &Followed, samples: &Samples, last: usize, stand: Stand) -> Option<usize> {
    let middle = 0.5 * (stand.from_s + stand.to_s);
    let index = ((middle / samples.period_s) as usize).min(samples.points.len() - 1);
    let [x, y, z, _] = samples.points[index];
    let around = last.saturating_sub(AROUND)..(last + AROUND + 1).min(program.corners.len());
    let near = around.filter_map(|corner| {
        let [cx, cy, cz] = program.corners[corner].at;
        let apart = ((x - cx).powi(2) + (y - cy).powi(2) + (z - cz).powi(2)).sqrt();
        let is_homing = program.corners[corner].is_homed && stand.to_s < followed.passed_s[corner] - AFTER_HOMING_S;
        let is_passed = followed.passed_s[corner].is_finite();
        (is_passed && apart <= AT_CORNER_MM && !is_homing).then_some((corner, apart))
    });
    // Of corners close together, the one with an event to wait for counts.
    let asks = |corner: usize| events_at(program, corner).next().is_some();
    let order = |a: &(usize, f64), b: &(usize, f64)| asks(b.0).cmp(&asks(a.0)).then(a.1.total_cmp(&b.1));
    near.min_by(order).map(|(corner, _)| corner)
}
