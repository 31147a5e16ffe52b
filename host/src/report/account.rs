//! The account of a run's time, for the page and the summary.

use super::edges::Executed;
use super::follow::{Way, follow};
use super::machine::Machine;
use super::path::Samples;
use super::program::Program;
use super::slow::{self, SlowPlace, Starved};
use super::spent::{Course, Kind, Span, events_at};
use super::times::{Odometer, Times};

/// Distance beyond which the machine is off the path, mm; the second if corners are rounded on purpose.
const OFF_MM: f64 = 0.3;
const ROUNDED_OFF_MM: f64 = 1.0;
/// Distance within which the machine comes back onto an exact path, mm: homing touches the path's beginning
/// more than once.
const ON_MM: f64 = 0.1;
/// Weight of distances along Z if levelling moves Z: half a millimetre counts as a twentieth.
const LEVELLED_Z: f64 = 0.1;

/// Account of a run's time.
#[derive(Clone, Debug, Default)]
pub struct Account {
    /// Sums of time by kind, layer, feature and object.
    pub times: Times,
    /// Spans of time, in order and without gaps.
    pub spans: Vec<Span>,
    /// The slowest places, ordered by the time they lost, greatest first.
    pub slow: Vec<SlowPlace>,
    /// Stops that nothing asks for; none if the run could not be laid along its program.
    pub starved: Option<Vec<Starved>>,
    /// Distance of the path from the program's; none if the run could not be laid along its program.
    pub closeness: Option<Closeness>,
}

/// Distance of an executed path from that of its program.
#[derive(Clone, Copy, Debug)]
pub struct Closeness {
    /// The largest distance, mm.
    pub largest_mm: f64,
    /// First line at which the machine left the path though the program has nothing to do there.
    pub left_at: Option<u32>,
}

impl Account {
    /// Accounts for a run that ends after `end_s`.
    pub fn of(
        executed: &Executed,
        samples: &Samples,
        machine: Option<&Machine>,
        program: Option<&Program>,
        end_s: f64,
    ) -> Self {
        let filament = machine.map(Machine::filament).unwrap_or_default();
        let known = machine.filter(|machine| machine.kinematics.is_some()).zip(program);
        let followed = known.map(|(machine, program)| {
            let is_rounded = machine.shaped || program.rounds_corners;
            let way = Way {
                samples,
                corners: &program.corners,
                off_mm: if is_rounded { ROUNDED_OFF_MM } else { OFF_MM },
                trial_mm: if is_rounded { ROUNDED_OFF_MM } else { ON_MM },
                z_weight: if program.unknown.is_some() { LEVELLED_Z } else { 1.0 },
            };
            (program, follow(&way, program.homes))
        });
        let mut course = Course { end_s, executed, samples, program: followed, filament };
        let stands = course.place_stands();
        let spans = course.spans(&stands);
        let odometer = Odometer::new(samples);
        let times = Times::of(&spans, &odometer, program, end_s);
        let mut account = Self { times, spans, ..Self::default() };
        if let (Some((program, followed)), Some(machine)) = (&course.program, machine) {
            let is_asked =
                |corner: usize| (corner.saturating_sub(1)..=corner).any(|at| events_at(program, at).next().is_some());
            let left = followed.left.iter().find(|corner| !is_asked(**corner));
            let left_at = left.map(|corner| program.corners[*corner].line);
            account.closeness = Some(Closeness { largest_mm: followed.largest_mm, left_at });
            account.slow = slow::places(program, followed, &stands, machine.max_speed);
            account.starved = Some(slow::starved(program, followed, &stands, &odometer));
        }
        account
    }

    /// Returns the account in a few lines. `counted`: times at which the runner itself saw the planner
    /// starve.
    pub fn text(&self, counted: Option<&[f64]>) -> String {
        let times = &self.times;
        let share = |seconds: f64| 100.0 * seconds / times.seconds.max(1e-9);
        let kinds = times.kinds.iter().filter(|row| row.seconds >= 0.05);
        let kinds = kinds.map(|row| format!("{} {:.1} s ({:.0} %)", row.name, row.seconds, share(row.seconds)));
        let mut text = format!("  time  {}\n", kinds.collect::<Vec<_>>().join(", "));
        for (name, pace) in ["print moves", "travel"].into_iter().zip(times.pace) {
            let moving = pace.cruising + pace.accelerating + pace.braking;
            if moving > 0.0 {
                let share = |seconds: f64| 100.0 * seconds / moving;
                text += &format!(
                    "  pace  {name}: {:.0} % at even speed, {:.0} % accelerating, {:.0} % braking\n",
                    share(pace.cruising),
                    share(pace.accelerating),
                    share(pace.braking)
                );
            }
        }
        let layers: Vec<_> = times.layers.iter().filter(|layer| layer.number > 0).collect();
        if let Some(longest) = layers.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds)) {
            let (count, number, seconds) = (layers.len(), longest.number, longest.seconds);
            text += &format!("  layers  {count}, the longest is {number} with {seconds:.1} s\n");
        }
        for object in times.objects.iter().filter(|object| !object.name.is_empty()) {
            let left_out = if object.left_out { ", left out" } else { "" };
            let (name, seconds, filament) = (&object.name, object.seconds, object.filament);
            text += &format!("  object  {name}: {seconds:.1} s, {filament:.1} mm of filament{left_out}\n");
        }
        let mut features: Vec<_> = times.features.iter().filter(|feature| !feature.name.is_empty()).collect();
        features.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
        let features = features.iter().map(|feature| {
            let mean = feature.length / feature.seconds;
            format!("{} {:.1} s at {mean:.0} mm/s", feature.name, feature.seconds)
        });
        let features: Vec<_> = features.collect();
        if !features.is_empty() {
            text += &format!("  features  {}\n", features.join(", "));
        }
        for place in self.slow.iter().take(3) {
            text += &format!(
                "  slow  line {}: {} moves at {:.0} of {:.0} mm/s, {:.2} s more\n",
                place.line, place.moves, place.speed, place.asked, place.lost
            );
        }
        text + &self.starvation(counted) + &self.untold()
    }

    fn starvation(&self, counted: Option<&[f64]>) -> String {
        let seen = match &self.starved {
            None => "not told: the run could not be laid along its program".to_owned(),
            Some(starved) if starved.is_empty() => "none seen".to_owned(),
            Some(starved) => {
                let stood: f64 = starved.iter().map(|each| each.stood).sum();
                let first = starved[0].line.map_or_else(String::new, |line| format!(", the first before line {line}"));
                format!("{} stops that nothing asks for, {stood:.2} s in all{first}", starved.len())
            }
        };
        let counted = counted.map_or_else(String::new, |times| format!("; the planner counted {}", times.len()));
        format!("  planner  starved: {seen}{counted}\n")
    }

    fn untold(&self) -> String {
        let (untold, moving) = (self.times.untold, self.times.of_kind(Kind::Print) + self.times.of_kind(Kind::Travel));
        if untold < 0.05 {
            return String::new();
        }
        format!("  untold  {untold:.1} s of {moving:.1} s of moves could not be laid to lines\n")
    }
}

#[cfg(test)]
mod tests;
