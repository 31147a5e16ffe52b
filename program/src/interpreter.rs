//! What a program has set, and what it has done: the state that each block is read in. What blocks mean is in
//! [`crate::meaning`], which block means what in [`crate::codes`].

use gcode::Code;
use heapless::{Deque, Vec};
use units::{Axis, MmPerSecond, PerAxis};

use crate::action::{Action, ControlPoint, Corner, Effect, Move, Rate, Shape};
use crate::auxiliary::Spindle;
use crate::claims::{Claim, MOST_CLAIMS};
use crate::cycles::{Cycles, LeftHole, Series, ToCome};
use crate::flow::Flow;
use crate::holes::Next;
use crate::left_out::LeftOut;
use crate::memory::Memory;
use crate::modal::{Modal, MotionMode, Saved};
use crate::park::ParkPosition;
use crate::rotation::Rotations;
use crate::saved_modes::SavedFrames;
use crate::setup::{HeaterSetup, Setup};
use crate::splines::Splines;
use crate::tool_table::ToolTable;
use crate::tools::Tools;

/// How deep M120 saves.
const SAVED_STATES: usize = 8;
/// What a block does beside its action: a code is claimed so often, and M72 has the switches of four.
const MOST_EFFECTS: usize = MOST_CLAIMS + 16;
/// Actions that can wait behind the first one of a block.
const FOLLOWING: usize = 4;

/// The state of a program.
#[derive(Clone, Debug)]
pub struct Interpreter {
    pub(crate) modal: Modal,
    pub(crate) tools: Tools,
    pub(crate) splines: Splines,
    pub(crate) cycles: Cycles,
    pub(crate) park: ParkPosition,
    pub(crate) second_park: Option<ParkPosition>,
    /// Machine position where the last action ends.
    pub(crate) position: PerAxis<f64>,
    pub(crate) saved: Vec<Saved, SAVED_STATES>,
    pub(crate) compliant_seek_rate: bool,
    pub(crate) heaters: Vec<HeaterSetup, { units::MAX_HEATERS }>,
    /// X Y Z of the last G38, machine position in mm, and whether its contact was found.
    pub(crate) last_probe: ([f64; 3], bool),
    pub(crate) memory: Memory,
    pub(crate) flow: Flow,
    pub(crate) frames: SavedFrames,
    /// What the last M66 has found: `#5399`.
    pub(crate) input_result: f64,
    /// `#5599`: `(DEBUG, ...)` is said.
    pub(crate) debugs: bool,
    /// `#<_line>`: the line of the file that is played; 0 without one.
    pub(crate) line: u32,
    pub(crate) setup: Setup,
    pub(crate) left_out: Option<LeftOut>,
    pub(crate) effects: Deque<Effect, MOST_EFFECTS>,
    pub(crate) following: Deque<Action<'static>, FOLLOWING>,
    pub(crate) before: Before,
}

