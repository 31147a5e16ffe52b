//! The filament detector: notices that filament has run out, is too thick or too thin, or is stuck.
//!
//! The detector reacts by issuing M600, as a person would. Inputs are looked at while filament is used: while
//! a file is played, or while a host streams moves. While no filament is used a person is told once, and
//! `resume` is refused as long as filament is missing.

mod codes;
mod delay_line;
mod width;

use base::failure::{Failure, Texts};
use base::ports::{Input, InputLevels};
use base::sessions::Reply;
use base::tuning::Tuning;
use config::{Command, MachineConfig};
use units::{Axis, Micros};

pub use codes::{told, told_of_width};
pub use width::{Width, WidthNews};

/// Least time between two changes of an input: a shorter change is noise, or a splice that passes.
const DEBOUNCE: Micros = Micros::from_millis(50);
/// Pulses that may be missing before the filament counts as stuck: the wheel stands anywhere between two
/// pulses, and has some play.
const MISSING: f64 = 1.5;

/// Fault of the filament.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// No filament, according to the detector's input.
    RunOut,
    /// Filament too thick, according to the detector's input.
    Bulge,
    /// Extruder that pushes while the wheel does not turn.
    Stuck,
    /// Measured width below the least diameter.
    TooThin,
    /// Measured width above the greatest diameter.
    TooThick,
}

impl Trouble {
    /// Returns the message for a person.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::RunOut => "the filament has run out",
            Self::Bulge => "the filament is too thick (a bulge)",
            Self::Stuck => "the filament does not move: a jam, a break, or its end",
            Self::TooThin => "the filament is too thin: its end, or a break",
            Self::TooThick => "the filament is too thick: it would jam",
        }
    }
}

/// Present use of filament.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// A file is played.
    Plays,
    /// Something moves: a host prints, or a person loads filament.
    Moves,
    /// A job is suspended, or paused.
    Rests,
    /// Filament is not used.
    Idle,
}

/// State of the filament wheel.
#[derive(Clone, Copy, Debug, Default)]
struct Wheel {
    level: bool,
    pulses: u32,
    due: Micros,
    /// Extruder's axis, and how far it had pushed at the last look that counted, mm.
    from: Option<(Axis, f64)>,
    /// Distance that the extruder has pushed since then, mm.
    pushed: f64,
}

/// News of a look, given once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum News {
    /// Fault because of which the job is to be suspended.
    Suspends(Trouble),
    /// Fault found while no filament is used.
    Noted(Trouble),
}

/// Filament detector with its state.
#[derive(Clone, Debug, Default)]
pub struct Filament {
    /// Whether M405 has switched the detector off.
    off: bool,
    /// Level of the input, and the time since which it has had it.
    level: (bool, Micros),
    /// Whether the debounced input says that there is no filament, or that it is too thick.
    is_bad: bool,
    /// Whether a person has been told.
    was_noted: bool,
    /// Fault that the width sensor finds.
    width: Option<Trouble>,
    wheel: Wheel,
    rested: bool,
    /// Whether the job is being suspended, or is, because of the filament.
    has_asked: bool,
    command: bool,
    /// Lines of the configuration to be sent: filament has run out, filament was put in.
    lines: [bool; 2],
}

impl Filament {
    /// Counts the wheel's pulses. Called as often as the kill button is looked at.
    pub fn count(&mut self, levels: InputLevels) {
        let level = levels.is_active(Input::FilamentWheel);
        self.wheel.pulses = self.wheel.pulses.saturating_add(u32::from(level && !self.wheel.level));
        self.wheel.level = level;
    }

    /// Notes the fault that the width sensor finds, if any.
    pub const fn note_width(&mut self, trouble: Option<Trouble>) {
        self.width = trouble;
    }

    /// Looks at the filament, a hundred times a second. `extruder`: the axis of the extruder in use, and
    /// where its motor is, mm.
    pub fn look(
        &mut self,
        levels: InputLevels,
        config: &MachineConfig,
        tuning: &Tuning,
        using: Use,
        extruder: impl FnOnce() -> Option<(Axis, f64)>,
        now: Micros,
    ) -> Option<News> {
        if self.off {
            return None;
        }
        let was_put_in = self.look_at_level(levels, now);
        let is_used = matches!(using, Use::Plays | Use::Moves);
        self.lines[1] |= was_put_in && !is_used;
        let rests = using == Use::Rests;
        if core::mem::replace(&mut self.rested, rests) != rests {
            // A person who has loaded filament has turned the wheel, and has seen to what was wrong.
            self.wheel = Wheel { level: self.wheel.level, ..Wheel::default() };
            self.has_asked &= rests;
        }
        self.has_asked &= using != Use::Idle;
        let has_wheel = config.filament_detector.wheel_pin().is_some();
        let is_stuck = has_wheel && is_used && self.wheel.look(tuning, extruder, now);
        let Some(trouble) = self.is_missing(config).or(is_stuck.then_some(Trouble::Stuck)) else {
            self.was_noted = false;
            // Without a suspension the filament may run out once more in the same job.
            self.has_asked &= config.filament_detector.suspends || has_wheel;
            return None;
        };
        let is_new = !core::mem::replace(&mut self.was_noted, true);
        // Without a file, a fault from before the first move is known to the person who moves: he loads
        // filament.
        if !self.has_asked && (using == Use::Plays || using == Use::Moves && is_new) {
            let suspends = config.filament_detector.suspends;
            (self.has_asked, self.command, self.lines[0]) = (true, suspends, true);
            return Some(if suspends { News::Suspends(trouble) } else { News::Noted(trouble) });
        }
        (is_new && !is_used).then_some(News::Noted(trouble))
    }

