//! Extruders and spindle tools: the active tool, and the filament fed so far.

use heapless::Vec;
use units::{Axis, ToolId};

use crate::fault::{Fault, Problem};
use crate::state::setup::ToolSettings;
use crate::state::tool_table::{ToolEntry, ToolTable};
use crate::words::Words;

/// Greatest number of extruders: the motors of A, B and C.
pub const MAX_TOOLS: usize = 3;

/// State of an extruder.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Settings, which codes may change.
    pub settings: ToolSettings,
    /// E position in the program's count.
    pub e: f64,
    /// Flow factor (M221); 1 is as programmed.
    pub flow: f64,
    /// Correction of the flow for the measured filament width; 1 without a measurement.
    pub width_factor: f64,
    /// Lift of Z, mm, if retracted by G10.
    pub(crate) retracted: Option<f64>,
}

impl Tool {
    /// Returns the millimetres of filament in one unit of E.
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

/// All tools of the machine.
#[derive(Clone, Debug, Default)]
pub struct Tools {
    pub(crate) tools: Vec<Tool, MAX_TOOLS>,
    pub(crate) active: usize,
    /// Tool number of T on a machine without extruders, for the next M6.
    pub(crate) selected: u16,
    /// Number of the tool that M6 put in.
    pub(crate) in_spindle: u16,
    /// Table of spindle tools.
    pub(crate) table: ToolTable,
}

impl Tools {
    /// Creates the extruders; the one with the lowest number is active.
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

    /// Returns all extruders, in order of their numbers.
    #[must_use]
    pub fn all(&self) -> &[Tool] {
        &self.tools
    }

    /// Returns the active extruder.
    #[must_use]
    pub fn active(&self) -> Option<&Tool> {
        self.tools.get(self.active)
    }

    /// Sets the flow correction of an extruder whose filament is thicker or thinner than nominal.
    pub(crate) fn set_width_factor(&mut self, id: ToolId, factor: f64) {
        if let Some(tool) = self.tools.iter_mut().find(|tool| tool.settings.id == id) {
            tool.width_factor = factor;
        }
    }

    pub(crate) fn active_mut(&mut self) -> Option<&mut Tool> {
        self.tools.get_mut(self.active)
    }

    /// Whether tools are extruders, rather than spindle tools.
    #[must_use]
    pub fn has_extruders(&self) -> bool {
        !self.tools.is_empty()
    }

    /// Returns the number of the active extruder, or of the tool in the spindle, 0 when there is none.
    #[must_use]
    pub fn number(&self) -> u32 {
        if self.has_extruders() { u32::from(self.active_id().0) } else { u32::from(self.in_spindle) }
    }

    /// Returns the table of spindle tools.
    #[must_use]
    pub const fn table(&self) -> &ToolTable {
        &self.table
    }

    /// Returns the table's entry of the tool in the spindle.
    pub(crate) fn spindle_entry(&self) -> Option<&ToolEntry> {
        self.table.get(self.in_spindle).filter(|_| !self.has_extruders())
    }

    /// Returns the pocket of a tool in the table, 0 without an entry.
    pub(crate) fn pocket(&self, number: u16) -> f64 {
        self.table.get(number).and_then(|tool| tool.pocket).map_or(0.0, f64::from)
    }

    /// M6: puts the selected tool in the spindle, and returns its number.
    pub(crate) fn change(&mut self) -> u32 {
        self.in_spindle = self.selected;
        u32::from(self.in_spindle)
    }

    /// Returns the number of the active extruder; 0 when there is none.
    #[must_use]
    pub fn active_id(&self) -> ToolId {
        self.active().map_or(ToolId(0), |tool| tool.settings.id)
    }

    /// Returns the axes of the extruders.
    pub(crate) fn axes(&self) -> Vec<Axis, MAX_TOOLS> {
        self.tools.iter().map(|tool| tool.settings.axis).collect()
    }

    /// Whether an extruder turns this axis.
    #[must_use]
    pub fn uses(&self, axis: Axis) -> bool {
        self.tools.iter().any(|tool| tool.settings.axis == axis)
    }

    /// Returns the extruder whose number a P word gives, else the active extruder.
    ///
    /// # Errors
    /// When no extruder has that number.
    pub fn selected(&self, words: &Words<'_>) -> Result<&Tool, Fault> {
        let place = self.place(words, &['P'])?;
        self.tools.get(place).ok_or(Problem::NoExtruder.refused(0))
    }

    /// Returns the extruder whose number a word gives, else the active extruder.
    ///
    /// # Errors
    /// When no extruder has that number.
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

    /// Returns the tool whose number one of these letters gives, else the active tool.
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

    /// Notes a move; motion of Z cancels the lift of a retraction.
    pub(crate) fn moved(&mut self, along_z: bool) {
        if let Some(lift) = self.active_mut().filter(|_| along_z).and_then(|tool| tool.retracted.as_mut()) {
            *lift = 0.0;
        }
    }
}
