//! The machine for macros.

use base::failure::Failure;
use base::sessions::Recipient;
use base::taken_codes::TakenCodes;
use base::tuning::Tuning;
use base::{Ports, World};
use jobs::player::Jobs;
use parts::filament::Filament;
use preflight::forecast::SharedForecast;
use printer_cfg::Section;
use program::{Interpreter, State};

use super::state::Macros;
use crate::features::state::States;
use crate::features::viewers::ViewedHands;
use crate::machine::Machine;
use crate::machine::moments::Served as _;
use crate::machine::source::Source;
use crate::machine::work_hands::JobHands;

/// Parts of the machine that macros see, beside what viewers see.
pub(crate) struct Seen<'m, 'c, P> {
    pub macros: &'m mut Macros<'c>,
    pub world: &'m mut World<'c, P>,
    pub program: &'m Interpreter,
    pub tuning: &'m Tuning,
    pub filament: &'m Filament,
    pub jobs: &'m Jobs,
}

/// Name of the section that stands for G28.
pub(super) const OVERRIDE: &str = "homing_override";

/// The machine for macros.
pub(crate) trait MacroHands<'c>: ViewedHands<'c> + JobHands<'c> {
    /// Returns what macros keep.
    fn macros(&mut self) -> &mut Macros<'c>;

    /// Returns what macros see.
    fn seen(&mut self) -> Seen<'_, 'c, Self::Ports>;

    /// Returns the look ahead at a file.
    fn look_ahead(&self) -> &'c SharedForecast;

    /// Whether G-code is due.
    fn is_due(&self) -> bool;

    /// Whether `[homing_override]` stands for G28.
    fn has_homing(&self) -> bool;

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
        let Self { features: States { macros, filament, .. }, world, program, tuning, jobs, .. } = self;
        Seen { macros, world, program, tuning, filament, jobs }
    }

    fn look_ahead(&self) -> &'c SharedForecast {
        self.forecast
    }

    fn is_due(&self) -> bool {
        self.features.macros.is_due
    }

    fn has_homing(&self) -> bool {
        self.features.macros.memory.store.section(OVERRIDE).is_some()
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

/// Makes a refusal of trouble with the configuration.
pub(super) fn refused<'c>(hands: &mut impl MacroHands<'c>, trouble: &printer_cfg::Trouble) -> Failure {
    let Seen { macros, world, .. } = hands.seen();
    let path = macros.memory.store.path_of(trouble);
    world.texts.refused(format_args!("{}: {trouble}", path.rsplit_once('/').map_or(path, |(_, name)| name)))
}

/// Whether a section has an option.
pub(super) fn has_option<'c>(hands: &mut impl MacroHands<'c>, section: Section, key: &str) -> Result<bool, Failure> {
    let Seen { macros, world, .. } = hands.seen();
    let read = macros.memory.store.read((section, key), &mut world.ports, |_| ());
    read.map(|read| read.is_some()).map_err(|trouble| refused(hands, &trouble))
}

/// Reads an option into memory. False: there is none.
pub(super) fn read_option<'c>(hands: &mut impl MacroHands<'c>, section: Section, key: &str) -> Result<bool, Failure> {
    let Seen { macros, world, .. } = hands.seen();
    let memory = &mut macros.memory;
    let read = memory.store.read((section, key), &mut world.ports, |text| memory.text.fill(text));
    read.map(|read| read.is_some()).map_err(|trouble| refused(hands, &trouble))
}
