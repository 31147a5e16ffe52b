//! `[extruder]`: extruders and their firmware retraction.

use crate::names::Name;
use crate::setting::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, number};
use crate::setting::declare::settings;
use units::{Actuator, Axis, Celsius, MmPerSecond, ToolId, ToolSettings};

/// Greatest number of extruders: actuators delta, epsilon and zeta.
pub const MAX_EXTRUDERS: usize = 3;

settings! {
    /// Extruders and their firmware retraction. Tool 0 turns motor delta, tool 1 epsilon, tool 2 zeta.
    #[derive(Clone, Debug, Default)]
    pub struct ExtruderConfig {
        /// Name of the extruder in the file.
        name: Name;
        /// There is such an extruder.
        enable: bool = bool("false").v1("extruder.<name>.enable");
        /// Tool number; also picks the motor.
        "tool_id" = integer("0", &(0, 2)) => ExtruderConfig::set_tool_id;
        /// What codes can change of the extruder.
        tool: ToolSettings;
        /// Part of the tool offset while this tool is selected. G10 L1 changes it.
        "x_offset" tool.offset[0] = number("0", ANY).unit("mm").v1("extruder.<name>.x_offset");
        /// Part of the tool offset while this tool is selected. G10 L1 changes it.
        "y_offset" tool.offset[1] = number("0", ANY).unit("mm").v1("extruder.<name>.y_offset");
        /// Part of the tool offset while this tool is selected. G10 L1 changes it.
        "z_offset" tool.offset[2] = number("0", ANY).unit("mm").v1("extruder.<name>.z_offset");
        /// Makes E count cubic millimetres of filament this thick; 0: millimetres of filament. M200 D changes
        /// it.
        "filament_diameter" tool.filament_diameter = number("0", NOT_NEGATIVE)
            .klipper("[extruder] filament_diameter").unit("mm").typical(&(1.0, 4.0))
            .v1("extruder.<name>.filament_diameter") => |v: f64| (v > 0.01).then_some(v);
        /// Filament that G10 pulls back. M207 S changes it.
        "retract_length" tool.retract_length = number("3", NOT_NEGATIVE)
            .klipper("[firmware_retraction] retract_length").unit("mm").typical(&(0.1, 50.0))
            .v1("extruder.<name>.retract_length");
        /// Speed of the G10 pull. M207 F changes it.
        "retract_feedrate" tool.retract_rate = number("45", POSITIVE)
            .klipper("[firmware_retraction] retract_speed").unit("mm/s").typical(&(1.0, 200.0))
            .v1("extruder.<name>.retract_feedrate");
        /// Filament that G11 pushes beyond the retracted length. M208 S changes it.
        "retract_recover_length" tool.recover_length = number("0", ANY)
            .klipper("[firmware_retraction] unretract_extra_length").unit("mm")
            .v1("extruder.<name>.retract_recover_length");
        /// Speed of the G11 push. M208 F changes it.
        "retract_recover_feedrate" tool.recover_rate = number("30", POSITIVE)
            .klipper("[firmware_retraction] unretract_speed").unit("mm/s").typical(&(1.0, 200.0))
            .v1("extruder.<name>.retract_recover_feedrate");
        /// Z hop of G10, undone by G11; 0 for none. M207 Z changes it.
        "retract_zlift_length" tool.z_lift = number("0", ANY)
            .unit("mm").v1("extruder.<name>.retract_zlift_length") => |v: f64| if v > 0.0 { v } else { 0.0 };
        /// Speed of the hop; the only rate here in mm/min. M207 Q changes it.
        "retract_zlift_feedrate" tool.z_lift_rate = number("6000", POSITIVE)
            .unit("mm/min").typical(&(60.0, 60_000.0)).v1("extruder.<name>.retract_zlift_feedrate")
            => MmPerSecond::from_per_minute;
        /// Colder than this it does not turn: a line that asks for it is refused, and a file waits there; 0:
        /// it always does. M302 changes it.
        min_extrude_temp: Celsius = number("0", &(0.0, 500.0))
            .unit("C").klipper("[extruder] min_extrude_temp").velvet();
        /// Longest filament that a line without X, Y and Z feeds or draws back; a longer one is refused, and
        /// a file waits there; 0: any.
        max_extrude_only_distance: f64 = number("0", NOT_NEGATIVE)
            .unit("mm").klipper("[extruder] max_extrude_only_distance").velvet();
        /// Filament pushed ahead for each mm/s of its speed, on moves that extrude while X or Y move; 0 for
        /// none.
        "pressure_advance" pressure_advance_s: f64 = number("0", &(0.0, 10.0))
            .unit("s").typical(&(0.001, 2.0)).klipper("[extruder] pressure_advance").velvet();
        /// Width of the window that pressure advance is averaged over. With pressure advance on, all axes lag
        /// behind the plan by at least half of it.
        "pressure_advance_smooth_time" pressure_advance_smooth_time_s: f64 = number("0.04", &(0.001, 0.2))
            .unit("s").klipper("[extruder] pressure_advance_smooth_time").velvet();
    }
}

impl ExtruderConfig {
    fn set_tool_id(&mut self, id: i64) {
        self.tool.id = ToolId(id as u8);
        self.tool.axis = match id {
            0 => Axis::A,
            1 => Axis::B,
            _ => Axis::C,
        };
    }

    /// Returns whether a move feeds more filament, mm, than the extruder may without X, Y or Z.
    #[must_use]
    pub fn feeds_too_far(&self, fed: f64, is_alone: bool) -> bool {
        is_alone && self.max_extrude_only_distance > 0.0 && fed.abs() > self.max_extrude_only_distance
    }

    /// Returns the motor of the extruder: delta for tool 0, epsilon for 1, zeta for 2.
    #[must_use]
    pub const fn actuator(&self) -> Option<Actuator> {
        Actuator::from_index(3 + self.tool.id.0 as usize)
    }
}
