//! How parts of the machine are addressed: by what the user wrote, never by a place in a list.

use units::ToolId;

use super::{MAX_TEMPERATURES, MachineConfig, TemperatureConfig};

/// A temperature control of this machine. What a user writes becomes one by [`MachineConfig::heater_with`] alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeaterId(u8);

impl HeaterId {
    /// Its place in lists that are kept in the description's order.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// Every id a machine can have, in the description's order.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..MAX_TEMPERATURES as u8).map(Self)
    }
}

impl MachineConfig {
    /// The temperature controls, in the description's order.
    pub fn heaters(&self) -> impl Iterator<Item = (HeaterId, &TemperatureConfig)> {
        HeaterId::all().zip(&self.temperatures)
    }

    /// A temperature control's description; `None` for an id of another machine.
    #[must_use]
    pub fn heater(&self, id: HeaterId) -> Option<&TemperatureConfig> {
        self.temperatures.get(id.index())
    }

    /// The temperature control with this number.
    #[must_use]
    pub fn heater_with(&self, tool_id: ToolId) -> Option<HeaterId> {
        self.heaters().find(|(_, heater)| heater.tool_id == tool_id).map(|(id, _)| id)
    }
}
