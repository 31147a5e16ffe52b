//! A file on its way through a preflight: the program's state, and the totals so far.

use base::failure::{ShortText, Texts, short};
use base::laser::LaserScale;
use base::motion_config::motion_config;
use base::program_setup;
use base::safety::travel::Travel;
use base::sessions::LineBytes;
use base::taken_codes::TakenCodes;
use base::tuning::Tuning;
use config::MachineConfig;
use gcode::Code;
use jobs::player::MOST_CALLERS;
use motion::{Motion, Passage, Tag};
use procedures::leveling::words::configured as configured_skew;
use program::{Action, CodeInfo, Dialect, Effect, Facts, Interpreter, Remark, copy_program};
use units::{Axis, AxisSet, Celsius, MAX_HEATERS, MmPerSecond, PerAxis};

use super::cost::Costs;
use super::finding::{Finding, Kind, Once, SubName};
use super::kept_modes::KeptModes;
use super::limits::Limit;
use super::macro_calls::{Called, MacroCall, MacroPlace};
use super::turns::end_turn;

/// Greatest number of lines that are read: loops may have no end.
pub const MOST_LINES: u32 = 20_000_000;

/// Number of blocks and lines before everybody else gets a turn: a tenth of a millisecond on the board.
const IN_A_ROW: u8 = 4;

/// Receiver of what a preflight finds.
pub trait Listener {
    /// Hears of a fault in the file.
    fn found(&mut self, finding: &Finding);

    /// Takes a block of the look-ahead queue that has been passed, along [`Motion::passed_path`].
    fn passed(&mut self, _passage: &Passage, _motion: &Motion) {}

    /// Hears which object the lines behind this one make, with the text of M486. Lines are counted here as
    /// tags of moves are: each that is no comment, as often as it is carried out.
    fn labelled(&mut self, _line: u32, _text: &str) {}

    /// Hears that the machine waits for so many seconds at this line, counted as for `labelled`.
    fn waited(&mut self, _line: u32, _seconds: f64) {}

    /// Whether what follows need not be read.
    fn has_heard_enough(&self) -> bool {
        false
    }

    /// Hears an action before it is followed. False: nothing is to come of it.
    ///
    /// # Errors
    /// With what is wrong with it.
    fn acts(&mut self, _action: &Action<'_>) -> Result<bool, ShortText> {
        Ok(true)
    }

    /// Hears an effect that a code has beside its action. False: nothing is to come of it.
    fn acts_on_the_way(&mut self, _effect: Effect) -> bool {
        true
    }

    /// Hears a comment with a meaning.
    fn remarks(&mut self, _remark: Remark<'_>, _program: &Interpreter) {}

    /// Hears a command of the console.
    ///
    /// # Errors
    /// With what is wrong with it.
    fn commands(&mut self, _text: &str) -> Result<(), ShortText> {
        Ok(())
    }

    /// Hears of a code that is not carried out, and of its row. False: nothing is to be said of it.
    ///
    /// # Errors
    /// With what is wrong with it.
    fn leaves_out(&mut self, _row: Option<&CodeInfo>, _code: Code) -> Result<bool, ShortText> {
        Ok(true)
    }

    /// Looks for the macro of a call, and renders it. None: not yet; ask again.
    fn called(&mut self, _call: MacroCall<'_>) -> Option<Called> {
        Some(Called::Nothing)
    }

    /// Writes the next line of the macros that were called, and its place. None: not yet; ask again.
    fn macro_line(&mut self, _line: &mut LineBytes, _place: &mut MacroPlace) -> Option<Called> {
        Some(Called::Nothing)
    }
}

/// Totals of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Number of lines read.
    pub lines: u32,
    /// Time of moves at even speed, seconds.
    pub even_seconds: f64,
    /// Time of moves whose speed changes, seconds.
    pub ramp_seconds: f64,
    /// Time of dwells, and of coming to a standstill and from it, seconds.
    pub waiting_seconds: f64,
    /// Time of homing, by the configured ways and speeds, seconds.
    pub homing_seconds: f64,
    /// Time lost to limits, seconds, in the order of [`Limit::ALL`].
    pub limits: [f64; Limit::COUNT],
    /// Filament that moves feed, mm.
    pub filament: f64,
    /// Path of moves that feed filament, mm.
    pub printed: f64,
    /// Path of moves that feed none, mm.
    pub travelled: f64,
    /// Least and greatest places, mm; none where nothing moved.
    pub extents: Option<[PerAxis<f64>; 2]>,
    /// Number of waits for a temperature.
    pub heat_waits: u32,
    /// Number of waits for each heater, and the highest temperature waited for.
    pub heats: [(u32, Celsius); MAX_HEATERS],
    /// Number of findings that stop the job.
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

