//! A file on its way through a preflight: the program's state, and what the file has come to so far.

use config::MachineConfig;
use motion::{Motion, Passage, Tag};
use program::{Dialect, Facts, Interpreter, copy_program};
use units::{Axis, AxisSet, Celsius, MAX_HEATERS, MmPerSecond, PerAxis};

use super::cost::Costs;
use super::finding::{Finding, Once, SubName};
use super::limits::Limit;
use super::turns::end_turn;
use crate::failure::Texts;
use crate::jobs::MOST_CALLERS;
use crate::leveling::words::configured as configured_skew;
use crate::motion_config::motion_config;
use crate::program_setup;
use crate::safety::travel::Travel;
use crate::tuning::Tuning;

/// Lines that are read at most: loops may have no end.
pub const MOST_LINES: u32 = 20_000_000;

/// Blocks and lines that are done with before everybody else gets a turn: a tenth of a millisecond on the
/// board.
const IN_A_ROW: u8 = 4;

/// Receiver of what a preflight finds.
pub trait Listener {
    /// Something that is wrong with the file.
    fn found(&mut self, finding: &Finding);

    /// Takes a block of the look-ahead queue that has been passed, along [`Motion::passed_path`].
    fn passed(&mut self, _passage: &Passage, _motion: &Motion) {}

    /// A line says which object the lines behind it make, with the text of M486. Lines are counted here as
    /// tags of moves are: each that is no comment, as often as it is carried out.
    fn labelled(&mut self, _line: u32, _text: &str) {}

    /// At this line, counted so, the machine waits for so many seconds.
    fn waited(&mut self, _line: u32, _seconds: f64) {}
}

/// Totals of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Number of lines read.
    pub lines: u32,
    /// Moves at even speed, seconds.
    pub even_seconds: f64,
    /// Moves whose speed changes, seconds.
    pub ramp_seconds: f64,
    /// Dwells, and coming to a standstill and from it, seconds.
    pub waiting_seconds: f64,
    /// Homing, by what the configuration says of ways and speeds, seconds.
    pub homing_seconds: f64,
    /// Time lost to limits, seconds, in the order of [`Limit::ALL`].
    pub limits: [f64; Limit::COUNT],
    /// Filament that moves feed, mm.
    pub filament: f64,
    /// Path of moves that feed filament, mm.
    pub printed: f64,
    /// Path of moves that do not, mm.
    pub travelled: f64,
    /// The least and the greatest places, mm; none where nothing moved.
    pub extents: Option<[PerAxis<f64>; 2]>,
    /// Times that the file waits for a temperature.
    pub heat_waits: u32,
    /// Number of waits for each heater, and the highest temperature waited for.
    pub heats: [(u32, Celsius); MAX_HEATERS],
    /// Findings that stop the job.
    pub stops: u32,
    /// Number of other findings.
    pub warnings: u32,
}

impl Totals {
    /// Returns the time that all limits cost, seconds.
    #[must_use]
    pub fn lost_seconds(&self) -> f64 {
        self.limits.iter().sum()
    }

    /// Everything but heating, seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.even_seconds + self.ramp_seconds + self.waiting_seconds + self.homing_seconds
    }
}

/// A machine in the middle of its work.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AsItIs<'m> {
    /// Program with all that it has been told.
    pub program: &'m Interpreter,
    pub tuning: &'m Tuning,
    pub travel: &'m Travel,
    pub homed: AxisSet,
    pub targets: [Celsius; MAX_HEATERS],
    /// The highest temperatures that heaters may have.
    pub most_celsius: [Celsius; MAX_HEATERS],
    /// Dialect that the file states.
    pub dialect: Option<Dialect>,
    /// The file is what the program does next.
    pub goes_on: bool,
}

/// Never inlined: what it is made of is on the stack meanwhile.
#[inline(never)]
fn new_program<'p>(config: &MachineConfig, place: &'p mut Option<Interpreter>) -> &'p mut Interpreter {
    place.insert(Interpreter::new(program_setup::setup(config)))
}

/// A file on its way through.
#[derive(Debug)]
pub struct Preflight<'c> {
    pub(super) config: &'c MachineConfig,
    /// Texts of failure messages.
    pub(super) texts: &'c Texts,
    pub(super) program: &'c mut Interpreter,
    pub(super) tuning: Tuning,
    pub(super) travel: Travel,
    pub(super) homed: AxisSet,
    pub(super) can_home: AxisSet,
    pub(super) dialect: Dialect,
    pub(super) targets: [Celsius; MAX_HEATERS],
    /// The highest temperatures of heaters.
    pub(super) most_celsius: [Celsius; MAX_HEATERS],
    /// Up to where a mesh fades, and what is left of it there, where a code has said so, mm.
    pub(super) fade: (Option<f64>, Option<f64>),
    /// The line that has loaded a mesh first.
    pub(super) loads_mesh: Option<u32>,
    /// The file is what the machine has saved, and no job.
    pub(super) reads_settings: bool,
    /// Files of subroutines that are open, the last one being read.
    pub(super) files: heapless::Vec<SubName, MOST_CALLERS>,
    /// The subroutine that was called, which may have a file of its own.
    pub(super) called: SubName,
    /// Time of a standstill, seconds.
    pub(super) settling: f64,
    /// Moves have been submitted since the last standstill.
    pub(super) moves: bool,
    pub(super) totals: Totals,
    pub(super) once: Once,
    /// Cost of limits so far.
    pub(super) costs: Costs,
    /// The file has said how fast rapids are to be.
    pub(super) asks_of_rapids: bool,
    /// The acceleration that the file has asked for, mm/s2.
    pub(super) asked_acceleration: Option<f64>,
    /// The speed of the move at hand, were there no limit of flow.
    pub(super) without_flow_limit: Option<MmPerSecond>,
    pub(super) line: u32,
    /// Lines that are no comments, as often as they were carried out.
    pub(super) begun: u32,
    pub(super) has_begun: bool,
    pub(super) has_ended: bool,
    /// Done with since everybody else had a turn.
    in_a_row: u8,
}

