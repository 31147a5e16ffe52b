//! Plans of machines with an external driver.

use crate::Plan;

impl Plan {
    /// Puts X on an external driver of this kind, on header pins; its own settings are still to come.
    #[must_use]
    pub fn with_x_outside(self, kind: &str) -> Self {
        let lines = [
            "[uart console] enable = false",
            "[tmc2590] alpha.spi_cs_pin",
            "[tmc2590] alpha.sense_resistor",
            "[tmc2590] alpha.max_current",
            "[tmc2590] alpha.step_interpolation",
            "[actuator] alpha.step_pin = PJ5",
            "[actuator] alpha.dir_pin = PJ1",
        ];
        let plan = lines.iter().fold(self, |plan, line| plan.set(line));
        plan.set(&format!("[actuator] alpha.driver = {kind}"))
    }
}
