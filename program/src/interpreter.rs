//! State of a program, in which each block is read: modes and offsets set so far, and the position reached.
//! [`crate::meaning`] has the meaning of blocks, [`crate::codes`] the table that assigns meanings to codes.

use gcode::Code;
use heapless::{Deque, Vec};
use units::{Axis, ControlPoint, MmPerSecond, PerAxis};

use crate::action::{Action, Effect, Move, Rate, Shape};
use crate::cycles::holes::Next;
use crate::cycles::{Cycles, LeftHole, Series, ToCome};
use crate::flow::Flow;
use crate::flow::memory::Memory;
use crate::state::auxiliary::Spindle;
use crate::state::claims::{Claim, MOST_CLAIMS};
use crate::state::kept::{Before, Kept};
use crate::state::left_out_objects::LeftOut;
use crate::state::modal::{Modal, MotionMode, Saved};
use crate::state::park::ParkPosition;
use crate::state::pixels::Pixels;
use crate::state::rotation::Rotations;
use crate::state::saved_modes::SavedFrames;
use crate::state::setup::{HeaterSetup, Setup};
use crate::state::splines::Splines;
use crate::state::tool_table::ToolTable;
use crate::state::tools::Tools;

/// Greatest depth of states saved by M120.
const SAVED_STATES: usize = 8;
/// Most effects of a block beside its action: all claims of a code, or the switches of four codes (M72).
const MOST_EFFECTS: usize = MOST_CLAIMS + 16;
/// Most actions that can wait behind the first action of a block.
const FOLLOWING: usize = 4;

/// State of a program.
#[derive(Clone, Debug)]
pub struct Interpreter {
    pub(crate) modal: Modal,
    pub(crate) tools: Tools,
    pub(crate) splines: Splines,
    pub(crate) cycles: Cycles,
    pub(crate) park: ParkPosition,
    pub(crate) second_park: Option<ParkPosition>,
    /// Machine position at the end of the last action.
    pub(crate) position: PerAxis<f64>,
    pub(crate) saved: Vec<Saved, SAVED_STATES>,
    pub(crate) compliant_seek_rate: bool,
    pub(crate) heaters: Vec<HeaterSetup, { units::MAX_HEATERS }>,
    /// X Y Z of the last G38, machine position in mm, and whether its contact was found.
    pub(crate) last_probe: ([f64; 3], bool),
    pub(crate) memory: Memory,
    pub(crate) flow: Flow,
    pub(crate) frames: SavedFrames,
    /// Result of the last M66: `#5399`.
    pub(crate) input_result: f64,
    /// Whether `(DEBUG, ...)` is printed (`#5599`).
    pub(crate) debugs: bool,
    /// Line number of the file that is played (`#<_line>`); 0 without a file.
    pub(crate) line: u32,
    pub(crate) setup: Setup,
    pub(crate) left_out: Option<LeftOut>,
    pub(crate) effects: Deque<Effect, MOST_EFFECTS>,
    pub(crate) following: Deque<Action<'static>, FOLLOWING>,
    /// Pixels that are left of the line of the last action.
    pub(crate) pixels: Pixels,
    pub(crate) before: Before,
}

