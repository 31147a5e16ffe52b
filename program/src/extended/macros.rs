//! Klipper's commands about macros, and others that take more of the machine than codes: its configuration in
//! Klipper's terms, what is in force.

use super::row::{Becomes, ExtendedInfo};

const fn of_macros(name: &'static str, takes: &'static str, help: &'static str) -> ExtendedInfo {
    ExtendedInfo { name, takes, help, becomes: Becomes::Macros }
}

pub(super) const COMMANDS: &[ExtendedInfo] = &[
    of_macros("FORCE_MOVE", "STEPPER DISTANCE VELOCITY ACCEL", "move a motor, homed or not, as test acc"),
    of_macros("RUN_TEMPLATE", "SECTION OPTION", "carry out a template of a section of the printer.cfg"),
    of_macros("SAVE_VARIABLE", "VARIABLE VALUE", "keep a value on the card for macros, in [save_variables]"),
    of_macros("SET_GCODE_VARIABLE", "MACRO VARIABLE VALUE", "change a variable of a macro until the next restart"),
    of_macros("SET_IDLE_TIMEOUT", "TIMEOUT", "seconds without work after which [idle_timeout] acts"),
    of_macros("STEPPER_BUZZ", "STEPPER", "move a motor to and fro by a millimetre, as test jog"),
    of_macros("UPDATE_DELAYED_GCODE", "ID DURATION", "seconds until a [delayed_gcode] is carried out, 0 for never"),
    of_macros("Z_OFFSET_APPLY_ENDSTOP", "", "the shift of Z, as M290, becomes one of where Z homes, as M206"),
    of_macros("Z_OFFSET_APPLY_PROBE", "", "the shift of Z, as M290, becomes one of the probe's offset, as M565"),
];
