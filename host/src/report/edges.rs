//! Reads `steps.csv`: every step edge of the run, as positions over time.
//!
//! An edge stands where the ideal position passes half way between two steps. Between edges the position is a
//! straight line, so the path has no staircase. A long job has tens of millions of edges; per motor only the
//! first and the last of each short time slot are kept.

use std::io::BufRead;
use std::path::Path;

use anyhow::{Context, Result};
use sim::trace::{Fnv1a, StepEdge};
use units::{Actuator, MAX_ACTUATORS};

use super::rows::{self, Rows};

/// Least time without an edge of X, Y and Z that is a stop.
const STOP_NS: u64 = 4_000_000;
/// Least time between edges that is standing: braking and setting off again also take a few milliseconds
/// for the last step and the first.
const STAND_NS: u64 = 20_000_000;
/// Multiple of the neighbouring interval below which a time between edges is slow motion.
const SLOW: u64 = 3;
/// Time without a step that is no motion, however slow.
const SURELY_NS: u64 = 1_000_000_000;

/// Position of a motor over time, in half steps, as straight lines.
#[derive(Debug, Default)]
pub struct Track {
    corners: Vec<(u64, i32)>,
    slot: Option<u64>,
}

impl Track {
    fn push(&mut self, time_ns: u64, half_steps: i32, slot_ns: u64) {
        let slot = time_ns / slot_ns;
        if self.slot == Some(slot) && self.corners.len() >= 2 && self.is_second_of(slot, slot_ns) {
            self.corners.pop();
        }
        self.slot = Some(slot);
        self.corners.push((time_ns, half_steps));
    }

    fn is_second_of(&self, slot: u64, slot_ns: u64) -> bool {
        let [.., first, last] = self.corners.as_slice() else { return false };
        first.0 / slot_ns == slot && last.0 / slot_ns == slot
    }

    /// Returns the spans within these times in which the motor moved; a longer pause than `gap_ns` ends a
    /// span.
    pub fn moved(&self, from_ns: u64, to_ns: u64, gap_ns: u64) -> Vec<(u64, u64)> {
        let first = self.corners.partition_point(|corner| corner.0 < from_ns);
        let mut moved: Vec<(u64, u64)> = Vec::new();
        for (time_ns, _) in self.corners[first..].iter().take_while(|corner| corner.0 <= to_ns) {
            match moved.last_mut() {
                Some(last) if time_ns - last.1 <= gap_ns => last.1 = *time_ns,
                _ => moved.push((*time_ns, *time_ns)),
            }
        }
        moved
    }

    /// Puts the motor on its whole step wherever it rests: an edge is only half way to it. Its last half step
    /// is taken to be as fast as the step before.
    fn rest_on_steps(&mut self) {
        let corners = &self.corners;
        let gap = |index: Option<usize>| {
            let pair = index.and_then(|index| Some((corners.get(index)?, corners.get(index + 1)?)));
            pair.map(|(from, to)| to.0 - from.0)
        };
        let mut rested = Vec::with_capacity(corners.len());
        for (index, (time_ns, half_steps)) in corners.iter().enumerate() {
            rested.push((*time_ns, *half_steps));
            let (before, after) = (gap(index.checked_sub(1)), gap(Some(index + 1)));
            // A motor that stays after its last edge is at rest from then on.
            let length = gap(Some(index)).unwrap_or(u64::MAX / 2);
            let beside = before.into_iter().chain(after).max().unwrap_or(length / SLOW);
            if length < STOP_NS || length < SLOW * beside {
                continue;
            }
            let came = index.checked_sub(1).map(|index| half_steps - corners[index].1);
            let goes = corners.get(index + 1).map(|next| next.1 - half_steps);
            // After a step back the next edge is at the same place.
            let Some(way) = came.filter(|way| *way != 0).or(goes.filter(|way| *way != 0)) else { continue };
            let step = half_steps + way.signum();
            rested.push((time_ns + before.unwrap_or(beside).min(length / SLOW) / 2, step));
            if let Some(next) = corners.get(index + 1) {
                rested.push((next.0 - after.unwrap_or(beside).min(length / SLOW) / 2, step));
            }
        }
        self.corners = rested;
    }

    /// Returns a reader that goes forward in time.
    pub const fn reader(&self) -> TrackReader<'_> {
        TrackReader { track: self, next: 0 }
    }
}

/// Reader of a [`Track`] at times that do not go back.
pub struct TrackReader<'a> {
    track: &'a Track,
    next: usize,
}

impl TrackReader<'_> {
    /// Returns the motor's position in steps.
    pub fn steps_at(&mut self, time_ns: u64) -> f64 {
        let corners = &self.track.corners;
        while corners.get(self.next).is_some_and(|corner| corner.0 <= time_ns) {
            self.next += 1;
        }
        let half_steps = match (self.next.checked_sub(1).map(|before| corners[before]), corners.get(self.next)) {
            (None, None) => 0.0,
            (None, Some(_)) => 0.0,
            (Some(before), None) => f64::from(before.1),
            (Some(before), Some(after)) => {
                let share = (time_ns - before.0) as f64 / (after.0 - before.0) as f64;
                f64::from(before.1) + share * f64::from(after.1 - before.1)
            }
        };
        half_steps * 0.5
    }
}

