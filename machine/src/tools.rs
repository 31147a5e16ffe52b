//! Extruders: which one is active, how far it has fed, firmware retraction.

use core::fmt::Write;

use config::{ExtruderConfig, MAX_EXTRUDERS, ToolId};
use gcode::Block;
use heapless::Vec;
use motion::Mode;
use units::{Axis, MmPerSecond};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::ports::Ports;

/// One extruder.
#[derive(Clone, Debug)]
pub struct Tool {
    /// Settings; M-codes may change them.
    pub settings: ExtruderConfig,
    /// The axis that its motor is.
    pub axis: Axis,
    /// E position as the program counts it.
    pub e: f64,
    /// Flow factor (M221), 1 is as programmed.
    pub flow: f64,
    /// Retracted by G10, with this Z lift in mm.
    retracted: Option<f64>,
}

impl Tool {
    fn new(settings: &ExtruderConfig) -> Self {
        let axis = match settings.tool_id {
            ToolId(0) => Axis::A,
            ToolId(1) => Axis::B,
            _ => Axis::C,
        };
        Self { settings: settings.clone(), axis, e: 0.0, flow: 1.0, retracted: None }
    }

    /// Millimetres of filament for one unit of E.
    #[must_use]
    pub fn scale(&self) -> f64 {
        let volumetric = match self.settings.filament_diameter {
            Some(diameter) if diameter.0 > 0.01 => {
                let radius = diameter.0 / 2.0;
                1.0 / (core::f64::consts::PI * radius * radius)
            }
            _ => 1.0,
        };
        volumetric * self.flow
    }
}

/// All extruders.
#[derive(Clone, Debug, Default)]
pub struct Tools {
    tools: Vec<Tool, MAX_EXTRUDERS>,
    active: usize,
}

impl Tools {
    /// As configured; the one with the lowest number is active.
    #[must_use]
    pub fn new(extruders: &[ExtruderConfig]) -> Self {
        let mut tools: Vec<Tool, MAX_EXTRUDERS> = extruders.iter().take(MAX_EXTRUDERS).map(Tool::new).collect();
        tools.sort_unstable_by_key(|tool| tool.settings.tool_id);
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

    /// The active extruder.
    pub fn active_mut(&mut self) -> Option<&mut Tool> {
        self.tools.get_mut(self.active)
    }

    /// Number of the active tool; 0 when there is none.
    #[must_use]
    pub fn active_id(&self) -> ToolId {
        self.active().map_or(ToolId(0), |tool| tool.settings.tool_id)
    }

    /// Whether an extruder turns this axis.
    #[must_use]
    pub fn uses(&self, axis: Axis) -> bool {
        self.tools.iter().any(|tool| tool.axis == axis)
    }

    /// The extruder that a P word names by its `tool_id`, else the active one.
    ///
    /// # Errors
    /// When there is none with that number: those there are.
    pub fn selected(&self, p: Option<f64>) -> Result<&Tool, Failure> {
        let place = self.place(p)?;
        self.tools.get(place).ok_or_else(|| Failure::refused("no extruder is configured"))
    }

    /// The same, to change it.
    ///
    /// # Errors
    /// As [`Self::selected`].
    pub fn selected_mut(&mut self, p: Option<f64>) -> Result<&mut Tool, Failure> {
        let place = self.place(p)?;
        self.tools.get_mut(place).ok_or_else(|| Failure::refused("no extruder is configured"))
    }

    fn place(&self, p: Option<f64>) -> Result<usize, Failure> {
        let Some(word) = p else { return Ok(self.active) };
        let id = ToolId::from_word(word);
        self.tools.iter().position(|tool| Some(tool.settings.tool_id) == id).ok_or_else(|| {
            let mut text = message(format_args!("no extruder has tool_id {word}; there are"));
            for (place, tool) in self.tools.iter().enumerate() {
                let comma = if place == 0 { "" } else { "," };
                // What does not fit any more is left out.
                let _ = write!(text, "{comma} P{} {}", tool.settings.tool_id, tool.settings.name);
            }
            Failure::Refused(text)
        })
    }

    /// A move was made; one of Z undoes the lift of a retraction.
    pub fn moved(&mut self, along_z: bool) {
        if let Some(lift) = self.active_mut().filter(|_| along_z).and_then(|tool| tool.retracted.as_mut()) {
            *lift = 0.0;
        }
    }

    fn select(&mut self, id: ToolId) -> bool {
        let place = self.tools.iter().position(|tool| tool.settings.tool_id == id);
        self.active = place.unwrap_or(self.active);
        place.is_some()
    }
}

impl<P: Ports> Controller<P> {
    /// Tn.
    pub(crate) async fn select_tool(&mut self, number: u16) -> Outcome {
        let id = ToolId::from_word(f64::from(number));
        if id == Some(self.tools.active_id()) {
            return Ok(Answer::Ok);
        }
        self.wait_idle().await?;
        if !id.is_some_and(|id| self.tools.select(id)) {
            return Err(Failure::Refused(message(format_args!("there is no tool T{number}"))));
        }
        if let Some(tool) = self.tools.active() {
            self.modal.tool_offset = tool.settings.offset.map(|mm| mm.0);
        }
        Ok(Answer::Ok)
    }

