//! Extruders: which one is active, how far it has fed, firmware retraction.

use heapless::Vec;
use units::{Axis, MmPerSecond, PerAxis, ToolId};

use crate::action::{Action, Corner, Move, Rate, Shape};
use crate::fault::{Fault, Part, Problem};
use crate::interpreter::{Context, Interpreter, Meaning, NOTHING};
use crate::setup::ToolSettings;
use crate::words::Words;

/// Extruders at most: the motors of A, B and C.
pub const MAX_TOOLS: usize = 3;

/// One extruder.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Settings; codes may change them.
    pub settings: ToolSettings,
    /// E position as the program counts it.
    pub e: f64,
    /// Flow factor (M221), 1 is as programmed.
    pub flow: f64,
    /// Retracted by G10, with this lift of Z in mm.
    pub(crate) retracted: Option<f64>,
}

impl Tool {
    /// Millimetres of filament for one unit of E.
    #[must_use]
    pub fn scale(&self) -> f64 {
        let volumetric = match self.settings.filament_diameter {
            Some(diameter) => {
                let radius = diameter / 2.0;
                1.0 / (core::f64::consts::PI * radius * radius)
            }
            None => 1.0,
        };
        volumetric * self.flow
    }
}

/// All extruders.
#[derive(Clone, Debug, Default)]
pub struct Tools {
    tools: Vec<Tool, MAX_TOOLS>,
    active: usize,
}

impl Tools {
    /// As configured; the one with the lowest number is active.
    pub(crate) fn new(settings: &[ToolSettings]) -> Self {
        let new = |settings: &ToolSettings| Tool { settings: settings.clone(), e: 0.0, flow: 1.0, retracted: None };
        let mut tools: Vec<Tool, MAX_TOOLS> = settings.iter().take(MAX_TOOLS).map(new).collect();
        tools.sort_unstable_by_key(|tool| tool.settings.id);
        Self { tools, active: 0 }
    }

    /// All extruders, in order of their numbers.
    #[must_use]
    pub fn all(&self) -> &[Tool] {
        &self.tools
    }

    /// The active extruder.
    #[must_use]
    pub fn active(&self) -> Option<&Tool> {
        self.tools.get(self.active)
    }

    pub(crate) fn active_mut(&mut self) -> Option<&mut Tool> {
        self.tools.get_mut(self.active)
    }

    /// Number of the active tool; 0 when there is none.
    #[must_use]
    pub fn active_id(&self) -> ToolId {
        self.active().map_or(ToolId(0), |tool| tool.settings.id)
    }

    /// Whether an extruder turns this axis.
    #[must_use]
    pub fn uses(&self, axis: Axis) -> bool {
        self.tools.iter().any(|tool| tool.settings.axis == axis)
    }

    /// The extruder that a P word names by its number, else the active one.
    ///
    /// # Errors
    /// When there is none with that number.
    pub fn selected(&self, words: &Words<'_>) -> Result<&Tool, Fault> {
        let place = self.place(words)?;
        self.tools.get(place).ok_or(Problem::NoExtruder.refused(0))
    }

    fn selected_mut(&mut self, words: &Words<'_>) -> Result<&mut Tool, Fault> {
        let place = self.place(words)?;
        self.tools.get_mut(place).ok_or(Problem::NoExtruder.refused(0))
    }

    fn place(&self, words: &Words<'_>) -> Result<usize, Fault> {
        let Some(word) = words.get('P') else { return Ok(self.active) };
        self.numbered(word).ok_or(Problem::NoSuchTool(word).refused(words.column_of('P')))
    }

    fn numbered(&self, word: f64) -> Option<usize> {
        let id = ToolId::from_word(word)?;
        self.tools.iter().position(|tool| tool.settings.id == id)
    }

    /// A move was made; one of Z undoes the lift of a retraction.
    pub(crate) fn moved(&mut self, along_z: bool) {
        if let Some(lift) = self.active_mut().filter(|_| along_z).and_then(|tool| tool.retracted.as_mut()) {
            *lift = 0.0;
        }
    }
}

impl Interpreter {
    /// Tn.
    pub(crate) fn select_tool<'b>(&mut self, number: u16, column: u16) -> Result<Meaning<'b>, Fault> {
        let place = self.tools.numbered(f64::from(number));
        let place = place.or((number == 0 && self.tools.all().is_empty()).then_some(0));
        self.tools.active = place.ok_or(Problem::NoSuchTool(f64::from(number)).refused(column))?;
        if let Some(tool) = self.tools.active() {
            self.modal.tool_offset = tool.settings.offset;
        }
        NOTHING
    }