/// Stretch of time without an edge of X, Y and Z.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stop {
    /// Time of the edge before the stop; 0 for the first of a run, which has none.
    pub since_ns: u64,
    /// Time of the edge that ends the stop; the last stop of a run has none.
    pub until_ns: u64,
    /// Position of every motor at the stop's end, in steps from power-on.
    pub steps: [i64; MAX_ACTUATORS],
    /// Edges of every motor up to the stop's end.
    pub edges: [u64; MAX_ACTUATORS],
    /// The shorter one of the times between edges before the stop and behind it.
    pub beside_ns: u64,
}

/// Stretch of time in which X, Y and Z stood still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    /// Beginning of the stand, seconds.
    pub from_s: f64,
    /// End of the stand, seconds.
    pub to_s: f64,
}

/// State of X, Y and Z's last edges while reading.
#[derive(Default)]
struct Primary {
    last_ns: Option<u64>,
    /// Time between the last two edges.
    interval_ns: u64,
    /// The last edge ended a stop.
    follows_stop: bool,
}

/// Executed motion of all motors.
#[derive(Debug)]
pub struct Executed {
    /// Position over time of each motor.
    pub tracks: [Track; MAX_ACTUATORS],
    /// Forward minus backward edges.
    pub net_steps: [i64; MAX_ACTUATORS],
    /// All edges of each motor.
    pub edges: [u64; MAX_ACTUATORS],
    /// Stops in order; the first ends with the first edge, the last is the end of the run.
    pub stops: Vec<Stop>,
    /// Time of the last edge.
    pub end_ns: u64,
    /// Hash over all edges, to compare with the run's own.
    pub hash: u64,
}

impl Executed {
    /// Reads `steps.csv`, keeping corners no closer than `slot_ns`.
    pub fn read(path: &Path, slot_ns: u64) -> Result<Self> {
        Self::parse(rows::open(path)?, slot_ns).with_context(|| format!("cannot read {}", path.display()))
    }

    /// Reads a text; see [`Self::read`].
    pub fn parse(csv: impl BufRead, slot_ns: u64) -> Result<Self> {
        let mut executed = Self {
            tracks: Default::default(),
            net_steps: [0; MAX_ACTUATORS],
            edges: [0; MAX_ACTUATORS],
            stops: Vec::new(),
            end_ns: 0,
            hash: 0,
        };
        let mut hash = Fnv1a::default();
        let mut primary = Primary::default();
        for edge in Rows::of(csv) {
            let StepEdge { time_ns, actuator, direction } = edge?;
            let direction = direction.sign() as i8;
            hash.update(&time_ns.to_le_bytes());
            hash.update(&[actuator as u8, direction as u8]);
            executed.take(time_ns, actuator, direction, slot_ns, &mut primary);
        }
        executed.hash = hash.value();
        let (since_ns, beside_ns) = (primary.last_ns.unwrap_or(0), primary.interval_ns);
        let (steps, edges) = (executed.net_steps, executed.edges);
        executed.stops.push(Stop { since_ns, until_ns: u64::MAX, steps, edges, beside_ns });
        Ok(executed)
    }

    /// Returns the times in which X, Y and Z stood still, in a run that ends at `end_s`. The machine stands
    /// before the first edge and behind the last.
    pub fn stands(&self, end_s: f64) -> Vec<Stand> {
        let last = self.stops.len().saturating_sub(1);
        let is_stand = |(place, stop): &(usize, &Stop)| {
            let length = stop.until_ns.saturating_sub(stop.since_ns);
            let is_slow = length < SURELY_NS && length < SLOW.saturating_mul(stop.beside_ns);
            *place == 0 || *place == last || length >= STAND_NS && !is_slow
        };
        let seconds = |ns: u64| (ns as f64 * 1e-9).min(end_s);
        let stands = self.stops.iter().enumerate().filter(is_stand);
        stands.map(|(_, stop)| Stand { from_s: seconds(stop.since_ns), to_s: seconds(stop.until_ns) }).collect()
    }

    /// Puts each motor on its whole step wherever it rests; for edges that were all kept.
    pub fn rest_on_steps(&mut self) {
        self.tracks.iter_mut().for_each(Track::rest_on_steps);
    }

