//! Rows of the section `[extruder]`.

use super::build::{ANY, NOT_NEGATIVE, POSITIVE, bool, integer, new_name, number};
use super::{CannotCreate, Docs, Form, Instances, Section, Setting};
use crate::machine::{ExtruderConfig, MAX_EXTRUDERS, ToolId};
use units::{Celsius, Mm, MmPerSecond};

/// `|extruder, value| ...` on the extruder at the instance's place.
macro_rules! extruder {
    (|$extruder:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($extruder) = c.extruders.get_mut(i) {
                $body;
            }
        }
    };
}

pub const EXTRUDER: Section = Section {
    name: "extruder",
    store: None,
    docs: Docs::new("Extruders and their firmware retraction. Tool 0 turns motor delta, tool 1 epsilon, tool 2 zeta."),
    form: Form::Named(Instances {
        noun: "extruder",
        find: |c, name| c.extruders.iter().position(|extruder| extruder.name == name),
        create: |c, name| {
            let extruder = ExtruderConfig { name: new_name(name)?, ..ExtruderConfig::default() };
            c.extruders.push(extruder).map_err(|_| CannotCreate::Full(MAX_EXTRUDERS))?;
            Ok(c.extruders.len() - 1)
        },
        name: |c, i| c.extruders.get(i).map_or("", |extruder| extruder.name.as_str()),
        is_live: |c, i| c.extruders.get(i).is_some_and(|extruder| extruder.enable),
    }),
    settings: &[
        bool("enable", "false", extruder!(|e, v| e.enable = v), "There is such an extruder.")
            .v1("extruder.<name>.enable"),
        integer("tool_id", "0", &(0, 2), extruder!(|e, v| e.tool_id = ToolId(v as u8)), "Tool number; also picks the motor."),
        offset("x_offset", extruder!(|e, v| e.offset[0] = Mm(v))).v1("extruder.<name>.x_offset"),
        offset("y_offset", extruder!(|e, v| e.offset[1] = Mm(v))).v1("extruder.<name>.y_offset"),
        offset("z_offset", extruder!(|e, v| e.offset[2] = Mm(v))).v1("extruder.<name>.z_offset"),
        number(
            "filament_diameter",
            "0",
            NOT_NEGATIVE,
            extruder!(|e, v| e.filament_diameter = (v > 0.01).then_some(Mm(v))),
            "Makes E count cubic millimetres of filament this thick; 0: millimetres of filament. M200 D changes it.",
        )
        .klipper("[extruder] filament_diameter")
        .unit("mm")
        .typical(&(1.0, 4.0))
        .v1("extruder.<name>.filament_diameter"),
        number(
            "retract_length",
            "3",
            NOT_NEGATIVE,
            extruder!(|e, v| e.retract_length = Mm(v)),
            "Filament that G10 pulls back. M207 S changes it.",
        )
        .klipper("[firmware_retraction] retract_length")
        .unit("mm")
        .typical(&(0.1, 50.0))
        .v1("extruder.<name>.retract_length"),
        number(
            "retract_feedrate",
            "45",
            POSITIVE,
            extruder!(|e, v| e.retract_rate = MmPerSecond(v)),
            "Speed of the G10 pull. M207 F changes it.",
        )
        .klipper("[firmware_retraction] retract_speed")
        .unit("mm/s")
        .typical(&(1.0, 200.0))
        .v1("extruder.<name>.retract_feedrate"),
        number(
            "retract_recover_length",
            "0",
            ANY,
            extruder!(|e, v| e.recover_length = Mm(v)),
            "Filament that G11 pushes beyond the retracted length. M208 S changes it.",
        )
        .klipper("[firmware_retraction] unretract_extra_length")
        .unit("mm")
        .v1("extruder.<name>.retract_recover_length"),
        number(
            "retract_recover_feedrate",
            "30",
            POSITIVE,
            extruder!(|e, v| e.recover_rate = MmPerSecond(v)),
            "Speed of the G11 push. M208 F changes it.",
        )
        .klipper("[firmware_retraction] unretract_speed")
        .unit("mm/s")
        .typical(&(1.0, 200.0))
        .v1("extruder.<name>.retract_recover_feedrate"),
        number(
            "retract_zlift_length",
            "0",
            ANY,
            extruder!(|e, v| e.z_lift = Mm(if v > 0.0 { v } else { 0.0 })),
            "Z hop of G10, undone by G11; 0 for none. M207 Z changes it.",
        )
        .unit("mm")
        .v1("extruder.<name>.retract_zlift_length"),
        number(
            "retract_zlift_feedrate",
            "6000",
            POSITIVE,
            extruder!(|e, v| e.z_lift_rate = MmPerSecond::from_per_minute(v)),
            "Speed of the hop; the only rate here in mm/min. M207 Q changes it.",
        )
        .unit("mm/min")
        .typical(&(60.0, 60_000.0))
        .v1("extruder.<name>.retract_zlift_feedrate"),
        number(
            "min_extrude_temp",
            "0",
            &(0.0, 500.0),
            extruder!(|e, v| e.min_extrude_temp = Celsius(v as f32)),
            "Colder than this it does not turn: a line that asks for it is refused, and a file waits there; 0: it always does. M302 changes it.",
        )
        .unit("C")
        .velvet(),
        number(
            "pressure_advance",
            "0",
            &(0.0, 10.0),
            extruder!(|e, v| e.pressure_advance_s = v),
            "Filament pushed ahead for each mm/s of its speed, on moves that extrude while X or Y move; 0 for none.",
        )
        .unit("s")
        .typical(&(0.001, 2.0))
        .klipper("[extruder] pressure_advance")
        .velvet(),
        number(
            "pressure_advance_smooth_time",
            "0.04",
            &(0.001, 0.2),
            extruder!(|e, v| e.pressure_advance_smooth_time_s = v),
            "Width of the window that pressure advance is averaged over. With pressure advance on, all axes lag behind the \
             plan by at least half of it.",
        )
        .unit("s")
        .klipper("[extruder] pressure_advance_smooth_time")
        .velvet(),
    ],
};

const fn offset(key: &'static str, set: super::Set<f64>) -> Setting {
    number(key, "0", ANY, set, "Part of the tool offset while this tool is selected. G10 L1 changes it.").unit("mm")
}