/// What the last block's moves change of the program, as it was before: the machine may refuse them.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Before {
    position: PerAxis<f64>,
    tool_offset: [f64; 3],
    shift: [f64; 3],
    thermal_z: f64,
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
            cycles: Cycles::default(),
            park: ParkPosition::default(),
            second_park: None,
            position,
            saved: Vec::new(),
            compliant_seek_rate: setup.compliant_seek_rate,
            heaters: setup.heaters.clone(),
            last_probe: ([0.0; 3], false),
            memory: Memory::default(),
            flow: Flow::default(),
            frames: SavedFrames::default(),
            input_result: 0.0,
            debugs: true,
            line: 0,
            setup,
            left_out: None,
            effects: Deque::new(),
            following: Deque::new(),
            before: Before::default(),
        }
    }

    /// A block begins: what the one before left to do is forgotten.
    #[inline]
    pub(crate) fn begin_block(&mut self) {
        self.effects.clear();
        self.following.clear();
        self.cycles.stop();
        let (e, retracted) = self.tools.active().map_or((0.0, None), |tool| (tool.e, tool.retracted));
        let (tool_offset, shift) = (self.modal.tool_offset, self.modal.shift);
        let thermal_z = self.modal.thermal_z;
        self.before = Before { position: self.position, tool_offset, shift, thermal_z, e, retracted };
    }

    /// What is to be done before the action of the last block.
    pub fn next_effect(&mut self) -> Option<Effect> {
        self.effects.pop_front()
    }

    /// An effect of a block beside its action.
    pub(crate) fn by_the_way(&mut self, effect: Effect) {
        let fits = self.effects.push_back(effect).is_ok();
        debug_assert!(fits, "a block has {MOST_EFFECTS} effects at most");
    }

    /// What an M-code of spindle or coolant switches: the next effects.
    pub(crate) fn switch(&mut self, number: u16) {
        for place in 0.. {
            let Some(claim) = self.setup.claims.of(Code::m(number)).nth(place) else { return };
            let (switch, on) = match claim {
                Claim::SwitchOn(switch) => (switch, true),
                Claim::SwitchOff(switch) => (switch, false),
                _ => continue,
            };
            let speed = self.modal.auxiliary.speed.filter(|_| on && number < 5);
            let value = speed.map(|speed| self.setup.value_of_s(switch, speed));
            self.by_the_way(Effect::Switch { switch, on, value });
        }
    }

    /// The spindle turns like this: what that switches are the next effects. From one way to the other it
    /// stops.
    pub(crate) fn turn_spindle(&mut self, spindle: Spindle) {
        if spindle.is_against(self.modal.auxiliary.spindle) {
            self.switch(Spindle::Stopped.code());
        }
        self.modal.auxiliary.spindle = spindle;
        self.switch(spindle.code());
    }

    /// What is to be done behind the action of the last block, or behind what this gave before, which has
    /// been taken.
    pub fn next_action(&mut self) -> Option<Action<'static>> {
        if let Some(action) = self.following.pop_front() {
            return Some(action);
        }
        if self.cycles.is_done() {
            return None;
        }
        self.before.position = self.position;
        while let Some(spindle) = self.cycles.turning() {
            if self.effects.is_empty() {
                self.turn_spindle(spindle);
            }
            let effect = self.effects.pop_front();
            if self.effects.is_empty() {
                self.cycles.next();
            }
            if let Some(effect) = effect {
                return Some(Action::Effect(effect));
            }
        }
        let Next::Action(action) = self.cycles.next()? else { return None };
        self.before.retracted = self.tools.active().and_then(|tool| tool.retracted);
        self.follow(&action);
        Some(action)
    }

    /// The operator draws the tool out of a hole (G88): nothing of its block goes on until
    /// [`Self::return_to`] it.
    pub const fn leave_hole(&mut self) -> LeftHole {
        self.cycles.leave_hole(self.modal.cycle)
    }

    /// He has, and the machine is where the program was told last. False when he has drilled other holes
    /// meanwhile: then nothing goes on.
    #[must_use]
    pub fn return_to(&mut self, left: &LeftHole) -> bool {
        if !self.cycles.return_to(left, self.position) {
            return false;
        }
        (self.modal.motion, self.modal.cycle) = (MotionMode::Cycle, left.cycle());
        self.before.position = self.position;
        true
    }

    /// The program has then made this move of a cycle.
    pub(crate) const fn follow(&mut self, action: &Action<'_>) {
        if let Action::Move(request) = action {
            self.position = request.target;
        }
    }

    /// Whether an effect or an action waits that has not been given.
    #[must_use]
    pub fn has_more(&self) -> bool {
        !self.effects.is_empty() || !self.is_last_action()
    }

    /// Whether nothing follows the action that was given last.
    #[must_use]
    pub fn is_last_action(&self) -> bool {
        self.following.is_empty() && self.cycles.is_done()
    }

    /// Places, in order, between which the moves lie that the last block makes behind the one given last. All
    /// are straight.
    pub fn moves_to_come(&self) -> ToCome {
        let mut places = self.cycles.to_come();
        for action in &self.following {
            if let Action::Move(request) = action {
                // What follows and a cycle's moves are never of one block: there is room.
                let _ = places.push(request.target);
            }
        }
        places
    }

    /// Something to do behind what the block does first.
    pub(crate) fn then(&mut self, action: Action<'static>) {
        let fits = self.following.push_back(action).is_ok();
        debug_assert!(fits, "a block has {FOLLOWING} more actions at most");
    }

    /// The move there, which the program has then made.
    // On its own the action is made where the caller's caller wants it; else it is copied there.
    #[inline(never)]
    pub(crate) fn draw<'b>(&mut self, target: PerAxis<f64>, shape: Shape, names_z: bool) -> Action<'b> {
        let rate = match self.modal.motion {
            MotionMode::Rapid => Rate::Rapid(self.modal.seek_rate),
            _ => Rate::Feed(self.modal.feed_rate),
        };
        self.position = target;
        self.tools.moved(names_z);
        Action::Move(Move { target, shape, rate, power: self.modal.power, corner: self.modal.corner })
    }

    /// A rapid move in a straight line, which the program has then made.
    pub(crate) fn rapid_to<'b>(&mut self, target: PerAxis<f64>) -> Action<'b> {
        self.position = target;
        let rate = Rate::Rapid(self.modal.seek_rate);
        let shape = Shape::Line { names_xy: true };
        Action::Move(Move { target, shape, rate, power: self.modal.power, corner: self.modal.corner })
    }

    /// A move of one axis at a rate of its own, which the program has then made.
    pub(crate) fn move_by<'b>(&mut self, axis: Axis, by: f64, rate: MmPerSecond) -> Action<'b> {
        let mut target: PerAxis<f64> = self.position;
        target[axis] += by;
        self.position = target;
        Action::Move(Move {
            target,
            shape: Shape::Line { names_xy: false },
            rate: Rate::Feed(rate),
            power: self.modal.power,
            corner: Corner::Sharp,
        })
    }

    /// The last block's action was refused: the program is where it was before. Of a cycle that is where the
    /// action before it ended.
    pub fn take_back(&mut self) {
        self.following.clear();
        self.cycles.take_back();
        let Before { position, tool_offset, shift, thermal_z, e, retracted } = self.before;
        self.position = position;
        (self.modal.tool_offset, self.modal.shift, self.modal.thermal_z) = (tool_offset, shift, thermal_z);
        if let Some(tool) = self.tools.active_mut() {
            (tool.e, tool.retracted) = (e, retracted);
        }
    }

    /// The machine is somewhere else than the program left it: after a stop, homing, probing.
    pub fn resynchronise(&mut self, position: PerAxis<f64>) {
        // What is left out has not moved it.
        if let Some(left_out) = &mut self.left_out {
            if left_out.stays_at(&position) {
                return;
            }
            left_out.take_place();
        }
        self.following.clear();
        self.cycles.stop();
        self.position = position;
    }

    /// Where it was before the last action that it gave.
    pub(crate) const fn before(&self) -> PerAxis<f64> {
        self.before.position
    }

    /// The operator's halt, or a fault: nothing of the program goes on.
    pub fn halt(&mut self) {
        self.following.clear();
        self.left_out = None;
        self.flow.reset();
        self.frames.clear();
        self.memory.end();
        self.end_cycles();
        (self.modal.auxiliary.mist, self.modal.auxiliary.flood) = (false, false);
        self.modal.auxiliary.spindle = Spindle::Stopped;
        self.modal.power = 0.0;
        self.modal.machine_next = false;
        self.splines = Splines::default();
    }

    /// Words without a code drill no more holes.
    pub fn end_cycles(&mut self) {
        self.cycles.stop();
        self.cycles.set_series(Series::default());
        if self.modal.motion == MotionMode::Cycle {
            self.modal.motion = MotionMode::Cancelled;
        }
    }

    /// Modes are as at boot; coordinate systems, tools and the park position stay (GRBL's reset).
    pub fn reset(&mut self) {
        self.halt();
        self.saved.clear();
        let (systems, rotations) = (self.modal.systems, self.modal.rotations);
        self.modal = Modal::new(self.setup.feed_rate, self.modal.seek_rate);
        (self.modal.systems, self.modal.rotations) = (systems, rotations);
    }

    /// Coordinate systems, G92 and the park position are as at first.
    pub fn clear_offsets(&mut self) {
        self.modal.systems = Default::default();
        self.modal.rotations = Rotations::NONE;
        self.modal.g92 = self.setup.g92;
        self.park = ParkPosition::default();
        self.second_park = None;
        crate::parameters::offsets_changed(self);
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

    /// What is known of the tools that go into the spindle.
    pub const fn tool_table(&mut self) -> &mut ToolTable {
        &mut self.tools.table
    }

    /// The park position.
    #[must_use]
    pub const fn park(&self) -> &ParkPosition {
        &self.park
    }

    /// The park position of G30, where one has been stored.
    #[must_use]
    pub const fn second_park(&self) -> Option<&ParkPosition> {
        self.second_park.as_ref()
    }

    /// Z of the park position of G28 or G30, where it takes part.
    pub(crate) fn parked_z(&self, number: u16) -> Option<f64> {
        if number == 30 { self.second_park.and_then(|place| place.z) } else { self.park.z }
    }

    /// Stores the park position of G28 or G30.
    pub(crate) const fn store_park(&mut self, number: u16, place: ParkPosition) {
        match number {
            30 => self.second_park = Some(place),
            _ => self.park = place,
        }
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
        let series = *self.cycles.series();
        Kept { series, modal: self.modal.clone(), e: self.tools.active().map_or(0.0, |tool| tool.e) }
    }

    /// Comes back to what was kept. What makes up for temperature is the machine's, and is as it is now.
    pub fn come_back_to(&mut self, kept: Kept) {
        let thermal_z = self.modal.thermal_z;
        self.modal = kept.modal;
        self.modal.set_thermal_z(thermal_z);
        self.cycles.set_series(kept.series);
        if let Some(tool) = self.tools.active_mut() {
            tool.e = kept.e;
        }
    }

    /// Z is so much higher from the next move on that names it, mm.
    pub fn set_thermal_z(&mut self, mm: f64) {
        self.modal.set_thermal_z(mm);
    }

    /// What is extruded along the path from now on is this much of what the program says, with this extruder.
    pub fn set_width_factor(&mut self, extruder: units::ToolId, factor: f64) {
        self.tools.set_width_factor(extruder, factor);
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
    pub const fn set_seek_rate(&mut self, rate: MmPerSecond) {
        self.modal.seek_rate = rate;
    }

    /// G30 Z: a contact at this height of the machine reads as given, both in mm.
    pub fn read_contact(&mut self, machine_z: f64, reads: f64) {
        let mut contact = self.position;
        contact[Axis::Z] = machine_z;
        self.modal.set_g92(Axis::Z, reads, &contact);
    }

    /// The operator's overrides count, whatever the program has said of them.
    pub const fn let_overrides_count(&mut self) {
        let modes = &mut self.modal.auxiliary;
        (modes.feed_override, modes.spindle_override) = (true, true);
    }

    /// M66: 1 or 0 as the input was found, -1 where nothing came of it in time.
    pub const fn set_input_result(&mut self, value: f64) {
        self.input_result = value;
    }

    /// The line of the file that is played, counted from 1: `#<_line>`.
    #[inline]
    pub const fn at_line(&mut self, line: u32) {
        self.line = line;
    }

    /// Whether `(DEBUG, ...)` is said (`#5599`).
    #[must_use]
    pub const fn debugs(&self) -> bool {
        self.debugs
    }

    /// Where a G38 ended, and whether it found its contact.
    pub const fn set_last_probe(&mut self, place: [f64; 3], found: bool) {
        self.last_probe = (place, found);
    }
}

/// Modes and E of a program, to go on with after somebody worked at the machine.
#[derive(Clone, Debug)]
pub struct Kept {
    pub(crate) modal: Modal,
    pub(crate) series: Series,
    pub(crate) e: f64,
}
