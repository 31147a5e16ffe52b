//! The interpreter: it holds what a program has set and says what each block means.

use gcode::{Block, Code, Letter};
use heapless::{Deque, Vec};
use units::{AxisSet, PerAxis};

use crate::action::{Action, ControlPoint, Effect, Function};
use crate::claims::Claim;
use crate::codes::{self, CodeInfo, Handler};
use crate::dialect::Dialect;
use crate::fault::Fault;
use crate::modal::{Modal, Saved};
use crate::park::ParkPosition;
use crate::setup::{HeaterSetup, Setup};
use crate::splines::Splines;
use crate::tools::Tools;
use crate::words::Words;

/// How deep M120 saves.
const SAVED_STATES: usize = 8;
/// Actions that can wait behind the first one of a block.
const FOLLOWING: usize = 4;
/// Claims of one code: every switch listens to it, and every heater.
pub(crate) const MOST_CLAIMS: usize = 16 + units::MAX_HEATERS;

/// What must be known of the machine to say what a block means.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Facts {
    /// Axes that are homed.
    pub homed: AxisSet,
    /// Axes that have a switch to home with.
    pub can_home: AxisSet,
}

impl Facts {
    /// Every axis that can be homed is.
    #[must_use]
    pub const fn all_homed(self) -> bool {
        self.homed.has_all(self.can_home)
    }
}

/// What a block means.
#[derive(Clone, Copy, Debug)]
pub enum Meaning<'b> {
    /// It changed how later words are read; the machine has nothing to do.
    Nothing,
    /// This is to be done, then what [`Interpreter::next_action`] gives.
    Action(Action<'b>),
    /// Nobody knows this code.
    Unknown,
}

pub(crate) const NOTHING: Result<Meaning<'static>, Fault> = Ok(Meaning::Nothing);

/// What a handler of a code has to go by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Context<'b> {
    pub words: Words<'b>,
    pub facts: Facts,
    pub dialect: Dialect,
    function: Option<Function>,
}

impl<'b> Context<'b> {
    /// The machine does it, as the row of the table says.
    pub const fn function(&self) -> Meaning<'b> {
        match self.function {
            Some(function) => Meaning::Action(Action::Function(function, self.words)),
            None => Meaning::Unknown,
        }
    }
}

/// The state of a program.
#[derive(Clone, Debug)]
pub struct Interpreter {
    pub(crate) modal: Modal,
    pub(crate) tools: Tools,
    pub(crate) splines: Splines,
    pub(crate) park: ParkPosition,
    /// Machine position where the last action ends.
    pub(crate) position: PerAxis<f64>,
    pub(crate) saved: Vec<Saved, SAVED_STATES>,
    pub(crate) compliant_seek_rate: bool,
    pub(crate) heaters: Vec<HeaterSetup, { units::MAX_HEATERS }>,
    /// X Y Z of the last G38, machine position in mm, and whether its contact was found.
    pub(crate) last_probe: ([f64; 3], bool),
    setup: Setup,
    effects: Deque<Effect, MOST_CLAIMS>,
    following: Deque<Action<'static>, FOLLOWING>,
    before: Before,
}

/// What the last block's moves change of the program, as it was before: the machine may refuse them.
#[derive(Clone, Copy, Debug, Default)]
struct Before {
    position: PerAxis<f64>,
    tool_offset: [f64; 3],
    /// E of the active tool, and the lift of Z that it is retracted with.
    e: f64,
    retracted: Option<f64>,
}