    /// Returns the time of everything but heating, seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.even_seconds + self.ramp_seconds + self.waiting_seconds + self.homing_seconds
    }
}

/// A machine in the middle of its work.
#[derive(Clone, Copy, Debug)]
pub struct AsItIs<'m> {
    /// Program with all that it has been told.
    pub program: &'m Interpreter,
    /// Settings that codes have changed.
    pub tuning: &'m Tuning,
    /// Travel of the axes.
    pub travel: &'m Travel,
    /// Axes that are homed.
    pub homed: AxisSet,
    /// Targets of the heaters.
    pub targets: [Celsius; MAX_HEATERS],
    /// The highest temperatures that heaters may have.
    pub most_celsius: [Celsius; MAX_HEATERS],
    /// Dialect that the file states.
    pub dialect: Option<Dialect>,
    /// Codes that macros have taken.
    pub taken: TakenCodes,
    /// The file is to go on with the program, loops and subroutines included.
    pub goes_on: bool,
}

/// Never inlined: its parts are on the stack meanwhile.
#[inline(never)]
fn new_program<'p>(config: &MachineConfig, place: &'p mut Option<Interpreter>) -> &'p mut Interpreter {
    place.insert(Interpreter::new(program_setup::setup(config)))
}

/// State of a file's preflight.
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
    /// Height up to which a mesh fades, and its offset left there, where a code has said so, mm.
    pub(super) fade: (Option<f64>, Option<f64>),
    /// Line that has loaded a mesh first.
    pub(super) loads_mesh: Option<u32>,
    /// The file holds saved settings, and no job.
    pub(super) reads_settings: bool,
    /// Files of subroutines that are open, the last one being read.
    pub(super) files: heapless::Vec<SubName, MOST_CALLERS>,
    /// Subroutine that was called, which may have a file of its own.
    pub(super) called: SubName,
    /// Time of a standstill, seconds.
    pub(super) settling: f64,
    /// Codes that macros have taken.
    pub(super) taken: TakenCodes,
    /// A macro was called whose lines come next.
    pub(super) calls_macros: bool,
    /// Line of a macro that is read.
    pub(super) within: Option<MacroPlace>,
    /// The line of a macro that is read has depended on the state of the machine.
    pub(super) is_guess: bool,
    /// What macros do has depended on the state of the machine, or is not known.
    pub(super) guesses: bool,
    /// A macro of which nothing is known may have set targets.
    pub(super) may_be_hot: bool,
    /// Modes that were kept by names.
    pub(super) kept: KeptModes,
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
    /// Speed of the move at hand, were there no limit of flow.
    pub(super) without_flow_limit: Option<MmPerSecond>,
    pub(super) line: u32,
    /// Number of lines that are no comments, each as often as it was carried out.
    pub(super) begun: u32,
    pub(super) has_begun: bool,
    pub(super) has_ended: bool,
    /// Number of blocks and lines since everybody else had a turn.
    in_a_row: u8,
}

impl<'c> Preflight<'c> {
    /// Makes the state of a machine that was just switched on. `motion` is set up for it, and `program` holds
    /// its program, which is large; `dialect` is the one that the file states, if any.
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
        // The machine says at boot which laser motion does not take, and goes without it.
        let _ = motion.configure_laser(LaserScale::new(config).in_motions_terms(config));
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

