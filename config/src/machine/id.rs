//! Addresses of machine parts: by the user's numbers and names, never by a place in a list.

use units::{HeaterId, ToolId};

use super::{MachineConfig, TemperatureConfig};

impl MachineConfig {
    /// Returns the temperature controls, in the description's order.
    pub fn heaters(&self) -> impl Iterator<Item = (HeaterId, &TemperatureConfig)> {
        HeaterId::all().zip(&self.temperatures)
    }

    /// Returns a temperature control's description; `None` for an id of another machine.
    #[must_use]
    pub fn heater(&self, id: HeaterId) -> Option<&TemperatureConfig> {
        self.temperatures.get(id.index())
    }

    /// Returns the temperature control with this number.
    #[must_use]
    pub fn heater_with(&self, tool_id: ToolId) -> Option<HeaterId> {
        self.heaters().find(|(_, heater)| heater.tool_id == tool_id).map(|(id, _)| id)
    }
}