    /// G10 without L: pull the filament back, then lift.
    pub(crate) fn retract<'b>(&mut self) -> Result<Meaning<'b>, Fault> {
        self.needs_extruder()?;
        let Some(tool) = self.tools.active_mut() else { return Ok(Meaning::Unknown) };
        if tool.retracted.is_some() {
            return NOTHING;
        }
        tool.retracted = Some(tool.settings.z_lift);
        let settings = tool.settings.clone();
        let pull = self.move_by(settings.axis, -settings.retract_length, settings.retract_rate);
        if settings.z_lift > 0.0 {
            let lift = self.move_by(Axis::Z, settings.z_lift, settings.z_lift_rate);
            self.then(lift);
        }
        Ok(Meaning::Action(pull))
    }

    /// G11: down again, then push the filament forward.
    pub(crate) fn recover<'b>(&mut self, _: &Context<'b>) -> Result<Meaning<'b>, Fault> {
        self.needs_extruder()?;
        let Some(tool) = self.tools.active_mut() else { return Ok(Meaning::Unknown) };
        let Some(lift) = tool.retracted.take() else { return NOTHING };
        let settings = tool.settings.clone();
        let length = settings.retract_length + settings.recover_length;
        if lift > 0.0 {
            let down = self.move_by(Axis::Z, -lift, settings.z_lift_rate);
            let push = self.move_by(settings.axis, length, settings.recover_rate);
            self.then(push);
            return Ok(Meaning::Action(down));
        }
        Ok(Meaning::Action(self.move_by(settings.axis, length, settings.recover_rate)))
    }

    fn needs_extruder(&self) -> Result<(), Fault> {
        let off = self.tools.active().filter(|tool| tool.settings.is_off);
        off.map_or(Ok(()), |tool| Err(Problem::PartIsOff(Part::Extruder(tool.settings.id)).refused(0)))
    }

    fn move_by<'b>(&mut self, axis: Axis, by: f64, rate: MmPerSecond) -> Action<'b> {
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

    /// G10 L1 Pn: offset of tool n - 1.
    pub(crate) fn set_tool_offset<'b>(&mut self, words: &Words<'b>) -> Result<Meaning<'b>, Fault> {
        let active = self.tools.active_id();
        let place = words.get('P').and_then(|p| self.tools.numbered(p - 1.0));
        let tool = place.and_then(|place| self.tools.tools.get_mut(place));
        let tool = tool.ok_or(Problem::ToolOfOffset.refused(words.column_of('P')))?;
        for (offset, axis) in tool.settings.offset.iter_mut().zip(Axis::PRIMARY) {
            *offset = words.axis(axis).unwrap_or(*offset);
        }
        if tool.settings.id == active {
            self.modal.tool_offset = tool.settings.offset;
        }
        NOTHING
    }

    /// M200.
    pub(crate) fn filament_diameter<'b>(&mut self, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
        let tool = self.tools.selected_mut(&context.words)?;
        let Some(diameter) = context.words.get('D') else { return Ok(context.function()) };
        tool.settings.filament_diameter = (diameter > 0.01).then_some(diameter);
        NOTHING
    }

    /// M207.
    pub(crate) fn retraction<'b>(&mut self, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
        let words = &context.words;
        let settings = &mut self.tools.selected_mut(words)?.settings;
        let word = |letter: char, now: f64| words.get(letter).unwrap_or(now);
        settings.retract_length = word('S', settings.retract_length);
        settings.retract_rate.0 = word('F', settings.retract_rate.0);
        settings.z_lift = word('Z', settings.z_lift);
        settings.z_lift_rate.0 = word('Q', settings.z_lift_rate.0);
        NOTHING
    }

    /// M208.
    pub(crate) fn recovery<'b>(&mut self, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
        let words = &context.words;
        let settings = &mut self.tools.selected_mut(words)?.settings;
        settings.recover_length = words.get('S').unwrap_or(settings.recover_length);
        settings.recover_rate.0 = words.get('F').unwrap_or(settings.recover_rate.0);
        NOTHING
    }

    /// M221.
    pub(crate) fn flow<'b>(&mut self, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
        let tool = self.tools.selected_mut(&context.words)?;
        let Some(factor) = context.words.get('S') else { return Ok(context.function()) };
        tool.flow = factor;
        NOTHING
    }
}