    /// G10: pull the filament back, then lift.
    pub(crate) async fn retract(&mut self) -> Outcome {
        self.needs_extruder()?;
        let Some(tool) = self.tools.active_mut() else { return Ok(Answer::Unknown) };
        if tool.retracted.is_some() {
            return Ok(Answer::Ok);
        }
        tool.retracted = Some(tool.settings.z_lift.0);
        let (axis, settings) = (tool.axis, tool.settings.clone());
        self.auxiliary_move(axis, -settings.retract_length.0, settings.retract_rate).await?;
        if settings.z_lift.0 > 0.0 {
            self.auxiliary_move(Axis::Z, settings.z_lift.0, settings.z_lift_rate).await?;
        }
        Ok(Answer::Ok)
    }

    /// G11: down again, then push the filament forward.
    pub(crate) async fn recover(&mut self) -> Outcome {
        self.needs_extruder()?;
        let Some(tool) = self.tools.active_mut() else { return Ok(Answer::Unknown) };
        let Some(lift) = tool.retracted.take() else { return Ok(Answer::Ok) };
        let (axis, settings) = (tool.axis, tool.settings.clone());
        if lift > 0.0 {
            self.auxiliary_move(Axis::Z, -lift, settings.z_lift_rate).await?;
        }
        let length = settings.retract_length.0 + settings.recover_length.0;
        self.auxiliary_move(axis, length, settings.recover_rate).await?;
        Ok(Answer::Ok)
    }

    fn needs_extruder(&self) -> Result<(), Failure> {
        self.tools.active().map_or(Ok(()), |tool| self.needs("extruder", &tool.settings.name))
    }

    async fn auxiliary_move(&mut self, axis: Axis, by: f64, rate: MmPerSecond) -> Result<(), Failure> {
        let mut target = self.position;
        target[axis] += by;
        self.go(target, rate, Mode::Feed).await
    }

    /// G10 L1 Pn: offset of tool n - 1.
    pub(crate) fn set_tool_offset(&mut self, block: &Block<'_>) -> Outcome {
        let offsets =
            [Axis::X, Axis::Y, Axis::Z].map(|axis| block.get(axis.letter()).map(|word| self.modal.to_mm(word)));
        let active = self.tools.active_id();
        let tool = block.get('P').and_then(|p| self.tools.selected_mut(Some(p - 1.0)).ok());
        let tool = tool.ok_or_else(|| Failure::refused("G10 L1: P must be the number of a tool plus one"))?;
        for (offset, word) in tool.settings.offset.iter_mut().zip(offsets) {
            offset.0 = word.unwrap_or(offset.0);
        }
        if tool.settings.tool_id == active {
            self.modal.tool_offset = tool.settings.offset.map(|mm| mm.0);
        }
        Ok(Answer::Ok)
    }

    /// M200, M207, M208, M221.
    pub(crate) fn extruder_code(&mut self, number: u16, block: &Block<'_>) -> Outcome {
        let tool = self.tools.selected_mut(block.get('P'))?;
        let set = |word: char, place: &mut f64| *place = block.get(word).unwrap_or(*place);
        let set_rate = |word: char, place: &mut MmPerSecond| {
            *place = block.get(word).map_or(*place, MmPerSecond::from_per_minute);
        };
        let settings = &mut tool.settings;
        match number {
            200 => match (block.get('D'), settings.filament_diameter) {
                (Some(diameter), _) => settings.filament_diameter = (diameter > 0.01).then_some(units::Mm(diameter)),
                (None, Some(diameter)) => self.say(format_args!("Filament Diameter: {:.6}\n", diameter.0)),
                (None, None) => self.say(format_args!("Volumetric extrusion is disabled\n")),
            },
            207 => {
                set('S', &mut settings.retract_length.0);
                set_rate('F', &mut settings.retract_rate);
                set('Z', &mut settings.z_lift.0);
                set_rate('Q', &mut settings.z_lift_rate);
            }
            208 => {
                set('S', &mut settings.recover_length.0);
                set_rate('F', &mut settings.recover_rate);
            }
            _ => match block.get('S') {
                Some(percent) if percent > 0.0 => tool.flow = percent / 100.0,
                Some(_) => return Err(Failure::refused("M221: S must be above 0")),
                None => {
                    let percent = tool.flow * 100.0;
                    self.say(format_args!("Flow rate at {percent:6.2} %\n"));
                }
            },
        }
        Ok(Answer::Ok)
    }
}