impl Interpreter {
    /// Creates a program at its beginning.
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
            pixels: Pixels::default(),
            before: Before::default(),
        }
    }

    /// Begins a block and drops what remains of the previous block.
    #[inline]
    pub(crate) fn begin_block(&mut self) {
        self.effects.clear();
        self.following.clear();
        self.pixels.clear();
        self.cycles.stop();
        let (e, retracted) = self.tools.active().map_or((0.0, None), |tool| (tool.e, tool.retracted));
        let (tool_offset, shift) = (self.modal.tool_offset, self.modal.shift);
        let thermal_z = self.modal.thermal_z;
        self.before = Before { position: self.position, tool_offset, shift, thermal_z, e, retracted };
    }

    /// Returns the next effect to apply before the action of the last block.
    pub fn next_effect(&mut self) -> Option<Effect> {
        self.effects.pop_front()
    }

    /// Queues an effect of a block beside its action.
    pub(crate) fn by_the_way(&mut self, effect: Effect) {
        let fits = self.effects.push_back(effect).is_ok();
        debug_assert!(fits, "a block has {MOST_EFFECTS} effects at most");
    }

    /// Queues the switching that an M-code of spindle or coolant causes.
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

    /// Changes the spindle's direction and queues the switching as effects. Reversing switches the spindle
    /// off first.
    pub(crate) fn turn_spindle(&mut self, spindle: Spindle) {
        if spindle.is_against(self.modal.auxiliary.spindle) {
            self.switch(Spindle::Stopped.code());
        }
        self.modal.auxiliary.spindle = spindle;
        self.switch(spindle.code());
    }

    /// Returns the next action behind the last block's first action. The previous action must have been
    /// carried out.
    pub fn next_action(&mut self) -> Option<Action<'static>> {
        if let Some(action) = self.following.pop_front() {
            return Some(action);
        }
        if !self.pixels.is_empty() {
            self.before.position = self.position;
            return self.next_pixel();
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

    /// Suspends the block while the operator draws the tool out of a hole (G88), until [`Self::return_to`].
    pub const fn leave_hole(&mut self) -> LeftHole {
        self.cycles.leave_hole(self.modal.cycle)
    }

    /// Goes on with a hole from the last reported position, once the operator has drawn the tool out. Returns
    /// false, and does nothing, when the operator has drilled other holes meanwhile.
    #[must_use]
    pub fn return_to(&mut self, left: &LeftHole) -> bool {
        if !self.cycles.return_to(left, self.position) {
            return false;
        }
        (self.modal.motion, self.modal.cycle) = (MotionMode::Cycle, left.cycle());
        self.before.position = self.position;
        true
    }

    /// Moves the program's position to the end of this move of a cycle.
    pub(crate) const fn follow(&mut self, action: &Action<'_>) {
        if let Action::Move(request) = action {
            self.position = request.target;
        }
    }

    /// Whether an effect or an action still waits to be taken.
    #[must_use]
    pub fn has_more(&self) -> bool {
        !self.effects.is_empty() || !self.is_last_action()
    }

    /// Whether nothing follows the action that was given last.
    #[must_use]
    pub fn is_last_action(&self) -> bool {
        self.following.is_empty() && self.cycles.is_done() && self.pixels.is_empty()
    }

    /// Returns positions, in order, whose path bounds the last block's remaining moves, all of them straight.
    pub fn moves_to_come(&self) -> ToCome {
        let mut places = self.cycles.to_come();
        for action in &self.following {
            if let Action::Move(request) = action {
                // A block never has both queued actions and a cycle's moves, so there is room.
                let _ = places.push(request.target);
            }
        }
        if let Some(end) = self.pixels.end() {
            // Nor both pixels and any of these.
            let _ = places.push(end);
        }
        places
    }

    /// Queues an action behind the first action of the block.
    pub(crate) fn then(&mut self, action: Action<'static>) {
        let fits = self.following.push_back(action).is_ok();
        debug_assert!(fits, "a block has {FOLLOWING} more actions at most");
    }

    /// Returns the move to a position, and moves the program's position there.
    // Not inlined, so that the action is built in the outer caller's place instead of being copied there.
    #[inline(never)]
    pub(crate) fn draw<'b>(&mut self, target: PerAxis<f64>, shape: Shape, names_z: bool) -> Action<'b> {
        let rate = match self.modal.motion {
            MotionMode::Rapid => Rate::Rapid(self.modal.seek_rate),
            _ => Rate::Feed(self.modal.feed_rate),
        };
        self.position = target;
        self.tools.moved(names_z);
        Action::Move(self.by_modes(target, shape, rate))
    }

    /// Returns a straight rapid move, and moves the program's position to its end.
    pub(crate) fn rapid_to<'b>(&mut self, target: PerAxis<f64>) -> Action<'b> {
        self.position = target;
        let rate = Rate::Rapid(self.modal.seek_rate);
        let shape = Shape::Line { names_xy: true };
        Action::Move(self.by_modes(target, shape, rate))
    }

    fn by_modes(&self, target: PerAxis<f64>, shape: Shape, rate: Rate) -> Move {
        let (power, power_law) = self.setup.power_of_moves(&self.modal);
        Move { target, shape, rate, power, power_law, corner: self.modal.corner }
    }

    /// Returns the move of the next pixel of a line, and moves the program's position to its end.
    pub(crate) fn next_pixel<'b>(&mut self) -> Option<Action<'b>> {
        let (power, target) = self.pixels.next()?;
        (self.modal.power, self.modal.auxiliary.speed) = (power, Some(power));
        Some(self.draw(target, Shape::Line { names_xy: true }, false))
    }

    /// Takes back the last action, which the machine refused: the program's position is again that before the
    /// action.
    pub fn take_back(&mut self) {
        self.following.clear();
        self.pixels.clear();
        self.cycles.take_back();
        let Before { position, tool_offset, shift, thermal_z, e, retracted } = self.before;
        self.position = position;
        (self.modal.tool_offset, self.modal.shift, self.modal.thermal_z) = (tool_offset, shift, thermal_z);
        if let Some(tool) = self.tools.active_mut() {
            (tool.e, tool.retracted) = (e, retracted);
        }
    }

    /// Adopts the machine's position after a stop, homing or probing.
    pub fn resynchronise(&mut self, position: PerAxis<f64>) {
        // Left-out moves have not moved the machine.
        if let Some(left_out) = &mut self.left_out {
            if left_out.stays_at(&position) {
                return;
            }
            left_out.take_place();
        }
        self.following.clear();
        self.pixels.clear();
        self.cycles.stop();
        self.position = position;
    }

    /// Returns the program's position before the last action.
    pub(crate) const fn before(&self) -> PerAxis<f64> {
        self.before.position
    }

    /// Stops the program for good, after the operator's halt or a fault.
    pub fn halt(&mut self) {
        self.following.clear();
        self.pixels.clear();
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

    /// Ends cycles, so that words without a code drill no more holes.
    pub fn end_cycles(&mut self) {
        self.cycles.stop();
        self.cycles.set_series(Series::default());
        if self.modal.motion == MotionMode::Cycle {
            self.modal.motion = MotionMode::Cancelled;
        }
    }

    /// Resets modes as at boot; coordinate systems, tools and the park position stay (GRBL's reset).
    pub fn reset(&mut self) {
        self.halt();
        self.saved.clear();
        let (systems, rotations) = (self.modal.systems, self.modal.rotations);
        self.modal = Modal::new(self.setup.feed_rate, self.modal.seek_rate);
        (self.modal.systems, self.modal.rotations) = (systems, rotations);
    }

    /// Clears coordinate systems, G92 and the park position.
    pub fn clear_offsets(&mut self) {
        self.modal.systems = Default::default();
        self.modal.rotations = Rotations::NONE;
        self.modal.g92 = self.setup.g92;
        self.park = ParkPosition::default();
        self.second_park = None;
        crate::parameters::offsets_changed(self);
    }

    // --- what it holds ---

    /// Returns the machine position at the end of the last action.
    #[must_use]
    pub const fn position(&self) -> &PerAxis<f64> {
        &self.position
    }

    /// Returns the modes, offsets and rates.
    #[must_use]
    pub const fn modal(&self) -> &Modal {
        &self.modal
    }

    /// Returns the extruders' state and settings.
    #[must_use]
    pub const fn tools(&self) -> &Tools {
        &self.tools
    }

    /// Returns the table of the spindle's tools.
    pub const fn tool_table(&mut self) -> &mut ToolTable {
        &mut self.tools.table
    }

    /// Returns the park position of G28.
    #[must_use]
    pub const fn park(&self) -> &ParkPosition {
        &self.park
    }

    /// Returns the park position of G30, if stored.
    #[must_use]
    pub const fn second_park(&self) -> Option<&ParkPosition> {
        self.second_park.as_ref()
    }

    /// Returns Z of the park position of G28 or G30, if Z takes part in parking.
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

    /// Returns X Y Z of the last G38, machine position in mm, and whether its contact was found.
    #[must_use]
    pub const fn last_probe(&self) -> ([f64; 3], bool) {
        self.last_probe
    }

    /// Returns the control points of the NURBS that the last action draws.
    #[must_use]
    pub fn control_points(&self) -> &[ControlPoint] {
        self.splines.closed()
    }

    /// Returns modes, extruder and E of the program, to be restored later.
    #[must_use]
    pub fn keep(&self) -> Kept {
        let e = self.tools.active().map_or(0.0, |tool| tool.e);
        Kept { series: *self.cycles.series(), modal: self.modal.clone(), tool: self.tools.active, e }
    }

    /// Restores modes, extruder and E. The compensation of temperature belongs to the machine and keeps its
    /// current value.
    pub fn come_back_to(&mut self, kept: Kept) {
        let thermal_z = self.modal.thermal_z;
        self.modal = kept.modal;
        self.modal.set_thermal_z(thermal_z);
        self.cycles.set_series(kept.series);
        self.tools.active = kept.tool;
        if let Some(tool) = self.tools.active_mut() {
            tool.e = kept.e;
        }
    }

    /// Raises Z by this distance, mm, from the next move on that names Z.
    pub fn set_thermal_z(&mut self, mm: f64) {
        self.modal.set_thermal_z(mm);
    }

    /// Scales the extrusion along later paths of this extruder by a factor.
    pub fn set_width_factor(&mut self, extruder: units::ToolId, factor: f64) {
        self.tools.set_width_factor(extruder, factor);
    }

    /// Selects millimetres; returns whether inches were selected before.
    pub fn count_in_mm(&mut self) -> bool {
        core::mem::take(&mut self.modal.inches)
    }

    /// Selects inches or millimetres.
    pub const fn count_in_inches(&mut self, inches: bool) {
        self.modal.inches = inches;
    }

    /// Sets the rate of G0 (M203 S).
    pub const fn set_seek_rate(&mut self, rate: MmPerSecond) {
        self.modal.seek_rate = rate;
    }

    /// Sets the work offset so that a contact at this machine height reads as given, both in mm (G30 Z).
    pub fn read_contact(&mut self, machine_z: f64, reads: f64) {
        let mut contact = self.position;
        contact[Axis::Z] = machine_z;
        self.modal.set_g92(Axis::Z, reads, &contact);
    }

    /// Enables the operator's overrides, whatever the program has set.
    pub const fn let_overrides_count(&mut self) {
        let modes = &mut self.modal.auxiliary;
        (modes.feed_override, modes.spindle_override) = (true, true);
    }

    /// Sets the result of M66: 1 or 0 for the input's state, -1 after a time-out.
    pub const fn set_input_result(&mut self, value: f64) {
        self.input_result = value;
    }

    /// Sets the line number of the file that is played, counted from 1 (`#<_line>`).
    #[inline]
    pub const fn at_line(&mut self, line: u32) {
        self.line = line;
    }

    /// Returns whether `(DEBUG, ...)` is printed (`#5599`).
    #[must_use]
    pub const fn debugs(&self) -> bool {
        self.debugs
    }

    /// Sets the end position of a G38, and whether its contact was found.
    pub const fn set_last_probe(&mut self, place: [f64; 3], found: bool) {
        self.last_probe = (place, found);
    }
}