    fn take(&mut self, time_ns: u64, actuator: Actuator, direction: i8, slot_ns: u64, primary: &mut Primary) {
        let index = actuator as usize;
        if index < 3 {
            let interval_ns = time_ns.saturating_sub(primary.last_ns.unwrap_or(0));
            if let (true, Some(stop)) = (primary.follows_stop, self.stops.last_mut()) {
                stop.beside_ns = stop.beside_ns.min(interval_ns);
            }
            primary.follows_stop = primary.last_ns.is_none() || interval_ns >= STOP_NS;
            if primary.follows_stop {
                let (since_ns, beside_ns) = (primary.last_ns.unwrap_or(0), primary.interval_ns);
                let (steps, edges) = (self.net_steps, self.edges);
                self.stops.push(Stop { since_ns, until_ns: time_ns, steps, edges, beside_ns });
            }
            primary.interval_ns = interval_ns;
            primary.last_ns = Some(time_ns);
        }
        let middle = self.net_steps[index] * 2 + i64::from(direction);
        self.tracks[index].push(time_ns, middle as i32, slot_ns);
        self.net_steps[index] += i64::from(direction);
        self.edges[index] += 1;
        self.end_ns = time_ns;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Executed> {
        Executed::parse(text.as_bytes(), 1_000_000)
    }

    #[test]
    fn positions_pass_half_steps_at_the_edges_and_run_straight_between() {
        let run = parse("time_ns,actuator,direction\n1000000,alpha,1\n3000000,alpha,1\n5000000,0,-1\n").unwrap();
        let mut reader = run.tracks[0].reader();
        let at = [0, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 9_000_000].map(|t| reader.steps_at(t));
        assert_eq!(at, [0.0, 0.5, 1.0, 1.5, 1.5, 1.5]);
        assert_eq!((run.net_steps[0], run.edges[0], run.end_ns), (1, 3, 5_000_000));
    }

    #[test]
    fn a_motor_that_rests_is_on_its_whole_step() {
        let ms = |from: u64, count: u64, direction: i32| {
            (0..count).map(move |n| format!("{},beta,{direction}\n", (from + n) * 1_000_000))
        };
        // Eight steps, a rest, four more, a rest, six steps back.
        let rows: String = ms(10, 8, 1).chain(ms(300, 4, 1)).chain(ms(600, 6, -1)).collect();
        let mut run = Executed::parse(rows.as_bytes(), 1).unwrap();
        run.rest_on_steps();
        let mut reader = run.tracks[1].reader();
        let at = [12, 17, 20, 150, 295, 301, 450, 590, 605, 900].map(|ms| reader.steps_at(ms * 1_000_000));
        assert_eq!(at, [2.5, 7.5, 8.0, 8.0, 8.0, 9.5, 12.0, 12.0, 6.5, 6.0]);
    }

    #[test]
    fn even_motion_has_no_rests() {
        let rows: String = (1..50).map(|n| format!("{},beta,1\n", n * 7_000_000)).collect();
        let mut run = Executed::parse(rows.as_bytes(), 1).unwrap();
        let before = run.tracks[1].corners.clone();
        run.rest_on_steps();
        assert_eq!(run.tracks[1].corners[..before.len()], before);
    }

    #[test]
    fn a_slot_keeps_its_first_and_last_edge() {
        let rows: String = (0..100).map(|n| format!("{},beta,1\n", n * 10_000)).collect();
        let run = parse(&rows).unwrap();
        assert_eq!(run.tracks[1].corners, [(0, 1), (990_000, 199)]);
    }

    #[test]
    fn standing_still_long_enough_is_a_stop() {
        let run = parse("5,alpha,1\n10,beta,1\n30000000,delta,1\n50000000,alpha,-1\n").unwrap();
        let stops: Vec<_> = run.stops.iter().map(|stop| (stop.until_ns, stop.steps[0], stop.steps[3])).collect();
        assert_eq!(stops, [(5, 0, 0), (50_000_000, 1, 1), (u64::MAX, 0, 1)]);
    }

    #[test]
    fn a_stand_is_told_from_braking_and_from_slow_motion() {
        let steps = |from_ms: u64, every_ms: u64| (0..10).map(move |n| from_ms + n * every_ms);
        // The motor moves fast, turns round in 12 ms, moves fast, rests 200 ms, then makes a step every 30
        // ms.
        let times = steps(1_000, 1).chain(steps(1_021, 1)).chain(steps(1_230, 30));
        let rows: String = times.map(|ms| format!("{},alpha,1\n", ms * 1_000_000)).collect();
        let stands = parse(&rows).unwrap().stands(2.0);
        let found: Vec<_> = stands.iter().map(|s| ((s.from_s * 1e3).round(), (s.to_s * 1e3).round())).collect();
        assert_eq!(found, [(0.0, 1_000.0), (1_030.0, 1_230.0), (1_500.0, 2_000.0)]);
    }

    #[test]
    fn the_hash_is_the_trace_s_own() {
        use units::Direction::{Backward, Forward};
        let mut trace = sim::trace::Trace::default();
        let mut csv = String::new();
        for (time_ns, actuator, direction) in [(7, Actuator::Alpha, Forward), (9, Actuator::Delta, Backward)] {
            trace.push(sim::trace::StepEdge { time_ns, actuator, direction });
            csv += &format!("{time_ns},{},{}\n", actuator.name(), direction.sign());
        }
        assert_eq!(parse(&csv).unwrap().hash, trace.edge_hash());
    }

    #[test]
    fn a_bad_row_is_named() {
        for bad in ["x,alpha,1", "1,eta,1", "1,alpha,2", "1,alpha", "1,alpha,1,1"] {
            let error = format!("{:#}", parse(&format!("1,alpha,1\n{bad}\n")).unwrap_err());
            assert!(error.contains("line 2") && error.contains(bad), "{error}");
        }
    }
}