impl Interpreter {
    /// A program at its beginning.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let mut modal = Modal::new(setup.feed_rate, setup.seek_rate);
        modal.g92 = setup.g92;
        let position = PerAxis([0.0; units::MAX_AXES]);
        Self {
            modal,
            tools: Tools::new(&setup.tools),
            splines: Splines::default(),
            park: ParkPosition::default(),
            position,
            saved: Vec::new(),
            compliant_seek_rate: setup.compliant_seek_rate,
            heaters: setup.heaters.clone(),
            last_probe: ([0.0; 3], false),
            setup,
            effects: Deque::new(),
            following: Deque::new(),
            before: Before::default(),
        }
    }

    /// The row of the table that says how a block is read, and where it may run; `None` when nobody knows its
    /// code.
    #[must_use]
    pub fn row(&self, block: &Block<'_>) -> Option<&'static CodeInfo> {
        let code = block.code.unwrap_or(self.modal.motion.code());
        if code.letter == Letter::T {
            return Some(codes::TOOL);
        }
        let known = codes::find(code);
        if known.is_none() && self.setup.claims.may_have(code) {
            return self.setup.claims.of(code).next().map(codes::claimed);
        }
        known
    }

    /// What a question asks for: it changes nothing, and may be answered while a line is being carried out.
    /// `None` when the block is no question, or a word of it is wrong.
    #[must_use]
    pub fn question<'b>(&self, block: &'b Block<'b>) -> Option<(&'static CodeInfo, Function, Words<'b>)> {
        let row = self.row(block).filter(|row| row.waits == codes::Waits::Question)?;
        let (Handler::Function(function) | Handler::Both(_, function)) = row.handler else { return None };
        let words = Words::new(block, row, self.modal.inches);
        words.check().is_ok().then_some((row, function, words))
    }

    /// What a block means, read as its row says.
    ///
    /// # Errors
    /// What is wrong with it; nothing has changed then, unless the fault halts.
    pub fn run<'b>(
        &mut self,
        block: &'b Block<'b>,
        row: &'static CodeInfo,
        facts: Facts,
        dialect: Dialect,
    ) -> Result<Meaning<'b>, Fault> {
        self.effects.clear();
        self.following.clear();
        let (e, retracted) = self.tools.active().map_or((0.0, None), |tool| (tool.e, tool.retracted));
        self.before = Before { position: self.position, tool_offset: self.modal.tool_offset, e, retracted };
        let words = Words::new(block, row, self.modal.inches);
        words.check()?;
        let function = match row.handler {
            Handler::Function(function) | Handler::Both(_, function) => Some(function),
            _ => None,
        };
        let context = Context { words, facts, dialect, function };
        let claimed = block.code.filter(|code| self.setup.claims.may_have(*code));
        if let Some(meaning) = claimed.map(|code| self.claimed(code, &context)).transpose()?.flatten() {
            return Ok(meaning);
        }
        match row.handler {
            Handler::Interpret(interpret) | Handler::Both(interpret, _) => interpret(self, &context),
            Handler::Function(_) => Ok(context.function()),
            Handler::Tool => self.select_tool(context.words.code().number, words.column()),
            Handler::Nothing => NOTHING,
            Handler::Claimed if claimed.is_some() => NOTHING,
            Handler::Claimed => Ok(Meaning::Unknown),
        }
    }

    /// What switches and heaters that listen to a code do. Where it is a heater's, that is all the code does.
    fn claimed<'b>(&mut self, code: Code, context: &Context<'b>) -> Result<Option<Meaning<'b>>, Fault> {
        let claims: Vec<Claim, MOST_CLAIMS> = self.setup.claims.of(code).take(MOST_CLAIMS).collect();
        for claim in &claims {
            let effect = match *claim {
                Claim::SwitchOn(switch) => {
                    let value = context.words.get('S').map(|value| value as f32);
                    Effect::Switch { switch, on: true, value }
                }
                Claim::SwitchOff(switch) => Effect::Switch { switch, on: false, value: None },
                _ => continue,
            };
            self.by_the_way(effect);
        }
        let heats = claims.iter().find(|claim| !matches!(claim, Claim::SwitchOn(_) | Claim::SwitchOff(_)));
        heats.map(|claim| self.heat(*claim, &claims, context)).transpose()
    }

    /// What is to be done before the action of the last block.
    pub fn next_effect(&mut self) -> Option<Effect> {
        self.effects.pop_front()
    }

    /// An effect of a block beside its action.
    pub(crate) fn by_the_way(&mut self, effect: Effect) {
        let fits = self.effects.push_back(effect).is_ok();
        debug_assert!(fits, "a code is claimed {MOST_CLAIMS} times at most");
    }

    /// What is to be done behind the action of the last block.
    pub fn next_action(&mut self) -> Option<Action<'static>> {
        self.following.pop_front()
    }

    /// Whether nothing follows the action that was given last.
    #[must_use]
    pub fn is_last_action(&self) -> bool {
        self.following.is_empty()
    }

    /// Where the moves end that the last block makes behind its first one, in order. All are straight.
    pub fn moves_to_come(&self) -> impl Iterator<Item = &PerAxis<f64>> {
        self.following
            .iter()
            .filter_map(|action| if let Action::Move(request) = action { Some(&request.target) } else { None })
    }

    /// Something to do behind what the block does first.
    pub(crate) fn then(&mut self, action: Action<'static>) {
        let fits = self.following.push_back(action).is_ok();
        debug_assert!(fits, "a block has {FOLLOWING} more actions at most");
    }

    /// The last block's action was refused: the program is where it was before.
    pub fn take_back(&mut self) {
        self.following.clear();
        let Before { position, tool_offset, e, retracted } = self.before;
        self.position = position;
        self.modal.tool_offset = tool_offset;
        if let Some(tool) = self.tools.active_mut() {
            (tool.e, tool.retracted) = (e, retracted);
        }
    }

    /// The machine is somewhere else than the program left it: after a stop, homing, probing.
    pub fn resynchronise(&mut self, position: PerAxis<f64>) {
        self.following.clear();
        self.position = position;
    }

    /// The operator's halt, or a fault: nothing of the program goes on.
    pub fn halt(&mut self) {
        self.following.clear();
        self.modal.power = 0.0;
        self.modal.machine_next = false;
        self.splines = Splines::default();
    }

    // --- what it holds ---

    /// Machine position where the last action ends.
    #[must_use]
    pub const fn position(&self) -> &PerAxis<f64> {
        &self.position
    }

    /// Modes, offsets and rates.
    #[must_use]
    pub const fn modal(&self) -> &Modal {
        &self.modal
    }

    /// The extruders.
    #[must_use]
    pub const fn tools(&self) -> &Tools {
        &self.tools
    }

    /// The park position.
    #[must_use]
    pub const fn park(&self) -> &ParkPosition {
        &self.park
    }

    /// X Y Z of the last G38, machine position in mm, and whether its contact was found.
    #[must_use]
    pub const fn last_probe(&self) -> ([f64; 3], bool) {
        self.last_probe
    }

    /// The control points of the NURBS that the last action draws.
    #[must_use]
    pub fn control_points(&self) -> &[ControlPoint] {
        self.splines.closed()
    }

    /// Modes and E of the program as they are, to come back to.
    #[must_use]
    pub fn keep(&self) -> Kept {
        Kept { modal: self.modal.clone(), e: self.tools.active().map_or(0.0, |tool| tool.e) }
    }

    /// Comes back to what was kept.
    pub fn come_back_to(&mut self, kept: Kept) {
        self.modal = kept.modal;
        if let Some(tool) = self.tools.active_mut() {
            tool.e = kept.e;
        }
    }

    /// Counts in mm from now on; what it counted in before.
    pub fn count_in_mm(&mut self) -> bool {
        core::mem::take(&mut self.modal.inches)
    }

    /// Counts in inches, or in mm.
    pub const fn count_in_inches(&mut self, inches: bool) {
        self.modal.inches = inches;
    }

    /// M203 S: the rate of G0.
    pub const fn set_seek_rate(&mut self, rate: units::MmPerSecond) {
        self.modal.seek_rate = rate;
    }

    /// G30 Z: a contact at this height of the machine reads as given, both in mm.
    pub fn read_contact(&mut self, machine_z: f64, reads: f64) {
        self.modal.set_g92(units::Axis::Z, reads, machine_z);
    }

    /// Where a G38 ended, and whether it found its contact.
    pub const fn set_last_probe(&mut self, place: [f64; 3], found: bool) {
        self.last_probe = (place, found);
    }
}

/// What a program goes on with after somebody worked at the machine.
#[derive(Clone, Debug)]
pub struct Kept {
    modal: Modal,
    e: f64,
}
