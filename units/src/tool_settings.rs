//! Settings of extruders, canned cycles and servos, as the configuration has them and programs take them.

use crate::{Axis, MmPerSecond, ToolId};

/// Settings of an extruder that codes can change.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToolSettings {
    /// Tool number of the extruder.
    pub id: ToolId,
    /// Axis of the extruder's motor.
    pub axis: Axis,
    /// Offset of the nozzle from tool 0, X Y Z in mm.
    pub offset: [f64; 3],
    /// Diameter of the filament, mm, if E counts in mm3.
    pub filament_diameter: Option<f64>,
    /// Length that G10 retracts, mm.
    pub retract_length: f64,
    /// Rate of the retraction.
    pub retract_rate: MmPerSecond,
    /// Length that G11 pushes beyond the retraction, mm.
    pub recover_length: f64,
    /// Rate of the recovery.
    pub recover_rate: MmPerSecond,
    /// Lift of Z after a retraction, mm.
    pub z_lift: f64,
    /// Rate of the lift.
    pub z_lift_rate: MmPerSecond,
    /// Greatest flow of G1 if E counts in mm3, mm3/s (M203 V).
    pub flow_limit: Option<f64>,
    /// Whether an error in the configuration keeps the extruder off.
    pub is_off: bool,
}

/// Settings of canned cycles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CycleSetup {
    /// Whether canned cycles are switched off.
    pub is_off: bool,
    /// Whether P is in milliseconds instead of seconds.
    pub dwell_in_ms: bool,
}

/// Servo, turned from 0 to the greatest angle by pulses from the least to the widest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ServoSetup {
    /// Greatest angle of the servo, degrees.
    pub max_angle: f32,
    /// Pulse widths at angle 0 and at the greatest angle, microseconds.
    pub pulse_us: [f32; 2],
}
