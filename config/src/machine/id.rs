//! How parts of the machine are addressed: by what the user wrote, never by a place in a list.

use units::{HeaterId, ToolId};

use super::{MachineConfig, TemperatureConfig};

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
