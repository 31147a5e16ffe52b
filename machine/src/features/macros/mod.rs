//! Klipper's macros: `[gcode_macro]` and `[delayed_gcode]` of a printer.cfg on the card, docs/macros.md.
//!
//! A macro is rendered whole by crate `macros` before its first line is carried out ([`calls`]). Its lines
//! go on as a step on the stack of frames, so pauses and aborts act between them. What macros see of the
//! machine is in [`look`] and [`objects`].

pub(crate) mod calls;
mod commands;
pub(crate) mod kept_modes;
mod look;
mod objects;
pub(crate) mod reload;
mod saved;
pub(crate) mod state;

use base::failure::{Failure, Outcome};
use base::sessions::Recipient;
use base::tuning::Tuning;
use base::{Ports, World};
use gcode::Block;
use parts::filament::Filament;
use program::{Interpreter, State};
use units::Micros;

use crate::features::state::States;
use crate::features::viewers::ViewedHands;
use crate::machine::Machine;
use crate::machine::moments::{JobBegins, Moments, Served as _};
use crate::machine::source::Source;
use crate::machine::taken_codes::TakenCodes;
use crate::machine::work_hands::JobHands;
use state::Macros;

/// Line that carries out the delayed G-code that is due.
const DUE: &str = "UPDATE_DELAYED_GCODE";

/// Parts of the machine that macros see, beside what viewers see.
pub(crate) struct Seen<'m, 'c, P> {
    pub macros: &'m mut Macros<'c>,
    pub world: &'m mut World<'c, P>,
    pub program: &'m Interpreter,
    pub tuning: &'m Tuning,
    pub filament: &'m Filament,
}

/// The machine for macros.
pub(crate) trait MacroHands<'c>: ViewedHands<'c> + JobHands<'c> {
    /// Returns what macros keep.
    fn macros(&mut self) -> &mut Macros<'c>;

    /// Returns what macros see.
    fn seen(&mut self) -> Seen<'_, 'c, Self::Ports>;

    /// Whether G-code is due.
    fn is_due(&self) -> bool;

    /// Whether nothing is in work.
    fn is_at_rest(&self) -> bool;

    /// Notes which codes are those of macros.
    fn take_codes(&mut self, taken: TakenCodes);

    /// Waits until a recipient has taken most of what was said.
    fn wait_until_heard(&mut self, to: Recipient);

    /// Runs a line of a macro.
    fn run_line(&mut self, line: &[u8], source: Source);
}

impl<'c, P: Ports> MacroHands<'c> for Machine<'c, P> {
    fn macros(&mut self) -> &mut Macros<'c> {
        &mut self.features.macros
    }

    fn seen(&mut self) -> Seen<'_, 'c, P> {
        let Self { features: States { macros, filament, .. }, world, program, tuning, .. } = self;
        Seen { macros, world, program, tuning, filament }
    }

    fn is_due(&self) -> bool {
        self.features.macros.is_due
    }

    fn is_at_rest(&self) -> bool {
        self.frames.is_empty() && self.safety.state() == State::Idle && !self.jobs.is_playing()
    }

    fn take_codes(&mut self, taken: TakenCodes) {
        self.taken_codes = taken;
    }

    fn wait_until_heard(&mut self, to: Recipient) {
        self.drain(to);
    }

    fn run_line(&mut self, line: &[u8], source: Source) {
        P::run_line(self, line, source);
    }
}

/// Macros, at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: MacroHands<'c>> Moments<M> for Feature {
    fn read_files(hands: &mut M) {
        reload::at_start(hands);
    }

    fn each_10_ms(hands: &mut M, now: Micros) {
        if hands.macros().memory.store.sections() > 0 {
            commands::follow_time(hands, now);
        }
    }

    fn line(hands: &M) -> Option<&'static str> {
        hands.is_due().then_some(DUE)
    }

    fn take_line(hands: &mut M) -> Option<&'static str> {
        hands.is_due().then_some(DUE)
    }

    fn session_line_begins(hands: &mut M) {
        hands.macros().is_idle = false;
    }

    fn job_begins(hands: &mut M, _from: JobBegins) {
        hands.macros().is_idle = false;
    }

    fn run_named(hands: &mut M, line: &str, source: Source) -> Option<Outcome> {
        calls::run_named(hands, line, source)
    }

    fn run_code(hands: &mut M, block: &Block<'_>, source: Source) -> Option<Outcome> {
        calls::run_code(hands, block, source)
    }
}

/// Makes a refusal of trouble with the configuration.
fn refused<'c>(hands: &mut impl MacroHands<'c>, trouble: &printer_cfg::Trouble) -> Failure {
    let Seen { macros, world, .. } = hands.seen();
    let path = macros.memory.store.path_of(trouble);
    world.texts.refused(format_args!("{}: {trouble}", path.rsplit_once('/').map_or(path, |(_, name)| name)))
}