impl<'c> Preflight<'c> {
    /// Of a machine that was just switched on. `motion` is set up for it, and `program` holds its program,
    /// which is large; `dialect` is what the file says it is written in, if it does.
    ///
    /// # Errors
    /// When the machine has no geometry that can move.
    pub fn new(
        texts: &'c Texts,
        config: &'c MachineConfig,
        dialect: Option<Dialect>,
        program: &'c mut Option<Interpreter>,
        motion: &mut Motion,
    ) -> Result<Self, config::ArmSolution> {
        let own = motion_config(config)?;
        motion.configure_to_pass(&own).map_err(|_| config.motion.arm_solution)?;
        let mut preflight = Self::of_nothing(config, texts, program);
        preflight.settling = Motion::settling(&own);
        for (slot, (_, heater)) in preflight.most_celsius.iter_mut().zip(config.heaters()) {
            *slot = heater.max_temp;
        }
        // The machine says at boot which skew motion does not take, and goes without it.
        let _ = motion.set_skew(configured_skew(&config.leveling));
        preflight.read_as(dialect);
        Ok(preflight)
    }

    /// Of no file yet.
    pub(crate) fn of_nothing(
        config: &'c MachineConfig,
        texts: &'c Texts,
        program: &'c mut Option<Interpreter>,
    ) -> Self {
        let homes = |axis: &Axis| config.homing_endstop(*axis).is_some();
        Self {
            config,
            texts,
            program: new_program(config, program),
            tuning: Tuning::new(config),
            travel: Travel::default(),
            homed: AxisSet::NONE,
            can_home: AxisSet::collect(Axis::ALL.into_iter().filter(homes)),
            dialect: program_setup::dialect(config),
            targets: [Celsius(0.0); MAX_HEATERS],
            most_celsius: [Celsius(0.0); MAX_HEATERS],
            fade: (None, None),
            loads_mesh: None,
            reads_settings: false,
            files: heapless::Vec::new(),
            called: SubName::new(),
            settling: 0.0,
            moves: false,
            totals: Totals::default(),
            once: Once::default(),
            costs: Costs::default(),
            asks_of_rapids: false,
            asked_acceleration: None,
            without_flow_limit: None,
            line: 0,
            begun: 0,
            has_begun: false,
            has_ended: false,
            in_a_row: 0,
        }
    }

    /// Each standstill takes so many seconds.
    pub(crate) const fn settles_in(&mut self, seconds: f64) {
        self.settling = seconds;
    }

    /// Another file, of the machine as it is. In place: it is large.
    pub(crate) fn begin(&mut self, machine: &AsItIs<'_>) {
        copy_program(self.program, machine.program);
        self.tuning.clone_from(machine.tuning);
        self.travel.clone_from(machine.travel);
        (self.homed, self.targets, self.most_celsius) = (machine.homed, machine.targets, machine.most_celsius);
        self.read_as(machine.dialect);
        if !machine.goes_on {
            // Another file's loops and subroutines are none of this one's.
            self.program.end_program();
        }
        self.forget_the_file();
    }

    /// Nothing has been read.
    pub(super) fn forget_the_file(&mut self) {
        self.files.clear();
        self.asks_of_rapids = false;
        (self.totals, self.once) = (Totals::default(), Once::default());
        self.costs.clear();
        (self.asked_acceleration, self.without_flow_limit) = (None, None);
        (self.line, self.begun) = (0, 0);
        (self.moves, self.has_begun, self.has_ended) = (false, false, false);
    }

    /// Sets the dialect, by the one that the file states.
    pub(crate) fn read_as(&mut self, dialect: Option<Dialect>) {
        let forced = program_setup::file_dialect(self.config);
        self.dialect = forced.or(dialect).unwrap_or(program_setup::dialect(self.config));
    }

    /// The program has ended before its file does.
    #[must_use]
    pub const fn has_ended(&self) -> bool {
        self.has_ended
    }

    /// Returns the totals of the file so far.
    #[must_use]
    pub const fn totals(&self) -> &Totals {
        &self.totals
    }

    /// Ends the turn, so that the work before or behind has one of its own.
    pub(super) async fn turn_alone(&mut self) {
        self.in_a_row = 0;
        end_turn().await;
    }

    /// A line or a block is done with: now and then everybody else gets a turn.
    pub(super) async fn turn(&mut self) {
        self.in_a_row += 1;
        if self.in_a_row >= IN_A_ROW {
            self.in_a_row = 0;
            end_turn().await;
        }
    }

    pub(super) const fn facts(&self) -> Facts {
        Facts { homed: self.homed, can_home: self.can_home }
    }

    /// The ends of travel, as they are now.
    pub(super) fn travel(&mut self) -> &Travel {
        self.travel.up_to_date(self.config, &self.tuning)
    }

    pub(super) const fn tag(&self) -> Tag {
        Tag(self.begun)
    }
}