    /// Makes the state without a file.
    pub fn of_nothing(config: &'c MachineConfig, texts: &'c Texts, program: &'c mut Option<Interpreter>) -> Self {
        let homes = |axis: &Axis| config.homing_endstop(*axis).is_some();
        Self {
            config,
            texts,
            program: new_program(config, program),
            tuning: Tuning::new(config),
            travel: Travel::default(),
            homed: AxisSet::NONE,
            can_home: AxisSet::collect(Axis::ALL.into_iter().filter(homes)),
            dialect: config.general.usual_dialect(),
            targets: [Celsius(0.0); MAX_HEATERS],
            most_celsius: [Celsius(0.0); MAX_HEATERS],
            fade: (None, None),
            loads_mesh: None,
            reads_settings: false,
            files: heapless::Vec::new(),
            called: SubName::new(),
            settling: 0.0,
            taken: TakenCodes::None,
            calls_macros: false,
            within: None,
            is_guess: false,
            guesses: false,
            may_be_hot: false,
            kept: KeptModes::new(),
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

    /// Only interprets, by this program, on a machine that has all parts and is homed; the listener follows
    /// the actions.
    pub fn only_listens(&mut self, program: Interpreter, dialect: Dialect) {
        (*self.program, self.dialect) = (program, dialect);
        (self.homed, self.can_home) = (AxisSet::PRIMARY, AxisSet::PRIMARY);
        // Nothing is without leveling.
        self.reads_settings = true;
    }

    /// Sets which codes macros have taken.
    pub const fn takes(&mut self, taken: TakenCodes) {
        self.taken = taken;
    }

    /// Sets the time of each standstill, seconds.
    pub const fn settles_in(&mut self, seconds: f64) {
        self.settling = seconds;
    }

    /// Begins another file, for the machine as it is. In place: the state is large.
    pub fn begin(&mut self, machine: &AsItIs<'_>) {
        copy_program(self.program, machine.program);
        self.tuning.clone_from(machine.tuning);
        self.travel.clone_from(machine.travel);
        (self.homed, self.targets, self.most_celsius) = (machine.homed, machine.targets, machine.most_celsius);
        self.taken = machine.taken;
        self.read_as(machine.dialect);
        if !machine.goes_on {
            // Loops and subroutines of another file are none of this file's.
            self.program.end_program();
        }
        self.forget_the_file();
    }

    /// Forgets everything read of a file.
    pub(super) fn forget_the_file(&mut self) {
        self.files.clear();
        self.asks_of_rapids = false;
        (self.totals, self.once) = (Totals::default(), Once::default());
        self.costs.clear();
        (self.asked_acceleration, self.without_flow_limit) = (None, None);
        (self.line, self.begun) = (0, 0);
        (self.moves, self.has_begun, self.has_ended) = (false, false, false);
        (self.calls_macros, self.guesses, self.may_be_hot) = (false, false, false);
        self.within = None;
        self.kept.clear();
    }

    /// Sets the dialect, by the one that the file states.
    pub fn read_as(&mut self, dialect: Option<Dialect>) {
        let forced = self.config.player.dialect;
        self.dialect = forced.or(dialect).unwrap_or(self.config.general.usual_dialect());
    }

    /// Whether the program has ended before its file does.
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

    /// Gives everybody else a turn now and then; called after each line or block.
    pub(super) async fn turn(&mut self) {
        self.in_a_row += 1;
        if self.in_a_row >= IN_A_ROW {
            self.in_a_row = 0;
            end_turn().await;
        }
    }

    /// Whether more lines have been carried out than any file needs, and reports that.
    pub fn is_endless(&self, listener: &mut dyn Listener) -> bool {
        let is_endless = self.totals.lines > MOST_LINES;
        if is_endless {
            let text = format_args!("more than {MOST_LINES} lines are carried out: what follows is not looked at");
            listener.found(&self.finding(self.line, Kind::Unforeseen, short(text)));
        }
        is_endless
    }

    /// Returns a finding at this line of the file being read.
    pub(super) fn finding(&self, line: u32, kind: Kind, what: ShortText) -> Finding {
        Finding { sub: self.files.last().cloned(), line, kind, what }
    }

    pub(super) fn facts(&self) -> Facts {
        let [.., probe_height] = self.config.probe_offsets();
        Facts { homed: self.homed, can_home: self.can_home, probe_height }
    }

    /// Returns the ends of travel, as they are now.
    pub(super) fn travel(&mut self) -> &Travel {
        self.travel.up_to_date(self.config, &self.tuning)
    }

    pub(super) const fn tag(&self) -> Tag {
        Tag(self.begun)
    }
}