    /// Returns the line to be sent next.
    #[must_use]
    pub fn line<'c>(&self, config: &'c MachineConfig) -> Option<&'c str> {
        if self.command {
            return Some("M600");
        }
        let mut lines = self.lines.iter().zip(&config.filament_lines);
        lines.find(|(is_due, line)| **is_due && !line.is_empty()).map(|(_, line)| line.as_str())
    }

    /// Takes the line to be sent next.
    pub fn take_line(&mut self, config: &MachineConfig, tuning: &Tuning) -> Option<Command> {
        if core::mem::take(&mut self.command) {
            return Command::try_from(if tuning.filament.leave_heaters_on { "M600.1" } else { "M600" }).ok();
        }
        let mut lines = self.lines.iter_mut().zip(&config.filament_lines);
        lines.find_map(|(is_due, line)| (core::mem::take(is_due) && !line.is_empty()).then(|| line.clone()))
    }

    /// Notes that extruders count from another place than before, without having moved.
    pub const fn counts_anew(&mut self) {
        self.wheel.from = None;
    }

    /// Drops the wish to suspend: the machine was halted, or the job is over.
    pub fn forget(&mut self) {
        (self.command, self.has_asked, self.lines) = (false, false, [false; 2]);
    }

    /// Whether the detector counts: M405 has not switched it off.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        !self.off
    }

    /// Returns the fault because of which no job can go on, if any.
    #[must_use]
    pub fn is_missing(&self, config: &MachineConfig) -> Option<Trouble> {
        let bulge = config.filament_detector.bulge_pin.is_some();
        let by_level = self.is_bad.then_some(if bulge { Trouble::Bulge } else { Trouble::RunOut });
        by_level.or(self.width).filter(|_| !self.off)
    }

    /// Returns whether a job that begins now would be suspended with the next look.
    #[must_use]
    pub fn is_about_to_ask(&self, config: &MachineConfig) -> bool {
        (self.command || !self.has_asked) && self.is_missing(config).is_some()
    }

    /// Checks that a job that was begun can go on.
    ///
    /// # Errors
    /// When there is no filament for it.
    pub fn must_be_there(&self, texts: &Texts, config: &MachineConfig) -> Result<(), Failure> {
        let Some(trouble) = self.is_missing(config).filter(|_| config.filament_detector.suspends) else {
            return Ok(());
        };
        let text = trouble.text();
        Err(texts.refused(format_args!("{text}: see to it, or M405 has it passed over")))
    }

    /// Looks at the input. True: filament has been put in.
    fn look_at_level(&mut self, levels: InputLevels, now: Micros) -> bool {
        let level = levels.is_active(Input::Filament);
        if level != self.level.0 {
            self.level = (level, now);
        }
        if now.since(self.level.1) < DEBOUNCE {
            return false;
        }
        core::mem::replace(&mut self.is_bad, level) && !level
    }

    /// M405, M406, M412: switches the detector on or off.
    fn switch(&mut self, on: bool) {
        *self = Self { off: !on, ..Self::default() };
    }

    /// M407: prints the detector's state.
    fn report(&self, config: &MachineConfig, tuning: &Tuning, reply: &mut Reply<'_>) {
        if !config.filament_detector.enable {
            return;
        }
        if config.filament_detector.wheel_pin().is_some() {
            reply.say(format_args!("Extruder moved: {:.6} mm\n", self.wheel.pushed));
            reply.say(format_args!("Encoder pulses: {}\n", self.wheel.pulses));
        }
        if let Some(trouble) = self.is_missing(config) {
            reply.say(format_args!("Now {}\n", trouble.text()));
        }
        reply.say(format_args!("Filament detector is {}abled\n", if self.off { "dis" } else { "en" }));
        reply.say(format_args!("Leave heaters on is {}\n", tuning.filament.leave_heaters_on));
    }
}

impl Wheel {
    /// Returns whether the filament is stuck. Pushed lengths are added up until they are worth some pulses; a
    /// length that is pushed again after a retraction says nothing.
    fn look(&mut self, tuning: &Tuning, extruder: impl FnOnce() -> Option<(Axis, f64)>, now: Micros) -> bool {
        if now < self.due {
            return false;
        }
        self.due = now.plus(tuning.filament.check_every);
        let Some((axis, here)) = extruder() else { return false };
        let Some((_, most)) = self.from.filter(|(before, _)| *before == axis) else {
            (self.from, self.pulses) = (Some((axis, here)), 0);
            return false;
        };
        self.pushed = (here - most).max(0.0);
        if here <= most {
            // A retraction, or its way back: pulses of these are not those of the way on.
            self.pulses = 0;
            return false;
        }
        if self.pushed * tuning.filament.pulses_per_mm < MISSING {
            return false;
        }
        let is_stuck = self.pulses == 0;
        (self.from, self.pulses, self.pushed) = (Some((axis, here)), 0, 0.0);
        is_stuck
    }
}

#[cfg(test)]
mod tests;
