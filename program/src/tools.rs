//! Extruders: which one is active, how far it has fed.

use heapless::Vec;
use units::{Axis, ToolId};

use crate::fault::{Fault, Problem};
use crate::setup::ToolSettings;
use crate::tool_table::{ToolEntry, ToolTable};
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
    /// What the measured width of the filament makes of the flow along the path, 1 where nothing is known.
    pub width_factor: f64,
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
    pub(crate) tools: Vec<Tool, MAX_TOOLS>,
    pub(crate) active: usize,
    /// T on a machine without extruders: the tool that M6 puts in.
    pub(crate) selected: u16,
    /// The one that it has put in.
    pub(crate) in_spindle: u16,
    /// What is known of the tools that go into the spindle.
    pub(crate) table: ToolTable,
}

impl Tools {
    /// As configured; the one with the lowest number is active.
    pub(crate) fn new(settings: &[ToolSettings]) -> Self {
        let new = |settings: &ToolSettings| Tool {
            settings: settings.clone(),
            e: 0.0,
            flow: 1.0,
            width_factor: 1.0,
            retracted: None,
        };
        let mut tools: Vec<Tool, MAX_TOOLS> = settings.iter().take(MAX_TOOLS).map(new).collect();
        units::sort_short(&mut tools, |one, other| one.settings.id.cmp(&other.settings.id));
        Self { tools, active: 0, selected: 0, in_spindle: 0, table: ToolTable::default() }
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

    /// What is extruded along the path from now on is this much of what the program says, with the extruder
    /// of this number: its filament is thicker or thinner than meant.
    pub(crate) fn set_width_factor(&mut self, id: ToolId, factor: f64) {
        if let Some(tool) = self.tools.iter_mut().find(|tool| tool.settings.id == id) {
            tool.width_factor = factor;
        }
    }

    pub(crate) fn active_mut(&mut self) -> Option<&mut Tool> {
        self.tools.get_mut(self.active)
    }

    /// Whether tools are extruders.
    #[must_use]
    pub fn has_extruders(&self) -> bool {
        !self.tools.is_empty()
    }

    /// Number of the tool in the spindle, 0 when there is none; of the active extruder.
    #[must_use]
    pub fn number(&self) -> u32 {
        if self.has_extruders() { u32::from(self.active_id().0) } else { u32::from(self.in_spindle) }
    }

    /// What is known of the tools that go into the spindle.
    #[must_use]
    pub const fn table(&self) -> &ToolTable {
        &self.table
    }

    /// What the table knows of the tool in the spindle.
    pub(crate) fn spindle_entry(&self) -> Option<&ToolEntry> {
        self.table.get(self.in_spindle).filter(|_| !self.has_extruders())
    }

    /// The pocket of a tool as the table has it, 0 where it says nothing.
    pub(crate) fn pocket(&self, number: u16) -> f64 {
        self.table.get(number).and_then(|tool| tool.pocket).map_or(0.0, f64::from)
    }

    /// M6: the selected tool is in the spindle.
    pub(crate) fn change(&mut self) -> u32 {
        self.in_spindle = self.selected;
        u32::from(self.in_spindle)
    }

    /// Number of the active extruder; 0 when there is none.
    #[must_use]
    pub fn active_id(&self) -> ToolId {
        self.active().map_or(ToolId(0), |tool| tool.settings.id)
    }

    /// What the extruders turn.
    pub(crate) fn axes(&self) -> Vec<Axis, MAX_TOOLS> {
        self.tools.iter().map(|tool| tool.settings.axis).collect()
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
        let place = self.place(words, &['P'])?;
        self.tools.get(place).ok_or(Problem::NoExtruder.refused(0))
    }

    /// The extruder that a word names by its number, else the active one.
    ///
    /// # Errors
    /// When there is none with that number.
    pub fn named_by(&self, words: &Words<'_>, letter: char) -> Result<&Tool, Fault> {
        let place = match words.get(letter) {
            Some(word) => self.numbered(word).ok_or(Problem::NoSuchTool(word).refused(words.column_of(letter)))?,
            None => self.active,
        };
        self.tools.get(place).ok_or(Problem::NoExtruder.refused(0))
    }

    pub(crate) fn selected_mut(&mut self, words: &Words<'_>) -> Result<&mut Tool, Fault> {
        self.selected_by(words, &['P'])
    }

    /// The tool that one of these letters names; the one in use where none does.
    pub(crate) fn selected_by(&mut self, words: &Words<'_>, letters: &[char]) -> Result<&mut Tool, Fault> {
        let place = self.place(words, letters)?;
        self.tools.get_mut(place).ok_or(Problem::NoExtruder.refused(0))
    }

    fn place(&self, words: &Words<'_>, letters: &[char]) -> Result<usize, Fault> {
        let named = letters.iter().find_map(|letter| Some((*letter, words.get(*letter)?)));
        let Some((letter, word)) = named else { return Ok(self.active) };
        self.numbered(word).ok_or(Problem::NoSuchTool(word).refused(words.column_of(letter)))
    }

    pub(crate) fn numbered(&self, word: f64) -> Option<usize> {
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
